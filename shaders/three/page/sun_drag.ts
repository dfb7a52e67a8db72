// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Shift-drag over the picture turns the sun, where a plain one orbits.

import { KINDS } from "../src/kinds";
import type { Viewer } from "./viewer";

const DEGREES = 0.4; // for each CSS pixel

/** Let Shift-drags turn the viewer's sun, if one of its bakes is lit by it, within a `change`. */
export function followSunDrag(viewer: Viewer, change: (act: () => void) => void): void {
  const kinds = viewer.shown.parts.map(({ manifest }) => KINDS[manifest.bake.kind]);
  if (!kinds.some(({ sun }) => sun.includes("direction"))) return;
  const canvas = viewer.renderer.domElement;
  let last: PointerEvent | null = null;
  // Before the canvas hears of it, whose other listeners orbit and inspect.
  viewer.stage.addEventListener(
    "pointerdown",
    (event) => {
      if (event.target !== canvas || !event.shiftKey || event.button !== 0) return;
      event.stopPropagation();
      canvas.setPointerCapture(event.pointerId);
      last = event;
    },
    { capture: true },
  );
  canvas.addEventListener("pointermove", (event) => {
    if (event.pointerId !== last?.pointerId) return;
    const [across, down] = [event.clientX - last.clientX, event.clientY - last.clientY];
    last = event;
    change(() => viewer.turnSun(across * DEGREES, -down * DEGREES));
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"] as const) {
    canvas.addEventListener(end, () => (last = null));
  }
}
