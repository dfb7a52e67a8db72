// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// How each layout and kind is looked up: the shaders that ship with every export, and what they are given.

import { DataTexture, type Texture } from "three";

import bucketLookups from "../../radtex.glsl";
import shadowLookups from "../../radtex_shadow.glsl";
import layeredLookups from "../../radtex_layered.glsl";
import throughLookups from "../../radtex_layered_through.glsl";
import transferLookups from "../../radtex_transfer.glsl";
import type { Filter } from "./filters.js";
import { BASE, bucketsOf, SUM, WHOLE } from "./layers.js";
import { type Manifest, ofOneLobe, type ShaderFacts, type Sidecar, STEADY, type UniformValues } from "./manifest.js";
import { Problem } from "./problem.js";
import bucketLight from "./shaders/buckets.glsl";
import layeredLight from "./shaders/layered.glsl";
import shadowLight from "./shaders/shadow.glsl";
import transferLight from "./shaders/transfer.glsl";
import type { SunUniforms } from "./sun.js";
import type { BakeTexture } from "./textures.js";

// The layers in whose place a material's own images are read; and what stands for an image that it does not have.
const OF_IMAGES = ["colour", "tint", "normal"];
const WHITE = new DataTexture(new Uint8Array([255, 255, 255, 255]), 1, 1);
WHITE.needsUpdate = true;

/** What is drawn: the mesh, the inspector's picture of one bucket, or its three pixels of numbers. */
export type Stage = "mesh" | "bucket" | "probe";

/** The same, or the mirror ball. */
type Drawn = Stage | "mirror";

export type Uniforms = Record<string, { value: unknown }>;

/** GLSL with a function `light`, and its uniforms. */
export type Parts = [string, Uniforms];

/** A material's own images, as the .glb has them: base colour, metal in blue, and the normal map. */
export interface MaterialImages {
  base: Texture | null;
  metal: Texture | null;
  bump: Texture | null;
}

/** A bake with its textures, and the sun that lights some kinds. */
export interface Bake {
  manifest: Manifest;
  textures: ReadonlyMap<string, BakeTexture>;
  sun: SunUniforms;
  /** Of the materials that are shown by their own images, by their numbers. */
  images?: ReadonlyMap<number, MaterialImages> | undefined;
  /** Told why its textures cannot be drawn; without it the console is. */
  failed?: (problem: Problem) => void;
  /** The bakes of the lamps that are added to it by now, in the order of their names. */
  lampBakes?: readonly Bake[];
}

/** How a bake is looked up, by a filter. */
export function partsOf(shown: Bake, filter: Filter, stage: Drawn, layer: string, material: number): Parts {
  const { manifest, textures, sun } = shown;
  const { bake } = manifest;
  if (bake.layout === "layered") return layeredParts(shown, stage, material);
  const loaded = needed(textures, bucketsOf(layer, bake.kind));
  if (bake.kind === "shadow") return shadowParts(bake, loaded, sun, stage);
  if (bake.kind === "transfer") return transferParts(bake, loaded, sun, stage);
  const [defines, uniforms] = layerParts(bake, textures, layer);
  const [lookups, own] = bucketParts(bake, loaded, filter, stage);
  return [[...defines, lookups].join("\n"), { ...own, ...uniforms }];
}

/** What a layer changes: the base is an image, and what covers is the whole's to say. */
function layerParts(bake: Sidecar, textures: ReadonlyMap<string, BakeTexture>, layer: string): [string[], Uniforms] {
  if (layer === WHOLE) return [[], {}];
  const whole = needed(textures, bake.kind);
  const uniforms: Uniforms = { u_whole: { value: whole.texture } };
  const defines = [
    layer === BASE ? "#define BASE_ALONE" : "",
    layer === SUM ? "#define BASE_ADDED" : "",
    layer === "normal" ? "#define NORMALS" : "",
    whole.entry.format === "RGBA16F" ? "#define COVERED" : "",
  ];
  if (layer === BASE || layer === SUM) uniforms["u_base"] = { value: needed(textures, BASE).texture };
  return [defines, uniforms];
}

function bucketParts(bake: Sidecar, loaded: BakeTexture, filter: Filter, stage: Drawn): Parts {
  const { arrangement, levels, pages, page_texels: page, texels } = loaded.entry;
  const slices = arrangement === "slices";
  const modes: Partial<Record<Filter, string>> = { nearest: "RADTEX_NEAREST", linear: "RADTEX_LINEAR" };
  const defines = [
    "#define RADTEX_HARDWARE_LINEAR",
    `#define SAMPLER ${loaded.isArray ? "sampler2DArray" : "sampler2D"}`,
    `#define FILTER ${modes[filter] ?? "RADTEX_QUADRILINEAR"}`,
    slices ? "#define SLICES" : "",
    loaded.isArray && !slices ? "#define RADTEX_PAGES" : "",
    filter === "levels" ? `#define LEVELS ${levels}` : "",
    stage === "bucket" ? "#define STORED" : "",
    bake.kind === "ao" ? "#define AMBIENT" : "",
  ];
  const uniforms: Uniforms = {
    u_radiance: { value: loaded.texture },
    u_texels: { value: texels },
    u_bucket: { value: bake.bucket },
    u_pages: { value: [...(pages ?? [1, 1]), ...(page ?? texels)] },
  };
  return [[...defines, bucketLookups, bucketLight].join("\n"), uniforms];
}

