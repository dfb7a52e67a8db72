// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// A bake's textures in Babylon.js, without its own loaders: they do not know all formats.

import type { Engine } from "@babylonjs/core/Engines/engine.js";
import { BaseTexture } from "@babylonjs/core/Materials/Textures/baseTexture.js";
import { Texture } from "@babylonjs/core/Materials/Textures/texture.js";
import type { Scene } from "@babylonjs/core/scene.js";

import { withoutBlocks } from "../../three/src/blocks.js";
import { unpack } from "../../three/src/containers.js";
import { checkSize, type Device, isTaken } from "../../three/src/device.js";
import { fetchBytes, fileUrl } from "../../three/src/fetching.js";
import type { TextureEntry } from "../../three/src/manifest.js";
import type { Requests } from "../../three/src/requests.js";
import { uploaded } from "../../three/src/upload.js";

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
