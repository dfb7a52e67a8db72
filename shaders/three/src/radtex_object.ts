// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// A bake in a scene of three.js.

import {
  type Camera,
  Color,
  Frustum,
  type GeometryGroup,
  Group,
  type JSONMeta,
  type Material,
  Matrix4,
  type Mesh,
  MeshBasicMaterial,
  type Object3DJSON,
  Object3D,
  type Scene,
  type Texture,
  type WebGLRenderer,
} from "three";

import { Clones } from "./clones.js";
import { sortTriangles } from "./far_first.js";
import { type Filter, filtersOf } from "./filters.js";
import type { Lamp } from "./lamps.js";
import { layersOf, WHOLE } from "./layers.js";
import type { Manifest } from "./manifest.js";
import { depthMaterial, flatMaterial, hasAlpha, type Nodes, plainLook, RadTexMaterial, type Surface } from "./material.js";
import { RadTexMirror } from "./mirror.js";
import type { Bake, MaterialImages } from "./parts.js";
import { Problem, report } from "./problem.js";
import { changedSun, FIRST_SUN, shine, type Sun, type SunUniforms, sunUniforms } from "./sun.js";
import type { BakeTexture } from "./textures.js";

const NONE: ReadonlyMap<string, BakeTexture> = new Map();

/** A mesh of the bake, as the .glb has it, the number of its material, the images that this is shown by, and whether it hides what lies behind. */
export interface BakedMesh {
  mesh: Mesh;
  number: number;
  images?: MaterialImages;
  opaque?: boolean;
}

/**
 * A bake: its meshes, where they stood in Blender (three.js's axes, y up), with their materials. It may be moved, turned
 * and scaled like any object; the light moves along. Until its textures are there it shows its flat lightmap.
 */
export class RadTexObject extends Group implements Bake {
  readonly isRadTexObject = true;
  readonly meshes: readonly Mesh[];
  readonly sun: SunUniforms = sunUniforms();
  readonly images: ReadonlyMap<number, MaterialImages>;
  /** Why the textures cannot be shown, if so: the flat lightmap stays. */
  problem: Problem | null = null;
  /** The flat lightmap, one colour a texel. */
  readonly flat: Surface;
  /** What the light of each lamp is multiplied by, by the lamp's name: change the colours as you like. */
  readonly lamps: ReadonlyMap<string, Color>;
  /** Where it was loaded from: what toJSON keeps of it. */
  address: string | null = null;
  private added: readonly Lamp[] = [];
  private found: ReadonlyMap<string, BakeTexture> | null = null;
  private chosen: { filter: Filter; layer: string };
  private shining: Readonly<Sun> = FIRST_SUN;
  private covering = 1;
  private readonly look = plainLook();
  private readonly numbers = new Map<Mesh, number>();
  private readonly opaque: ReadonlySet<number>;
  private readonly materials = new Map<string, Surface>();
  private readonly baked: Matrix4;
  private readonly clones: Clones;
  private readonly reported = new Set<string>();
  private depth: Material | null = null; // of what fades
  private depthDrawn: { frame: number; camera: Camera | null } = { frame: -1, camera: null };
  private plain: MeshBasicMaterial | null = null; // for a renderer that does not know ours
  private drawnBy: object | null = null; // of nodes
  private refused: Problem | null = null; // why it does not draw them

