// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// When the graphics device is taken away, as phones do to pages in the background, and given back.

import { thisDevice } from "../src/device";
import { loadTextures } from "../src/load_textures";
import type { RadTexObject } from "../src/radtex_object";
import type { BakeTexture } from "../src/textures";
import { element } from "./elements";
import type { Viewer } from "./viewer";

/** Load the textures of the bake at `url` again whenever the viewer's device comes back. */
export function recover(viewer: Viewer, url: URL): void {
  const canvas = viewer.renderer.domElement;
  canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault(); // else it is not given back
    element("step").textContent = "Waiting for the graphics device";
    document.body.classList.add("refining");
    for (const part of viewer.shown.parts) part.forget();
  });
  canvas.addEventListener("webglcontextrestored", () => {
    viewer.invalidate();
    const shared = new Map<string, Promise<BakeTexture>>();
    const again = async (part: RadTexObject): Promise<void> =>
      part.take(part.manifest, await loadTextures(part.manifest, url, thisDevice(), { shared }));
    Promise.all(viewer.shown.parts.map(again))
      .then(() => viewer.completed())
      .catch((error: unknown) => console.warn(error)) // the flat lightmap stays
      .finally(() => document.body.classList.remove("refining"));
  });
}
