// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The sun's sliders and its colour, as far as one of the bakes depends on them.

import { element } from "./elements";
import { KINDS } from "../src/kinds";
import type { Sun } from "../src/sun";
import type { Viewer } from "./viewer";

type Setting = "azimuth" | "height" | "size" | "strength";

const SETTINGS = {
  direction: ["azimuth", "height"],
  size: ["size"],
  strength: ["strength", "colour"],
} as const;
const WORDS: Record<Setting, (value: number) => string> = {
  azimuth: (value) => `${Math.round(value)}°`,
  height: (value) => `${Math.round(value)}°`,
  size: (value) => (value ? `${value.toFixed(1)}°` : "a point"),
  strength: (value) => value.toFixed(1),
};

export class SunControls {
  private readonly shownSettings: ReadonlyArray<keyof Sun>;

  constructor(
    private readonly viewer: Viewer,
    change: (act: () => void) => void,
  ) {
    const asked = viewer.shown.parts.flatMap(({ manifest }) => KINDS[manifest.bake.kind].sun);
    this.shownSettings = [...new Set(asked)].flatMap((part) => [...SETTINGS[part]]);
    element("sun").hidden = element("sun-gesture").hidden = !this.turns;
    for (const setting of Object.values(SETTINGS).flat()) {
      element(`sun-${setting}-row`).hidden = !this.shownSettings.includes(setting);
      const input = this.input(setting);
      const value = (): Partial<Sun> => ({ [setting]: setting === "colour" ? input.value : Number(input.value) });
      input.addEventListener("input", () => change(() => viewer.setSun(value())));
    }
  }

  /** Whether there is a sun that can be turned. */
  get turns(): boolean {
    return this.shownSettings.includes("azimuth");
  }

  /** Have the controls say what is so. */
  sync(): void {
    for (const setting of this.shownSettings) {
      this.input(setting).value = String(this.viewer.sun[setting]);
      if (setting !== "colour") element(`sun-${setting}-word`).textContent = WORDS[setting](this.viewer.sun[setting]);
    }
  }

  private input(setting: keyof Sun): HTMLInputElement {
    return element<HTMLInputElement>(`sun-${setting}`);
  }
}