  /**
   * `map` is the flat lightmap's texture. The meshes, which have the same matrix, are taken out of their parents; those of
   * a clone of `original` have none. `nodes` make the materials for WebGPURenderer, in the place of WebGLRenderer's.
   */
  constructor(
    private current: Manifest,
    private readonly parts: readonly BakedMesh[],
    private readonly map: Texture,
    lamps: readonly string[] = [],
    private readonly nodes: Nodes | null = null,
    original: RadTexObject | null = null,
  ) {
    super();
    this.lamps = new Map(lamps.map((name) => [name, new Color(1, 1, 1)]));
    this.name = current.name;
    this.meshes = parts.map(({ mesh }) => mesh);
    const [first] = this.meshes;
    if (!first) throw new Error("a bake needs a mesh");
    this.baked = (original?.baked ?? first.matrixWorld).clone();
    this.images = new Map(parts.flatMap(({ number, images }) => (images ? [[number, images] as const] : [])));
    this.opaque = new Set(parts.filter((part) => part.opaque).map(({ number }) => number));
    this.flat = (nodes?.flat ?? flatMaterial)(current, map, this.baked, this.look);
    this.clones = original?.clones ?? new Clones(map, this.images.values());
    this.clones.members.add(this);
    for (const { mesh, number } of parts) {
      this.numbers.set(mesh, number);
      if (mesh.parent) this.attach(mesh);
      else this.add(mesh);
      mesh.material = this.flat;
      mesh.onBeforeRender = (renderer, scene, camera) => this.beforeMesh(mesh, renderer, scene, camera);
    }
    this.chosen = { filter: filtersOf(current).at(-1) as Filter, layer: WHOLE };
    shine(this.sun, this.shining);
  }

  /** What the bake's own light is multiplied by, before lamps are added to it. */
  get own(): Color {
    return this.look.own;
  }

  /** What all its light is multiplied by, the lamps' too. */
  get tint(): Color {
    return this.look.tint;
  }

  /** The number that all its light is multiplied by, as by a renderer's `toneMappingExposure`: 2 is a stop more. */
  get exposure(): number {
    return this.look.exposure.value;
  }

  set exposure(exposure: number) {
    this.look.exposure.value = exposure;
  }

  /** How much it hides of what lies behind it, 0 to 1, where it is opaque: below 1 it is drawn among what is transparent. */
  get opacity(): number {
    return this.covering;
  }

  set opacity(opacity: number) {
    this.covering = opacity;
    for (const material of [this.flat, ...this.materials.values(), this.plain]) if (material) this.cover(material);
  }

  get manifest(): Manifest {
    return this.current;
  }

  /** The bake's textures, by name; none before they are loaded. */
  get textures(): ReadonlyMap<string, BakeTexture> {
    return this.found ?? NONE;
  }

  /** The bakes of its lamps, in the order of `lamps`; none before they are loaded. */
  get lampBakes(): readonly Bake[] {
    return this.added.map(({ bake }) => bake);
  }

  /** How textures can be filtered, the best last. */
  get filters(): Filter[] {
    return filtersOf(this.current);
  }

  get filter(): Filter {
    return this.chosen.filter;
  }

  set filter(filter: Filter) {
    if (!this.filters.includes(filter)) throw new Error(`no filter ${filter}: there are ${this.filters.join(", ")}`);
    this.chosen = { ...this.chosen, filter };
    this.show();
  }

  /** What can be shown: "whole", the export's layers, and "sum" of base and rest. */
  get lightLayers(): string[] {
    return layersOf(this.current);
  }

  get lightLayer(): string {
    return this.chosen.layer;
  }

  set lightLayer(layer: string) {
    if (!this.lightLayers.includes(layer)) throw new Error(`no layer ${layer}: there are ${this.lightLayers.join(", ")}`);
    this.chosen = { ...this.chosen, layer };
    this.show();
  }

  /** The sun that lights bakes of some kinds, in the scene's world. */
  get sunlight(): Readonly<Sun> {
    return this.shining;
  }

  /** Change some of the sun's settings. */
  setSun(change: Partial<Sun>): void {
    this.shining = changedSun(this.shining, change);
    shine(this.sun, this.shining);
  }

  /** Bytes of all textures: on the GPU, and as files. */
  get memory(): { gpu: number; files: number } {
    const all = this.everyTexture();
    const sum = (values: number[]): number => values.reduce((total, each) => total + each, 0);
    return { gpu: sum(all.map(({ bytes }) => bytes)), files: sum(all.map(({ fileBytes }) => fileBytes)) };
  }

