// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Materials of three.js that show a bake.

import {
  type Camera,
  Color,
  DoubleSide,
  FrontSide,
  type Material,
  Matrix4,
  type Mesh,
  type Scene,
  ShaderMaterial,
  type Side,
  type Texture,
  UniformsLib,
  UniformsUtils,
  type WebGLRenderer,
} from "three";

import type { Device } from "./device.js";
import { type Filter, filtersOf } from "./filters.js";
import { type Lamp, lampParts, lampUniforms } from "./lamps.js";
import { WHOLE } from "./layers.js";
import type { Manifest } from "./manifest.js";
import { type Bake, partsOf, type Parts } from "./parts.js";
import depth from "./shaders/depth.glsl";
import flatLight from "./shaders/flat.glsl";
import surface from "./shaders/surface.glsl";
import surfaceVertex from "./shaders/surface.vert.glsl";
import type { Problem } from "./problem.js";
import { type BakeTexture, uploadForFrame } from "./textures.js";

export interface MaterialOptions {
  /** How textures are filtered; by default the best that there is. */
  filter?: Filter;
  /** What is shown of the bake: "whole", one of its layers, or "sum". */
  layer?: string;
  /** Which of the baked object's materials it is, as the mesh says. */
  number?: number;
  /** Whether it hides what lies behind it, though the bake has clear materials, too. */
  opaque?: boolean;
  /** From the mesh's own space to the world of the bake. */
  baked?: Matrix4;
  /** Lamps whose light is added. */
  lamps?: readonly Lamp[];
  /** What its light is multiplied by; the material keeps to these very objects, which others may share. */
  look?: Look;
}

/** What a surface's light is multiplied by: its bake's own light, and then all of it, lamps' too. */
export interface Look {
  own: Color;
  tint: Color;
  exposure: { value: number };
}

/** A material of a baked surface, of WebGLRenderer's or of WebGPURenderer's. */
export type Surface = Material & {
  /** The colour that all its light is multiplied by. */
  readonly tint: Color;
  /** The number that all its light is multiplied by, as by `toneMappingExposure`: 2 is a stop more. */
  exposure: number;
  /** Whether what lies behind may be seen through it. */
  readonly blended: boolean;
};

/** Makes materials for WebGPURenderer: `nodes` of radtex-three/webgpu. */
export interface Nodes {
  surface: (bake: Bake, options: MaterialOptions) => Surface;
  flat: (manifest: Manifest, map: Texture, baked: Matrix4, look: Look) => Surface;
  /** What the device takes, as far as it is known before there is a renderer. */
  device: () => Device;
  /** Put a texture onto the renderer's device, once. Throws a Problem where it does not fit there. */
  upload: (texture: BakeTexture, renderer: unknown) => void;
  /** A material that draws depth alone; and draw a mesh with it, now. */
  depth: (side: Side) => Material;
  drawDepth: (renderer: unknown, mesh: Mesh, scene: Scene, camera: Camera, material: Material) => void;
  /** Why the renderer cannot show a bake's layer of light, if so. */
  refusal: (bake: Bake, layer: string, renderer: unknown) => Problem | null;
}

/** A look that changes nothing. */
export function plainLook(): Look {
  return { own: new Color(1, 1, 1), tint: new Color(1, 1, 1), exposure: { value: 1 } };
}

/** A material of a baked surface. `opacity` below 1 needs `transparent`, as in all of three.js's materials. */
export class SurfaceMaterial extends ShaderMaterial {
  get blended(): boolean {
    return "BLENDED" in this.defines;
  }

  /** The colour that all its light is multiplied by. */
  get tint(): Color {
    return this.uniforms["u_tint"]?.value as Color;
  }

  /** The number that all its light is multiplied by, as by `toneMappingExposure`: 2 is a stop more. */
  get exposure(): number {
    return this.uniforms["u_exposure"]?.value as number;
  }

  set exposure(exposure: number) {
    this.uniforms["u_exposure"]!.value = exposure;
  }

  /** As that of three.js, with the same textures: a copy of one that is not uploaded yet would stay empty. */
  override copy(source: this): this {
    super.copy(source);
    this.uniforms = { ...source.uniforms };
    for (const name of ["u_own", "u_tint"]) this.uniforms[name] = { value: (source.uniforms[name]?.value as Color).clone() };
    for (const name of ["u_exposure", "u_opacity"]) this.uniforms[name] = { value: source.uniforms[name]?.value as number };
    return this;
  }

  override onBeforeRender(_renderer: WebGLRenderer): void {
    const { opacity } = this;
    const uniform = this.uniforms["u_opacity"]!;
    if (uniform.value === opacity) return;
    uniform.value = opacity;
    this.uniformsNeedUpdate = true;
  }
}

/** The light of a bake, as it leaves its surface towards the camera. For a Mesh or an InstancedMesh of the bake's. */
export class RadTexMaterial extends SurfaceMaterial {
  readonly isRadTexMaterial = true;
  private bakes: readonly Bake[]; // its own, and its lamps'
  private way: { filter: Filter; layer: string; number: number };
  private read: { manifest: Manifest; textures: Bake["textures"] };

