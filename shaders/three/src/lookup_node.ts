// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The lookup of a bake as a node of three.js's: text of RadTex's shaders, which reads what three.js binds.

import { type Camera, type Color, DataArrayTexture, DataTexture, type Texture, Vector2, Vector3, Vector4 } from "three";
import * as TSL from "three/tsl";
import { CodeNode, Node } from "three/webgpu";

import { type Filter, filtersOf } from "./filters.js";
import { type GpuRenderer, uploadByNodes } from "./gpu_textures.js";
import { type Lamp, lampParts } from "./lamps.js";
import { WHOLE } from "./layers.js";
import type { Look, MaterialOptions } from "./material.js";
import { type Bake, partsOf, type Uniforms } from "./parts.js";
import { type Problem, report } from "./problem.js";
import type { SunUniforms } from "./sun.js";
import { uploadForFrame } from "./textures.js";
import { type Lookups, wgslOf, wgslRefuses } from "./wgsl.js";

/** A node, or its builder: three.js's types do not know builders, and take each step of an expression for another type. */
export type Nodal = any;
export const tsl = TSL as Nodal;

/** What nodes are updated with. */
export interface Frame {
  camera: Camera;
}

/** What a fragment knows of its place: nodes, in the world of the bake, in glTF's axes. */
export interface Place {
  place: Nodal;
  uv: Nodal;
  images: Nodal;
  normal: Nodal;
  tangent: Nodal;
  V: Nodal;
  /** A direction in the scene's world, in that of the bake. */
  turned: (direction: Nodal) => Nodal;
}

// What is read in the place of textures that are gone.
const NO_IMAGE = new DataTexture(new Uint8Array(4), 1, 1);
const NO_SLICES = new DataArrayTexture(new Uint8Array(4), 1, 1, 1);
NO_IMAGE.needsUpdate = NO_SLICES.needsUpdate = true;

const WRAPPER = `
#ifdef SUNLIT
uniform vec3 u_sun_here;
#endif
vec4 radtex_seen(vec3 place, vec2 uv, vec2 images, vec3 normal, vec4 tangent, vec3 V) {
#ifdef LAYERED
    surface_place = place;
#endif
#ifdef RADTEX_IMAGES
    surface_images = images;
#endif
#ifdef SUNLIT
    to_sun = normalize(u_sun_here);
#endif
    vec4 seen = light(uv, normal, tangent, V);
#ifdef LAMPS
    seen.rgb = light_of_lamps(seen.rgb, place, uv, normal, tangent, V);
#endif
    return seen;
}`;

// What GLSL calls types, and three.js; others are samplers, or vectors of four numbers.
const NUMBERS: Record<string, string> = { int: "int", float: "float", vec3: "vec3", ivec2: "ivec2", ivec4: "ivec4" };
const DECLARED = /^[ \t]*uniform\s+(?:(?:highp|mediump|lowp)\s+)?(\w+)\s+([^;]+);/gm;

function filterOf({ manifest }: Bake, { filter }: MaterialOptions): Filter {
  return filter ?? (filtersOf(manifest).at(-1) as Filter);
}