  /** The number of a mesh's material, as the bake counts them. */
  numberOf(mesh: Mesh): number {
    return this.numbers.get(mesh) ?? 0;
  }

  /** The material of a mesh by the filter and layer that are set; the flat lightmap before there are textures. */
  materialOf(mesh: Mesh): Surface {
    if (!this.found || this.refused) return this.flat;
    const { filter, layer } = this.chosen;
    const number = this.numberOf(mesh);
    const key = `${filter} ${layer} ${number}`;
    const material = this.materials.get(key) ?? this.made(number);
    this.materials.set(key, material);
    return material;
  }

  private made(number: number): Surface {
    const { added: lamps, baked, filter, lightLayer: layer, look } = this;
    const opaque = this.opaque.has(number);
    const options = { filter, layer, number, baked, lamps, look, opaque };
    const material = this.nodes?.surface(this, options) ?? new RadTexMaterial(this, options);
    this.cover(material);
    return material;
  }

  /** Give a material the object's opacity. */
  private cover(material: Material): void {
    material.opacity = this.covering;
    const { blended } = (material === this.plain ? this.flat : material) as Surface;
    material.transparent = this.covering < 1 || blended;
  }

  /** Show these textures of the same surface, and lamps', from now on, and free those from before that nobody else shows. */
  take(manifest: Manifest, textures: ReadonlyMap<string, BakeTexture>, lamps: readonly Lamp[] = this.added): void {
    for (const texture of texturesOf([{ textures }, ...lamps.map(({ bake }) => bake)])) texture.use();
    this.forget();
    this.current = manifest;
    const { filters, lightLayers, chosen } = this;
    this.chosen = { // what the former export had, this one may lack
      filter: filters.includes(chosen.filter) ? chosen.filter : (filters.at(-1) as Filter),
      layer: lightLayers.includes(chosen.layer) ? chosen.layer : WHOLE,
    };
    this.found = textures;
    this.added = lamps;
    this.show();
  }

  /** Put the textures onto the GPU of the renderer, a WebGPURenderer with nodes, now, not when it first draws the object. */
  prepare(renderer: WebGLRenderer): void {
    for (const texture of this.everyTexture()) {
      if (this.nodes) this.nodes.upload(texture, renderer);
      else texture.upload(renderer);
    }
    this.show();
  }

  /** Show the flat lightmap, and free materials and the textures that no other object shows. */
  forget(): void {
    for (const texture of this.everyTexture()) texture.release();
    for (const material of this.materials.values()) material.dispose();
    this.materials.clear();
    this.found = null;
    this.added = [];
    this.show();
  }

  /** Free all that it has on the GPU; what its clones show, too, is freed with the last of them. */
  dispose(): void {
    this.forget();
    this.flat.dispose();
    this.depth?.dispose();
    this.plain?.dispose();
    this.clones.leave(this);
  }

  /**
   * Another one in the same place, with the same textures and geometry, and with its own transform, tint, exposure, opacity,
   * sun and lamps. Textures that are still loading come to both.
   */
  override clone(recursive = true): this {
    const parts = this.parts.map(({ mesh, ...facts }) => ({ ...facts, mesh: mesh.clone(recursive) }));
    const made = new RadTexObject(this.current, parts, this.map, [...this.lamps.keys()], this.nodes, this);
    Object3D.prototype.copy.call(made, this, false);
    made.address = this.address;
    made.problem = this.problem;
    made.own.copy(this.own);
    made.tint.copy(this.tint);
    made.exposure = this.exposure;
    made.opacity = this.opacity;
    made.setSun(this.sunlight);
    for (const [name, colour] of this.lamps) made.lamps.get(name)?.copy(colour);
    made.chosen = { ...this.chosen };
    if (this.found) made.take(this.current, this.found, made.lampsOf(this.lampBakes));
    const others = recursive ? this.children.filter((child) => !this.numbers.has(child as Mesh)) : [];
    for (const child of others) {
      if (!(child instanceof RadTexMirror)) made.add(child.clone(recursive));
      else if (made.textures.size) made.add(child.clone(recursive, made));
    }
    return made as this;
  }

