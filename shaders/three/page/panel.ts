// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Buttons, slider, divider, keys and pointer, and what the page tells beside the picture.

import { element } from "./elements";
import { describeHelp } from "./help";
import type { Inspection, Inspector } from "./inspector";
import { KINDS } from "../src/kinds";
import { layerWords } from "../src/layers";
import { followLamps } from "./lamp_controls";
import { MirrorControls } from "./mirror_controls";
import type { Filter } from "../src/filters";
import { type Tone, TONES } from "./tones";
import { SunControls } from "./sun_controls";
import { followSunDrag } from "./sun_drag";
import type { Viewer } from "./viewer";

const FILTER_WORDS: Record<Filter, [string, string]> = {
  nearest: ["Nearest", "One cell of one texel"],
  linear: ["Linear", "One texel, blended between its cells"],
  quadrilinear: ["Quadrilinear", "Four texels, each blended between its cells"],
  levels: ["Levels", "Quadrilinear, and mip levels where texels are smaller than pixels"],
  layered: ["Layered", "The layered layout is looked up in one way"],
};
const TONE_WORDS: Record<Tone, string> = { none: "None", aces: "ACES", agx: "AgX", neutral: "Neutral" };
const CLICK = 5; // CSS pixels that a click may stray
const STEP = 0.07; // radians an arrow key turns
const SUN_STEP = 5; // degrees

export class Panel {
  private readonly exposure = element<HTMLInputElement>("exposure");
  private readonly divider = element("divider");
  private readonly help = element<HTMLDialogElement>("help");
  private readonly cards = element("cards");
  private readonly sun: SunControls;
  private readonly mirror: MirrorControls;
  private told = 0; // when, in milliseconds
  private later = 0; // a timer

  constructor(
    private readonly viewer: Viewer,
    private readonly inspector: Inspector,
  ) {
    this.describe();
    this.choices("filters", viewer.filters, (filter) => FILTER_WORDS[filter], (filter) => viewer.setFilter(filter));
    this.choices("layers", viewer.layers, layerWords, (layer) => viewer.setLayer(layer));
    this.choices("tones", [...TONES], (tone) => [TONE_WORDS[tone], ""], (tone) => viewer.setTone(tone));
    this.exposure.addEventListener("input", () => this.change(() => viewer.setExposure(Number(this.exposure.value))));
    this.exposure.addEventListener("dblclick", () => this.change(() => viewer.setExposure(0)));
    this.sun = new SunControls(viewer, (act) => this.change(act));
    this.mirror = new MirrorControls(viewer, (act) => this.change(act));
    followLamps(viewer, (act) => this.change(act));
    this.button("compare", () => viewer.setDivider(viewer.divider === null ? viewer.middle : null));
    this.button("turn", () => viewer.setTurning(!viewer.controls.autoRotate));
    this.button("walk", () => viewer.setWalking(!viewer.walking));
    this.button("reset", () => viewer.resetView());
    this.button("settings", () => document.body.classList.toggle("open"));
    this.button("inspector-close", () => inspector.inspect(null));
    this.button("help-open", () => this.help.showModal());
    this.button("help-close", () => this.help.close());
    this.followPointer();
    followSunDrag(viewer, (act) => this.change(act));
    this.followDivider();
    this.followBucket();
    document.addEventListener("keydown", (event) => this.key(event));
    viewer.drawn = () => this.afterFrame();
    element("filters").hidden = element("filters-title").hidden = viewer.filters.length < 2;
    element("layers").hidden = element("layers-title").hidden = viewer.layers.length < 2;
    new ResizeObserver(() => this.cover()).observe(this.cards);
    this.sync();
    this.cover();
    viewer.resetView();
  }

  /** The textures are there, or this device does not take them. */
  complete(): void {
    const problem = this.viewer.shown.parts.find((part) => part.problem)?.problem;
    element("notice").hidden = !problem;
    if (problem) element("notice").textContent = `The flat lightmap is shown: ${problem.message}. ${problem.remedy}`;
    this.mirror.complete();
    this.sync();
  }

