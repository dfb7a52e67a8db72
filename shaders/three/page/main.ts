// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The page's entry: load, show, or say why not.

import "./style.css";

import { loadRadTexScene } from "../src/load";
import { asProblem, Problem } from "../src/problem";
import { element } from "./elements";
import { Inspector } from "./inspector";
import { askedLamps } from "./lamp_controls";
import { manifestUrl, rendererOn } from "./loading";
import { Panel } from "./panel";
import { recover } from "./recovering";
import { scriptOf } from "./script";
import { Viewer } from "./viewer";
import { watch } from "./watching";

const { body } = document;

/** Show the flat lightmap as soon as it is there, then the light. */
async function open(): Promise<[Viewer, Inspector]> {
  if (location.protocol === "file:") throw new Problem(said("headline"), said("remedy")); // as index.html shows it
  body.classList.toggle("bare", new URLSearchParams(location.search).get("ui") === "0");
  const renderer = rendererOn(element<HTMLCanvasElement>("view"));
  const url = manifestUrl();
  let viewer: Viewer | undefined;
  const progressed = (done: number, all: number): void => {
    tell(`Loading textures: ${done} of ${all}`);
    viewer?.invalidate(); // of several bakes one may be complete
  };
  const loaded = await loadRadTexScene(url, { progressed, lamps: askedLamps(), restore: false });
  body.classList.remove("loading"); // the panel measures what it covers
  body.classList.add("refining");
  viewer = new Viewer(renderer, element("stage"), loaded);
  const inspector = new Inspector(viewer, element<HTMLCanvasElement>("bucket"));
  const panel = new Panel(viewer, inspector);
  viewer.draw();
  performance.mark("radtex-first");
  const exchanged = (): void => {
    inspector.forget();
    panel.complete();
    panel.describe();
  };
  recover(viewer, loaded.reload, exchanged);
  await loaded.complete;
  viewer.completed();
  panel.complete();
  viewer.draw();
  performance.mark("radtex-complete");
  body.classList.remove("refining");
  watch(viewer, url, exchanged);
  return [viewer, inspector];
}

function tell(step: string): void {
  element("step").textContent = step;
}

function said(id: string): string {
  return element(id).textContent ?? "";
}

function complain(headline: string, remedy: string): void {
  element("headline").textContent = headline;
  element("remedy").textContent = remedy;
  body.classList.remove("loading", "refining");
  body.classList.add("failed");
}

const page = open();
window.radtex = scriptOf(page);
page.catch((error: unknown) => {
  const problem = asProblem(error);
  console.error(error);
  complain(problem.message, problem.remedy);
});
