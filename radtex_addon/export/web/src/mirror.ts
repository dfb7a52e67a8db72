// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// A chrome ball that moves: each of its fragments traces one ray against the mesh and looks the hit up in the bake.

import { GLSL3, Mesh, NoBlending, RawShaderMaterial, ShaderChunk, SphereGeometry, Vector3 } from "three";

import traceLookups from "../../../../shaders/radtex_trace.glsl";
import { WHOLE } from "./layers";
import type { Manifest } from "./manifest";
import { type Filter, partsOf } from "./parts";
import display from "./shaders/display.glsl";
import meshVertex from "./shaders/ball.vert.glsl";
import mirrorMain from "./shaders/mirror.glsl";
import { shown } from "./shaders";
import type { Loaded } from "./textures";

const CHROME = [0.9, 0.92, 0.95]; // seen straight on
const LAP = 12; // seconds once around
const HULL = 1.003; // times the radius: the drawn mesh encloses the ball, whose edge the shader finds

export interface MirrorState {
  shown: boolean;
  /** Whether it moves by itself. */
  moving: boolean;
  /** Its middle, in the page's world: glTF's axes. */
  place: [number, number, number];
  radius: number;
}

export class Mirror {
  readonly mesh: Mesh;
  moving = !window.matchMedia("(prefers-reduced-motion: reduce)").matches;
  private radius: number;
  private angle = 0.8; // radians along its way
  private before: number | null = null; // when it moved last, in milliseconds
  private readonly materials = new Map<Filter, RawShaderMaterial>();
  private readonly own;

  constructor(
    private readonly manifest: Manifest,
    private textures: Map<string, Loaded>,
  ) {
    const { mirror } = manifest;
    const tree = textures.get("mirror");
    if (!mirror || !tree) throw new Error("the export has no mirror");
    this.radius = mirror.radius;
    this.own = {
      u_tree: { value: tree.texture },
      u_nodes: { value: mirror.nodes },
      u_sky: { value: mirror.sky },
      u_chrome: { value: CHROME },
      u_centre: { value: new Vector3() },
      u_radius: { value: this.radius },
    };
    this.mesh = new Mesh(new SphereGeometry(HULL, 128, 64));
    this.follow();
  }

  get state(): MirrorState {
    const { mesh, moving, radius } = this;
    return { shown: mesh.visible, moving, place: mesh.position.toArray(), radius };
  }

  set(change: Partial<MirrorState>): void {
    if (change.place) this.mesh.position.fromArray(change.place);
    this.radius = change.radius ?? this.radius;
    this.mesh.visible = change.shown ?? this.mesh.visible;
    this.moving = change.moving ?? (change.place ? false : this.moving);
    this.before = null;
    this.settle();
  }

  /** Mirror other textures of the same surface. */
  exchange(textures: Map<string, Loaded>): void {
    const tree = textures.get("mirror");
    if (tree) this.own.u_tree.value = tree.texture;
    for (const material of this.materials.values()) material.dispose();
    this.materials.clear();
    this.textures = textures;
  }

  /** Move on to a time in milliseconds; whether it will move again. */
  advance(now: number): boolean {
    if (!this.mesh.visible || !this.moving) return false;
    this.angle += (((now - (this.before ?? now)) / 1000) * 2 * Math.PI) / LAP;
    this.before = now;
    this.follow();
    return true;
  }

  /** Its material, where the bake is looked up by a filter. Levels need derivatives, which a ray's hit has not. */
  material(filter: Filter): RawShaderMaterial {
    const plain = filter === "levels" ? "quadrilinear" : filter;
    const material = this.materials.get(plain) ?? this.assembled(plain);
    this.materials.set(plain, material);
    return material;
  }

  private follow(): void {
    const { middle, across } = this.manifest.mirror ?? { middle: [0, 0, 0], across: [1, 1] };
    const [x = 0, y = 0, z = 0] = middle;
    const [a = 1, b = 1] = across;
    this.mesh.position.set(x + a * Math.cos(this.angle), z, -(y + b * Math.sin(this.angle)));
    this.settle();
  }

  private settle(): void {
    this.mesh.scale.setScalar(this.radius);
    this.mesh.updateMatrixWorld(true);
    this.own.u_centre.value.copy(this.mesh.position);
    this.own.u_radius.value = this.radius;
  }

  private assembled(filter: Filter): RawShaderMaterial {
    const { manifest, textures } = this;
    const [lookups, uniforms] = partsOf(manifest, textures, filter, "mirror", WHOLE, 0);
    const clear = [...textures.values()].some(({ entry }) => entry.format === "RGBA16F") || textures.has("alpha");
    const defines = [`#define SURFACES ${clear ? 4 : 1}`, `#define CULLED ${manifest.culled ? "true" : "false"}`];
    const tones = ShaderChunk.tonemapping_pars_fragment;
    return new RawShaderMaterial({
      glslVersion: GLSL3,
      uniforms: { ...uniforms, ...shown, ...this.own },
      vertexShader: meshVertex,
      fragmentShader: [...defines, lookups, traceLookups, tones, display, mirrorMain].join("\n"),
      blending: NoBlending,
    });
  }
}
