// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// What a device takes: sizes, layers, and formats of pixels and blocks.

import type { PixelFormat, TextureEntry } from "./manifest.js";
import { Problem } from "./problem.js";

/** Internal format, format and type of pixels. */
export const PLAIN: Partial<Record<PixelFormat, [number, number, number]>> = {
  RGB9E5: [0x8c3d, 0x1907, 0x8c3e], // RGB9_E5, RGB, UNSIGNED_INT_5_9_9_9_REV
  RGBA16F: [0x881a, 0x1908, 0x140b], // RGBA16F, RGBA, HALF_FLOAT
  RGBA8: [0x8058, 0x1908, 0x1401], // RGBA8, RGBA, UNSIGNED_BYTE
  SRGB8_A8: [0x8c43, 0x1908, 0x1401], // SRGB8_ALPHA8, RGBA, UNSIGNED_BYTE
  R32UI: [0x8236, 0x8d94, 0x1405], // R32UI, RED_INTEGER, UNSIGNED_INT
  RG32UI: [0x823c, 0x8228, 0x1405], // RG32UI, RG_INTEGER, UNSIGNED_INT
  RGBA32F: [0x8814, 0x1908, 0x1406], // RGBA32F, RGBA, FLOAT
};

/** Internal format and extension of blocks. */
export const PACKED: Partial<Record<PixelFormat, [number, string]>> = {
  BC3: [0x83f3, "WEBGL_compressed_texture_s3tc"],
  BC3_SRGB: [0x8c4f, "WEBGL_compressed_texture_s3tc_srgb"],
  BC4: [0x8dbb, "EXT_texture_compression_rgtc"],
  BC6H: [0x8e8f, "EXT_texture_compression_bptc"],
  BC7: [0x8e8c, "EXT_texture_compression_bptc"],
  BC7_SRGB: [0x8e8d, "EXT_texture_compression_bptc"],
};

/** The limits of a device, and the formats that it knows. */
export interface Device {
  mostPixels: number;
  mostLayers: number;
  /** How many textures one shader may read. */
  mostTextures: number;
  /** Extensions of WebGL. */
  extensions: ReadonlySet<string>;
}

let own: Device | undefined;

/** What this device takes; asked once, of a context of its own. Throws a Problem where there is no WebGL 2. */
export function thisDevice(): Device {
  if (own) return own;
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) {
    throw new Problem(
      "This browser has no WebGL 2",
      "Use a browser of the last few years, and see that its settings allow hardware acceleration.",
    );
  }
  own = deviceOf(gl);
  gl.getExtension("WEBGL_lose_context")?.loseContext(); // browsers keep few contexts
  return own;
}

/** What the device of a context takes. */
export function deviceOf(gl: WebGL2RenderingContext): Device {
  return {
    mostPixels: gl.getParameter(gl.MAX_TEXTURE_SIZE) as number,
    mostLayers: gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS) as number,
    mostTextures: gl.getParameter(gl.MAX_TEXTURE_IMAGE_UNITS) as number,
    extensions: new Set(Object.values(PACKED).map(([, name]) => name).filter((name) => gl.getExtension(name))),
  };
}

/** Whether the device takes this format as it is. */
export function isTaken(device: Device, format: PixelFormat): boolean {
  const packed = PACKED[format];
  return !packed || device.extensions.has(packed[1]);
}

/** Throws a Problem for a texture that is too large for the device. */
export function checkSize(device: Device, entry: TextureEntry): void {
  const [width, height] = entry.size;
  if (Math.max(width, height) > device.mostPixels) {
    throw new Problem(
      `${entry.file} has ${width} × ${height} pixels; this device takes ${device.mostPixels} a side at most`,
      `Export again with --limit ${device.mostPixels}, or bake fewer texels.`,
      true,
    );
  }
  if (entry.layers > device.mostLayers) {
    throw new Problem(
      `${entry.file} has ${entry.layers} layers; this device takes ${device.mostLayers} at most`,
      "Export again with --arrangement matrix.",
      true,
    );
  }
}