  /** Its place and settings, and the address that it is loaded from; not its meshes and textures, which lie there. */
  override toJSON(meta?: JSONMeta): Object3DJSON {
    const short = new Group().copy(this, false) as Group;
    short.uuid = this.uuid;
    if (short.matrixAutoUpdate) short.updateMatrix();
    const { address, exposure, opacity } = this;
    const colours = { own: this.own.toArray(), tint: this.tint.toArray() };
    short.userData = { ...this.userData, radtex: { address, ...colours, exposure, opacity } };
    short.children = this.children.filter((child) => !this.numbers.has(child as Mesh) && !(child instanceof RadTexMirror));
    return short.toJSON(meta);
  }

  /** Have it and its clones show these textures, and lamps', as they were loaded. */
  receive(textures: ReadonlyMap<string, BakeTexture>, lamps: readonly Bake[]): void {
    for (const each of this.clones.members) {
      if (!each.plain) each.problem = null;
      each.take(each.current, textures, each.lampsOf(lamps));
    }
  }

  /** Have it and its clones keep to the flat lightmap. */
  refuse(problem: Problem): void {
    for (const each of this.clones.members) each.problem = problem;
  }

  /** Load its textures by `reload` whenever the graphics device was taken away and came back. */
  recoverBy(reload: () => Promise<void>): void {
    this.clones.reload = reload;
  }

  /** Keep why it cannot be drawn as it should, and tell the console, once. Never throws: that would end the page's frames. */
  readonly failed = (problem: Problem): void => {
    this.problem = problem;
    if (problem.ofDevice) queueMicrotask(() => this.forget()); // after this frame
    if (this.reported.has(problem.message)) return;
    this.reported.add(problem.message);
    report(problem);
  };

  private lampsOf(bakes: readonly Bake[]): Lamp[] {
    const colours = [...this.lamps.values()];
    const { images } = this;
    return bakes.map((bake, place) => ({ bake: { ...bake, images }, colour: colours[place] as Color }));
  }

  /** The bake's textures and the lamps'. */
  private everyTexture(): BakeTexture[] {
    return texturesOf([this, ...this.lampBakes]);
  }

  /** Give the meshes the materials that are set. */
  private show(): void {
    for (const texture of this.everyTexture()) {
      if (texture.entry.arrangement === "slices") texture.blendLevels(this.filter === "levels");
    }
    this.refuseNodes(this.nodes && this.refusal());
    for (const mesh of this.meshes) mesh.material = this.plain ?? this.materialOf(mesh);
  }

  /** A renderer is about to draw a mesh. */
  private beforeMesh(mesh: Mesh, renderer: WebGLRenderer, scene: Scene, camera: Camera): void {
    if (this.nodes || !("isWebGLRenderer" in renderer)) return this.beforeNodes(mesh, renderer, scene, camera);
    this.clones.watch(renderer.domElement);
    if (!(mesh.material as Material).transparent) return;
    // Of a hull in folds the nearest side alone is seen: drawn first, it hides the others.
    const hull = this.current.bake.kind === "proxy";
    if (hull || this.isClear(mesh)) sortTriangles(mesh, camera, hull);
    else if (this.isFading(mesh)) this.drawDepth(mesh, renderer, scene, camera);
  }

  /** Whether some of a mesh is clear; else it fades as a whole. */
  private isClear(mesh: Mesh): boolean {
    return hasAlpha(this.current) && !this.opaque.has(this.numberOf(mesh));
  }

  private isFading(mesh: Mesh): boolean {
    const { opacity, transparent } = mesh.material as Material;
    return transparent && opacity > 0 && opacity < 1 && !this.isClear(mesh);
  }