  constructor(bake: Bake, options: MaterialOptions = {}) {
    const { layer = WHOLE, number = 0, baked = new Matrix4(), lamps = [], look } = options;
    const clear = hasAlpha(bake.manifest) && !options.opaque;
    const filter = options.filter ?? (filtersOf(bake.manifest).at(-1) as Filter);
    super();
    this.bakes = [bake, ...lamps.map((lamp) => lamp.bake)];
    this.way = { filter, layer, number };
    this.read = { manifest: bake.manifest, textures: bake.textures };
    const [lookups, uniforms] = partsOf(bake, filter, "mesh", layer, number);
    const [more, further]: Parts = lamps.length ? lampParts(lamps, filter, number) : ["", {}];
    const parts: Parts = [[lookups, more].join("\n"), { ...uniforms, ...further }];
    assemble(this, parts, bake.manifest, clear, baked, look);
    if (options.opaque) this.defines["SOLID"] = "";
  }

  override copy(source: this): this {
    super.copy(source);
    this.bakes = source.bakes;
    this.way = source.way;
    this.read = source.read;
    return this;
  }

  override clone(): this {
    return new RadTexMaterial(this.bakes[0] as Bake).copy(this) as this;
  }

  override onBeforeRender(renderer: WebGLRenderer): void {
    super.onBeforeRender(renderer);
    const [first] = this.bakes;
    this.renew(first as Bake);
    for (const { textures } of this.bakes) uploadForFrame(textures.values(), renderer, first?.failed);
  }

  /** Read the textures that the bake and its lamps have by now, where they were loaded once more: instances keep their material. */
  private renew(bake: Bake): void {
    const { lampBakes = [], manifest, textures } = bake;
    if (textures === this.read.textures || !textures.size || manifest !== this.read.manifest) return;
    if (lampBakes.length !== this.bakes.length - 1) return;
    const { filter, layer, number } = this.way;
    const [, uniforms] = partsOf(bake, filter, "mesh", layer, number);
    Object.assign(uniforms, lampUniforms(lampBakes, filter, number));
    for (const [name, { value }] of Object.entries(uniforms)) this.uniforms[name]!.value = value;
    this.bakes = [bake, ...lampBakes];
    this.read = { manifest, textures };
    this.uniformsNeedUpdate = true;
  }
}

/** The flat lightmap on the mesh: what is seen until all textures are there. `map` is the .glb's own. */
export function flatMaterial(
  manifest: Manifest,
  map: Texture,
  baked = new Matrix4(),
  look: Look = plainLook(),
): SurfaceMaterial {
  const material = new SurfaceMaterial();
  const uniforms = { u_flat: { value: map }, u_flat_scale: { value: manifest.flat_scale || 1 } };
  const blended = manifest.bake.layout === "buckets";
  assemble(material, [flatLight, uniforms], manifest, blended, baked, look);
  return material;
}

/** Draws depth alone. */
export function depthMaterial(manifest: Manifest, baked: Matrix4): ShaderMaterial {
  const material = new ShaderMaterial({ vertexShader: surfaceVertex, fragmentShader: depth, colorWrite: false });
  material.uniforms["u_baked"] = { value: baked };
  material.clipping = true;
  material.side = sidesOf(manifest);
  return material;
}

/** Whether some of the bake is clear: what has no alpha is not blended. */
export function hasAlpha({ bake, textures }: Manifest): boolean {
  if (bake.layout === "layered") return Object.hasOwn(textures, "alpha");
  return Object.values(textures).some(({ format }) => format === "RGBA16F");
}

function assemble(
  material: ShaderMaterial,
  [lookups, uniforms]: Parts,
  manifest: Manifest,
  blended: boolean,
  baked: Matrix4,
  look = plainLook(),
): void {
  const { own, tint, exposure } = look;
  const multiplied = { u_own: { value: own }, u_tint: { value: tint }, u_exposure: exposure, u_opacity: { value: 1 } };
  const common = { ...UniformsUtils.clone(UniformsLib.fog), u_baked: { value: baked } };
  Object.assign(material.uniforms, common, uniforms, multiplied);
  material.vertexShader = surfaceVertex;
  material.fragmentShader = [lookups, surface].join("\n");
  material.fog = material.clipping = true;
  material.premultipliedAlpha = true;
  material.side = sidesOf(manifest);
  if (lookups.includes("#define SUNLIT")) material.defines["SUNLIT"] = "";
  if (lookups.includes("#define RADTEX_IMAGES")) material.defines["IMAGES"] = "";
  if (!blended) return;
  material.transparent = true;
  material.defines["BLENDED"] = "";
  // What is clear hides nothing, but in a hull, whose nearest side has it all.
  if (manifest.bake.kind !== "proxy") material.defines["CLEAR"] = "";
}

/** A hull shows its front alone: what is seen through it is in its texture; and so do faces with backs of their own. */
export function sidesOf(manifest: Manifest): Side {
  return manifest.bake.kind === "proxy" || manifest.culled ? FrontSide : DoubleSide;
}
