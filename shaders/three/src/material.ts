// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Materials of three.js that show a bake.

import {
  Color,
  CustomBlending,
  DoubleSide,
  FrontSide,
  Matrix4,
  OneFactor,
  OneMinusSrcAlphaFactor,
  ShaderMaterial,
  type Side,
  type Texture,
  UniformsLib,
  UniformsUtils,
  type WebGLRenderer,
} from "three";

import { type Filter, filtersOf } from "./filters.js";
import { type Lamp, lampParts } from "./lamps.js";
import { WHOLE } from "./layers.js";
import type { Manifest } from "./manifest.js";
import { type Bake, partsOf, type Parts } from "./parts.js";
import flatLight from "./shaders/flat.glsl";
import surface from "./shaders/surface.glsl";
import surfaceVertex from "./shaders/surface.vert.glsl";

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
  /** What the bake's own light is multiplied by, where there are lamps. */
  own?: Color;
}

/** The light of a bake, as it leaves its surface towards the camera. For a Mesh or an InstancedMesh of the bake's. */
export class RadTexMaterial extends ShaderMaterial {
  readonly isRadTexMaterial = true;
  private bakes: readonly Bake[];

  constructor(bake: Bake, options: MaterialOptions = {}) {
    const { layer = WHOLE, number = 0, baked = new Matrix4(), lamps = [], own = new Color(1, 1, 1) } = options;
    const clear = hasAlpha(bake) && !options.opaque;
    const filter = options.filter ?? (filtersOf(bake.manifest).at(-1) as Filter);
    super();
    this.bakes = [bake, ...lamps.map((lamp) => lamp.bake)];
    const [lookups, uniforms] = partsOf(bake, filter, "mesh", layer, number);
    const [more, further]: Parts = lamps.length ? lampParts(lamps, own, filter, number) : ["", {}];
    const parts: Parts = [[lookups, more].join("\n"), { ...uniforms, ...further }];
    assemble(this, parts, bake.manifest, clear, baked);
    if (options.opaque) this.defines["SOLID"] = "";
  }

  /** As that of three.js, with the same textures: a copy of one that is not uploaded yet would stay empty. */
  override copy(source: this): this {
    super.copy(source);
    this.uniforms = { ...source.uniforms };
    this.bakes = source.bakes;
    return this;
  }

  override clone(): this {
    return new RadTexMaterial(this.bakes[0] as Bake).copy(this) as this;
  }

  override onBeforeRender(renderer: WebGLRenderer): void {
    for (const { textures } of this.bakes) for (const texture of textures.values()) texture.upload(renderer);
  }
}

/** The flat lightmap on the mesh: what is seen until all textures are there. `map` is the .glb's own. */
export function flatMaterial(manifest: Manifest, map: Texture, baked = new Matrix4()): ShaderMaterial {
  const material = new ShaderMaterial();
  const uniforms = { u_flat: { value: map }, u_flat_scale: { value: manifest.flat_scale || 1 } };
  const blended = manifest.bake.layout === "buckets";
  assemble(material, [flatLight, uniforms], manifest, blended, baked);
  return material;
}

/** Whether some of the bake is clear: what has no alpha is not blended. */
function hasAlpha({ manifest, textures }: Bake): boolean {
  if (manifest.bake.layout === "layered") return textures.has("alpha");
  return [...textures.values()].some(({ entry }) => entry.format === "RGBA16F");
}

function assemble(
  material: ShaderMaterial,
  [lookups, uniforms]: Parts,
  manifest: Manifest,
  blended: boolean,
  baked: Matrix4,
): void {
  Object.assign(material.uniforms, UniformsUtils.clone(UniformsLib.fog), uniforms, { u_baked: { value: baked } });
  material.vertexShader = surfaceVertex;
  material.fragmentShader = [lookups, surface].join("\n");
  material.fog = material.clipping = true;
  material.side = sidesOf(manifest);
  if (lookups.includes("#define SUNLIT")) material.defines["SUNLIT"] = "";
  if (lookups.includes("#define RADTEX_IMAGES")) material.defines["IMAGES"] = "";
  if (!blended) return;
  material.transparent = true;
  material.premultipliedAlpha = true;
  material.defines["BLENDED"] = "";
  // What is clear hides nothing, but in a hull, whose nearest side has it all.
  if (manifest.bake.kind !== "proxy") material.defines["CLEAR"] = "";
  material.blending = CustomBlending;
  material.blendSrc = OneFactor;
  material.blendDst = OneMinusSrcAlphaFactor;
}

/** A hull shows its front alone: what is seen through it is in its texture; and so do faces with backs of their own. */
function sidesOf(manifest: Manifest): Side {
  return manifest.bake.kind === "proxy" || manifest.culled ? FrontSide : DoubleSide;
}
