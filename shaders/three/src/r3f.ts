// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// For react-three-fiber: a bake as a component, and as a hook.

import { type Color, type ThreeElements, useLoader, useThree } from "@react-three/fiber";
import { createElement, type ReactElement, type Ref, useEffect, useLayoutEffect, useMemo, useReducer, useState } from "react";
import { type Filter, type LoadOptions, Problem, RadTexLoader, type RadTexObject, type Sun } from "radtex-three";
import type { RadTex as Loaded } from "radtex-three";
import { Group, Loader, type WebGLRenderer } from "three";

// Milliseconds after which a clone is freed that React made while rendering and then gave up.
const GIVEN_UP = 10_000;

/** What `useRadTex` takes beside the address. As all of `useLoader`'s, it counts for the first load of an address. */
export interface UseRadTexOptions {
  /** Change the loader: `(loader) => loader.setRequestHeader(…)`. */
  extend?: ((loader: RadTexLoader) => void) | undefined;
  /** Called with the bytes that have come. */
  onProgress?: LoadOptions["received"];
}

/** How a bake is shown. What is left out is as the bake has it. */
interface Shown {
  /** What all its light is multiplied by. */
  tint?: Color | undefined;
  /** The same, as a number: 2 is a stop more. */
  exposure?: number | undefined;
  /** How much it hides of what lies behind it, 0 to 1. */
  opacity?: number | undefined;
  /** What the bake's own light is multiplied by, before lamps are added to it. */
  own?: Color | undefined;
  filter?: Filter | undefined;
  lightLayer?: string | undefined;
  /** The sun of a `shadow` or a `transfer`: what it changes. */
  sun?: Partial<Sun> | undefined;
  /** The object: null before it is there. */
  ref?: Ref<RadTexObject> | undefined;
}

/** The address of a NAME.export.json or NAME.glb, relative to the page, by either name. */
type Address = { url: string; src?: undefined } | { src: string; url?: undefined };

/** A group's props, among them events, and those of a bake. Shadows are cast by its meshes. */
export type RadTexProps = Omit<ThreeElements["group"], keyof Shown | keyof UseRadTexOptions | "args" | "url" | "src"> &
  Shown &
  UseRadTexOptions &
  Address;

/**
 * A bake in a Canvas. It suspends until all its textures are there, and throws a Problem, whose `message` and `remedy` are
 * for people, where a file is missing or damaged. All of one address share textures and geometry.
 */
export function RadTex(props: RadTexProps): ReactElement {
  const { url, src, extend, onProgress, sun, tint, exposure, opacity, own, filter, lightLayer, ...group } = props;
  const { object: original } = useRadTex(url ?? src ?? "", { extend, onProgress });
  const object = useClone(original);
  const invalidate = useThree((state) => state.invalidate);
  const { castShadow = false } = group;
  useLayoutEffect(() => {
    for (const mesh of object.meshes) mesh.castShadow = castShadow;
    if (sun) object.setSun(sun);
    invalidate();
  });
  return createElement("primitive", {
    ...useWithDefaults(group),
    object,
    tint: tint ?? "white",
    exposure: exposure ?? 1,
    opacity: opacity ?? 1,
    own: own ?? "white",
    filter: filter ?? object.filters.at(-1),
    lightLayer: lightLayer ?? object.lightLayers[0],
  });
}

/** Load a bake before it is needed. */
RadTex.preload = (url: string, extend?: UseRadTexOptions["extend"]): void => {
  useLoader.preload(first, url, ({ loader }) => extend?.(loader));
};

/** Forget a bake, or that it failed: it is loaded once more when it is needed again. What shows it now keeps showing it. */
RadTex.clear = (url: string): void => {
  for (const loader of [first, ...others]) loader.forget(url);
};

/**
 * The bake that all `<RadTex>` of this address are clones of: for instances, or to ask it what there is. Suspends and throws
 * as they do. To place it in a scene, take its clone, and dispose of that.
 */
export function useRadTex(url: string, { extend, onProgress }: UseRadTexOptions = {}): Loaded {
  const renderer = useThree((state) => state.gl);
  const loader = loaderOf(renderer);
  useEffect(() => loader.used(), [loader]);
  const result = useLoader(loader, url, (each) => extend?.(each.loader), onProgress);
  if ("loaded" in result) return result.loaded;
  throw result.error;
}

type Result = { loaded: Loaded } | { error: unknown };