  /** What is shown, in one line. */
  describe(): void {
    const { name, parts } = this.viewer.shown;
    const { bake, textures } = this.viewer.manifest;
    const formats = [...new Set(Object.values(textures).map(({ format }) => format))].join(", ");
    const several = bake.layout === "layered"; // images
    const layout = several ? "layered layout" : "";
    const arrangement = several ? "" : textures[bake.kind]?.arrangement;
    const { title, way } = KINDS[bake.kind];
    const facts = parts.length > 1 ? [`${parts.length} bakes`] : [
      bake.kind === "radiance" ? "" : title,
      `${bake.texels.join(" × ")} texels`,
      bake.kind === "ao" || bake.layout === "layered" ? "" : `${bake.bucket} × ${bake.bucket} cells`,
      bake.kind === "shadow" ? "" : `${bake.samples} samples`,
      layout,
      arrangement,
      formats,
    ];
    document.title = `${name} · RadTex`;
    element("name").textContent = name;
    element("facts").textContent = facts.filter(Boolean).join(" · ");
    element("side").textContent = title;
    element("way").textContent = way;
    describeHelp(this.viewer);
  }

  /** A row of buttons of which one is pressed. */
  private choices<Value extends string>(
    id: string,
    values: Value[],
    words: (value: Value) => [string, string],
    choose: (value: Value) => void,
  ): void {
    const row = element(id);
    for (const value of values) {
      const button = document.createElement("button");
      const [word, title] = words(value);
      button.type = "button";
      button.dataset["value"] = value;
      button.textContent = word;
      button.title = title;
      button.addEventListener("click", () => this.change(() => choose(value)));
      row.append(button);
    }
  }

  private button(id: string, act: () => void): void {
    element(id).addEventListener("click", () => this.change(act));
  }

  private change(act: () => void): void {
    act();
    this.viewer.invalidate();
    this.sync();
  }

  /** Have buttons and slider say what is so. */
  sync(): void {
    const { viewer } = this;
    const press = (id: string, value: string): void => {
      for (const button of element(id).querySelectorAll("button")) {
        button.setAttribute("aria-pressed", String(button.dataset["value"] === value));
      }
    };
    press("filters", viewer.filter);
    press("layers", viewer.layer);
    press("tones", viewer.tone);
    this.sun.sync();
    this.mirror.sync();
    this.exposure.value = String(viewer.exposure);
    element("stops").textContent = `${viewer.exposure > 0 ? "+" : ""}${viewer.exposure.toFixed(1)} stops`;
    element("compare").setAttribute("aria-pressed", String(viewer.divider !== null));
    element("walk").hidden = element("walk-keys").hidden = !viewer.walkable;
    element("walk").setAttribute("aria-pressed", String(viewer.walking));
    element("turn").setAttribute("aria-pressed", String(viewer.controls.autoRotate));
    element("settings").setAttribute("aria-expanded", String(document.body.classList.contains("open")));
    document.body.classList.toggle("comparing", viewer.divider !== null);
    document.body.classList.toggle("inspecting", this.inspector.point !== null);
    const share = viewer.divider ?? 0.5;
    document.body.style.setProperty("--divider", `${share * 100}%`);
    this.divider.setAttribute("aria-valuenow", String(Math.round(share * 100)));
  }

  /** Tell the viewer how much of the stage the cards cover: its right, or on small screens its bottom. */
  private cover(): void {
    const { width, height, left } = this.cards.getBoundingClientRect();
    const beside = left > this.viewer.stage.clientWidth / 3;
    this.viewer.setCovered(beside ? width + 16 : 0, beside ? 0 : height + 16);
  }

