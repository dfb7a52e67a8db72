// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Blocks of 4 x 4 pixels, unpacked here for devices that know none of their formats, as phones do. Only what RadTex
// writes is decoded: BC7 of mode 6 and BC6H of mode 11. radtex_addon/formats/codecs is the reference.

import { levelSize, type Pixels } from "./containers.js";
import type { PixelFormat } from "./manifest.js";

/** What the pixels of blocks become. */
const UNPACKED: Partial<Record<PixelFormat, PixelFormat>> = {
  BC3: "RGBA8",
  BC3_SRGB: "SRGB8_A8",
  BC4: "RGBA8",
  BC6H: "RGB9E5",
  BC7: "RGBA8",
  BC7_SRGB: "SRGB8_A8",
};

const SIDE = 4;
const WEIGHTS = [0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64];

/** Sixteen pixels of four bytes each, of the block that begins at `at`. */
type Decoder = (bytes: DataView, at: number, pixels: Uint8Array) => void;

/** The same picture in pixels, or as it is where its format has no blocks. */
export function withoutBlocks(packed: Pixels): Pixels {
  const format = UNPACKED[packed.format];
  const decode = DECODERS[packed.format];
  if (!format || !decode) return packed;
  const layers = Math.max(1, packed.layers);
  const levels = packed.levels.map((level, number) => {
    const [width, height] = levelSize(packed.size, number);
    const [values, size] = [4 * width * height, level.byteLength / layers];
    const image = new Uint8Array(values * layers);
    for (let layer = 0; layer < layers; layer++) {
      const from = level.subarray(layer * size, (layer + 1) * size);
      unpackLevel(from, decode, image.subarray(layer * values, (layer + 1) * values), width, height);
    }
    return image;
  });
  return { ...packed, format, levels };
}

function unpackLevel(
  level: Uint8Array,
  decode: Decoder,
  image: Uint8Array,
  width: number,
  height: number,
): void {
  const columns = Math.ceil(width / SIDE);
  const rows = Math.ceil(height / SIDE);
  const bytes = new DataView(level.buffer, level.byteOffset, level.byteLength);
  const size = level.byteLength / (columns * rows);
  const block = new Uint8Array(4 * SIDE * SIDE);
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      decode(bytes, (row * columns + column) * size, block);
      const wide = 4 * Math.min(SIDE, width - column * SIDE);
      for (let y = 0; y < Math.min(SIDE, height - row * SIDE); y++) {
        const begin = 4 * ((row * SIDE + y) * width + column * SIDE);
        image.set(block.subarray(4 * SIDE * y, 4 * SIDE * y + wide), begin);
      }
    }
  }
}

/** `count` bits from bit `first` of the 128 from byte `at` on; at most 32. */
function bits(bytes: DataView, at: number, first: number, count: number): number {
  let found = 0;
  for (let bit = 0; bit < count; bit++) {
    const place = first + bit;
    found |= ((bytes.getUint8(at + (place >> 3)) >> (place & 7)) & 1) << bit;
  }
  return found >>> 0;
}

/** The weights of the sixteen pixels of a line with indices of four bits, the first of which has three. */
function weight(bytes: DataView, at: number, pixel: number): number {
  const index = pixel ? bits(bytes, at, 64 + 4 * pixel, 4) : bits(bytes, at, 65, 3);
  return WEIGHTS[index] as number;
}

function between(first: number, last: number, weight: number): number {
  return (first * (64 - weight) + last * weight + 32) >> 6;
}

const bc7: Decoder = (bytes, at, pixels) => {
  // Of each channel the first end, then the last one; their lowest bits are the channels' in common.
  const ends = Array.from({ length: 8 }, (_, field) => (bits(bytes, at, 7 + 7 * field, 7) << 1) | bits(bytes, at, 63 + (field & 1), 1));
  for (let pixel = 0; pixel < 16; pixel++) {
    const along = weight(bytes, at, pixel);
    for (let channel = 0; channel < 4; channel++) {
      pixels[4 * pixel + channel] = between(ends[2 * channel] as number, ends[2 * channel + 1] as number, along);
    }
  }
};

const bc6h: Decoder = (bytes, at, pixels) => {
  const ends = Array.from({ length: 6 }, (_, field) => {
    const code = bits(bytes, at, 5 + 10 * field, 10);
    return code === 0 ? 0 : code === 1023 ? 65535 : 64 * code + 32;
  });
  const half = (channel: number, along: number): number =>
    (between(ends[channel] as number, ends[3 + channel] as number, along) * 31) >> 6;
  for (let pixel = 0; pixel < 16; pixel++) {
    const along = weight(bytes, at, pixel);
    sharedExponent(half(0, along), half(1, along), half(2, along), pixels, 4 * pixel);
  }
};

/** Three half floats of no sign, as their bits, with one exponent for all: four bytes of RGB9E5 from `place` on. */
function sharedExponent(red: number, green: number, blue: number, pixels: Uint8Array, place: number): void {
  const most = Math.max(red, green, blue);
  let exponent = most < 1024 ? (most < 512 ? -16 : -15) : (most >> 10) - 15; // of two, the greatest's
  if (Math.round(valueOf(most) * 2 ** (8 - exponent)) > 511 && exponent < 15) exponent++;
  const rounded = (half: number): number => Math.min(Math.round(valueOf(half) * 2 ** (8 - exponent)), 511);
  const packed = rounded(red) | (rounded(green) << 9) | (rounded(blue) << 18) | ((exponent + 16) << 27);
  for (let byte = 0; byte < 4; byte++) pixels[place + byte] = packed >>> (8 * byte);
}

/** A half float's value, of its bits. */
function valueOf(half: number): number {
  const power = half >> 10;
  return power === 0 ? half * 2 ** -24 : (1024 + (half & 1023)) * 2 ** (power - 25);
}

/** One channel, as BC4 has it and BC3 has its alpha, into the pixels from number `first` on. */
function single(bytes: DataView, at: number, pixels: Uint8Array, first: number): void {
  const one = bytes.getUint8(at);
  const two = bytes.getUint8(at + 1);
  const steps = one > two ? 7 : 5;
  for (let pixel = 0; pixel < 16; pixel++) {
    const index = bits(bytes, at, 16 + 3 * pixel, 3);
    const place = index > 1 ? index - 1 : steps * index;
    const mixed = (one * (steps - place) + two * place) / steps;
    pixels[4 * pixel + first] = Math.round(index > steps ? 255 * (index - 6) : mixed); // 6 and 7: black and white
  }
}

const bc4: Decoder = (bytes, at, pixels) => {
  pixels.fill(0);
  single(bytes, at, pixels, 0);
};

const bc3: Decoder = (bytes, at, pixels) => {
  single(bytes, at, pixels, 3);
  for (const [channel, place, count] of [[0, 11, 5], [1, 5, 6], [2, 0, 5]] as const) {
    const most = (1 << count) - 1;
    const one = (255 * bits(bytes, at, 64 + place, count)) / most;
    const two = (255 * bits(bytes, at, 80 + place, count)) / most;
    for (let pixel = 0; pixel < 16; pixel++) {
      const index = bits(bytes, at, 96 + 2 * pixel, 2);
      const thirds = [0, 3, 1, 2][index] as number;
      pixels[4 * pixel + channel] = Math.round((one * (3 - thirds) + two * thirds) / 3);
    }
  }
};

const DECODERS: Partial<Record<PixelFormat, Decoder>> = {
  BC3: bc3,
  BC3_SRGB: bc3,
  BC4: bc4,
  BC6H: bc6h,
  BC7: bc7,
  BC7_SRGB: bc7,
};
