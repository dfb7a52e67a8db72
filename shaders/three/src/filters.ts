// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// How textures can be filtered.

import { KINDS } from "./kinds.js";
import type { Manifest } from "./manifest.js";
import { Problem } from "./problem.js";

export type Filter = "nearest" | "linear" | "quadrilinear" | "levels" | "layered";

/** How the manifest's textures can be filtered, the best last. */
export function filtersOf(manifest: Manifest): Filter[] {
  if (manifest.bake.layout === "layered") return ["layered"];
  const radiance = manifest.textures[manifest.bake.kind];
  if (!radiance) {
    throw new Problem(
      `The manifest of ${manifest.name} names no texture “${manifest.bake.kind}”, which its bake is of`,
      "Export the object again.",
    );
  }
  if (KINDS[manifest.bake.kind].way === "L") return ["quadrilinear"];
  if (radiance.arrangement === "slices") return radiance.levels > 1 ? ["quadrilinear", "levels"] : ["quadrilinear"];
  return ["nearest", "linear", "quadrilinear", ...(radiance.levels > 1 ? (["levels"] as const) : [])];
}
