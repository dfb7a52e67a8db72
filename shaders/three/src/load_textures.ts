// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// All textures of a bake from their files.

import { withoutBlocks } from "./blocks";
import { unpack } from "./containers";
import { checkSize, type Device, isTaken } from "./device";
import { fetchBytes, fileUrl } from "./fetching";
import type { Manifest, TextureEntry } from "./manifest";
import { BakeTexture } from "./textures";

export interface TextureOptions {
  /** Called whenever a texture is there. */
  progressed?: ((done: number, all: number) => void) | undefined;
  /** Another address for each file's. */
  address?: ((url: URL) => URL) | undefined;
}

/** Fetch and unpack the textures of a manifest, which lies at `base`. Throws a Problem for the first that fails. */
export async function loadTextures(
  manifest: Manifest,
  base: URL,
  device: Device,
  { progressed, address = (url) => url }: TextureOptions = {},
): Promise<Map<string, BakeTexture>> {
  const { mirror } = manifest;
  const entries = Object.entries({ ...manifest.textures, ...(mirror ? { mirror } : {}) });
  for (const [, entry] of entries) checkSize(device, entry);
  const loaded = new Map<string, BakeTexture>();
  const load = async ([name, entry]: [string, TextureEntry]): Promise<void> => {
    const bytes = await fetchBytes(address(fileUrl(entry.file, base)), "low");
    const pixels = await unpack(bytes, entry);
    const taken = isTaken(device, pixels.format) ? pixels : withoutBlocks(pixels);
    loaded.set(name, new BakeTexture(entry, taken, bytes.byteLength));
    progressed?.(loaded.size, entries.length);
  };
  await Promise.all(entries.map(load));
  return loaded;
}
