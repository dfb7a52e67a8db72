// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// A slider and a colour for each lamp that was baked alone: ?lamp=KEY=Vase.key.export.json, as often as there are lamps.

import { Color } from "three";

import { Problem } from "../src/problem";
import { element } from "./elements";
import type { Viewer } from "./viewer";

const BRIGHTEST = "4"; // times what was baked
const OWN = "This bake";

/** The lamps that the page's address names, by their names. Throws a Problem for two of one name. */
export function askedLamps(): Record<string, URL> {
  const lamps = new Map<string, URL>();
  for (const text of new URLSearchParams(location.search).getAll("lamp")) {
    const equals = text.indexOf("=");
    const [name, address] = equals < 0 ? [stemOf(text), text] : [text.slice(0, equals), text.slice(equals + 1)];
    if (lamps.has(name)) {
      throw new Problem(`Two lamps in the address have the name ${name}`, "Give each a name: ?lamp=Key=Vase.key.export.json");
    }
    lamps.set(name, new URL(address, location.href));
  }
  return Object.fromEntries(lamps);
}

/** Make the controls of the viewer's lamps, if it has some, within a `change`. */
export function followLamps(viewer: Viewer, change: (act: () => void) => void): void {
  const { lamps, own } = viewer.object;
  element("lamps").hidden = !lamps.size;
  if (!lamps.size) return;
  for (const [name, colour] of [[OWN, own] as const, ...lamps]) element("lamps").append(row(name, colour, change));
}

function row(name: string, colour: Color, change: (act: () => void) => void): HTMLElement {
  const label = document.createElement("label");
  const tint = Object.assign(document.createElement("input"), { type: "color", value: "#ffffff", title: `${name}: colour` });
  const share = { type: "range", min: "0", max: BRIGHTEST, step: "0.05", value: "1", title: `${name}: strength` };
  const strength = Object.assign(document.createElement("input"), share);
  const set = (): void => change(() => void colour.set(tint.value).multiplyScalar(Number(strength.value)));
  label.className = "lamp";
  label.append(name, strength, tint);
  for (const input of [strength, tint]) input.addEventListener("input", set);
  return label;
}

function stemOf(address: string): string {
  return (address.split("/").pop() ?? address).replace(/\.export\.json$/, "");
}
