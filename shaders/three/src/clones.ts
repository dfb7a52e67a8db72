// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// What an object and its clones have in common: geometry, images, and where their textures come from.

import type { Texture } from "three";

import type { MaterialImages } from "./parts.js";
import { Problem } from "./problem.js";
import type { RadTexObject } from "./radtex_object.js";

/** Counts the objects that show one loaded bake. The last one that is disposed of frees what they share. */
export class Clones {
  readonly members = new Set<RadTexObject>();
  /** Loads the textures again for all members, after the graphics device was taken away and came back. */
  reload: (() => Promise<void>) | null = null;
  private readonly canvases = new Set<EventTarget>();
  private lostTextures = false;

  /** `map` is the flat lightmap, `images` those of materials that are shown by their own. */
  constructor(
    private readonly map: Texture,
    private readonly images: Iterable<MaterialImages>,
  ) {}

  /** Have the members forget their textures when the canvas loses its graphics device, and load them when it is back. */
  watch(canvas: EventTarget): void {
    if (this.canvases.has(canvas)) return;
    this.canvases.add(canvas);
    canvas.addEventListener("webglcontextlost", this.lost);
    canvas.addEventListener("webglcontextrestored", this.restored);
  }

  /** A member is disposed of: with the last one goes what is shared. */
  leave(member: RadTexObject): void {
    if (!this.members.delete(member) || this.members.size) return;
    for (const { geometry } of member.meshes) geometry.dispose();
    this.map.dispose();
    for (const { base, metal, bump } of this.images) for (const each of [base, metal, bump]) each?.dispose();
    for (const canvas of this.canvases) {
      canvas.removeEventListener("webglcontextlost", this.lost);
      canvas.removeEventListener("webglcontextrestored", this.restored);
    }
    this.canvases.clear();
  }

  private readonly lost = ({ target }: Event): void => {
    if (!this.reload) return;
    const concerned = [...this.members].filter((each) => [...each.textures.values()].some((texture) => texture.isOn(target)));
    this.lostTextures ||= concerned.length > 0;
    for (const each of concerned) each.forget();
  };

  private readonly restored = (): void => {
    if (!this.lostTextures) return;
    this.lostTextures = false;
    this.reload?.().catch((error: unknown) => {
      const reason = error instanceof Error ? error.message : String(error);
      const problem = error instanceof Problem ? error : new Problem(reason, "Call reload(), or reload the page.");
      for (const each of this.members) each.failed(problem);
    });
  };
}
