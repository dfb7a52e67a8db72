// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// KTX2 and DDS files, unpacked: formats/ktx2.py and formats/dds.py write them.

import { KHR_SUPERCOMPRESSION_NONE, KHR_SUPERCOMPRESSION_ZSTD, read } from "ktx-parse";
import { ZSTDDecoder } from "zstddec";

import type { PixelFormat, Size, TextureEntry } from "./manifest.js";
import { Problem } from "./problem.js";

/** Pixels as a GPU takes them: each level with all its layers, the first row at the bottom. */
export interface Pixels {
  format: PixelFormat;
  size: Size;
  /** 0 where the texture is no array. */
  layers: number;
  levels: Uint8Array[];
}

/** A block's side in pixels, and its bytes. */
export const BLOCKS: Record<PixelFormat, Size> = {
  RGB9E5: [1, 4],
  RGBA16F: [1, 8],
  RGBA8: [1, 4],
  SRGB8_A8: [1, 4],
  BC3: [4, 16],
  BC3_SRGB: [4, 16],
  BC4: [4, 8],
  BC6H: [4, 16],
  BC7: [4, 16],
  BC7_SRGB: [4, 16],
  R32UI: [1, 4],
  RG32UI: [1, 8],
  RGBA32F: [1, 16],
};

const VK_FORMATS = new Map<number, PixelFormat>([
  [97, "RGBA16F"],
  [123, "RGB9E5"],
  [137, "BC3"],
  [138, "BC3_SRGB"],
  [139, "BC4"],
  [143, "BC6H"],
  [145, "BC7"],
  [146, "BC7_SRGB"],
  [37, "RGBA8"],
  [98, "R32UI"],
  [101, "RG32UI"],
  [109, "RGBA32F"],
]);
const DXGI_FORMATS = new Map<number, PixelFormat>([
  [10, "RGBA16F"],
  [28, "RGBA8"],
  [77, "BC3"],
  [78, "BC3_SRGB"],
  [80, "BC4"],
  [95, "BC6H"],
  [98, "BC7"],
  [99, "BC7_SRGB"],
]);
const DDS_HEAD = 148; // "DDS ", DDS_HEADER, DDS_HEADER_DXT10

/** Unpack a file of the export. Throws a Problem where it is damaged or not what the manifest says. */
export async function unpack(bytes: Uint8Array<ArrayBuffer>, entry: TextureEntry): Promise<Pixels> {
  if (entry.container === "exr") {
    throw new Problem(`${entry.file} is an EXR, which this page does not read`, "Export with --format auto.");
  }
  const pixels = entry.container === "dds" ? fromDds(bytes, entry) : await fromKtx2(bytes, entry);
  const [width, height] = pixels.size;
  if (pixels.format !== entry.format || width !== entry.size[0] || height !== entry.size[1]) {
    throw damaged(entry, `it holds ${pixels.format} of ${width} × ${height} pixels`);
  }
  if (pixels.levels.length < entry.levels || Math.max(1, pixels.layers) !== entry.layers) {
    throw damaged(entry, `it has ${pixels.levels.length} levels and ${Math.max(1, pixels.layers)} layers`);
  }
  pixels.levels.forEach((level, number) => {
    if (level.byteLength !== levelBytes(pixels, number)) throw damaged(entry, `its level ${number} is cut short`);
  });
  return pixels;
}

/** How many bytes a level has on the GPU. */
export function levelBytes(pixels: Pixels, level: number): number {
  const [side, bytes] = BLOCKS[pixels.format];
  const [columns, rows] = levelSize(pixels.size, level).map((pixelsWide) => Math.ceil(pixelsWide / side)) as Size;
  return columns * rows * bytes * Math.max(1, pixels.layers);
}

/** A mip level's size in pixels. */
export function levelSize([width, height]: Size, level: number): Size {
  return [Math.max(1, width >> level), Math.max(1, height >> level)];
}

async function fromKtx2(bytes: Uint8Array<ArrayBuffer>, entry: TextureEntry): Promise<Pixels> {
  let container;
  try {
    container = read(bytes);
  } catch {
    throw damaged(entry, "it cannot be read as KTX2");
  }
  const format = VK_FORMATS.get(container.vkFormat);
  if (!format) throw damaged(entry, `it holds the unknown VkFormat ${container.vkFormat}`);
  const levels = await Promise.all(
    container.levels.map(async (level, number) => {
      switch (container.supercompressionScheme) {
        case KHR_SUPERCOMPRESSION_NONE:
          return level.levelData;
        case KHR_SUPERCOMPRESSION_ZSTD:
          return unzstd(level.levelData, level.uncompressedByteLength, entry, number);
        default:
          throw damaged(entry, `it is packed by the unknown scheme ${container.supercompressionScheme}`);
      }
    }),
  );
  return { format, size: [container.pixelWidth, container.pixelHeight], layers: container.layerCount, levels };
}

async function unzstd(packed: Uint8Array, size: number, entry: TextureEntry, level: number): Promise<Uint8Array> {
  const decoder = new ZSTDDecoder();
  await decoder.init();
  const unpacked = decoder.decode(packed, size);
  if (unpacked.byteLength !== size) throw damaged(entry, `its level ${level} does not unpack`);
  return unpacked;
}

function fromDds(bytes: Uint8Array<ArrayBuffer>, entry: TextureEntry): Pixels {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const word = (offset: number): number => view.getUint32(offset, true);
  if (bytes.byteLength < DDS_HEAD || word(0) !== 0x20534444 || word(84) !== 0x30315844) {
    throw damaged(entry, "it cannot be read as DDS");
  }
  const format = DXGI_FORMATS.get(word(128));
  if (!format) throw damaged(entry, `it holds the unknown DXGI format ${word(128)}`);
  const count = word(140);
  const pixels: Pixels = { format, size: [word(16), word(12)], layers: count > 1 ? count : 0, levels: [] };
  const levels = Math.min(32, Math.max(1, word(28)));
  const lengths = Array.from({ length: levels }, (_, level) => levelBytes({ ...pixels, layers: 0 }, level));
  const ofLayer = lengths.reduce((total, length) => total + length, 0);
  let begin = DDS_HEAD; // in a DDS each layer has all its levels; a GPU takes each level with all its layers
  for (const length of lengths) {
    const level = new Uint8Array(length * Math.max(1, count));
    for (let layer = 0; layer < Math.max(1, count); layer++) {
      const part = bytes.subarray(begin + layer * ofLayer, begin + layer * ofLayer + length);
      if (part.byteLength !== length) throw damaged(entry, "it is cut short");
      level.set(part, layer * length);
    }
    pixels.levels.push(level);
    begin += length;
  }
  return pixels;
}

function damaged(entry: TextureEntry, reason: string): Problem {
  return new Problem(`${entry.file} is damaged: ${reason}`, "Copy it once more, or export the object again.");
}
