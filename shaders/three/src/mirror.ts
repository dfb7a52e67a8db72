// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// A chrome ball that moves: each of its fragments traces one ray against the mesh and looks the hit up in the bake.

import { Mesh, NoBlending, ShaderMaterial, SphereGeometry, UniformsLib, UniformsUtils, Vector3, type WebGLRenderer } from "three";

import traceLookups from "../../radtex_trace.glsl";
import type { Filter } from "./filters.js";
import { WHOLE } from "./layers.js";
import type { MirrorEntry } from "./manifest.js";
import { type Bake, partsOf } from "./parts.js";
import { Problem, report } from "./problem.js";
import ballVertex from "./shaders/ball.vert.glsl";
import mirrorMain from "./shaders/mirror.glsl";
import { type BakeTexture, uploadForFrame } from "./textures.js";

const CHROME = [0.9, 0.92, 0.95]; // seen straight on
const LAP = 12; // seconds once around
const HULL = 1.003; // times the radius: the drawn mesh encloses the ball, whose edge the shader finds

export interface MirrorState {
  shown: boolean;
  /** Whether it moves by itself. */
  moving: boolean;
  /** Its middle, in the world of the bake: glTF's axes. */
  place: [number, number, number];
  radius: number;
}

/** The ball that mirrors a bake, for exports with --mirror: a child of the bake's object, in the world of the bake. */
export class RadTexMirror extends Mesh<SphereGeometry, ShaderMaterial> {
  moving = !window.matchMedia("(prefers-reduced-motion: reduce)").matches;
  private size: number;
  private angle = 0.8; // radians along its way
  private before: number | null = null; // when it moved last, in milliseconds
  private readonly facts: MirrorEntry;
  private readonly own;
  private tree: BakeTexture;

  /** `filter` is how the bake is looked up. Levels need derivatives, which a ray's hit has not: they are left out. */
  constructor(
    private readonly bake: Bake,
    private readonly filter: Filter,
  ) {
    const facts = bake.manifest.mirror;
    const tree = bake.textures.get("mirror");
    const { name } = bake.manifest;
    if (!facts) throw new Problem(`The export of ${name} has nothing for a mirror ball`, "Export it with --mirror.");
    if (!tree) throw new Problem(`The textures of ${name} have not come yet`, "Make its mirror ball after `await complete`.");
    super(new SphereGeometry(HULL, 128, 64));
    this.facts = facts;
    this.tree = tree;
    this.size = facts.radius;
    this.own = {
      u_tree: { value: tree.texture },
      u_nodes: { value: facts.nodes },
      u_sky: { value: facts.sky },
      u_chrome: { value: CHROME },
      u_centre: { value: new Vector3() },
      u_radius: { value: this.size },
      u_baked: { value: this.matrix },
    };
    this.material = this.assembled();
    this.onBeforeRender = (renderer): void => {
      if (!("isWebGLRenderer" in renderer)) return this.refuse();
      uploadForFrame(bake.textures.values(), renderer as WebGLRenderer, bake.failed);
      if (bake.textures.get("mirror") !== this.tree) queueMicrotask(() => this.renew()); // after this frame
    };
    this.follow();
  }

  get state(): MirrorState {
    return { shown: this.visible, moving: this.moving, place: this.position.toArray(), radius: this.size };
  }

  set(change: Partial<MirrorState>): void {
    if (change.place) this.position.fromArray(change.place);
    this.size = change.radius ?? this.size;
    this.visible = change.shown ?? this.visible;
    this.moving = change.moving ?? (change.place ? false : this.moving);
    this.before = null;
    this.settle();
  }

  /** Move on to a time in milliseconds; whether it will move again. */
  advance(now: number): boolean {
    if (!this.visible || !this.moving) return false;
    this.angle += (((now - (this.before ?? now)) / 1000) * 2 * Math.PI) / LAP;
    this.before = now;
    this.follow();
    return true;
  }

  /** Another ball in the same place, which mirrors the same bake, or another of the same surface. */
  override clone(_recursive?: boolean, bake = this.bake): this {
    const made = new RadTexMirror(bake, this.filter) as this;
    made.set(this.state);
    made.angle = this.angle;
    return made;
  }

  dispose(): void {
    this.geometry.dispose();
    this.material.dispose();
  }

  /** Hide it from a renderer that does not take its shader. */
  private refuse(): void {
    const { bake } = this;
    const problem = new Problem(`The mirror ball of ${bake.manifest.name} is not shown by WebGPURenderer`, "Draw it by WebGLRenderer.");
    queueMicrotask(() => (this.visible = false)); // after this frame
    if (bake.failed) bake.failed(problem);
    else report(problem);
  }

  private follow(): void {
    const [x = 0, y = 0, z = 0] = this.facts.middle;
    const [a = 1, b = 1] = this.facts.across;
    this.position.set(x + a * Math.cos(this.angle), z, -(y + b * Math.sin(this.angle)));
    this.settle();
  }

  private settle(): void {
    this.scale.setScalar(this.size);
    this.updateMatrix();
    this.own.u_centre.value.copy(this.position);
    this.own.u_radius.value = this.size;
  }

  /** Look up the textures that the bake has by now, as after its graphics device was lost. */
  private renew(): void {
    const tree = this.bake.textures.get("mirror");
    if (!tree || tree === this.tree) return;
    this.tree = tree;
    this.own.u_tree.value = tree.texture;
    this.material.dispose();
    this.material = this.assembled();
  }

  private assembled(): ShaderMaterial {
    const { bake } = this;
    const filter = this.filter === "levels" ? "quadrilinear" : this.filter;
    const { manifest, textures } = bake;
    const [lookups, uniforms] = partsOf(bake, filter, "mirror", WHOLE, 0);
    const clear = [...textures.values()].some(({ entry }) => entry.format === "RGBA16F") || textures.has("alpha");
    const defines = [`#define SURFACES ${clear ? 4 : 1}`, `#define CULLED ${manifest.culled ? "true" : "false"}`];
    return new ShaderMaterial({
      uniforms: { ...UniformsUtils.clone(UniformsLib.fog), ...uniforms, ...this.own },
      vertexShader: ballVertex,
      fragmentShader: [...defines, lookups, traceLookups, mirrorMain].join("\n"),
      blending: NoBlending,
      fog: true,
      clipping: true,
    });
  }
}
