// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Textures on the GPU, without three.js's own upload: it knows neither all formats nor mip levels of arrays.

import { ExternalTexture, type WebGLRenderer } from "three";

import { withoutBlocks } from "./blocks";
import { levelBytes, levelSize, type Pixels, unpack } from "./containers";
import { fetchBytes, fileUrl } from "./fetching";
import type { Manifest, PixelFormat, TextureEntry } from "./manifest";
import { Problem } from "./problem";

/** A texture that shaders read, and what it takes. */
export interface Loaded {
  texture: ExternalTexture;
  entry: TextureEntry;
  /** On the GPU. */
  bytes: number;
  /** As a file. */
  fileBytes: number;
  isArray: boolean;
  handle: WebGLTexture;
}

/** Internal format, format and type of pixels; internal format and extension of blocks. */
const PLAIN: Partial<Record<PixelFormat, [number, number, number]>> = {
  RGB9E5: [0x8c3d, 0x1907, 0x8c3e], // RGB9_E5, RGB, UNSIGNED_INT_5_9_9_9_REV
  RGBA16F: [0x881a, 0x1908, 0x140b], // RGBA16F, RGBA, HALF_FLOAT
  RGBA8: [0x8058, 0x1908, 0x1401], // RGBA8, RGBA, UNSIGNED_BYTE
  SRGB8_A8: [0x8c43, 0x1908, 0x1401], // SRGB8_ALPHA8, RGBA, UNSIGNED_BYTE
  R32UI: [0x8236, 0x8d94, 0x1405], // R32UI, RED_INTEGER, UNSIGNED_INT
  RG32UI: [0x823c, 0x8228, 0x1405], // RG32UI, RG_INTEGER, UNSIGNED_INT
  RGBA32F: [0x8814, 0x1908, 0x1406], // RGBA32F, RGBA, FLOAT
};
const PACKED: Partial<Record<PixelFormat, [number, string]>> = {
  BC3: [0x83f3, "WEBGL_compressed_texture_s3tc"],
  BC3_SRGB: [0x8c4f, "WEBGL_compressed_texture_s3tc_srgb"],
  BC4: [0x8dbb, "EXT_texture_compression_rgtc"],
  BC6H: [0x8e8f, "EXT_texture_compression_bptc"],
  BC7: [0x8e8c, "EXT_texture_compression_bptc"],
  BC7_SRGB: [0x8e8d, "EXT_texture_compression_bptc"],
};

/** Fetch and upload all textures of a manifest. Throws a Problem for the first that cannot be had. */
export async function loadTextures(
  renderer: WebGLRenderer,
  manifest: Manifest,
  base: URL,
  progressed: (done: number, all: number) => void,
  address: (url: URL) => URL = (url) => url,
): Promise<Map<string, Loaded>> {
  const gl = renderer.getContext() as WebGL2RenderingContext;
  const { mirror } = manifest;
  const entries = Object.entries({ ...manifest.textures, ...(mirror ? { mirror } : {}) });
  for (const [, entry] of entries) checkDevice(gl, entry);
  const loaded = new Map<string, Loaded>();
  const load = async ([name, entry]: [string, TextureEntry]): Promise<void> => {
    const bytes = await fetchBytes(address(fileUrl(entry.file, base)));
    const pixels = await unpack(bytes, entry);
    loaded.set(name, upload(gl, known(gl, pixels) ? pixels : withoutBlocks(pixels), entry, bytes.byteLength));
    progressed(loaded.size, entries.length);
  };
  await Promise.all(entries.map(load));
  renderer.resetState();
  return loaded;
}

/** Let an array of slices blend its mip levels, or keep to the finest. */
export function blendLevels(renderer: WebGLRenderer, loaded: Loaded, blend: boolean): void {
  const gl = renderer.getContext() as WebGL2RenderingContext;
  const target = loaded.isArray ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D;
  gl.bindTexture(target, loaded.handle);
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, blend ? gl.LINEAR_MIPMAP_LINEAR : gl.LINEAR);
  const anisotropic = gl.getExtension("EXT_texture_filter_anisotropic");
  if (anisotropic) {
    const most = blend ? Math.min(8, gl.getParameter(anisotropic.MAX_TEXTURE_MAX_ANISOTROPY_EXT) as number) : 1;
    gl.texParameterf(target, anisotropic.TEXTURE_MAX_ANISOTROPY_EXT, most);
  }
  renderer.resetState();
}

function checkDevice(gl: WebGL2RenderingContext, entry: TextureEntry): void {
  const most = gl.getParameter(gl.MAX_TEXTURE_SIZE) as number;
  const mostLayers = gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS) as number;
  const [width, height] = entry.size;
  if (Math.max(width, height) > most) {
    throw new Problem(
      `${entry.file} has ${width} × ${height} pixels; this device takes ${most} a side at most`,
      `Export again with --limit ${most}, or bake fewer texels.`,
    );
  }
  if (entry.layers > mostLayers) {
    throw new Problem(
      `${entry.file} has ${entry.layers} layers; this device takes ${mostLayers} at most`,
      "Export again with --arrangement matrix.",
    );
  }
}

/** Whether the device takes these blocks as they are; it does take pixels. */
function known(gl: WebGL2RenderingContext, pixels: Pixels): boolean {
  const packed = PACKED[pixels.format];
  return !packed || gl.getExtension(packed[1]) !== null;
}

function upload(gl: WebGL2RenderingContext, pixels: Pixels, entry: TextureEntry, fileBytes: number): Loaded {
  const handle = gl.createTexture();
  const isArray = pixels.layers > 0;
  const target = isArray ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D;
  const internal = (PLAIN[pixels.format] ?? PACKED[pixels.format])?.[0] ?? 0;
  const [width, height] = pixels.size;
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
    throw new Problem(`${entry.file} does not fit into this device's memory`, "Bake fewer texels or smaller buckets.");
  }
  const bytes = pixels.levels.reduce((total, _, level) => total + levelBytes(pixels, level), 0);
  return { texture: new ExternalTexture(handle), entry, bytes, fileBytes, isArray, handle };
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
