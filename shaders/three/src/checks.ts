// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Whether a manifest, or the extension in a .glb, is such as RadTex writes. Anybody may have made it: before it is checked
// here, no file that it names is fetched, and nothing of it becomes part of a shader. The rules are those of docs/format.md,
// "What a reader refuses".

import { isKind } from "./kinds.js";

type Facts = Record<string, unknown>;
type Range = readonly [number, number];

const CONTAINERS = ["ktx2", "dds", "exr"];
const SEEN = ["radiance", "incident", "reflection", "proxy"]; // the kinds that the layered layout can hold
const LAYOUTS = ["buckets", "sphere", "layered"];
const FORMATS = [
  ...["RGBA16F", "RGB9E5", "BC6H", "BC3", "BC3_SRGB", "BC4", "BC5", "BC7", "BC7_SRGB", "RGBA8", "SRGB8_A8", "RGBA32F"],
  ...["R32UI", "RG32UI"],
];
const ARRANGEMENTS = ["matrix", "slices", "image", "words", "tree"];
const LAYERS = [
  ...["colour", "irradiance", "tint", "normal", "width", "alpha", "tangent", "own", "rest", "world", "plane", "things", "distances"],
  ...["exit_direction", "exit_place", "field", "through_colour", "through_rest"],
];
// What may be defined in a shader of the layered layout, and from which whole number to which.
const DEFINES = new Map<string, Range>([
  ...["TINT", "NORMAL", "WIDTH", "ALPHA", "TANGENT", "PLANE", "THINGS", "MIRRORS", "GLOSSES", "SHAPES", "BEHIND", "THROUGH"].map(
    (name): [string, Range] => [`RADTEX_${name}`, [1, 1]],
  ),
  ["RADTEX_FIELD", [1, 1]],
  ["RADTEX_SRGB", [1, 1]],
  ...["OWN_CELLS", "REST_CELLS", "EXIT_CELLS", "THROUGH_CELLS"].map((name): [string, Range] => [`RADTEX_${name}`, [1, 64]]),
  ["RADTEX_LAMPS", [0, 8]],
  ["RADTEX_SHELL", [2, 8]],
  ["RADTEX_BOXES", [1, 8]],
  ["RADTEX_STEPS", [0, 2]],
  ["RADTEX_SECOND_LOBE", [0, 1]],
  ["RADTEX_OWN_TAPS", [0, 4]],
  ["RADTEX_REST_TAPS", [3, 4]],
  ["RADTEX_EXIT_TAPS", [4, 16]],
]);
// Its uniforms of one vector; those of as many as there are lamps, planes or boxes; and those of each material, with their lengths.
const VECTORS = new Set([
  ...LAYERS.map((layer) => `radtex_${layer}_range`),
  ...["middle", "own_tile", "rest_tile", "exit_tile", "through_rest_tile", "world_levels", "plane_levels"].map(
    (name) => `radtex_${name}`,
  ),
  ...["things_levels", "distances_size", "plane_place", "plane_eye", "things_eye"].map((name) => `radtex_${name}`),
  ...["field_low", "field_size", "field_glass", "field_tint"].map((name) => `radtex_${name}`),
]);
const COUNTED = new Map([
  ["radtex_lamp_place", "RADTEX_LAMPS"],
  ["radtex_lamp_light", "RADTEX_LAMPS"],
  ["radtex_lamp_across", "RADTEX_LAMPS"],
  ["radtex_lamp_up", "RADTEX_LAMPS"],
  ["radtex_shell", "RADTEX_SHELL"],
  ["radtex_box_low", "RADTEX_BOXES"],
  ["radtex_box_high", "RADTEX_BOXES"],
]);
const OF_IMAGES = "radtex_images"; // of some materials alone
const OF_MATERIAL = new Map([
  ["radtex_material", 16],
  ["radtex_lobes", 32],
  ["radtex_gloss", 1],
  ["radtex_brush", 1],
  [OF_IMAGES, 3],
]);
const MOST_PIXELS = 16384;
const MOST_LAYERS = 2048;
const MOST_TEXELS = 1 << 24;
const MOST_VIEWS = 16;
const MOST_MATERIALS = 1024;
const MOST_TEXTURES = 64;
const MOST_CHARACTERS = 255;
// Folders, drives, wildcards, control characters, line separators: nothing of it is in a name.
const FORBIDDEN = /[<>:"/\\|?*\u0000-\u001f\u007f-\u009f\u2028\u2029]/;
const DEVICES = /^(con|prn|aux|nul|com[0-9]|lpt[0-9]) *(\.|$)/i;

/** Whether it is the name of a file beside the manifest that has this ending. */
export function isPlainFile(name: unknown, ending: string): name is string {
  return isPlainStem(name) && name.length <= MOST_CHARACTERS && name.endsWith(`.${ending}`);
}

/** Whether files may have names that begin so: it leads nowhere, and is one line of text. */
export function isPlainStem(name: unknown): name is string {
  if (typeof name !== "string" || !name.trim() || name.startsWith(".") || name.startsWith(" ")) return false;
  return !FORBIDDEN.test(name) && !DEVICES.test(name);
}

/** The first thing that is wrong with a manifest, as the end of a sentence; null if nothing is. */
export function problemOf(manifest: unknown): string | null {
  try {
    checkAll(objectAt({ manifest }, "manifest"));
    return null;
  } catch (error) {
    if (error instanceof Refused) return error.message;
    throw error;
  }
}

class Refused extends Error {}

function expect(fine: boolean, key: string, value: unknown, expected: string): asserts fine {
  const found = (JSON.stringify(value) ?? "missing").slice(0, 80);
  if (!fine) throw new Refused(`${JSON.stringify(key).slice(0, 80)} is ${found}, expected ${expected}`);
}

/** Do `act`; what it refuses is in `place`. */
function within<Result>(place: string, act: () => Result): Result {
  try {
    return act();
  } catch (error) {
    throw error instanceof Refused ? new Refused(`${error.message}, in ${place}`) : error;
  }
}

function checkAll(facts: Facts): void {
  wholeAt(facts, "version", 1, 1);
  expect(isPlainStem(facts["name"]), "name", facts["name"], "what its files are called");
  fileAt(facts, "mesh", "glb");
  fileAt(facts, "flat", "png");
  positiveAt(facts, "flat_scale");
  for (const key of ["culled", "images"]) {
    expect([undefined, true, false].includes(facts[key] as boolean), key, facts[key], "true or false");
  }
  const textures = objectAt(facts, "textures");
  within("“bake”", () => checkBake(objectAt(facts, "bake"), textures, "shader" in facts));
  const names = Object.keys(textures);
  expect(names.length >= 1 && names.length <= MOST_TEXTURES, "textures", names.length, `1 to ${MOST_TEXTURES}`);
  for (const name of names) {
    expect(/^[A-Za-z_]\w{0,39}$/.test(name), "textures", name, "names of layers");
    within(`the texture “${name}”`, () => checkTexture(objectAt(textures, name)));
  }
  if ("shader" in facts) {
    const materials = within("“shader”", () => checkShader(objectAt(facts, "shader"), textures));
    if ("material" in facts) wholeAt(facts, "material", 0, materials - 1);
  }
  if ("mirror" in facts) within("“mirror”", () => checkMirror(objectAt(facts, "mirror")));
}

function checkBake(bake: Facts, textures: Facts, hasShader: boolean): void {
  const { kind } = bake;
  expect(typeof kind === "string" && isKind(kind), "kind", kind, "a kind that is shown");
  const layout = choiceAt(bake, "layout", LAYOUTS);
  sizeAt(bake, "texels", MOST_TEXELS);
  wholeAt(bake, "bucket", 1, MOST_PIXELS);
  expect(hasShader || layout !== "layered", "shader", null, "an object");
  if (hasShader) choiceAt(bake, "kind", SEEN);
  else expect(Object.hasOwn(textures, kind), "textures", Object.keys(textures), `one of its kind, ${kind}`);
  const transfer = kind === "transfer" ? objectAt(bake, "transfer") : {};
  if ("views" in transfer) wholeAt(transfer, "views", 2, MOST_VIEWS);
}

function checkTexture(entry: Facts): void {
  fileAt(entry, "file", choiceAt(entry, "container", CONTAINERS));
  if ("uri" in entry) expect(decoded(entry["uri"]) === entry["file"], "uri", entry["uri"], "its file");
  choiceAt(entry, "format", FORMATS);
  const arrangement = choiceAt(entry, "arrangement", ARRANGEMENTS);
  const size = sizeAt(entry, "size", MOST_PIXELS);
  const page = sizeAt(entry, "page_texels", MOST_PIXELS);
  const pages = sizeAt(entry, "pages", MOST_LAYERS);
  const stored = sizeAt(entry, "stored", MOST_TEXELS);
  const texels = sizeAt(entry, "texels", MOST_TEXELS);
  const layers = wholeAt(entry, "layers", 1, MOST_LAYERS);
  wholeAt(entry, "levels", 1, Math.floor(Math.log2(Math.max(...size))) + 1);
  if ("range" in entry) expect(areNumbers(entry["range"], 2), "range", entry["range"], "2 numbers");
  const held = [0, 1].every((side) => pages[side]! * page[side]! === stored[side] && texels[side]! <= stored[side]!);
  expect(held, "stored", stored, "pages that hold its texels");
  const paged = !["slices", "words"].includes(arrangement);
  expect(!paged || layers === pages[0]! * pages[1]!, "layers", layers, "a layer for each page");
}

/** Check what shaders are told; returns how many materials there are. */
function checkShader(shader: Facts, textures: Facts): number {
  const defines = objectAt(shader, "defines");
  for (const [name, value] of Object.entries(defines)) {
    const [least, most] = DEFINES.get(name) ?? [0, -1];
    expect(isWhole(value, least, most), name, value, "a number that shaders know");
  }
  const { layers, materials } = shader;
  expect(Array.isArray(layers) && layers.length <= LAYERS.length, "layers", layers, "names of layers");
  for (const layer of layers as unknown[]) {
    const known = typeof layer === "string" && LAYERS.includes(layer) && Object.hasOwn(textures, layer);
    expect(known, "layers", layer, "layers that have a texture");
  }
  for (const [name, value] of Object.entries(objectAt(shader, "values"))) {
    const counted = COUNTED.get(name);
    const rows = counted === undefined ? 0 : ((defines[counted] as number | undefined) ?? 0);
    checkValue(name, value, rows, counted !== undefined || VECTORS.has(name));
  }
  expect(Array.isArray(materials), "materials", materials, "a list");
  const count = (materials as unknown[]).length;
  expect(count >= 1 && count <= MOST_MATERIALS, "materials", count, `1 to ${MOST_MATERIALS}`);
  const namesOf = (values: Facts): string => String(Object.keys(values).filter((name) => name !== OF_IMAGES).sort());
  const names = namesOf(objectAt(materials as unknown as Facts, "0"));
  for (const number of (materials as unknown[]).keys()) {
    const values = objectAt(materials as unknown as Facts, String(number));
    for (const [name, value] of Object.entries(values)) {
      checkValue(name, value, OF_MATERIAL.get(name) ?? 0, OF_MATERIAL.has(name));
    }
    expect(namesOf(values) === names, "materials", number, "the same values of each");
    expect(OF_IMAGES in values || "colour" in textures, "materials", number, `“${OF_IMAGES}”, or a texture of colours`);
  }
  return count;
}

/** Check a uniform's value, four numbers, or so many `rows` of four. */
function checkValue(name: string, value: unknown, rows: number, known: boolean): void {
  const several = Array.isArray(value) && value.length === rows && value.every((row) => areNumbers(row, 4));
  const fine = known && (rows ? several : areNumbers(value, 4));
  expect(fine, name, value, "the value of a uniform that shaders know");
}

function checkMirror(mirror: Facts): void {
  checkTexture(mirror);
  const texels = 2 * wholeAt(mirror, "nodes", 1, MOST_TEXELS) + 9 * wholeAt(mirror, "triangles", 1, MOST_TEXELS);
  for (const [key, count] of [["sky", 3], ["middle", 3], ["across", 2]] as const) {
    expect(areNumbers(mirror[key], count), key, mirror[key], `${count} numbers`);
  }
  positiveAt(mirror, "radius");
  const [width = 0, height = 0] = sizeAt(mirror, "size", MOST_PIXELS);
  expect(texels <= width * height, "size", [width, height], `${texels} pixels at least`);
}

function objectAt(facts: Facts, key: string): Facts {
  const value = facts[key];
  expect(typeof value === "object" && value !== null && !Array.isArray(value), key, value, "an object");
  return value as Facts;
}

function fileAt(facts: Facts, key: string, ending: string): void {
  expect(isPlainFile(facts[key], ending), key, facts[key], `the name of a .${ending} beside it`);
}

function choiceAt(facts: Facts, key: string, among: readonly string[]): string {
  const value = facts[key];
  expect(typeof value === "string" && among.includes(value), key, value, among.join(" or "));
  return value;
}

function wholeAt(facts: Facts, key: string, least: number, most: number): number {
  const value = facts[key];
  expect(isWhole(value, least, most), key, value, `a whole number from ${least} to ${most}`);
  return value as number;
}

function positiveAt(facts: Facts, key: string): void {
  const value = facts[key];
  expect(areNumbers([value], 1) && (value as number) > 0, key, value, "a number above 0");
}

function sizeAt(facts: Facts, key: string, most: number): number[] {
  const value = facts[key];
  const fine = Array.isArray(value) && value.length === 2 && value.every((side) => isWhole(side, 1, most));
  expect(fine, key, value, `two whole numbers from 1 to ${most}`);
  return value as number[];
}

function isWhole(value: unknown, least: number, most: number): boolean {
  return Number.isInteger(value) && (value as number) >= least && (value as number) <= most;
}

function areNumbers(value: unknown, count: number): boolean {
  return Array.isArray(value) && value.length === count && value.every(Number.isFinite);
}

function decoded(uri: unknown): string | null {
  try {
    return typeof uri === "string" ? decodeURIComponent(uri) : null;
  } catch {
    return null;
  }
}
