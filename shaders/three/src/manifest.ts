// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The export's manifest, <name>.export.json: which file is which. docs/format.md describes it.

import { isPlainStem, problemOf } from "./checks.js";
import { fetchBytes, fileName } from "./fetching.js";
import { isKind, type Kind } from "./kinds.js";
import { Problem } from "./problem.js";
import type { Requests } from "./requests.js";

export const VERSION = 1;

export type Size = [number, number];
export type PixelFormat =
  | "RGB9E5"
  | "RGBA16F"
  | "BC3"
  | "BC3_SRGB"
  | "BC4"
  | "BC6H"
  | "BC7"
  | "BC7_SRGB"
  | "RGBA8"
  | "SRGB8_A8"
  | "R32UI"
  | "RG32UI"
  | "RGBA32F";

/** One texture of the export; sizes are in pixels or texels, x first. */
export interface TextureEntry {
  file: string;
  container: "ktx2" | "dds" | "exr";
  format: PixelFormat;
  arrangement: "matrix" | "slices" | "image" | "words" | "tree";
  size: Size;
  layers: number;
  texels: Size;
  levels: number;
  pages: Size;
  page_texels: Size;
}

/** The mesh as a tree that rays are traced in, and the ball's way, an ellipse, in Blender's world of the bake. */
export interface MirrorEntry extends TextureEntry {
  nodes: number;
  triangles: number;
  /** Light where a ray meets nothing. */
  sky: number[];
  middle: number[];
  /** Half axes along x and y. */
  across: number[];
  radius: number;
}

/** The values of shader uniforms, by name: vectors of four numbers, or arrays of such. */
export type UniformValues = Record<string, number[] | number[][]>;

/** What a layered bake's shaders are told: docs/format.md. */
export interface ShaderFacts {
  defines: Record<string, number>;
  /** Those whose textures are read. */
  layers: string[];
  /** The same for all materials. */
  values: UniformValues;
  /** Of each material, by its number. */
  materials: UniformValues[];
}

// By how much lobes widen where normals spread within a pixel, so that what moves does not shimmer: a pixel's own box.
export const STEADY = 0.16;

/** Leaves the second lobe out of the shader of a material that has none, though others of its bake do. */
export function ofOneLobe(material: UniformValues): Record<string, number> {
  const lobes = (material["radtex_lobes"] ?? []) as number[][];
  const second = lobes.slice(lobes.length / 2);
  const weights = second.flatMap((each) => each.slice(0, 3));
  return lobes.length && weights.every((weight) => weight === 0) ? { RADTEX_SECOND_LOBE: 0 } : {};
}

/** The bake's sidecar, as far as the page reads it. */
export interface Sidecar {
  kind: Kind;
  layout: "buckets" | "sphere" | "layered";
  texels: Size;
  bucket: number;
  samples: number;
  /** Of kind transfer; views along a side where it was seen from around. */
  transfer?: { view: "normal" | "camera" | "around"; views?: number };
}

export interface Manifest {
  version: number;
  tool: string;
  name: string;
  mesh: string;
  flat: string;
  /** The flat lightmap's light was multiplied by this before it was encoded. */
  flat_scale: number;
  bake: Sidecar;
  /** Faces are drawn from the front alone: those that are seen from behind have others for their backs. */
  culled?: boolean;
  /** Materials with `radtex_images` are shown by their own images, which the .glb holds. */
  images?: boolean;
  /** Of a layered bake. */
  shader?: ShaderFacts;
  textures: Record<string, TextureEntry>;
  /** What a moving mirror ball needs. */
  mirror?: MirrorEntry;
}

/** The bake of one node of a .glb that has several. */
export interface PartManifest extends Manifest {
  node: string;
}

/** Of an export of several bakes in one .glb. */
export interface SceneManifest {
  version: number;
  tool: string;
  name: string;
  mesh: string;
  scene: PartManifest[];
}

