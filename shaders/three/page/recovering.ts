// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// When the graphics device is taken away, as phones do to pages in the background, and given back.

import { thisDevice } from "../src/device";
import { loadTextures } from "../src/load_textures";
import { element } from "./elements";
import type { Viewer } from "./viewer";

/** Load the textures of the bake at `url` again whenever the viewer's device comes back. */
export function recover(viewer: Viewer, url: URL): void {
  const canvas = viewer.renderer.domElement;
  canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault(); // else it is not given back
    element("step").textContent = "Waiting for the graphics device";
    document.body.classList.add("refining");
    viewer.object.forget();
  });
  canvas.addEventListener("webglcontextrestored", () => {
    const { manifest } = viewer;
    viewer.invalidate();
    loadTextures(manifest, url, thisDevice())
      .then((textures) => viewer.take(manifest, textures))
      .catch((error: unknown) => console.warn(error)) // the flat lightmap stays
      .finally(() => document.body.classList.remove("refining"));
  });
}
