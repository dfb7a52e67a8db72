// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Textures of bakes on the devices that WebGPURenderer draws with: those of WebGPU, or of WebGL 2 where there is none.

import { LinearFilter, LinearMipmapLinearFilter, LinearMipmapNearestFilter, NearestFilter, UnsignedIntType } from "three";

import { withoutBlocks } from "./blocks.js";
import { BLOCKS, levelSize, type Pixels } from "./containers.js";
import { type Device as Limits, PACKED, thisDevice } from "./device.js";
import type { PixelFormat } from "./manifest.js";
import { Problem } from "./problem.js";
import type { BakeTexture } from "./textures.js";

/** What of a WebGPURenderer is used here. */
export interface GpuRenderer {
  backend: { isWebGPUBackend?: boolean; device?: Device; gl?: WebGL2RenderingContext };
}

/** A GPUDevice, as far as it is used: browsers' types have none yet. */
interface Device {
  features: ReadonlySet<string>;
  limits: { maxTextureDimension2D: number; maxTextureArrayLayers: number };
  queue: { writeTexture: (to: object, data: Uint8Array, layout: object, size: readonly number[]) => void };
  createTexture: (facts: object) => { destroy: () => void };
}

const FORMATS: Record<PixelFormat, string> = {
  RGB9E5: "rgb9e5ufloat",
  RGBA16F: "rgba16float",
  RGBA8: "rgba8unorm",
  SRGB8_A8: "rgba8unorm-srgb",
  BC3: "bc3-rgba-unorm",
  BC3_SRGB: "bc3-rgba-unorm-srgb",
  BC4: "bc4-r-unorm",
  BC6H: "bc6h-rgb-ufloat",
  BC7: "bc7-rgba-unorm",
  BC7_SRGB: "bc7-rgba-unorm-srgb",
  R32UI: "r32uint",
  RG32UI: "rg32uint",
  RGBA32F: "rgba32float",
};
const USAGE = 4 | 2; // TEXTURE_BINDING, COPY_DST

/** What WebGPU's devices take at least, where there is no WebGL 2 to be asked. */
export function deviceForNodes(): Limits {
  try {
    return thisDevice();
  } catch (error) {
    if (!(error instanceof Problem) || !("gpu" in navigator)) throw error;
    const extensions = new Set(Object.values(PACKED).map(([, name]) => name)); // unpacked later where it does not
    return { mostPixels: 8192, mostLayers: 256, mostTextures: 16, extensions };
  }
}

/** Put a texture onto the device of a renderer, once. Throws a Problem where it does not fit there. */
export function uploadByNodes(texture: BakeTexture, renderer: GpuRenderer): void {
  const { device, gl } = renderer.backend;
  if (!device && !gl) throw new Problem("This WebGPURenderer has no device yet", "Call `await renderer.init()` before.");
  setSampler(texture);
  if (gl) return texture.uploadTo(gl, null);
  texture.put(device as Device, null, (pixels) => created(device as Device, pixels, texture.entry.file));
}

/** Tell three.js what WebGL is told by textures.ts. */
function setSampler({ entry: { arrangement, format }, isArray, texture }: BakeTexture): void {
  const single = arrangement === "words" || arrangement === "tree";
  const smooth = arrangement === "image" || arrangement === "slices"; // the shader names levels of a matrix
  texture.magFilter = single ? NearestFilter : LinearFilter;
  texture.minFilter = single ? NearestFilter : smooth ? LinearMipmapLinearFilter : LinearMipmapNearestFilter;
  texture.anisotropy = arrangement === "slices" ? 8 : 1;
  texture.generateMipmaps = false;
  if (format === "R32UI" || format === "RG32UI") texture.type = UnsignedIntType;
  Object.assign(texture, { isArrayTexture: isArray });
}

function created(device: Device, given: Pixels, file: string): { handle: object; free: () => void } {
  const pixels = isTaken(device, given) ? given : withoutBlocks(given);
  const [side, bytes] = BLOCKS[pixels.format];
  const layers = Math.max(1, pixels.layers);
  const { maxTextureArrayLayers: mostLayers, maxTextureDimension2D: most } = device.limits;
  if (Math.max(...pixels.size) > most || layers > mostLayers) {
    const large = layers > mostLayers ? `${layers} layers, the renderer takes ${mostLayers}` : `${pixels.size.join(" × ")} pixels, the renderer takes ${most} a side`;
    throw new Problem(
      `${file} has ${large} at most`,
      "Give WebGPURenderer higher requiredLimits, or draw by WebGL 2: new WebGPURenderer({ forceWebGL: true }).",
      true,
    );
  }
  const handle = device.createTexture({
    size: [...pixels.size, layers],
    format: FORMATS[pixels.format],
    mipLevelCount: pixels.levels.length,
    usage: USAGE,
  });
  pixels.levels.forEach((data, mipLevel) => {
    const [width, height] = levelSize(pixels.size, mipLevel).map((length) => Math.ceil(length / side)) as [number, number];
    const layout = { bytesPerRow: width * bytes, rowsPerImage: height };
    device.queue.writeTexture({ texture: handle, mipLevel }, data, layout, [width * side, height * side, layers]);
  });
  return { handle, free: () => handle.destroy() };
}

/** Whether the device takes these pixels as they are: blocks must be whole. */
function isTaken({ features }: Device, { format, size }: Pixels): boolean {
  const [side] = BLOCKS[format];
  return side === 1 || (features.has("texture-compression-bc") && size.every((length) => length % side === 0));
}
