// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Lamps that were baked alone, mixed by the shader: light adds up.

import type { Color } from "three";

import type { Filter } from "./filters.js";
import { WHOLE } from "./layers.js";
import { type Bake, type Parts, partsOf, type Uniforms } from "./parts.js";

/** The bake of one lamp on the same surface, and what its light is multiplied by. */
export interface Lamp {
  bake: Bake;
  colour: Color;
}

// All names that lookups define or use of each other's; GLSL's own are in lower case, or begin with GL_.
const OURS =
  /\b(?:radtex\w*|RADTEX\w*|Radtex\w*|u_\w+|light|base_light|stored_cell|of_blender|surface_place|surface_images|to_sun|(?!GL_)[A-Z][A-Z_]+)\b/g;

/** Lookups that add lamps to a bake's own light, which is multiplied by u_own: GLSL with a function `light_of_lamps`. */
export function lampParts(lamps: readonly Lamp[], filter: Filter, number: number): Parts {
  const all: Parts[] = lamps.map(({ bake, colour }, place) => {
    const [lookups, uniforms] = partsOf(bake, filter, "mesh", WHOLE, number);
    return renamed([lookups, { ...uniforms, u_colour: { value: colour } }], `lamp${place}_`);
  });
  const added = all.map((_, place) => {
    const name = `lamp${place}_`;
    return `#ifdef ${name}LAYERED
    ${name}surface_place = place;
#endif
#ifdef ${name}RADTEX_IMAGES
    ${name}surface_images = surface_images;
#endif
    found += ${name}u_colour * ${name}light(uv, normal, tangent, V).rgb;`;
  });
  const declared = all.map((_, place) => `uniform vec3 lamp${place}_u_colour;`);
  const body = `#define LAMPS
uniform vec3 u_own;
vec3 light_of_lamps(vec3 own, vec3 place, vec2 uv, vec3 normal, vec4 tangent, vec3 V) {
    vec3 found = u_own * own;
${added.join("\n")}
    return found;
}`;
  const lookups = [...all.map(([text]) => text), ...declared, body].join("\n");
  return [lookups, Object.assign({}, ...all.map(([, uniforms]) => uniforms) as Uniforms[])];
}

/** What these lookups read of the bakes of lamps. */
export function lampUniforms(bakes: readonly Bake[], filter: Filter, number: number): Uniforms {
  const all = bakes.map((bake, place) => renamed(partsOf(bake, filter, "mesh", WHOLE, number), `lamp${place}_`)[1]);
  return Object.assign({}, ...all) as Uniforms;
}

/** The same lookups under other names, so that one shader holds them beside others. */
function renamed([lookups, uniforms]: Parts, prefix: string): Parts {
  const named = Object.entries(uniforms).map(([name, value]) => [`${prefix}${name}`, value]);
  return [lookups.replace(OURS, (name) => `${prefix}${name}`), Object.fromEntries(named)];
}
