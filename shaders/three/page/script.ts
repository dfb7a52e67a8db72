// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// window.radtex: the page as a script drives it, for tests and for who embeds it. docs/web.md tells of it.

import type { Inspection, Inspector } from "./inspector";
import type { MirrorState } from "../src/mirror";
import type { Filter } from "../src/filters";
import type { Tone } from "./tones";
import type { Sun } from "../src/sun";
import type { Viewer } from "./viewer";

export interface Picture {
  width: number;
  height: number;
  /** Base64 of float32, little-endian: (height, width, 4), linear, premultiplied, the upper row first. */
  values: string;
}

export interface Script {
  /** Fulfilled when the object is on the screen; rejected with what the page says instead. */
  ready: Promise<void>;
  filters: () => Filter[];
  /** Place the camera by its 4 x 4 matrix, row by row, in glTF's axes; it looks along its own -z. fovy in radians. */
  setCamera: (matrix: number[], fovy: number, width: number, height: number) => void;
  setFilter: (filter: Filter) => void;
  /** What setLayer takes here. */
  layers: () => string[];
  /** Show the whole, one of its layers, or the sum of base and rest. */
  setLayer: (layer: string) => void;
  setTone: (tone: Tone) => void;
  /** In stops. */
  setExposure: (stops: number) => void;
  /** Where the flat lightmap begins, in shares of the width; null for light alone. */
  setDivider: (share: number | null) => void;
  /** The sun that lights bakes of some kinds. */
  sun: () => Sun;
  /** Change some of its settings. */
  setSun: (change: Partial<Sun>) => void;
  /** How many samples a cell has of what is shown: it grows while a bake is refined. */
  samples: () => number;
  /** The mirror ball; null where the export has none. */
  mirror: () => MirrorState | null;
  /** Show it, move it, or have it move by itself; a place ends its own motion. */
  setMirror: (change: Partial<MirrorState>) => void;
  /** Walk through what is shown, as the button Walk does; false orbits around it again. */
  walk: (walking: boolean) => void;
  /** Where the camera is, in the page's world. */
  eye: () => [number, number, number];
  /** Inspect the point under a place of the canvas, in CSS pixels; null beside the object. */
  inspect: (x: number, y: number) => (Omit<Inspection, "bucket"> & { bucket: string }) | null;
  /** Light alone, without exposure or tone curve; of the flat lightmap if asked. */
  pixels: (flat?: boolean) => Picture;
}

declare global {
  interface Window {
    radtex: Script;
  }
}

/** The script of a page that is being loaded. */
export function scriptOf(page: Promise<[Viewer, Inspector]>): Script {
  let viewer: Viewer | undefined;
  let inspector: Inspector | undefined;
  const there = (): Viewer => {
    if (!viewer) throw new Error("the page is not ready: await radtex.ready");
    return viewer;
  };
  const ready = page.then((parts) => {
    [viewer, inspector] = parts;
  });
  ready.catch(() => undefined); // the page has said it
  return {
    ready,
    filters: () => there().filters,
    setCamera: (matrix, fovy, width, height) => there().setCamera(matrix, fovy, width, height),
    setFilter: (filter) => there().setFilter(filter),
    layers: () => there().layers,
    setLayer: (layer) => there().setLayer(layer),
    setTone: (tone) => there().setTone(tone),
    setExposure: (stops) => there().setExposure(stops),
    setDivider: (share) => there().setDivider(share),
    sun: () => ({ ...there().sun }),
    setSun: (change) => there().setSun(change),
    samples: () => there().manifest.bake.samples,
    mirror: () => there().mirror?.state ?? null,
    setMirror: (change) => there().setMirror(change),
    walk: (walking) => there().setWalking(walking),
    eye: () => there().camera.position.toArray(),
    inspect: (x, y) => {
      inspector?.inspect(there().pick(x, y));
      const inspection = inspector?.inspection;
      return inspection ? { ...inspection, bucket: base64(inspection.bucket) } : null;
    },
    pixels: (flat) => {
      const { width, height, values } = there().pixels(flat);
      return { width, height, values: base64(values) };
    },
  };
}

function base64(values: Float32Array): string {
  const bytes = new Uint8Array(values.buffer, values.byteOffset, values.byteLength);
  const parts: string[] = [];
  for (let begin = 0; begin < bytes.length; begin += 8192) {
    parts.push(String.fromCharCode(...bytes.subarray(begin, begin + 8192)));
  }
  return btoa(parts.join(""));
}
