// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The help's words and keys, by what is shown.

import { KINDS } from "../src/kinds";
import type { Manifest } from "../src/manifest";
import { element } from "./elements";
import type { Viewer } from "./viewer";

const LAYERED =
  "One sharp picture of the surroundings is shared by all texels. Each texel holds how it reflects that picture, " +
  "and the light that is its own. What you see is put together from both for where you stand. " +
  "A flat lightmap, as Compare shows it beside, knows one colour a texel.";

/** Have the help speak of the bakes that are shown, and of the filters that they have. */
export function describeHelp(viewer: Viewer): void {
  const { kind } = viewer.manifest.bake;
  const { title } = KINDS[kind];
  element("help-title").textContent =
    kind === "radiance" ? "A radiance texture" : title.charAt(0).toUpperCase() + title.slice(1);
  const abouts = new Set(viewer.shown.parts.map(({ manifest }) => about(manifest)));
  element("about").textContent = [...abouts].join(" ");
  element("filter-keys").hidden = viewer.filters.length < 2;
  element("last-filter").textContent = String(viewer.filters.length);
}

function about({ bake }: Manifest): string {
  return bake.layout === "layered" ? LAYERED : KINDS[bake.kind].about;
}
