// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Take in new textures of the bake that is shown, while it is refined: ?watch, or ?watch=5 for each five seconds.

import { thisDevice } from "../src/device";
import { loadTextures } from "../src/load_textures";
import { type Manifest, readManifest } from "../src/manifest";
import type { Viewer } from "./viewer";

const SECONDS = 2;

/** Look for other textures of the same bake, if the address says so. */
export function watch(viewer: Viewer, url: URL, changed: () => void): void {
  const asked = new URLSearchParams(location.search).get("watch");
  if (asked === null || viewer.shown.parts.length > 1) return; // a whole scene is not refined as one
  const pause = 1000 * (Number(asked) > 0 ? Number(asked) : SECONDS);
  let seen = JSON.stringify(viewer.manifest);
  let shownNow = seen;
  const look = async (): Promise<void> => {
    const manifest = await readManifest(fresh(url));
    const found = JSON.stringify(manifest);
    const settled = found === seen; // an export moves its files one by one: take what was there a while ago, too
    seen = found;
    if (!settled || found === shownNow || !sameSurface(manifest, viewer.manifest)) return;
    viewer.take(manifest, await loadTextures(manifest, url, thisDevice(), { address: fresh }));
    shownNow = found;
    changed();
  };
  const again = (): void => {
    look()
      .catch((error: unknown) => console.warn(error)) // it is asked again
      .finally(() => window.setTimeout(again, pause));
  };
  window.setTimeout(again, pause);
}

/** An address that no cache answers. */
function fresh(url: URL): URL {
  const asked = new URL(url);
  asked.searchParams.set("at", String(Date.now()));
  return asked;
}

function sameSurface(one: Manifest, other: Manifest): boolean {
  return String(one.bake.texels) === String(other.bake.texels) && one.bake.layout === other.bake.layout;
}
