// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// A material of Babylon.js that shows a bake.

import "@babylonjs/core/Shaders/ShadersInclude/helperFunctions.js";
import "@babylonjs/core/Shaders/ShadersInclude/imageProcessingDeclaration.js";
import "@babylonjs/core/Shaders/ShadersInclude/imageProcessingFunctions.js";
import { Camera } from "@babylonjs/core/Cameras/camera.js";
import type { Effect } from "@babylonjs/core/Materials/effect.js";
import { ImageProcessingConfiguration } from "@babylonjs/core/Materials/imageProcessingConfiguration.js";
import { ImageProcessingConfigurationDefines } from "@babylonjs/core/Materials/imageProcessingConfiguration.defines.js";
import { ShaderMaterial } from "@babylonjs/core/Materials/shaderMaterial.js";
import type { BaseTexture } from "@babylonjs/core/Materials/Textures/baseTexture.js";
import { Color3 } from "@babylonjs/core/Maths/math.color.js";
import { Matrix } from "@babylonjs/core/Maths/math.vector.js";
import type { AbstractMesh } from "@babylonjs/core/Meshes/abstractMesh.js";
import type { SubMesh } from "@babylonjs/core/Meshes/subMesh.js";
import type { Scene } from "@babylonjs/core/scene.js";

import bucketLookups from "../../radtex.glsl";
import layeredLookups from "../../radtex_layered.glsl";
import throughLookups from "../../radtex_layered_through.glsl";
import { type Manifest, ofOneLobe, type ShaderFacts, STEADY } from "../../three/src/manifest.js";
import bucketLight from "../../three/src/shaders/buckets.glsl";
import layeredLight from "../../three/src/shaders/layered.glsl";
import surface from "./shaders/surface.glsl";
import surfaceVertex from "./shaders/surface.vert.glsl";

// Has Babylon.js leave the text to the device, which knows all that is in it.
const VERSION = "#version 300 es\n";
const PRECISION = "precision highp float; precision highp int; precision highp sampler2D; precision highp sampler2DArray;\n";

/** GLSL with a function `light`, the values of its uniforms, and the textures that it reads, by their uniforms. */
interface Lookups {
  text: string;
  vectors: Record<string, number[]>;
  textures: Record<string, string>;
  whole: Record<string, number[]>;
}

/** The light of one material of a bake, as it leaves its surface towards the camera. */
export class RadTexMaterial extends ShaderMaterial {
  /** What all its light is multiplied by. */
  tint = Color3.White();
  /** The number that all its light is multiplied by: 2 is a stop more. */
  exposure = 1;
  private readonly processing = new ImageProcessingConfigurationDefines();

  /** @internal It and its clones, which read the same textures. */
  readonly clones: Set<RadTexMaterial>;
  private readonly whole: Record<string, number[]>;
  private readonly readBy: Record<string, string>;
  private textures: ReadonlyMap<string, BaseTexture> = new Map();

  /** @internal `baked` leads from the mesh's own space to the world of the bake. */
  static of(name: string, scene: Scene, manifest: Manifest, number: number, baked: Matrix): RadTexMaterial {
    return new RadTexMaterial(name, scene, manifest, number, baked);
  }

  private constructor(
    name: string,
    scene: Scene,
    private readonly manifest: Manifest,
    private readonly number: number,
    private readonly baked: Matrix,
    clones = new Set<RadTexMaterial>(),
  ) {
    const { text, vectors, textures, whole } = lookupsOf(manifest, number);
    const uniforms = ["world", "viewProjection", "u_baked", "u_eye", "u_light", ...Object.keys(vectors), ...Object.keys(whole)];
    const samplers = Object.keys(textures);
    ImageProcessingConfiguration.PrepareUniforms(uniforms, all(new ImageProcessingConfigurationDefines()));
    ImageProcessingConfiguration.PrepareSamplers(samplers, all(new ImageProcessingConfigurationDefines()));
    const sources = {
      vertexSource: VERSION + surfaceVertex,
      fragmentSource: [VERSION + PRECISION, text, surface].join("\n"),
    };
    const attributes = ["position", "normal", "tangent", "uv"];
    super(name, scene, sources, { attributes, uniforms, samplers, defines: [] });
    for (const [uniform, values] of Object.entries(vectors)) this.setArray4(uniform, values);
    this.whole = whole;
    this.readBy = textures;
    this.backFaceCulling = manifest.culled === true;
    this.clones = clones.add(this);
    this.onDisposeObservable.addOnce(() => clones.delete(this));
  }

