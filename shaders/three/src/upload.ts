// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Pixels onto a device of WebGL 2, whichever library draws with it.

import { levelSize, type Pixels } from "./containers.js";
import { PACKED, PLAIN } from "./device.js";
import type { TextureEntry } from "./manifest.js";
import { Problem } from "./problem.js";

/** Call `act`, and leave the state of the context that it changes as three.js knows it. */
export function withStateKept<Result>(gl: WebGL2RenderingContext, isArray: boolean, act: () => Result): Result {
  const target = isArray ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D;
  const bound = gl.getParameter(isArray ? gl.TEXTURE_BINDING_2D_ARRAY : gl.TEXTURE_BINDING_2D) as WebGLTexture | null;
  const names = [gl.UNPACK_FLIP_Y_WEBGL, gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, gl.UNPACK_ALIGNMENT] as const;
  const before = names.map((name) => gl.getParameter(name) as number | boolean);
  const buffer = gl.getParameter(gl.PIXEL_UNPACK_BUFFER_BINDING) as WebGLBuffer | null;
  try {
    return act();
  } finally {
    names.forEach((name, place) => gl.pixelStorei(name, before[place] as number | boolean));
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, buffer);
    gl.bindTexture(target, bound);
  }
}

/** A new texture with these pixels. Throws a Problem where it does not fit into the device's memory. */
export function uploaded(gl: WebGL2RenderingContext, pixels: Pixels, entry: TextureEntry): WebGLTexture {
  return withStateKept(gl, pixels.layers > 0, () => created(gl, pixels, entry));
}

function created(gl: WebGL2RenderingContext, pixels: Pixels, entry: TextureEntry): WebGLTexture {
  const handle = gl.createTexture();
  const isArray = pixels.layers > 0;
  const target = isArray ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D;
  const internal = (PLAIN[pixels.format] ?? PACKED[pixels.format])?.[0] ?? 0;
  const [width, height] = pixels.size;
  const extension = PACKED[pixels.format]?.[1];
  if (extension) gl.getExtension(extension);
  gl.bindTexture(target, handle);
  if (isArray) gl.texStorage3D(target, pixels.levels.length, internal, width, height, pixels.layers);
  else gl.texStorage2D(target, pixels.levels.length, internal, width, height);
  gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
  gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, null);
  pixels.levels.forEach((_, level) => uploadLevel(gl, pixels, level));
  const single = entry.arrangement === "words" || entry.arrangement === "tree"; // there is nothing between them
  const filter = single ? gl.NEAREST : gl.LINEAR;
  gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, filter);
  // Mip levels of a matrix are always named, and blended by the shader; a picture's are blended by the device.
  const between = entry.arrangement === "image" ? gl.LINEAR_MIPMAP_LINEAR : gl.LINEAR_MIPMAP_NEAREST;
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, pixels.levels.length > 1 ? between : filter);
  gl.texParameteri(target, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(target, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  if (gl.getError() === gl.OUT_OF_MEMORY) {
    gl.deleteTexture(handle);
    throw new Problem(
      `${entry.file} does not fit into this device’s memory`,
      "Close other tabs, or bake fewer texels or smaller buckets.",
      true,
    );
  }
  return handle;
}

function uploadLevel(gl: WebGL2RenderingContext, pixels: Pixels, level: number): void {
  const [width, height] = levelSize(pixels.size, level);
  const data = pixels.levels[level] as Uint8Array<ArrayBuffer>;
  const depth = pixels.layers;
  const plain = PLAIN[pixels.format];
  if (!plain) {
    const internal = PACKED[pixels.format]?.[0] ?? 0;
    if (depth) gl.compressedTexSubImage3D(gl.TEXTURE_2D_ARRAY, level, 0, 0, 0, width, height, depth, internal, data);
    else gl.compressedTexSubImage2D(gl.TEXTURE_2D, level, 0, 0, width, height, internal, data);
    return;
  }
  const [, format, type] = plain;
  const values = typed(data, type);
  if (depth) gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, level, 0, 0, 0, width, height, depth, format, type, values);
  else gl.texSubImage2D(gl.TEXTURE_2D, level, 0, 0, width, height, format, type, values);
}

/** The bytes in the array type that WebGL wants for a type of pixel; copied where they lie at an odd place. */
function typed(data: Uint8Array<ArrayBuffer>, type: number): Uint8Array | Uint16Array | Uint32Array | Float32Array {
  const bytes = data.byteOffset % 4 ? data.slice() : data;
  if (type === 0x8c3e || type === 0x1405) return new Uint32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 4);
  if (type === 0x1406) return new Float32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 4);
  if (type === 0x140b) return new Uint16Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 2);
  return bytes;
}
