// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The kinds of bakes that the page shows, and what it says of each.

export type Kind = "radiance" | "incident" | "reflection" | "proxy" | "shadow" | "ao" | "transfer";

interface KindFacts {
  /** What the picture is called where it stands beside the flat lightmap, and above. */
  title: string;
  /** The inspector's title. */
  bucket: string;
  /** The direction that is looked up: I to the viewer, L to the light. */
  way: "I" | "L";
  /** Which of the sun's settings the picture depends on. */
  sun: ReadonlyArray<"direction" | "size" | "strength">;
  /** What the help says, unless the layout is layered. */
  about: string;
}

const SEEN = { bucket: "The texel’s bucket", way: "I", sun: [] } as const;

export const KINDS: Record<Kind, KindFacts> = {
  radiance: {
    ...SEEN,
    title: "radiance",
    about:
      "Each texel holds a bucket: a small picture of the light that leaves it, with a cell for each direction. " +
      "What you see is that light, looked up for where you stand. " +
      "A flat lightmap, as Compare shows it beside, knows one colour a texel.",
  },
  incident: {
    ...SEEN,
    title: "incident light",
    about:
      "Each texel holds a bucket: a small picture of the light that arrives at it, with a cell for each direction. " +
      "What you see is the light that comes from your direction.",
  },
  reflection: {
    ...SEEN,
    title: "reflection",
    about:
      "Each texel holds a bucket: a small picture of what a mirror there would show, with a cell for each direction. " +
      "What you see is the object as a perfect mirror.",
  },
  proxy: {
    ...SEEN,
    title: "proxy",
    about:
      "This is a hull: each texel holds what a ray meets that goes on into it, and how much of it. " +
      "What you see inside is not there; only the hull is drawn.",
  },
  shadow: {
    title: "shadow",
    bucket: "The sky that the texel sees",
    way: "L",
    sun: ["direction", "size"],
    about:
      "Each texel holds one bit for each direction: is it blocked? So the sun can stand anywhere, and be of any size. " +
      "The object is drawn white.",
  },
  ao: {
    ...SEEN,
    title: "ambient occlusion",
    bucket: "The texel’s ambient visibility",
    about: "Each texel holds how much of the sky it sees. It is drawn white where nothing is in the way.",
  },
  transfer: {
    title: "transfer",
    bucket: "The texel, lit from all around",
    way: "L",
    sun: ["direction", "strength"],
    about:
      "Each texel holds how it answers to light from each direction, also from behind, through the object. " +
      "So the sun can stand anywhere.",
  },
};

export function isKind(word: string): word is Kind {
  return Object.hasOwn(KINDS, word);
}