/**
 * Loads the bakes of one renderer: textures belong to the one that draws them first. What fails is loaded, too, as what
 * it is: of an error `useLoader` would keep the message alone.
 *
 * `useLoader` knows it by itself, not by its class: it takes all classes of loaders for the same that have no properties.
 */
class CachedLoader extends Loader<Result, string> {
  readonly loader = new RadTexLoader();
  private readonly asked = new Map<string, Result | null>();
  private users = 0;

  override load(url: string, loaded: (result: Result) => void, progressed?: (event: ProgressEvent) => void): void {
    this.loadAsync(url, progressed).then(loaded, console.error);
  }

  override async loadAsync(url: string, progressed?: (event: ProgressEvent) => void): Promise<Result> {
    this.asked.set(url, null);
    const result = await this.result(url, progressed);
    if (this.asked.has(url)) this.asked.set(url, result);
    return result;
  }

  private async result(url: string, progressed?: (event: ProgressEvent) => void): Promise<Result> {
    const remedy = "Give it the address of a NAME.export.json or NAME.glb, relative to the page.";
    if (!url) return { error: new Problem("<RadTex> has no url", remedy) };
    try {
      return { loaded: await this.loader.loadAsync(url, progressed) };
    } catch (error) {
      return { error };
    }
  }

  /** Somebody shows its bakes, until what this returns is called. */
  used(): () => void {
    this.users++;
    return () => void this.users--;
  }

  /** Free an address's bake; of what shows it, the last frees what they share. */
  forget(url: string): void {
    useLoader.clear(this, url);
    const result = this.asked.get(url);
    this.asked.delete(url);
    if (result && "loaded" in result) result.loaded.object.dispose();
  }

  /** Free all its bakes if nobody shows them; whether that is so. */
  forgetAll(): boolean {
    if (this.users) return false;
    for (const url of [...this.asked.keys()]) this.forget(url);
    return true;
  }
}

/** Loads ahead, and for the first renderer. */
const first = new CachedLoader();
const others = new Set<CachedLoader>();
const loaders = new Map<WebGLRenderer, CachedLoader>();

/** The loader of a renderer, which is forgotten with all that it loaded when its Canvas is gone. */
function loaderOf(renderer: WebGLRenderer): CachedLoader {
  const known = loaders.get(renderer);
  if (known) return known;
  const isFirst = ![...loaders.values()].includes(first);
  const made = isFirst ? first : new CachedLoader();
  loaders.set(renderer, made);
  if (!isFirst) others.add(made);
  const canvas = renderer.domElement;
  const lost = (): void => {
    if (!made.forgetAll()) return; // else it comes back by itself
    loaders.delete(renderer);
    others.delete(made);
    canvas.removeEventListener("webglcontextlost", lost);
  };
  canvas.addEventListener("webglcontextlost", lost);
  return made;
}

/** A clone for one component, which is freed with it. */
function useClone(original: RadTexObject): RadTexObject {
  const [count, another] = useReducer((before: number) => before + 1, 0);
  const clone = useMemo(() => new HeldClone(original), [original, count]);
  useEffect(() => {
    if (clone.isFreed) another();
    else clone.keep();
    return () => clone.freeIn(0);
  }, [clone]);
  return clone.object;
}

/**
 * A clone that is freed if nobody keeps it. React renders also what it then gives up, of which it tells nobody; and in
 * StrictMode it ends and begins each effect once more, between which the clone stays.
 */
class HeldClone {
  readonly object: RadTexObject;
  isFreed = false;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(original: RadTexObject) {
    this.object = original.clone();
    this.freeIn(GIVEN_UP);
  }

  keep(): void {
    clearTimeout(this.timer);
  }

  freeIn(milliseconds: number): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.isFreed = true;
      this.object.dispose();
    }, milliseconds);
  }
}

const PLAIN = new Group();

/** Props with a group's own values for those that were passed before and no longer are: r3f would set a primitive's to 0. */
function useWithDefaults(props: Readonly<Record<string, unknown>>): Record<string, unknown> {
  const [defaults] = useState<Record<string, unknown>>({});
  for (const name of Object.keys(props)) {
    const plain = name.split("-").reduce<unknown>((found, key) => (found as Record<string, unknown> | undefined)?.[key], PLAIN);
    if (plain !== undefined && name !== "children") defaults[name] = plain;
  }
  return { ...defaults, ...props };
}
