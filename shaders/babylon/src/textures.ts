// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// A bake's textures in Babylon.js, without its own loaders: they do not know all formats.

import type { Engine } from "@babylonjs/core/Engines/engine.js";
import { BaseTexture } from "@babylonjs/core/Materials/Textures/baseTexture.js";
import { Texture } from "@babylonjs/core/Materials/Textures/texture.js";
import type { Scene } from "@babylonjs/core/scene.js";

import { withoutBlocks } from "../../three/src/blocks.js";
import { levelSize, type Pixels, unpack } from "../../three/src/containers.js";
import { checkSize, type Device, isTaken, PACKED, PLAIN } from "../../three/src/device.js";
import { fetchBytes, fileUrl } from "../../three/src/fetching.js";
import type { TextureEntry } from "../../three/src/manifest.js";
import { Problem } from "../../three/src/problem.js";
import type { Requests } from "../../three/src/requests.js";

/** Fetch a texture that lies beside the file at `base`. Throws a Problem where it is missing, damaged or too large. */
export async function loadTexture(
  entry: TextureEntry,
  base: URL,
  scene: Scene,
  device: Device,
  requests: Requests,
): Promise<BaseTexture> {
  checkSize(device, entry);
  const bytes = await fetchBytes(fileUrl(entry.file, base), "low", requests);
  const pixels = await unpack(bytes, entry);
  const engine = scene.getEngine() as Engine;
  const handle = uploaded(engine._gl, isTaken(device, pixels.format) ? pixels : withoutBlocks(pixels), entry);
  // A picture's mip levels are blended; those of a matrix are named by the shader.
  const sampling = entry.arrangement === "image" ? Texture.TRILINEAR_SAMPLINGMODE : Texture.LINEAR_LINEAR_MIPNEAREST;
  const texture = new BaseTexture(
    scene,
    engine.wrapWebGLTexture(handle, pixels.levels.length > 1, sampling, pixels.size[0], pixels.size[1]),
  );
  texture.name = entry.file;
  texture.wrapU = texture.wrapV = Texture.CLAMP_ADDRESSMODE;
  texture.anisotropicFilteringLevel = 1;
  texture.gammaSpace = false;
  return texture;
}

/** A new texture with these pixels; the context's state is as it was. */
function uploaded(gl: WebGL2RenderingContext, pixels: Pixels, entry: TextureEntry): WebGLTexture {
  const bound = gl.getParameter(gl.TEXTURE_BINDING_2D) as WebGLTexture | null;
  const names = [gl.UNPACK_FLIP_Y_WEBGL, gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, gl.UNPACK_ALIGNMENT] as const;
  const before = names.map((name) => gl.getParameter(name) as number | boolean);
  const buffer = gl.getParameter(gl.PIXEL_UNPACK_BUFFER_BINDING) as WebGLBuffer | null;
  const handle = gl.createTexture();
  names.forEach((name, place) => gl.pixelStorei(name, [false, false, 1][place] as number | boolean));
  gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, null);
  gl.bindTexture(gl.TEXTURE_2D, handle);
  const [internal, extension] = PACKED[pixels.format] ?? [PLAIN[pixels.format]?.[0] ?? 0, ""];
  if (extension) gl.getExtension(extension);
  gl.texStorage2D(gl.TEXTURE_2D, pixels.levels.length, internal, ...pixels.size);
  pixels.levels.forEach((_, level) => uploadLevel(gl, pixels, level));
  names.forEach((name, place) => gl.pixelStorei(name, before[place] as number | boolean));
  gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, buffer);
  gl.bindTexture(gl.TEXTURE_2D, bound);
  if (gl.getError() !== gl.OUT_OF_MEMORY) return handle;
  gl.deleteTexture(handle);
  throw new Problem(
    `${entry.file} does not fit into this device’s memory`,
    "Close other tabs, or bake fewer texels or smaller buckets.",
    true,
  );
}

function uploadLevel(gl: WebGL2RenderingContext, pixels: Pixels, level: number): void {
  const [width, height] = levelSize(pixels.size, level);
  const data = (pixels.levels[level] as Uint8Array<ArrayBuffer>).slice(); // at an even place
  const packed = PACKED[pixels.format];
  if (packed) {
    gl.compressedTexSubImage2D(gl.TEXTURE_2D, level, 0, 0, width, height, packed[0], data);
    return;
  }
  const [, format, type] = PLAIN[pixels.format] as [number, number, number];
  const bytesOf = new Map<number, new (buffer: ArrayBuffer) => ArrayBufferView>([
    [gl.UNSIGNED_BYTE, Uint8Array],
    [gl.HALF_FLOAT, Uint16Array],
    [gl.FLOAT, Float32Array],
  ]);
  const values = new (bytesOf.get(type) ?? Uint32Array)(data.buffer);
  gl.texSubImage2D(gl.TEXTURE_2D, level, 0, 0, width, height, format, type, values);
}