  /** @internal Read these textures. */
  read(textures: ReadonlyMap<string, BaseTexture>): void {
    this.textures = textures;
    for (const [uniform, name] of Object.entries(this.readBy)) this.setTexture(uniform, textures.get(name) as BaseTexture);
  }

  /** Another one with the same textures, and a look of its own. */
  override clone(name: string): RadTexMaterial {
    const made = new RadTexMaterial(name, this.getScene(), this.manifest, this.number, this.baked, this.clones);
    made.read(this.textures);
    made.tint = this.tint.clone();
    made.exposure = this.exposure;
    return made;
  }

  override isReady(mesh?: AbstractMesh, useInstances?: boolean, subMesh?: SubMesh): boolean {
    const { imageProcessingConfiguration } = this.getScene();
    imageProcessingConfiguration.prepareDefines(this.processing);
    if (!imageProcessingConfiguration.isReady()) return false;
    const exact = Number(this.getScene().getEngine().useExactSrgbConversions);
    this.options.defines = [`USE_EXACT_SRGB_CONVERSIONS ${exact}`, ...this.processing.toString().split("\n").filter(Boolean)];
    return super.isReady(mesh, useInstances, subMesh);
  }

  protected override _afterBind(mesh?: AbstractMesh, effect?: Effect | null, subMesh?: SubMesh): void {
    if (effect) this.bindLook(effect);
    super._afterBind(mesh, effect, subMesh);
  }

  private bindLook(effect: Effect): void {
    const scene = this.getScene();
    const camera = scene.activeCamera;
    effect.setMatrix("u_baked", this.baked);
    if (camera?.mode === Camera.ORTHOGRAPHIC_CAMERA) {
      const view = scene.getViewMatrix().m; // whose third column is the direction that the camera looks in, or away from
      const towards = scene.useRightHandedSystem ? 1 : -1;
      effect.setFloat4("u_eye", towards * (view[2] as number), towards * (view[6] as number), towards * (view[10] as number), 0);
    } else if (camera) {
      const { x, y, z } = camera.globalPosition;
      effect.setFloat4("u_eye", x, y, z, 1);
    }
    const { r, g, b } = this.tint;
    effect.setFloat3("u_light", r * this.exposure, g * this.exposure, b * this.exposure);
    for (const [uniform, values] of Object.entries(this.whole)) {
      if (values.length === 1) effect.setInt(uniform, values[0] as number);
      else effect.setInt2(uniform, ...(values as [number, number]));
    }
    if (!this.processing.IMAGEPROCESSINGPOSTPROCESS) scene.imageProcessingConfiguration.bind(effect);
  }
}

/** The same defines, with all that image processing can ask for. */
function all(defines: ImageProcessingConfigurationDefines): ImageProcessingConfigurationDefines {
  for (const name of ["EXPOSURE", "CONTRAST", "WHITEBALANCE", "COLORGRADING", "VIGNETTE", "COLORCURVES", "DITHER"] as const) {
    defines[name] = true;
  }
  return defines;
}

function lookupsOf(manifest: Manifest, number: number): Lookups {
  return manifest.bake.layout === "layered" ? layered(manifest.shader as ShaderFacts, number) : buckets(manifest);
}

function layered(facts: ShaderFacts, number: number): Lookups {
  const own = facts.materials[number] ?? {};
  const defines = { ...facts.defines, ...ofOneLobe(own), RADTEX_STEADY: STEADY };
  const told = Object.entries(defines).map(([name, value]) => `#define ${name} ${value}`);
  const through = "RADTEX_THROUGH" in facts.defines ? throughLookups : "";
  const values = Object.entries({ ...facts.values, ...own }).map(([name, value]) => [name, value.flat()]);
  return {
    text: ["#define LAYERED", ...told, layeredLookups, through, layeredLight].join("\n"),
    vectors: Object.fromEntries(values) as Record<string, number[]>,
    textures: Object.fromEntries(facts.layers.map((layer) => [`radtex_${layer}_map`, layer])),
    whole: {},
  };
}

function buckets({ bake, textures }: Manifest): Lookups {
  const levels = textures[bake.kind]?.levels ?? 1;
  const defines = [
    "#define RADTEX_HARDWARE_LINEAR",
    "#define SAMPLER sampler2D",
    "#define FILTER RADTEX_QUADRILINEAR",
    levels > 1 ? `#define LEVELS ${levels}` : "",
    bake.kind === "ao" ? "#define AMBIENT" : "",
  ];
  return {
    text: [...defines, bucketLookups, bucketLight].join("\n"),
    vectors: {},
    textures: { u_radiance: bake.kind },
    whole: { u_texels: textures[bake.kind]?.texels ?? bake.texels, u_bucket: [bake.bucket] },
  };
}
