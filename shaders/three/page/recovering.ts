// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// When the graphics device is taken away, as phones do to pages in the background, and given back.

import { element } from "./elements";
import type { Viewer } from "./viewer";

/** Have `reload` load the textures again whenever the viewer's device comes back. */
export function recover(viewer: Viewer, reload: () => Promise<void>): void {
  const canvas = viewer.renderer.domElement;
  canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault(); // else it is not given back
    element("step").textContent = "Waiting for the graphics device";
    document.body.classList.add("refining");
    for (const part of viewer.shown.parts) part.forget();
  });
  canvas.addEventListener("webglcontextrestored", () => {
    viewer.invalidate();
    reload()
      .then(() => viewer.completed())
      .catch((error: unknown) => console.warn(error)) // the flat lightmap stays
      .finally(() => document.body.classList.remove("refining"));
  });
}
