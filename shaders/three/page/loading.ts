// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// What the page shows, and where.

import { WebGLRenderer } from "three";

import { Problem } from "../src/problem";

/** ?bake=<name>.export.json, or what the export wrote into index.html. */
export function manifestUrl(): URL {
  const own = document.querySelector<HTMLMetaElement>('meta[name="radtex-bake"]')?.content;
  const asked = new URLSearchParams(location.search).get("bake") || own;
  if (!asked) {
    throw new Problem(
      "This page does not know which bake to show",
      "Name its manifest in the address: ?bake=Vase.export.json",
    );
  }
  return new URL(asked, location.href);
}

/** A renderer on a canvas. Throws a Problem where there is no WebGL 2. */
export function rendererOn(canvas: HTMLCanvasElement): WebGLRenderer {
  const context = canvas.getContext("webgl2", { alpha: true, antialias: true, powerPreference: "high-performance" });
  if (!context) {
    throw new Problem(
      "This browser has no WebGL 2",
      "Use a browser of the last few years, and see that its settings allow hardware acceleration.",
    );
  }
  context.getExtension("EXT_color_buffer_float"); // for the inspector's numbers
  const renderer = new WebGLRenderer({ canvas, context });
  renderer.autoClear = false;
  renderer.setClearColor(0, 0);
  renderer.debug.onShaderError = (gl, _program, _vertex, fragment) => {
    const log = gl.getShaderInfoLog(fragment)?.split("\n")[0] ?? "no reason given";
    throw new Problem("This device does not compile the page's shaders", log);
  };
  return renderer;
}
