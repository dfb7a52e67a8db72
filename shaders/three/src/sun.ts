// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The sun that lights bakes of some kinds.

import { Color } from "three";

export interface Sun {
  /** In degrees: 0 shines on the object's front, 90 from the right, up to 180 either way. */
  azimuth: number;
  /** In degrees above the horizon, -90 to 90. */
  height: number;
  /** How wide its disc is, in degrees. */
  size: number;
  /** The irradiance on a plane that faces it. */
  strength: number;
  /** As CSS writes it, #rrggbb. */
  colour: string;
}

export const FIRST_SUN: Readonly<Sun> = { azimuth: -40, height: 45, size: 15, strength: 3, colour: "#ffffff" };

/** Uniforms of the materials that a sun lights; the direction is in three.js's world, y up. */
export interface SunUniforms {
  [name: string]: { value: unknown };
  u_to_sun: { value: [number, number, number] };
  u_sun_angle: { value: number };
  u_irradiance: { value: number[] };
}

/** The uniforms of a new sun. */
export function sunUniforms(): SunUniforms {
  return { u_to_sun: { value: [0, 1, 0] }, u_sun_angle: { value: 0 }, u_irradiance: { value: [1, 1, 1] } };
}

/** A sun with some of its settings changed, within their limits. */
export function changedSun(sun: Readonly<Sun>, change: Partial<Sun>): Sun {
  const { azimuth, height, size, strength, colour } = { ...sun, ...change };
  const within = (value: number, least: number, most: number): number => Math.min(most, Math.max(least, value));
  return {
    azimuth: within(azimuth, -180, 180),
    height: within(height, -90, 90),
    size: within(size, 0, 120),
    strength: Math.max(0, strength),
    colour,
  };
}

/** Have the materials with these uniforms lit by this sun. */
export function shine(uniforms: SunUniforms, { azimuth, height, size, strength, colour }: Readonly<Sun>): void {
  const [turn, up, wide] = [azimuth, height, size].map((angle) => (angle * Math.PI) / 180) as [number, number, number];
  uniforms.u_to_sun.value = [Math.cos(up) * Math.sin(turn), Math.sin(up), Math.cos(up) * Math.cos(turn)];
  uniforms.u_sun_angle.value = wide;
  uniforms.u_irradiance.value = new Color(colour).toArray().map((part) => part * strength); // linear Rec.709
}
