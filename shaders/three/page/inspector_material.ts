// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Materials of the inspector: one bucket, a pixel a cell, or the numbers of one lookup.

import { DoubleSide, GLSL3, RawShaderMaterial, ShaderChunk } from "three";

import type { Filter } from "../src/filters";
import { WHOLE } from "../src/layers";
import { type Bake, partsOf, type Uniforms } from "../src/parts";
import bucketMain from "./shaders/bucket.glsl";
import display from "./shaders/display.glsl";
import probeMain from "./shaders/probe.glsl";
import squareVertex from "./shaders/square.vert.glsl";

/** The inspector's picture of one bucket, or three pixels of numbers. */
export type Stage = "bucket" | "probe";

const MAINS: Record<Stage, string> = { bucket: bucketMain, probe: probeMain };

/** What a stage draws of a bake's material by its number. */
export function inspectorMaterial(bake: Bake, filter: Filter, stage: Stage, number: number): RawShaderMaterial {
  const [lookups, uniforms] = partsOf(bake, filter, stage, WHOLE, number);
  const own: Uniforms = {
    u_texel: { value: [0, 0] },
    u_side: { value: 1 },
    u_point: { value: [0, 0] },
    u_normal: { value: [0, 0, 1] },
    u_tangent: { value: [1, 0, 0, 1] },
    u_viewer: { value: [0, 0, 1] },
    u_place: { value: [0, 0, 0] },
    u_images: { value: [0, 0] },
    u_tone: { value: -1 },
    toneMappingExposure: { value: 1 },
  };
  const tones = ShaderChunk.tonemapping_pars_fragment;
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    uniforms: { ...own, ...uniforms },
    vertexShader: squareVertex,
    fragmentShader: ["precision highp float;", lookups, tones, display, MAINS[stage]].join("\n"),
    side: DoubleSide,
  });
}
