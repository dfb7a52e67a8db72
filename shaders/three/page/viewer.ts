// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The picture: camera, mesh, and drawing it by its light, by its flat lightmap, or by both side by side.

import {
  Box3,
  type BufferAttribute,
  type BufferGeometry,
  FloatType,
  Matrix3,
  Matrix4,
  type Mesh,
  NoBlending,
  PerspectiveCamera,
  Raycaster,
  Scene,
  Sphere,
  Spherical,
  Vector2,
  Vector3,
  type WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

import type { Filter } from "../src/filters";
import type { RadTexScene } from "../src/load";
import type { Manifest } from "../src/manifest";
import type { Surface } from "../src/material";
import { type MirrorState, RadTexMirror } from "../src/mirror";
import type { RadTexObject } from "../src/radtex_object";
import type { Sun } from "../src/sun";
import type { BakeTexture } from "../src/textures";
import { type Tone, TONE_MAPPINGS, TONES } from "./tones";
import { type Standpoint, standpointIn, Walk } from "./walking";

/** A point of the surface, in the page's world, and how it lies there. */
export interface SurfacePoint {
  place: Vector3;
  /** v grows upwards, as in Blender. */
  uv: [number, number];
  /** Of the images that the material is shown by, if any; v grows downwards, as in glTF. */
  images: [number, number];
  normal: [number, number, number];
  /** Its fourth number is the bitangent's sign. */
  tangent: [number, number, number, number];
  /** The number of its material. */
  material: number;
  /** The bake that it is of. */
  part: RadTexObject;
}

const FOVY = 35; // degrees
const WALKING_FOVY = 65; // as one sees more of a room that one stands in
const WALKABLE = 1.5; // metres: the least radius of what one can be in
const NEAREST = 0.05; // metres that a walk comes near
const FILLED = 0.84; // of the free stage, by the first view
const FIRST_VIEW = new Vector3(0.45, 0.22, 1).normalize(); // Blender's front, a little from the right and above

export class Viewer {
  readonly camera = new PerspectiveCamera(FOVY);
  readonly controls: OrbitControls;
  /** Called after each frame that was drawn. */
  drawn: () => void = () => undefined;
  /** The ball that mirrors the bake, if the export has what it needs, once textures are there. */
  mirror: RadTexMirror | null = null;
  tone: Tone = "none";
  /** In stops. */
  exposure = 0;
  /** Where the flat lightmap begins, from the left, in shares of the width; null shows light alone. */
  divider: number | null = null;
  /** Frames a second while pictures follow one another, else null. */
  rate: number | null = null;

  readonly meshes: readonly Mesh[];
  private readonly scene = new Scene();
  private readonly owners = new Map<Mesh, RadTexObject>();
  private readonly ball: Sphere;
  private scheduled = 0;
  private before = 0; // when the last frame was, in milliseconds
  private flowing = false; // one frame asks for the next
  private scripted = false;
  private walk: Walk | null = null;
  private standpoint: Standpoint | null = null; // once it was asked for
  private covered = { right: 0, bottom: 0 }; // CSS pixels of the stage under cards

  constructor(
    readonly renderer: WebGLRenderer,
    readonly stage: HTMLElement,
    readonly shown: Pick<RadTexScene, "name" | "object" | "parts">,
  ) {
    for (const part of shown.parts) for (const mesh of part.meshes) this.owners.set(mesh, part);
    this.meshes = [...this.owners.keys()];
    this.scene.add(shown.object);
    this.ball = new Box3().setFromObject(shown.object).getBoundingSphere(new Sphere());
    this.controls = new OrbitControls(this.camera, renderer.domElement);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.autoRotateSpeed = 1.5;
    this.controls.minDistance = this.ball.radius * 0.15;
    this.controls.maxDistance = this.ball.radius * 40;
    this.controls.addEventListener("change", () => this.invalidate());
    new ResizeObserver(() => this.resize()).observe(stage);
    this.setTone(this.tone);
    this.resize();
    this.scene.updateMatrixWorld(true);
    this.resetView();
  }

  /** The first bake of several. */
  get object(): RadTexObject {
    return this.shown.parts[0] as RadTexObject;
  }

  get manifest(): Manifest {
    return this.object.manifest;
  }

  /** Those of the bake that has most of them. */
  get filters(): Filter[] {
    return this.richest(({ filters }) => filters.length).filters;
  }

  get filter(): Filter {
    return this.richest(({ filters }) => filters.length).filter;
  }

  /** Those of the bake that has most of them. */
  get layers(): string[] {
    return this.richest(({ lightLayers }) => lightLayers.length).lightLayers;
  }

  get layer(): string {
    return this.richest(({ lightLayers }) => lightLayers.length).lightLayer;
  }

  get sun(): Readonly<Sun> {
    return this.object.sunlight;
  }

  /** Bytes of all textures: on the GPU, and as files. */
  get memory(): [number, number] {
    const all = [...new Set(this.shown.parts.flatMap(({ textures }) => [...textures.values()]))];
    return [all.reduce((sum, { bytes }) => sum + bytes, 0), all.reduce((sum, { fileBytes }) => sum + fileBytes, 0)];
  }

  /** Show these textures of the first bake; camera, filter and all else stay as they are. */
  take(manifest: Manifest, textures: ReadonlyMap<string, BakeTexture>): void {
    this.object.take(manifest, textures);
    this.completed();
  }

  /** The object's textures have come, or are looked up in another way. */
  completed(): void {
    const state = this.mirror?.state;
    if (this.mirror) {
      this.object.remove(this.mirror);
      this.mirror.dispose();
      this.mirror = null;
    }
    if (this.manifest.mirror && this.object.textures.size) {
      this.mirror = new RadTexMirror(this.object, this.object.filter);
      this.object.add(this.mirror);
      if (state) this.mirror.set(state);
    }
    this.invalidate();
  }

  /** Draw soon. */
  invalidate(): void {
    this.scheduled ||= requestAnimationFrame((now) => this.frame(now));
  }

  setFilter(filter: Filter): void {
    if (!this.filters.includes(filter)) throw new Error(`no filter ${filter}: there are ${this.filters.join(", ")}`);
    for (const part of this.shown.parts) if (part.filters.includes(filter)) part.filter = filter;
    this.completed(); // the mirror ball looks up in the same way
  }

  setLayer(layer: string): void {
    if (!this.layers.includes(layer)) throw new Error(`no layer ${layer}: there are ${this.layers.join(", ")}`);
    for (const part of this.shown.parts) if (part.lightLayers.includes(layer)) part.lightLayer = layer;
    this.invalidate();
  }

  setTone(tone: Tone): void {
    if (!TONES.includes(tone)) throw new Error(`no tone curve ${tone}: there are ${TONES.join(", ")}`);
    this.tone = tone;
    this.renderer.toneMapping = TONE_MAPPINGS[tone];
    this.invalidate();
  }

  setExposure(stops: number): void {
    this.exposure = Math.min(10, Math.max(-10, stops));
    this.renderer.toneMappingExposure = 2 ** this.exposure;
    this.invalidate();
  }

  setSun(change: Partial<Sun>): void {
    for (const part of this.shown.parts) part.setSun(change);
    this.invalidate();
  }

  /** Turn the sun by degrees, to the right about the vertical and up: it goes round, but not over the top. */
  turnSun(right: number, up: number): void {
    const { azimuth, height } = this.sun;
    this.setSun({ azimuth: ((((azimuth + right + 180) % 360) + 360) % 360) - 180, height: height + up });
  }

  setDivider(share: number | null): void {
    this.divider = share === null ? null : Math.min(1, Math.max(0, share));
    this.invalidate();
  }

  setMirror(change: Partial<MirrorState>): void {
    this.mirror?.set(change);
    this.invalidate();
  }

  setTurning(turning: boolean): void {
    if (this.walk) this.setWalking(false);
    this.controls.autoRotate = turning;
    this.invalidate();
  }

  /** Whether what is shown is large enough to walk in. */
  get walkable(): boolean {
    return this.ball.radius >= WALKABLE && !this.scripted;
  }

  get walking(): boolean {
    return this.walk !== null;
  }

  /** Walk through what is shown, or orbit around it again. */
  setWalking(walking: boolean): void {
    if (walking === this.walking || (walking && !this.walkable)) return;
    this.walk?.end();
    this.walk = null;
    this.controls.autoRotate = false;
    this.controls.enabled = !walking;
    this.camera.fov = walking ? WALKING_FOVY : FOVY;
    if (walking) {
      this.standpoint ??= standpointIn(this.meshes);
      const again = (): void => this.invalidate();
      this.walk = new Walk(this.camera, this.meshes, this.standpoint, this.renderer.domElement, again);
    } else this.lookAround();
    this.invalidate();
  }

  /** Walk on from the floor under a place of the canvas, in CSS pixels; whether there is one. */
  standAt(x: number, y: number): boolean {
    const point = this.walk && this.pick(x, y);
    return point ? (this.walk?.stand(point.place, point.normal) ?? false) : false;
  }

  /** Keep the object in the middle of what cards leave free, in CSS pixels from the right and the bottom. */
  setCovered(right: number, bottom: number): void {
    this.covered = { right, bottom };
    this.frameView();
    this.invalidate();
  }

  /** The middle of what is free, in shares of the width. */
  get middle(): number {
    return (1 - this.covered.right / Math.max(1, this.stage.clientWidth)) / 2;
  }

  /** The first view: of a room from inside, of all else as a whole. */
  resetView(): void {
    if (this.walkable) this.standpoint ??= standpointIn(this.meshes);
    const indoors = this.walkable && this.standpoint?.indoors === true;
    if (this.walking) this.setWalking(false);
    if (indoors) this.setWalking(true);
    else this.lookAround();
  }

  /** The whole object, seen from its front. */
  private lookAround(): void {
    const { clientWidth: width, clientHeight: height } = this.stage;
    const high = Math.tan((FOVY / 2) * (Math.PI / 180));
    const freely = [(width - this.covered.right) / height, (height - this.covered.bottom) / height];
    const [right, up] = freely.map((share) => high * share * FILLED) as [number, number];
    const turn = new Matrix4().lookAt(FIRST_VIEW, new Vector3(), new Vector3(0, 1, 0)).transpose();
    const corner = new Vector3();
    let away = this.ball.radius * 0.1;
    for (const mesh of this.meshes) {
      const places = mesh.geometry.getAttribute("position") as BufferAttribute;
      for (let vertex = 0; vertex < places.count; vertex++) {
        corner.fromBufferAttribute(places, vertex).applyMatrix4(mesh.matrixWorld).sub(this.ball.center);
        corner.applyMatrix4(turn);
        away = Math.max(away, corner.z + Math.max(Math.abs(corner.x) / right, Math.abs(corner.y) / up));
      }
    }
    this.controls.enableDamping = false; // ends what motion is left
    this.controls.update();
    this.controls.enableDamping = true;
    this.controls.target.copy(this.ball.center);
    this.camera.position.copy(FIRST_VIEW).multiplyScalar(away).add(this.ball.center);
    this.controls.update();
    this.invalidate();
  }

  /** Orbit by angles in radians and come nearer by a factor. */
  orbit(across: number, up: number, nearer = 1): void {
    if (this.walk) return;
    const offset = this.camera.position.clone().sub(this.controls.target);
    const ball = new Spherical().setFromVector3(offset);
    ball.theta += across;
    ball.phi = Math.min(Math.PI - 0.01, Math.max(0.01, ball.phi - up));
    ball.radius = Math.min(this.controls.maxDistance, Math.max(this.controls.minDistance, ball.radius / nearer));
    this.camera.position.copy(this.controls.target).add(offset.setFromSpherical(ball));
    this.controls.update();
    this.invalidate();
  }

  /** A camera of the script's: its matrix in the page's world, row by row, its angle of view, and pixels. */
  setCamera(matrix: number[], fovy: number, width: number, height: number): void {
    this.walk?.end();
    this.walk = null;
    this.scripted = true;
    this.controls.enabled = false;
    this.controls.autoRotate = false;
    new Matrix4().fromArray(matrix).transpose().decompose(this.camera.position, this.camera.quaternion, new Vector3());
    this.camera.fov = (fovy * 180) / Math.PI;
    this.camera.clearViewOffset();
    this.camera.aspect = width / height;
    this.renderer.setPixelRatio(1);
    this.renderer.setSize(width, height);
    this.draw();
  }

  /** The surface under a place of the canvas, in CSS pixels from its upper left corner; null beside it. */
  pick(x: number, y: number): SurfacePoint | null {
    const { clientWidth: width, clientHeight: height } = this.renderer.domElement;
    const caster = new Raycaster();
    caster.setFromCamera(new Vector2((x / width) * 2 - 1, 1 - (y / height) * 2), this.camera);
    const [hit] = caster.intersectObjects<Mesh>([...this.meshes], false);
    if (!hit?.face || !hit.barycoord) return null;
    const { geometry, matrixWorld } = hit.object;
    const corners = [hit.face.a, hit.face.b, hit.face.c];
    const between = (name: string): number[] => interpolated(geometry, name, corners, hit.barycoord?.toArray() ?? []);
    const [u = 0, v = 0] = between("uv");
    const [nx, ny, nz] = between("normal") as [number, number, number];
    const [tx, ty, tz, sign] = between("tangent") as [number, number, number, number];
    const turn = new Matrix3().setFromMatrix4(matrixWorld);
    const mirrored = Math.sign(turn.determinant());
    const normal = new Vector3(nx, ny, nz).applyMatrix3(turn.clone().invert().transpose());
    const tangent = new Vector3(tx, ty, tz).applyMatrix3(turn);
    return {
      place: hit.point,
      uv: [u, 1 - v],
      images: geometry.hasAttribute("uv_images") ? (between("uv_images") as [number, number]) : [0, 0],
      normal: normal.normalize().toArray(),
      tangent: [...tangent.normalize().toArray(), sign * mirrored],
      material: this.ownerOf(hit.object).numberOf(hit.object),
      part: this.ownerOf(hit.object),
    };
  }

  /** Draw now, and not again in the frame that was asked for. */
  draw(): void {
    cancelAnimationFrame(this.scheduled);
    this.frame(performance.now());
  }

  private paint(): void {
    const { renderer } = this;
    const { width, height } = renderer.getSize(new Vector2());
    this.setDepths();
    renderer.setScissorTest(false);
    renderer.clear();
    const edge = this.divider === null ? width : Math.round(width * this.divider);
    renderer.setScissorTest(true);
    if (edge > 0) {
      renderer.setScissor(0, 0, edge, height);
      this.render((mesh) => this.ownerOf(mesh).materialOf(mesh));
    }
    if (edge < width) {
      renderer.setScissor(edge, 0, width - edge, height);
      this.render((mesh) => this.ownerOf(mesh).flat);
    }
    renderer.setScissorTest(false);
    this.drawn();
  }

  /** The light of each pixel, linear, (height, width, 4) with the upper row first; 0 beside the object. */
  pixels(flat = false): { width: number; height: number; values: Float32Array } {
    const { renderer } = this;
    const { width, height } = renderer.getDrawingBufferSize(new Vector2());
    const target = new WebGLRenderTarget(width, height, { type: FloatType });
    const materialOf = (mesh: Mesh): Surface => {
      const part = this.ownerOf(mesh);
      return flat ? part.flat : part.materialOf(mesh);
    };
    const materials = [...new Set(this.meshes.map(materialOf))];
    const blendings = materials.map(({ blending }) => blending);
    for (const material of materials) material.blending = NoBlending; // many devices do not blend floats
    renderer.setRenderTarget(target);
    renderer.clear();
    this.render(materialOf);
    const below = new Float32Array(width * height * 4);
    renderer.readRenderTargetPixels(target, 0, 0, width, height, below);
    renderer.setRenderTarget(null);
    target.dispose();
    materials.forEach((material, place) => (material.blending = blendings[place] ?? material.blending));
    const values = new Float32Array(below.length);
    for (let row = 0; row < height; row++) {
      values.set(below.subarray((height - 1 - row) * width * 4, (height - row) * width * 4), row * width * 4);
    }
    return { width, height, values };
  }

  private render(materialOf: (mesh: Mesh) => Surface): void {
    for (const mesh of this.meshes) {
      mesh.material = materialOf(mesh);
    }
    if (this.meshes.some((mesh) => this.isHull(mesh))) {
      const materials = new Set(this.meshes.filter((mesh) => this.isHull(mesh)).map(materialOf));
      for (const material of materials) material.colorWrite = false; // first the depths: of a hull in folds nothing is
      this.renderer.render(this.scene, this.camera); // seen but its nearest side
      for (const material of materials) material.colorWrite = true;
    }
    this.renderer.render(this.scene, this.camera);
  }

  /** The bake that has most of something, of several such the first. */
  private richest(count: (part: RadTexObject) => number): RadTexObject {
    return this.shown.parts.reduce((best, part) => (count(part) > count(best) ? part : best));
  }

  private ownerOf(mesh: Mesh): RadTexObject {
    return this.owners.get(mesh) as RadTexObject;
  }

  private isHull(mesh: Mesh): boolean {
    return this.ownerOf(mesh).manifest.bake.kind === "proxy";
  }

  private frame(now: number): void {
    this.scheduled = 0;
    // Which also asks for the next frame.
    const moving = this.walk ? this.walk.advance(now) : this.controls.enabled && this.controls.update();
    const mirroring = this.mirror?.advance(now) ?? false;
    const rate = 1000 / Math.max(1, now - this.before);
    this.before = now;
    this.rate = !this.flowing ? null : this.rate === null ? rate : this.rate + (rate - this.rate) * 0.15;
    this.paint();
    if (moving || this.controls.autoRotate || mirroring) this.invalidate();
    this.flowing = this.scheduled !== 0;
    if (!this.flowing) this.rate = null;
  }

  /** Have the object between the camera's planes, as tightly as depth wants. */
  private setDepths(): void {
    const away = this.camera.position.distanceTo(this.ball.center);
    const { mirror } = this;
    const out = mirror ? mirror.position.distanceTo(this.ball.center) + mirror.scale.x * 1.01 : 0;
    const radius = Math.max(this.ball.radius, out);
    this.camera.near = Math.max(this.walk ? NEAREST : radius / 200, (away - radius) * 0.9);
    this.camera.far = (away + radius) * 1.1;
    this.camera.updateProjectionMatrix();
  }

  private resize(): void {
    if (this.scripted) return;
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (!width || !height) return;
    this.camera.aspect = width / height;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height);
    this.frameView();
    this.invalidate();
  }

  /** Shift the picture towards what is free. */
  private frameView(): void {
    if (this.scripted) return;
    const { clientWidth: width, clientHeight: height } = this.stage;
    const { right, bottom } = this.covered;
    if (width && height) this.camera.setViewOffset(width, height, right / 2, bottom / 2, width, height);
  }
}

/** A vertex attribute between three vertices. */
function interpolated(geometry: BufferGeometry, name: string, corners: number[], weights: number[]): number[] {
  const attribute = geometry.getAttribute(name) as BufferAttribute | undefined;
  if (!attribute) return [];
  return Array.from({ length: attribute.itemSize }, (_, component) =>
    corners.reduce((sum, corner, place) => sum + (weights[place] ?? 0) * attribute.getComponent(corner, component), 0),
  );
}