/** The lookups of WebGL, which say what they read themselves. */
function lookupsOfGl(bake: Bake, options: MaterialOptions, look: Look, place: Place): Lookups {
  const { layer = WHOLE, lamps = [], number = 0 } = options;
  const chosen = filterOf(bake, options);
  const [text, uniforms] = partsOf(bake, chosen, "mesh", layer, number);
  const [more, further] = lamps.length ? lampParts(lamps, chosen, number) : ["", {}];
  const values: Uniforms = { ...uniforms, ...further, u_own: { value: look.own } };
  const found: Lookups = { text: "", call: "radtex_seen", textures: [], vectors: [], numbers: [] };
  const whole = [text, more, WRAPPER].join("\n");
  const types = new Map<string, string>();
  for (const [, type = "", names = ""] of whole.matchAll(DECLARED)) {
    for (const name of names.split(",")) types.set(name.trim().replace(/\[.*/, ""), type);
  }
  const sun = values["u_to_sun"] as SunUniforms["u_to_sun"] | undefined;
  if (sun) found.numbers.push(["u_sun_here", place.turned(sunlight(sun))]);
  for (const [name, type] of types) {
    const held = values[name];
    if (!held) continue; // the shader has it for bakes of another sort
    if (type === "vec4") found.vectors.push([name, [...(held.value as number[])]]);
    else if (type in NUMBERS) found.numbers.push([name, uniformOf(held, NUMBERS[type] as string)]);
    else found.textures.push([name, held.value as Texture]);
  }
  found.text = whole.replace(DECLARED, "");
  return found;
}

/** The direction towards the sun, in the scene's world. */
function sunlight(sun: SunUniforms["u_to_sun"]): Nodal {
  const direction = new Vector3();
  return tsl.uniform(direction).onObjectUpdate(() => direction.fromArray(sun.value));
}

/** A uniform that has what `held` has by now. */
function uniformOf(held: { value: unknown }, type: string): Nodal {
  const vectors = [Vector2, Vector3, Vector4];
  const { value } = held;
  if (Array.isArray(value)) {
    const made = new (vectors[value.length - 2] as typeof Vector4)(...(value as [number, number, number, number]));
    return tsl.uniform(made, type).onObjectUpdate(() => made.fromArray(held.value as number[]));
  }
  if (typeof value !== "number") return tsl.uniform(value, (value as Color).isColor ? "color" : type);
  return tsl.uniform(value, type).onObjectUpdate(() => held.value);
}

/** The textures of a bake and of its lamps, as they are now. */
function setsOf({ lampBakes = [], textures }: Bake): Bake["textures"][] {
  return [textures, ...lampBakes.map((lamp) => lamp.textures)];
}

const loads = new WeakMap<object, number>();
let counted = 0;

/** A number of the textures that a bake and its lamps have: of others, another one. */
export function loadOf(bake: Bake): string {
  const numbers = setsOf(bake).map((set) => {
    const number = loads.get(set) ?? ++counted;
    loads.set(set, number);
    return number;
  });
  return numbers.join(" ");
}

/** Looks the light of a bake up. */
export class LookupNode extends Node {
  static get type(): string {
    return "RadTexLookupNode";
  }

  private lookups: Lookups | null = null;
  private parts: { textures: Nodal[]; values: Nodal; numbers: Nodal[]; inputs: Nodal[] } | null = null;
  private readonly load: string;

  constructor(
    private readonly bake: Bake,
    private readonly options: MaterialOptions,
    private readonly place: Place,
    private readonly look: Look,
  ) {
    super("vec4" as Nodal);
    this.load = loadOf(bake);
    this.updateType = "object" as Nodal;
  }

  /** Where the bake has other textures by now, read none of those that are gone, and have the material built once more. */
  override update({ material }: Nodal): undefined {
    if (loadOf(this.bake) === this.load) return;
    for (const node of this.parts?.textures ?? []) node.value = node.value.isArrayTexture ? NO_SLICES : NO_IMAGE;
    material.needsUpdate = true;
  }

  setup(builder: Nodal): Nodal {
    const gpu = builder.renderer.backend.isWebGPUBackend === true;
    const { bake, look, options, place } = this;
    const { layer = WHOLE, number = 0 } = options;
    if (gpu && wgslRefuses(bake, layer)) return null; // the object tells it, and shows its flat lightmap
    if (!this.ready(builder.renderer)) return null;
    const lamps = this.lamps();
    const lookups = gpu
      ? wgslOf(bake, filterOf(bake, options), number)
      : lookupsOfGl(bake, { ...options, lamps }, look, place);
    this.lookups = lookups;
    const { uv, images, normal, tangent, V } = place;
    const packed = new Float32Array(lookups.vectors.flatMap(([, values]) => values));
    this.parts = {
      textures: lookups.textures.map(([, texture]) => tsl.texture(texture)),
      values: packed.length ? tsl.buffer(packed, "vec4", packed.length / 4) : null,
      numbers: lookups.numbers.map(([, node]) => node),
      inputs: [place.place, uv, images, normal, tangent, V],
    };
    const properties = builder.getNodeProperties(this);
    const children: Nodal[] = [...this.parts.textures, this.parts.values, ...this.parts.numbers, ...this.parts.inputs];
    children.forEach((node, position) => (properties[`part${position}`] = node));
    return null;
  }

  /** Whether all textures are on the renderer's device, where they are put. */
  private ready(renderer: GpuRenderer): boolean {
    const { bake } = this;
    const textures = setsOf(bake).flatMap((set) => [...set.values()]);
    let whole = bake.textures.size > 0;
    const failed = (problem: Problem): void => {
      whole = false;
      (bake.failed ?? report)(problem);
    };
    uploadForFrame(textures, renderer, failed, uploadByNodes);
    return whole;
  }

  /** The lamps, with the textures that they have by now. */
  private lamps(): Lamp[] {
    const { lampBakes = [] } = this.bake;
    return (this.options.lamps ?? []).map(({ bake, colour }, place) => ({ bake: { ...bake, ...lampBakes[place] }, colour }));
  }

  generate(builder: Nodal): string {
    const { lookups, parts } = this;
    if (!lookups || !parts) return builder.format("0.0", "float", "vec4") as string;
    const name = (node: Nodal): string => node.build(builder, "property") as string;
    const named = new Map<string, string>();
    lookups.textures.forEach(([own], place) => {
      const texture = name(parts.textures[place]);
      named.set(own, texture).set(`${own}_sampler`, `${texture}_sampler`);
    });
    lookups.numbers.forEach(([own], place) => named.set(own, name(parts.numbers[place])));
    const values = parts.values ? name(parts.values) : "";
    let first = 0;
    const arrays = new Map<string, string>();
    for (const [own, { length }] of lookups.vectors) {
      arrays.set(own, `${values}[${first} + `);
      named.set(own, `${values}[${first}]`);
      first += length / 4;
    }
    const renamed = (own: string): string => named.get(own) ?? own;
    const text = lookups.text
      .replace(/([\w.]+)\[/g, (whole, own: string) => arrays.get(own) ?? whole)
      .replace(/[A-Za-z_]\w*(?:\.\w+)?/g, (own) => named.get(own) ?? own.replace(/^\w+/, renamed));
    new CodeNode(text).build(builder);
    const types = ["vec3", "vec2", "vec2", "vec3", "vec4", "vec3"];
    return `${lookups.call}(${parts.inputs.map((node, place) => node.build(builder, types[place]) as string).join(", ")})`;
  }
}
