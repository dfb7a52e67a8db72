// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// The page's entry: load, show, or say why not.

import "./style.css";

import { element } from "./elements";
import { Inspector } from "./inspector";
import { load } from "./loading";
import { Panel } from "./panel";
import { asProblem, Problem } from "./problem";
import { scriptOf } from "./script";
import type { Viewer } from "./viewer";
import { watch } from "./watching";

async function open(): Promise<[Viewer, Inspector]> {
  if (location.protocol === "file:") throw new Problem(said("headline"), said("remedy")); // as index.html shows it
  const canvas = element<HTMLCanvasElement>("view");
  const [viewer, url] = await load(element("stage"), canvas, (step) => (element("step").textContent = step));
  document.body.classList.remove("loading"); // the panel measures what it covers
  const inspector = new Inspector(viewer, element<HTMLCanvasElement>("bucket"));
  const panel = new Panel(viewer, inspector);
  canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault();
    complain("The graphics device was taken away", "Its memory may have run out: reload the page.");
  });
  viewer.draw();
  watch(viewer, url, () => {
    inspector.forget();
    panel.describe();
  });
  return [viewer, inspector];
}

function said(id: string): string {
  return element(id).textContent ?? "";
}

function complain(headline: string, remedy: string): void {
  element("headline").textContent = headline;
  element("remedy").textContent = remedy;
  document.body.classList.remove("loading");
  document.body.classList.add("failed");
}

const page = open();
window.radtex = scriptOf(page);
page.catch((error: unknown) => {
  const problem = asProblem(error);
  console.error(error);
  complain(problem.message, problem.remedy);
});