/** Read the manifest of one bake. Throws a Problem where it is missing, damaged, of several, or of a newer version. */
export async function readManifest(url: URL, requests?: Requests): Promise<Manifest> {
  const manifest = await readAnyManifest(url, requests);
  if (!("scene" in manifest)) return manifest;
  throw new Problem(`${fileName(url)} is of ${manifest.scene.length} bakes`, "Load it by loadRadTexScene.");
}

/** Read the manifest of one bake, or of several. Throws a Problem as `readManifest` does. */
export async function readAnyManifest(url: URL, requests?: Requests): Promise<Manifest | SceneManifest> {
  const text = new TextDecoder().decode(await fetchBytes(url, "high", requests));
  let manifest: Manifest | SceneManifest;
  try {
    manifest = JSON.parse(text) as Manifest | SceneManifest;
  } catch {
    throw damaged(url, "it is no JSON");
  }
  checkSort(manifest, url);
  if (!Array.isArray((manifest as Partial<SceneManifest> | null)?.scene)) return checkManifest(manifest as Manifest, url);
  const { scene, ...whole } = manifest as SceneManifest;
  if (!scene.length) throw damaged(url, "it has no bakes");
  if (!isPlainStem(whole.name)) throw damaged(url, "its “name” is not what its files are called");
  const parts = scene.map((part) => ({ ...checkManifest({ ...part, mesh: whole.mesh }, url), node: part.node }));
  return { ...whole, scene: parts };
}

/** The same facts, of the file `url`. Throws a Problem where they are damaged, or of a newer version. */
export function checkManifest(manifest: Manifest | undefined, url: URL): Manifest {
  if (typeof manifest?.version !== "number") throw damaged(url, "it has no version");
  if (manifest.version > VERSION) {
    throw new Problem(
      `${fileName(url)} is of version ${manifest.version}, this page reads version ${VERSION}`,
      `${manifest.tool ?? "A newer RadTex"} wrote it: update radtex-three, or take the page that the same export made.`,
    );
  }
  for (const key of ["name", "mesh", "flat", "bake", "textures"] as const) {
    if (!manifest[key]) throw damaged(url, `it has no “${key}”`);
  }
  const { kind, layout, texels, bucket } = manifest.bake;
  if (!isKind(kind)) {
    throw new Problem(
      `${fileName(url)} is of a bake of kind “${kind as string}”, which this page does not show`,
      `${manifest.tool ?? "A newer RadTex"} wrote it: update radtex-three, or take the page that the same export made.`,
    );
  }
  if ((layout as string) === "shared") {
    throw new Problem(
      `${fileName(url)} is of a bake in the shared layout, which this page no longer shows`,
      "Bake the object again and export it, or take the page that the same export made.",
    );
  }
  if (!["buckets", "sphere", "layered"].includes(layout) || !(texels?.length === 2) || !(bucket >= 1)) {
    throw damaged(url, "its “bake” is no sidecar that this page knows");
  }
  if (layout === "layered" && !manifest.shader?.materials?.length) throw damaged(url, "it has no “shader”");
  const problem = problemOf(manifest);
  if (problem) throw damaged(url, problem);
  return manifest;
}

/** Throws a Problem for JSON that people take for a manifest. */
function checkSort(facts: unknown, url: URL): void {
  const has = (key: string): boolean => typeof facts === "object" && facts !== null && key in facts;
  if (has("layout") && has("kind")) {
    throw new Problem(
      `${fileName(url)} is a bake, not its export`,
      "Export it by bake.py export, or Export… in the panel, and load the NAME.export.json of that.",
    );
  }
  if (has("asset")) {
    throw new Problem(
      `${fileName(url)} is a glTF, not a manifest of RadTex`,
      "Load the NAME.export.json beside it, or the glTF by three.js’s GLTFLoader with the plugin radtex.",
    );
  }
}

function damaged(url: URL, reason: string): Problem {
  return new Problem(`${fileName(url)} is no manifest of RadTex: ${reason}`, "Export the object again.");
}
