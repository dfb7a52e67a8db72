// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// A bake in a scene of three.js.

import { Color, Group, type Material, Matrix4, type Mesh, type ShaderMaterial, type Texture, type WebGLRenderer } from "three";

import { sortTriangles } from "./far_first.js";
import { type Filter, filtersOf } from "./filters.js";
import type { Lamp } from "./lamps.js";
import { layersOf, WHOLE } from "./layers.js";
import type { Manifest } from "./manifest.js";
import { flatMaterial, RadTexMaterial } from "./material.js";
import type { Bake, MaterialImages } from "./parts.js";
import type { Problem } from "./problem.js";
import { changedSun, FIRST_SUN, shine, type Sun, type SunUniforms, sunUniforms } from "./sun.js";
import type { BakeTexture } from "./textures.js";

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
  /** Why the textures cannot be shown on this device, if so: the flat lightmap stays. */
  problem: Problem | null = null;
  /** The flat lightmap, one colour a texel. */
  readonly flat: ShaderMaterial;
  /** What the bake's own light is multiplied by, where lamps are added to it. */
  readonly own = new Color(1, 1, 1);
  /** What the light of each lamp is multiplied by, by the lamp's name: change the colours as you like. */
  readonly lamps: ReadonlyMap<string, Color>;
  private added: readonly Lamp[] = [];
  private found: ReadonlyMap<string, BakeTexture> | null = null;
  private chosen: { filter: Filter; layer: string };
  private shining: Readonly<Sun> = FIRST_SUN;
  private readonly numbers = new Map<Mesh, number>();
  private readonly opaque: ReadonlySet<number>;
  private readonly materials = new Map<string, RadTexMaterial>();
  private readonly baked: Matrix4;

  /** `map` is the flat lightmap's texture. The meshes, which have the same matrix, are taken out of their parents. */
  constructor(
    private current: Manifest,
    parts: readonly BakedMesh[],
    map: Texture,
    lamps: readonly string[] = [],
  ) {
    super();
    this.lamps = new Map(lamps.map((name) => [name, new Color(1, 1, 1)]));
    this.name = current.name;
    this.meshes = parts.map(({ mesh }) => mesh);
    const [first] = this.meshes;
    if (!first) throw new Error("a bake needs a mesh");
    this.baked = first.matrixWorld.clone();
    this.images = new Map(parts.flatMap(({ number, images }) => (images ? [[number, images] as const] : [])));
    this.opaque = new Set(parts.filter((part) => part.opaque).map(({ number }) => number));
    this.flat = flatMaterial(current, map, this.baked);
    for (const { mesh, number } of parts) {
      this.numbers.set(mesh, number);
      this.attach(mesh);
      mesh.material = this.flat;
      mesh.onBeforeRender = (_renderer, _scene, camera) => {
        const material = mesh.material as Material;
        // Of a hull in folds the nearest side alone is seen: drawn first, it hides the others.
        if (material.transparent) sortTriangles(mesh, camera, this.manifest.bake.kind === "proxy");
      };
    }
    this.chosen = { filter: filtersOf(current).at(-1) as Filter, layer: WHOLE };
    shine(this.sun, this.shining);
  }

  get manifest(): Manifest {
    return this.current;
  }

  /** The bake's textures, by name; none before they are loaded. */
  get textures(): ReadonlyMap<string, BakeTexture> {
    return this.found ?? new Map();
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
  materialOf(mesh: Mesh): ShaderMaterial {
    if (!this.found) return this.flat;
    const { filter, layer } = this.chosen;
    const number = this.numberOf(mesh);
    const key = `${filter} ${layer} ${number}`;
    const material = this.materials.get(key) ?? this.made(number);
    this.materials.set(key, material);
    return material;
  }

  private made(number: number): RadTexMaterial {
    const { added: lamps, baked, filter, lightLayer: layer, own } = this;
    const opaque = this.opaque.has(number);
    return new RadTexMaterial(this, { filter, layer, number, baked, lamps, own, opaque });
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

  /** Put the textures onto the renderer's GPU now, not when it first draws the object. */
  prepare(renderer: WebGLRenderer): void {
    for (const texture of this.everyTexture()) texture.upload(renderer);
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

  /** Free all that it has on the GPU. */
  dispose(): void {
    this.forget();
    for (const mesh of this.meshes) mesh.geometry.dispose();
    (this.flat.uniforms["u_flat"]?.value as Texture).dispose();
    for (const { base, metal, bump } of this.images.values()) for (const each of [base, metal, bump]) each?.dispose();
    this.flat.dispose();
  }

  /** The bake's textures and the lamps'. */
  private everyTexture(): BakeTexture[] {
    return texturesOf([this, ...this.added.map(({ bake }) => bake)]);
  }

  /** Not to be had: it throws. */
  override clone(): never {
    throw new Error("a RadTexObject has no clone(): make an InstancedMesh of its meshes, or clone these");
  }

  /** Give the meshes the materials that are set. */
  private show(): void {
    for (const texture of this.everyTexture()) {
      if (texture.entry.arrangement === "slices") texture.blendLevels(this.filter === "levels");
    }
    for (const mesh of this.meshes) mesh.material = this.materialOf(mesh);
  }
}

/** All textures of some bakes. */
function texturesOf(bakes: readonly Pick<Bake, "textures">[]): BakeTexture[] {
  return bakes.flatMap(({ textures }) => [...textures.values()]);
}
