// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Materials: the shaders that ship with every export, between what the page adds.

import {
  CustomBlending,
  DoubleSide,
  GLSL3,
  OneFactor,
  OneMinusSrcAlphaFactor,
  RawShaderMaterial,
  ShaderChunk,
  type Texture,
} from "three";

import condensedLookups from "../../../../shaders/radtex_condensed.glsl";
import bucketLookups from "../../../../shaders/radtex.glsl";
import sharedLookups from "../../../../shaders/radtex_shared.glsl";
import type { Lobe, Manifest, Sidecar } from "./manifest";
import { Problem } from "./problem";
import bucketMain from "./shaders/bucket.glsl";
import bucketLight from "./shaders/buckets.glsl";
import display from "./shaders/display.glsl";
import flatLight from "./shaders/flat.glsl";
import lobeLight from "./shaders/lobe.glsl";
import meshMain from "./shaders/mesh.glsl";
import meshVertex from "./shaders/mesh.vert.glsl";
import probeMain from "./shaders/probe.glsl";
import sharedLight from "./shaders/shared.glsl";
import sharedImages from "./shaders/shared_images.glsl";
import squareVertex from "./shaders/square.vert.glsl";
import type { Loaded } from "./textures";

export const TONES = ["none", "aces", "agx", "neutral"] as const;
export type Tone = (typeof TONES)[number];
export type Filter = "nearest" | "linear" | "quadrilinear" | "levels" | "shared";

/** What is drawn: the mesh, the inspector's picture of one bucket, or its three pixels of numbers. */
export type Stage = "mesh" | "bucket" | "probe";
const MAINS: Record<Stage, string> = { mesh: meshMain, bucket: bucketMain, probe: probeMain };

type Uniforms = Record<string, { value: unknown }>;

/** Exposure and tone, which all materials of a page have in common. */
export const shown = { toneMappingExposure: { value: 1 }, u_tone: { value: 0 } };

/** How the manifest's textures can be filtered, the best last. */
export function filtersOf(manifest: Manifest): Filter[] {
  if (manifest.bake.layout === "shared") return ["shared"];
  const radiance = manifest.textures[manifest.bake.kind];
  if (!radiance) throw new Problem(`The manifest names no texture “${manifest.bake.kind}”`, "Export the object again.");
  if (radiance.arrangement === "slices") return radiance.levels > 1 ? ["quadrilinear", "levels"] : ["quadrilinear"];
  return ["nearest", "linear", "quadrilinear", ...(radiance.levels > 1 ? (["levels"] as const) : [])];
}

/** The light of a bake, by a filter. */
export function lightMaterial(
  manifest: Manifest,
  textures: Map<string, Loaded>,
  filter: Filter,
  stage: Stage,
): RawShaderMaterial {
  const shared = manifest.bake.layout === "shared";
  const [lookups, uniforms] = shared
    ? sharedParts(manifest.bake, textures, stage)
    : bucketParts(manifest, textures, filter, stage);
  const material = assembled(lookups, uniforms, stage);
  if (stage === "mesh" && [...textures.values()].some((loaded) => !shared && loaded.entry.format === "RGBA16F")) {
    material.transparent = true; // what has no alpha of its own is not blended
    material.blending = CustomBlending;
    material.blendSrc = OneFactor;
    material.blendDst = OneMinusSrcAlphaFactor;
  }
  return material;
}

/** The flat lightmap on the mesh. */
export function flatMaterial(texture: Texture, scale: number): RawShaderMaterial {
  const uniforms = { u_flat: { value: texture }, u_flat_scale: { value: scale } };
  return assembled(`precision highp float;\n${flatLight}`, uniforms, "mesh");
}

function assembled(lookups: string, uniforms: Uniforms, stage: Stage): RawShaderMaterial {
  const tones = ShaderChunk.tonemapping_pars_fragment;
  const own: Uniforms = {
    u_texel: { value: [0, 0] },
    u_side: { value: 1 },
    u_point: { value: [0, 0] },
    u_normal: { value: [0, 0, 1] },
    u_tangent: { value: [1, 0, 0, 1] },
    u_viewer: { value: [0, 0, 1] },
  };
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    uniforms: { ...(stage === "mesh" ? {} : own), ...uniforms, ...shown },
    vertexShader: stage === "mesh" ? meshVertex : squareVertex,
    fragmentShader: [lookups, tones, display, MAINS[stage]].join("\n"),
    side: DoubleSide,
  });
}

function bucketParts(
  manifest: Manifest,
  textures: Map<string, Loaded>,
  filter: Filter,
  stage: Stage,
): [string, Uniforms] {
  const loaded = needed(textures, manifest.bake.kind);
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
  ];
  const uniforms: Uniforms = {
    u_radiance: { value: loaded.texture },
    u_texels: { value: texels },
    u_bucket: { value: manifest.bake.bucket },
    u_pages: { value: [...(pages ?? [1, 1]), ...(page ?? texels)] },
  };
  return [[...defines, bucketLookups, bucketLight].join("\n"), uniforms];
}

function sharedParts(bake: Sidecar, textures: Map<string, Loaded>, stage: Stage): [string, Uniforms] {
  const facts = bake.shared as NonNullable<Sidecar["shared"]>;
  const { condensed } = facts;
  const defines = [
    "#define RADTEX_HARDWARE_LINEAR",
    `#define RADTEX_FALLOFF ${facts.falloff.length}`,
    "#define RADTEX_NO_DERIVATIVES",
    condensed ? `#define CONDENSED\n#define RADTEX_RANK ${condensed.rank}` : "",
    ...facts.lobes.map((lobe) => `#define ${lobe.toUpperCase()}`),
  ];
  const uniforms: Uniforms = {
    u_fine: { value: facts.colour },
    u_texels: { value: bake.texels },
    u_bucket: { value: bake.bucket },
    u_around: { value: [facts.surroundings, facts.levels] },
    u_falloff: { value: facts.falloff.flat() },
  };
  const parts = condensed ? ["weights", "ends_xy", "ends_zs", "gain", "rest"] : ["ends", "gain", "rest"];
  const layers = facts.lobes.flatMap((lobe) => parts.map((part) => `${lobe}_${part}`));
  for (const layer of ["colour", "irradiance", "surroundings", ...layers]) {
    uniforms[`u_${layer}`] = { value: needed(textures, layer).texture };
  }
  if (condensed) {
    uniforms["u_columns"] = { value: condensed.columns };
    for (const lobe of facts.lobes) uniforms[`u_${lobe}_ranges`] = { value: rangesOf(condensed.lobes, lobe) };
  }
  const lookups = condensed ? [sharedLookups, condensedLookups] : [sharedLookups];
  if (stage !== "mesh") lookups.unshift(bucketLookups); // for the surface's frame
  const lobes = facts.lobes.map((lobe) => lobeLight.replaceAll("LOBE", lobe));
  return [[...defines, ...lookups, sharedImages, ...lobes, sharedLight].join("\n"), uniforms];
}

/** The twelve vec4 of radtex_condensed.glsl. */
function rangesOf(lobes: Record<Lobe, { ends: number[][]; gain: number[][]; rest: number[][] }>, lobe: Lobe): number[] {
  const { ends, gain, rest } = lobes[lobe];
  return [...ends, ...gain, ...rest].flatMap((range) => [0, 1, 2, 3].map((place) => range[place] ?? 0));
}

function needed(textures: Map<string, Loaded>, name: string): Loaded {
  const loaded = textures.get(name);
  if (!loaded) throw new Problem(`The manifest names no texture “${name}”`, "Export the object again.");
  return loaded;
}
