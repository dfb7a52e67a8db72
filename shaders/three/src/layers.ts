// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Layers: the whole, the parts of its light that lie beside it, and base and rest together.

import type { Manifest } from "./manifest.js";

export const WHOLE = "whole";
export const SUM = "sum";
export const BASE = "base";
const REST = "rest";

/** What can be shown of a bake: the whole first; a bake without layers has nothing else. */
export function layersOf({ bake, textures }: Manifest): string[] {
  if (bake.layout !== "buckets") return [WHOLE];
  const layers = Object.keys(textures).filter((name) => name !== bake.kind);
  return [WHOLE, ...layers, ...(layers.includes(BASE) && layers.includes(REST) ? [SUM] : [])];
}

/** The texture with buckets that a layer is looked up in; the base has none, and borrows the whole's. */
export function bucketsOf(layer: string, kind: string): string {
  if (layer === SUM) return REST;
  return layer === WHOLE || layer === BASE ? kind : layer;
}

/** A layer's name, and what it is. */
export function layerWords(layer: string): [string, string] {
  const words: Record<string, [string, string]> = {
    whole: ["Whole", "All light"],
    base: ["Base", "Diffuse light, one value a texel: the same from everywhere"],
    rest: ["Rest", "What the base lacks, in each direction; black where that is less than nothing"],
    sum: ["Base + Rest", "Both, added by the shader: the whole again"],
    normal: ["Normal", "The normals of what is seen, in Blender’s world, from −1 … 1 to black … white"],
  };
  return words[layer] ?? [layer.charAt(0).toUpperCase() + layer.slice(1), `The ${layer} part of the light`];
}