  /** Before the first of its meshes in a picture, draw the depth of all that fade, so that none shows through another. */
  private drawDepth(first: Mesh, renderer: WebGLRenderer, scene: Scene, camera: Camera): void {
    const { calls, frame = calls } = renderer.info.render; // WebGPURenderer counts what it renders as calls
    if (this.depthDrawn.frame === frame && this.depthDrawn.camera === camera) return;
    this.depthDrawn = { frame, camera };
    const { nodes } = this;
    this.depth ??= nodes ? nodes.depth(this.flat.side) : depthMaterial(this.current, this.baked);
    const seen = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    const view = new Frustum().setFromProjectionMatrix(seen, renderer.coordinateSystem, camera.reversedDepth);
    for (const mesh of this.meshes) {
      const drawn = mesh.visible && mesh.layers.test(camera.layers) && (!mesh.frustumCulled || view.intersectsObject(mesh));
      if (mesh !== first && (!drawn || !this.isFading(mesh))) continue;
      const { clippingPlanes, clipIntersection } = mesh.material as Material;
      Object.assign(this.depth, { clippingPlanes, clipIntersection });
      if (nodes) nodes.drawDepth(renderer, mesh, scene, camera, this.depth);
      else renderer.renderBufferDirect(camera, scene, mesh.geometry, this.depth, mesh, null as unknown as GeometryGroup);
    }
  }

  /** A renderer that takes nodes is about to draw a mesh, or one that does not, though the object has some. */
  private beforeNodes(mesh: Mesh, renderer: WebGLRenderer, scene: Scene, camera: Camera): void {
    this.drawnBy = renderer;
    const problem = this.refusal();
    if (problem && !(this.nodes && "backend" in renderer)) return this.showPlainly(problem);
    this.refuseNodes(problem);
    if (problem || !(mesh.material as Material).transparent) return;
    const hull = this.current.bake.kind === "proxy";
    if (hull || this.isClear(mesh)) sortTriangles(mesh, camera, hull);
    else if (this.isFading(mesh)) this.drawDepth(mesh, renderer, scene, camera);
  }

  /** Why the renderer cannot show the radiance, if so; null also before it has drawn the object. */
  private refusal(): Problem | null {
    const { drawnBy, nodes } = this;
    if (!drawnBy) return null;
    const isOfNodes = !("isWebGLRenderer" in drawnBy);
    if (isOfNodes && nodes) return this.found && nodes.refusal(this, this.lightLayer, drawnBy);
    return isOfNodes
      ? new Problem(
          `${this.name} is shown by its flat lightmap: WebGPURenderer does not take RadTex’s shaders, which are GLSL`,
          "Load it with `nodes` of radtex-three/webgpu, or draw it by three.js’s WebGLRenderer.",
        )
      : new Problem(
          `${this.name} is shown by its flat lightmap: it was loaded with nodes, which WebGLRenderer does not take`,
          "Load it without `nodes`, or draw it by WebGPURenderer.",
        );
  }

  /** Keep to the flat lightmap for this reason, or for none any longer. */
  private refuseNodes(problem: Problem | null): void {
    const before = this.refused;
    this.refused = problem;
    if (problem?.message === before?.message) return;
    if (problem) this.failed(problem);
    else if (this.problem === before) this.problem = null;
    queueMicrotask(() => this.show()); // after this frame
  }

  /** Show the flat lightmap by a material that every renderer knows, and say why. */
  private showPlainly(problem: Problem): void {
    const told = this.plain !== null;
    this.plain ??= new MeshBasicMaterial({ map: this.map, side: this.flat.side });
    this.plain.color.copy(this.tint).multiply(this.own).multiplyScalar(this.exposure / (this.current.flat_scale || 1));
    if (told) return;
    this.cover(this.plain);
    this.failed(problem);
    queueMicrotask(() => this.show()); // after this frame
  }
}

/** All textures of some bakes. */
function texturesOf(bakes: readonly Pick<Bake, "textures">[]): BakeTexture[] {
  return bakes.flatMap(({ textures }) => [...textures.values()]);
}
