// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Tone curves: three.js's.

import { ACESFilmicToneMapping, AgXToneMapping, LinearToneMapping, NeutralToneMapping, type ToneMapping } from "three";

export const TONES = ["none", "aces", "agx", "neutral"] as const;
export type Tone = (typeof TONES)[number];

/** What three.js calls them; without a curve light is exposed alone. */
export const TONE_MAPPINGS: Record<Tone, ToneMapping> = {
  none: LinearToneMapping,
  aces: ACESFilmicToneMapping,
  agx: AgXToneMapping,
  neutral: NeutralToneMapping,
};
