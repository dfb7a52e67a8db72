// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Materials: how a bake is looked up, between what the page adds.

import {
  CustomBlending,
  DoubleSide,
  FrontSide,
  GLSL3,
  OneFactor,
  OneMinusSrcAlphaFactor,
  RawShaderMaterial,
  ShaderChunk,
  type Side,
  type Texture,
} from "three";

import { KINDS } from "./kinds";
import { WHOLE } from "./layers";
import type { Manifest } from "./manifest";
import { type Filter, partsOf, type Stage, type Uniforms } from "./parts";
import { Problem } from "./problem";
import bucketMain from "./shaders/bucket.glsl";
import display from "./shaders/display.glsl";
import flatLight from "./shaders/flat.glsl";
import meshMain from "./shaders/mesh.glsl";
import meshVertex from "./shaders/mesh.vert.glsl";
import probeMain from "./shaders/probe.glsl";
import squareVertex from "./shaders/square.vert.glsl";
import type { Loaded } from "./textures";

export const TONES = ["none", "aces", "agx", "neutral"] as const;
export type Tone = (typeof TONES)[number];

const MAINS: Record<Stage, string> = { mesh: meshMain, bucket: bucketMain, probe: probeMain };

/** Exposure and tone, which all materials of a page have in common. */
export const shown = { toneMappingExposure: { value: 1 }, u_tone: { value: 0 } };

/** How the manifest's textures can be filtered, the best last. */
export function filtersOf(manifest: Manifest): Filter[] {
  if (manifest.bake.layout === "layered") return ["layered"];
  const radiance = manifest.textures[manifest.bake.kind];
  if (!radiance) throw new Problem(`The manifest names no texture “${manifest.bake.kind}”`, "Export the object again.");
  if (KINDS[manifest.bake.kind].way === "L") return ["quadrilinear"];
  if (radiance.arrangement === "slices") return radiance.levels > 1 ? ["quadrilinear", "levels"] : ["quadrilinear"];
  return ["nearest", "linear", "quadrilinear", ...(radiance.levels > 1 ? (["levels"] as const) : [])];
}

/** The light of a bake, by a filter. */
export function lightMaterial(
  manifest: Manifest,
  textures: Map<string, Loaded>,
  filter: Filter,
  stage: Stage,
  layer: string = WHOLE,
  number = 0,
): RawShaderMaterial {
  const parts = partsOf(manifest, textures, filter, stage, layer, number);
  const material = assembled(...parts, stage, sidesOf(manifest));
  const clear = hasAlpha(manifest, textures);
  return stage === "mesh" && clear ? blended(material, manifest) : material; // what has no alpha is not blended
}

function hasAlpha({ bake }: Manifest, textures: Map<string, Loaded>): boolean {
  if (bake.layout === "layered") return textures.has("alpha");
  return [...textures.values()].some(({ entry }) => entry.format === "RGBA16F");
}

/** The flat lightmap on the mesh. */
export function flatMaterial(manifest: Manifest, texture: Texture): RawShaderMaterial {
  const uniforms = { u_flat: { value: texture }, u_flat_scale: { value: manifest.flat_scale || 1 } };
  const material = assembled(`precision highp float;\n${flatLight}`, uniforms, "mesh", sidesOf(manifest));
  return manifest.bake.layout === "buckets" ? blended(material, manifest) : material;
}

/** Blend it over what is drawn before. What is clear hides nothing, but in a hull, whose nearest side has it all. */
function blended(material: RawShaderMaterial, manifest: Manifest): RawShaderMaterial {
  material.transparent = true;
  if (manifest.bake.kind !== "proxy") material.defines = { CLEAR: "" };
  material.blending = CustomBlending;
  material.blendSrc = OneFactor;
  material.blendDst = OneMinusSrcAlphaFactor;
  return material;
}

/** A hull shows its front alone: what is seen through it is in its texture; and so do faces with backs of their own. */
function sidesOf(manifest: Manifest): Side {
  return manifest.bake.kind === "proxy" || manifest.culled ? FrontSide : DoubleSide;
}

function assembled(lookups: string, uniforms: Uniforms, stage: Stage, sides: Side): RawShaderMaterial {
  const tones = ShaderChunk.tonemapping_pars_fragment;
  const own: Uniforms = {
    u_texel: { value: [0, 0] },
    u_side: { value: 1 },
    u_point: { value: [0, 0] },
    u_normal: { value: [0, 0, 1] },
    u_tangent: { value: [1, 0, 0, 1] },
    u_viewer: { value: [0, 0, 1] },
    u_place: { value: [0, 0, 0] },
  };
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    uniforms: { ...(stage === "mesh" ? {} : own), ...uniforms, ...shown },
    vertexShader: stage === "mesh" ? meshVertex : squareVertex,
    fragmentShader: [lookups, tones, display, MAINS[stage]].join("\n"),
    side: stage === "mesh" ? sides : DoubleSide,
  });
}