  private followPointer(): void {
    const canvas = this.viewer.renderer.domElement;
    let down: PointerEvent | null = null;
    canvas.addEventListener("dblclick", (event) => this.change(() => this.standAt(event)));
    canvas.addEventListener("pointerdown", (event) => (down = event.isPrimary ? event : null));
    canvas.addEventListener("pointerup", (event) => {
      const still = down && Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) <= CLICK;
      if (still && event.isPrimary && event.button === 0) this.inspectAt(event.clientX, event.clientY);
      down = null;
    });
  }

  private standAt(event: MouseEvent): void {
    const box = this.viewer.renderer.domElement.getBoundingClientRect();
    if (this.viewer.standAt(event.clientX - box.left, event.clientY - box.top)) this.inspector.inspect(null);
  }

  private inspectAt(clientX: number, clientY: number): void {
    if (!this.inspector.works) return;
    const box = this.viewer.renderer.domElement.getBoundingClientRect();
    const point = this.viewer.pick(clientX - box.left, clientY - box.top);
    if (!point || point.part.textures.size) this.change(() => this.inspector.inspect(point));
  }

  private followDivider(): void {
    const { divider, viewer } = this;
    const drag = (event: PointerEvent): void => {
      const box = viewer.renderer.domElement.getBoundingClientRect();
      if (divider.hasPointerCapture(event.pointerId)) {
        this.change(() => viewer.setDivider((event.clientX - box.left) / box.width));
      }
    };
    divider.addEventListener("pointerdown", (event) => divider.setPointerCapture(event.pointerId));
    divider.addEventListener("pointermove", drag);
    divider.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -0.02, ArrowRight: 0.02, Home: -1, End: 1 }[event.key];
      if (step === undefined) return;
      event.preventDefault();
      event.stopPropagation();
      this.change(() => viewer.setDivider((viewer.divider ?? 0.5) + step));
    });
  }

  /** The value of the cell under the pointer. */
  private followBucket(): void {
    const canvas = element<HTMLCanvasElement>("bucket");
    const told = element("cell-light");
    canvas.addEventListener("pointerleave", () => (told.textContent = ""));
    canvas.addEventListener("pointermove", (event) => {
      const at = this.inspector.inspection;
      if (!at) return;
      const p = Math.min(at.side - 1, Math.max(0, Math.floor((event.offsetX / canvas.clientWidth) * at.side)));
      const q = Math.min(at.side - 1, Math.max(0, Math.floor((1 - event.offsetY / canvas.clientHeight) * at.side)));
      const begin = (q * at.side + p) * 4;
      told.textContent = `cell (${p}, ${q}): ${numbers(at.bucket.subarray(begin, begin + 3))}`;
    });
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey || this.help.open) return;
    const inSlider = event.target instanceof HTMLInputElement;
    const arrow = event.key.startsWith("Arrow");
    const pressing = event.target instanceof HTMLButtonElement && (event.key === " " || event.key === "Enter");
    if ((inSlider && arrow) || pressing || (this.viewer.walking && arrow)) return;
    const { viewer } = this;
    const filter = viewer.filters[Number(event.key) - 1];
    const next = TONES[(TONES.indexOf(viewer.tone) + 1) % TONES.length] as Tone;
    const box = viewer.renderer.domElement.getBoundingClientRect();
    const acts: Record<string, () => void> = {
      ArrowLeft: () => viewer.orbit(-STEP, 0),
      ArrowRight: () => viewer.orbit(STEP, 0),
      ArrowUp: () => viewer.orbit(0, STEP),
      ArrowDown: () => viewer.orbit(0, -STEP),
      "+": () => viewer.orbit(0, 0, 1.1),
      "=": () => viewer.orbit(0, 0, 1.1),
      "-": () => viewer.orbit(0, 0, 1 / 1.1),
      "[": () => viewer.setExposure(viewer.exposure - 0.5),
      "]": () => viewer.setExposure(viewer.exposure + 0.5),
      "0": () => viewer.setExposure(0),
      t: () => viewer.setTone(next),
      c: () => viewer.setDivider(viewer.divider === null ? viewer.middle : null),
      r: () => viewer.resetView(),
      v: () => viewer.setWalking(!viewer.walking),
      m: () => this.mirror.toggle(),
      b: () => this.mirror.toggleMotion(),
      i: () => this.inspectAt(box.left + box.width / 2, box.top + box.height / 2),
      " ": () => viewer.setTurning(!viewer.controls.autoRotate),
      Escape: () => this.inspector.inspect(null),
      "?": () => this.help.showModal(),
    };
    if (event.shiftKey && this.sun.turns) {
      Object.assign(acts, {
        ArrowLeft: () => viewer.turnSun(-SUN_STEP, 0),
        ArrowRight: () => viewer.turnSun(SUN_STEP, 0),
        ArrowUp: () => viewer.turnSun(0, SUN_STEP),
        ArrowDown: () => viewer.turnSun(0, -SUN_STEP),
      });
    }
    const act = filter ? () => viewer.setFilter(filter) : acts[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act) return;
    event.preventDefault();
    this.change(act);
  }

  private afterFrame(): void {
    const { inspector } = this;
    if (inspector.point) {
      inspector.update();
      this.placeMark();
      if (inspector.inspection) this.tellInspection(inspector.inspection);
    }
    window.clearTimeout(this.later);
    this.later = window.setTimeout(() => this.tellStatus(), 300);
    const now = performance.now();
    if (now - this.told < 250) return;
    this.told = now;
    this.tellStatus();
  }

  private tellStatus(): void {
    const { viewer } = this;
    const [bytes, fileBytes] = viewer.memory;
    const { width, height } = viewer.renderer.domElement;
    element("rate").textContent = viewer.rate === null ? "at rest" : `${Math.round(viewer.rate)} frames/s`;
    element("memory").textContent = `${memorySize(bytes)} textures`;
    element("memory").title = `${memorySize(fileBytes)} as files`;
    element("size").textContent = `${width} × ${height}`;
  }

  /** Put the ring onto the inspected point. */
  private placeMark(): void {
    const { viewer, inspector } = this;
    const at = inspector.point?.place.clone().project(viewer.camera);
    const canvas = viewer.renderer.domElement;
    if (!at) return;
    element("mark").style.transform =
      `translate(${((at.x + 1) / 2) * canvas.clientWidth}px, ${((1 - at.y) / 2) * canvas.clientHeight}px)`;
  }

  private tellInspection(at: Inspection): void {
    const begin = (at.cell[1] * at.side + at.cell[0]) * 4;
    const { kind } = (this.inspector.point?.part ?? this.viewer.object).manifest.bake;
    const channels = kind === "proxy" ? 4 : 3; // a hull's alpha says what is in it
    const words: Record<string, string> = {
      "at-uv": numbers(at.uv, 4),
      "at-texel": `(${at.texel.join(", ")})`,
      "at-cell": `(${at.cell.join(", ")}) of ${at.side} × ${at.side}`,
      "at-incidence": numbers(at.incidence),
      "at-stored": numbers(at.bucket.subarray(begin, begin + channels)),
      "at-light": numbers(at.light.slice(0, channels)),
    };
    for (const [id, word] of Object.entries(words)) element(id).textContent = word;
    element("bucket-note").textContent = at.stored ? KINDS[kind].bucket : "Light of this point, every way";
  }
}

function numbers(values: Iterable<number>, digits = 3): string {
  return [...values].map((value) => value.toFixed(digits)).join("  ");
}

function memorySize(bytes: number): string {
  if (bytes < 2 ** 20) return `${Math.round(bytes / 2 ** 10)} KiB`;
  return `${(bytes / 2 ** 20).toFixed(bytes < 10 * 2 ** 20 ? 1 : 0)} MiB`;
}
