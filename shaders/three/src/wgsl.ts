// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Lookups for WebGPU: the WGSL that ships with every export, with what one bake has.

import type { Texture } from "three";

import bucketLookups from "../../radtex.wgsl";
import layeredLookups from "../../radtex_layered.wgsl";
import throughLookups from "../../radtex_layered_through.wgsl";
import pageLookups from "../../radtex_pages.wgsl";
import type { Filter } from "./filters.js";
import { WHOLE } from "./layers.js";
import { STEADY } from "./manifest.js";
import { type Bake, layeredFacts, needed } from "./parts.js";
import layeredLight from "./shaders/layered.wgsl";
import imagesLight from "./shaders/layered_images.wgsl";
import throughLight from "./shaders/layered_through.wgsl";

/** A function of a shader, and what it reads: its text has names of its own, which give way to the renderer's. */
export interface Lookups {
  text: string;
  /** The function's name. */
  call: string;
  textures: [string, Texture][];
  /** Vectors of four numbers, one behind the other, by the name of what holds them: one, or an array. */
  vectors: [string, number[]][];
  /** Other uniforms of three.js's, by their names. */
  numbers: [string, unknown][];
}

// What uniforms of WebGL are in WGSL.
const RENAMED: Record<string, string> = {
  radtex_material: "radtex_of.curves",
  radtex_lobes: "radtex_of.lobes",
  radtex_gloss: "radtex_of.gloss",
  radtex_brush: "radtex_of.brush",
  radtex_images: "radtex_images",
};
const BOUND = /^@group\(1\) @binding\(\d+\) var(?:<uniform>)? (\w+): .*$/gm;
const STRUCTS = /^struct (Radtex(?:Bake|Material|Through)) \{\n([\s\S]*?)^\}$/gm;
const HELD: Record<string, string> = { RadtexBake: "radtex", RadtexMaterial: "radtex_of", RadtexThrough: "radtex_exit" };

/** What of a bake there is no WGSL for, in words; null if there is. */
export function wgslRefuses({ lampBakes, manifest: { bake } }: Bake, layer: string): string | null {
  if (layer !== WHOLE) return `single layers (“${layer}”)`;
  if (lampBakes?.length) return "lamps";
  return bake.kind === "shadow" || bake.kind === "transfer" ? `bakes of kind ${bake.kind}` : null;
}

/** The lookups of a bake's material, whole, where `wgslRefuses` has no reason against it. */
export function wgslOf(bake: Bake, filter: Filter, material: number): Lookups {
  return bake.manifest.bake.layout === "layered" ? layered(bake, material) : buckets(bake, filter);
}

function buckets({ manifest: { bake }, textures }: Bake, filter: Filter): Lookups {
  const { entry, isArray, texture } = needed(textures, bake.kind);
  const slices = entry.arrangement === "slices";
  const { levels, pages = [1, 1], page_texels: page = entry.texels } = entry;
  const texels = `vec2i(${entry.texels.join(", ")})`;
  const paged = isArray && !slices;
  const read = paged ? `radiance_map, vec4i(${[...pages, ...page].join(", ")})` : "radiance_map, radiance_map_sampler";
  const way = paged ? "paged" : "filtered";
  const modes: Partial<Record<Filter, string>> = { nearest: "RADTEX_NEAREST", linear: "RADTEX_LINEAR" };
  const found = slices
    ? filter === "levels" ? `radtex_slices(${read}, ${bake.bucket}, uv, I)` : `radtex_slices_level(${read}, ${bake.bucket}, uv, I, 0.0)`
    : filter === "levels"
      ? `radtex_sample_level_${way}(${read}, ${texels}, ${bake.bucket}, uv, I, radtex_level(uv, ${texels}, ${levels}))`
      : `radtex_sample_${way}(${read}, ${texels}, ${bake.bucket}, uv, I, ${modes[filter] ?? "RADTEX_QUADRILINEAR"})`;
  const light = `
fn radtex_seen(place: vec3f, uv: vec2f, images: vec2f, normal: vec3f, tangent: vec4f, V: vec3f) -> vec4f {
    let I = radtex_incidence(V, normal, tangent.xyz, tangent.w);
    let seen = ${found};
    return ${bake.kind === "ao" ? "vec4f(seen.aaa, 1.0)" : "seen"};  // of ao, alpha is how much is open
}
`;
  const text = [bucketLookups, paged ? pageLookups : "", light].join("\n");
  return { text, call: "radtex_seen", textures: [["radiance_map", texture]], vectors: [], numbers: [] };
}

function layered(bake: Bake, material: number): Lookups {
  const { defines, uniforms } = layeredFacts(bake, "mesh", material);
  const through = "RADTEX_THROUGH" in defines;
  const light = "RADTEX_IMAGES" in defines ? imagesLight : through ? throughLight : layeredLight;
  const steady = throughLookups.replace("radtex_layered(uv, position, N, V)", `radtex_layered_steady(uv, position, N, V, ${STEADY})`);
  const source = [layeredLookups, through ? steady : "", light].join("\n");
  const textures: [string, Texture][] = [];
  const vectors = new Map<string, number[]>();
  for (const [name, { value }] of Object.entries(uniforms)) {
    if (name.endsWith("_map")) textures.push([name, value as Texture]);
    else vectors.set(nameOf(name), value as number[]);
  }
  // What the bake lacks is never read, but must be there.
  const [spare] = textures[0] as [string, Texture];
  const lacking = new Map<string, string>();
  for (const [, name = ""] of source.matchAll(BOUND)) if (name.endsWith("_map") && !(name in uniforms)) lacking.set(name, spare);
  for (const [, struct = "", fields = ""] of source.matchAll(STRUCTS)) {
    for (const [, field = ""] of fields.matchAll(/^ *(\w+):/gm)) {
      const name = `${HELD[struct]}.${field}`;
      if (!vectors.has(name)) vectors.set(name, [0, 0, 0, 0]);
    }
  }
  lacking.set("radtex_filtering", "radtex_irradiance_map_sampler").set("RADTEX_STEADY", String(STEADY));
  const text = source
    .replace(/^override (\w+): (\w+) = ([^;]+);/gm, (_, name: string, type: string, value: string) => {
      const given = name in defines ? (type === "bool" ? "true" : String(defines[name])) : value;
      return `const ${name}: ${type} = ${given};`;
    })
    .replace("textureSampleLevel(image, radtex_filtering, uv * range.xy, 0.0)", "textureSample(image, radtex_filtering, uv * range.xy)")
    .replace(STRUCTS, "")
    .replace(BOUND, "")
    .replace(/\b\w+\b/g, (name) => lacking.get(name) ?? name);
  return { text, call: "radtex_seen", textures, vectors: [...vectors], numbers: [] };
}

function nameOf(uniform: string): string {
  const through = /^radtex_(?:through_(colour_range|rest_range|rest_tile)|(field_\w+))$/.exec(uniform);
  if (through) return `radtex_exit.${through[1] ?? through[2]}`;
  const exit = /^radtex_exit_(\w+)$/.exec(uniform);
  return RENAMED[uniform] ?? (exit ? `radtex_exit.${exit[1]}` : uniform.replace("radtex_", "radtex."));
}
