// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// When the graphics device is taken away, as phones do to pages in the background, and given back.

import { asProblem } from "../src/problem";
import { element } from "./elements";
import type { Viewer } from "./viewer";

/** Have `reload` load the textures again whenever the viewer's device comes back, and then call `exchanged`. */
export function recover(viewer: Viewer, reload: () => Promise<void>, exchanged: () => void): void {
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
      .then(() => {
        viewer.completed();
        exchanged();
      })
      .catch((error: unknown) => {
        const { message, remedy } = asProblem(error);
        console.warn(error);
        element("notice").hidden = false;
        element("notice").textContent = `The flat lightmap is shown: ${message}. ${remedy}`;
      })
      .finally(() => document.body.classList.remove("refining"));
  });
}