function shadowParts(bake: Sidecar, loaded: BakeTexture, sun: SunUniforms, stage: Drawn): Parts {
  const defines = [
    "#define RADTEX_NO_DERIVATIVES",
    "#define SUNLIT",
    loaded.isArray ? "#define RADTEX_SHADOW_LAYERS" : "",
    stage === "bucket" ? "#define STORED" : "",
  ];
  const uniforms: Uniforms = {
    u_bits: { value: loaded.texture },
    u_texels: { value: bake.texels },
    u_bucket: { value: bake.bucket },
    ...sun,
  };
  return [[...defines, bucketLookups, shadowLookups, shadowLight].join("\n"), uniforms];
}

function transferParts(bake: Sidecar, loaded: BakeTexture, sun: SunUniforms, stage: Drawn): Parts {
  const { pages, page_texels: page, texels } = loaded.entry;
  const views = bake.transfer?.views ?? 1;
  const defines = [
    "#define RADTEX_NO_DERIVATIVES",
    "#define SUNLIT",
    "#define SPHERE",
    `#define SAMPLER ${loaded.isArray ? "sampler2DArray" : "sampler2D"}`,
    loaded.isArray ? "#define RADTEX_PAGES" : "",
    views > 1 ? "#define AROUND" : "",
    stage === "bucket" ? "#define STORED" : "",
  ];
  const uniforms: Uniforms = {
    u_transfer: { value: loaded.texture },
    u_texels: { value: bake.texels },
    u_bucket: { value: bake.bucket },
    u_views: { value: views },
    u_pages: { value: [...(pages ?? [1, 1]), ...(page ?? texels)] },
    ...sun,
  };
  return [[...defines, bucketLookups, transferLookups, transferLight].join("\n"), uniforms];
}

function layeredParts(bake: Bake, stage: Drawn, material: number): Parts {
  const { defines, uniforms } = layeredFacts(bake, stage, material);
  const told = Object.entries(defines).map(([name, value]) => `#define ${name} ${value}`);
  // The surface's frame is for the inspector alone.
  const framed = stage === "bucket" || stage === "probe";
  const through = "RADTEX_THROUGH" in defines;
  const lookups = [framed ? bucketLookups : "", layeredLookups, through ? throughLookups : "", layeredLight];
  return [["#define LAYERED", ...told, ...lookups].join("\n"), uniforms];
}

/** What lookups of a layered bake are told, and what they read: textures, and vectors of four numbers one behind the other. */
export function layeredFacts(
  { manifest, textures, images: own }: Bake,
  stage: Drawn,
  material: number,
): { defines: Record<string, number | string>; uniforms: Uniforms } {
  const facts = manifest.shader as ShaderFacts;
  const values = stage === "mirror" ? ofAll(facts.materials) : (facts.materials[material] ?? {});
  const defines: Record<string, number | string> = { ...facts.defines };
  if (stage === "mirror") defines["RADTEX_MATERIALS"] = facts.materials.length;
  else Object.assign(defines, ofOneLobe(values));
  const uniforms: Uniforms = { ...valued(facts.values), ...valued(values) };
  const ofImages = "radtex_images" in values && stage !== "mirror";
  for (const layer of facts.layers) {
    if (ofImages && OF_IMAGES.includes(layer)) continue;
    uniforms[`radtex_${layer}_map`] = { value: needed(textures, layer).texture };
  }
  if (ofImages) {
    const images = own?.get(material);
    defines["RADTEX_IMAGES"] = "";
    uniforms["radtex_base_map"] = { value: images?.base ?? WHITE };
    uniforms["radtex_metal_map"] = { value: images?.metal ?? WHITE };
    uniforms["radtex_bump_map"] = { value: images?.bump ?? WHITE };
  }
  if (stage === "mesh") defines["RADTEX_STEADY"] = STEADY;
  else defines["RADTEX_NO_DERIVATIVES"] = ""; // a picture of one point has none
  return { defines, uniforms };
}

/** The values of all materials, one behind the other. */
function ofAll(materials: UniformValues[]): UniformValues {
  const names = Object.keys(materials[0] ?? {});
  return Object.fromEntries(names.map((name) => [name, materials.flatMap((each) => (each[name] ?? []).flat())]));
}

function valued(values: UniformValues): Uniforms {
  return Object.fromEntries(Object.entries(values).map(([name, value]) => [name, { value: value.flat() }]));
}

/** A texture by its name. Throws a Problem if the manifest names none. */
export function needed(textures: ReadonlyMap<string, BakeTexture>, name: string): BakeTexture {
  const loaded = textures.get(name);
  if (loaded) return loaded;
  const others = [...textures.values()].map(({ entry }) => entry.file).join(", ") || "no texture";
  throw new Problem(`There is no texture “${name}”: the manifest names ${others}`, "Export the object again.");
}
