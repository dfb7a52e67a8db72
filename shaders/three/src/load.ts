// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// From an address to an object in a scene.

import { type Device, thisDevice } from "./device";
import { fileUrl } from "./fetching";
import { loadTextures, type TextureOptions } from "./load_textures";
import { checkManifest, type Manifest, readManifest } from "./manifest";
import { bakeBelow, loadMeshFile } from "./mesh_file";
import { Problem } from "./problem";
import { RadTexObject } from "./radtex_object";

export interface LoadOptions extends TextureOptions {
  /** What the device takes; by default this one is asked. */
  device?: Device;
}

/** A bake that can be drawn. */
export interface RadTex {
  /** Shows the flat lightmap at first, and the radiance from when `complete` is fulfilled. */
  object: RadTexObject;
  manifest: Manifest;
  /**
   * Fulfilled when all textures are there, or the device cannot take them: `object.problem` says why then. Rejected with
   * a Problem for a file that is missing or damaged.
   */
  complete: Promise<void>;
}

/**
 * Load an export of RadTex by the address of its NAME.export.json or NAME.glb, relative to the page.
 *
 * Fulfilled as soon as the object can be drawn with its flat lightmap; await `complete` for the whole. Rejected with a
 * Problem, whose `message` and `remedy` are for people, where a file is missing, damaged, or of a newer version.
 */
export async function loadRadTex(address: string | URL, options: LoadOptions = {}): Promise<RadTex> {
  const url = new URL(address, document.baseURI);
  const device = options.device ?? thisDevice();
  const [manifest, early] = url.pathname.endsWith(".glb") ? await manifestOfMesh(url) : [await readManifest(url), null];
  const textures = loadTextures(manifest, url, device, options);
  textures.catch(() => undefined); // `complete` tells it
  const mesh = fileUrl(manifest.mesh, url);
  const { parts, map } = bakeBelow(early ?? (await loadMeshFile(mesh)), mesh);
  const object = new RadTexObject(manifest, parts, map);
  return { object, manifest, complete: completed(object, textures) };
}

/** What a .glb says of its bake, and its contents. */
async function manifestOfMesh(url: URL): Promise<[Manifest, Awaited<ReturnType<typeof loadMeshFile>>]> {
  const root = await loadMeshFile(url);
  return [checkManifest(bakeBelow(root, url).facts, url), root];
}

async function completed(object: RadTexObject, textures: ReturnType<typeof loadTextures>): Promise<void> {
  try {
    object.take(object.manifest, await textures);
  } catch (error) {
    if (!(error instanceof Problem) || !error.ofDevice) throw error;
    object.problem = error;
  }
}
