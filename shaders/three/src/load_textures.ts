// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// All textures of a bake from their files.

import { withoutBlocks } from "./blocks.js";
import { unpack } from "./containers.js";
import { checkSize, type Device, isTaken } from "./device.js";
import { fetchBytes, fileUrl } from "./fetching.js";
import type { Manifest, TextureEntry } from "./manifest.js";
import type { Requests } from "./requests.js";
import { BakeTexture } from "./textures.js";

export interface TextureOptions {
  /** Called whenever a texture is there. */
  progressed?: ((done: number, all: number) => void) | undefined;
  /** Another address for each file's. */
  address?: ((url: URL) => URL) | undefined;
  /** Textures that other bakes have asked for, by their addresses: what several share is loaded once. */
  shared?: Map<string, Promise<BakeTexture>> | undefined;
  /** How files are asked for. */
  requests?: Requests | undefined;
}

/** Fetch and unpack the textures of a manifest, which lies at `base`. Throws a Problem for the first that fails. */
export async function loadTextures(
  manifest: Manifest,
  base: URL,
  device: Device,
  { progressed, address = (url) => url, shared = new Map(), requests }: TextureOptions = {},
): Promise<Map<string, BakeTexture>> {
  const entries = entriesOf(manifest);
  for (const [, entry] of entries) checkSize(device, entry);
  const loaded = new Map<string, BakeTexture>();
  const load = async ([name, entry]: [string, TextureEntry]): Promise<void> => {
    const url = address(fileUrl(entry.file, base));
    const texture = shared.get(url.href) ?? loadTexture(url, entry, device, requests);
    shared.set(url.href, texture);
    loaded.set(name, await texture);
    progressed?.(loaded.size, entries.length);
  };
  await Promise.all(entries.map(load));
  return loaded;
}

/** All textures of a manifest, by their names. */
export function entriesOf({ textures, mirror }: Manifest): [string, TextureEntry][] {
  return Object.entries({ ...textures, ...(mirror ? { mirror } : {}) });
}

async function loadTexture(url: URL, entry: TextureEntry, device: Device, requests?: Requests): Promise<BakeTexture> {
  const bytes = await fetchBytes(url, "low", requests);
  const pixels = await unpack(bytes, entry);
  return new BakeTexture(entry, isTaken(device, pixels.format) ? pixels : withoutBlocks(pixels), bytes.byteLength);
}
