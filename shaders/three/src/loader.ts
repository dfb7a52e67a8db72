// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Loading as three.js's own loaders do.

import { Loader, type LoadingManager, LoaderUtils } from "three";

import { type LoadOptions, loadRadTex, loadRadTexScene, type RadTex, type RadTexScene } from "./load.js";
import type { RequestOptions } from "./requests.js";

/** What a loader has settings of its own for. */
export type LoaderOptions = Omit<LoadOptions, keyof RequestOptions>;

/** What all loaders of RadTex's share: `Data` is what they load. */
abstract class OwnLoader<Data extends RadTex | RadTexScene> extends Loader<Data> {
  /** What `loadRadTex` takes beside: lamps, the device. */
  options: LoaderOptions = {};
  /** Ends the load when it is aborted. */
  signal: AbortSignal | null = null;
  /** Milliseconds without a byte after which a load fails; 0 waits for as long as the browser does. */
  timeout = 0;
  private ending = new AbortController();

  constructor(manager?: LoadingManager) {
    super(manager);
  }

  protected abstract begin(address: string, options: LoadOptions): Promise<Data>;

  setOptions(options: LoaderOptions): this {
    this.options = options;
    return this;
  }

  setSignal(signal: AbortSignal | null): this {
    this.signal = signal;
    return this;
  }

  setTimeout(milliseconds: number): this {
    this.timeout = milliseconds;
    return this;
  }

  /** End all loads of this loader: they fail with a DOMException called AbortError. */
  override abort(): this {
    this.ending.abort();
    this.ending = new AbortController();
    return this;
  }

  /** Load a NAME.export.json or NAME.glb with all textures, and call one of these; what fails is a Problem. */
  override load(
    address: string,
    loaded: (data: Data) => void,
    progressed?: (event: ProgressEvent) => void,
    failed?: (error: unknown) => void,
  ): void {
    this.loadAsync(address, progressed).then(loaded, (error: unknown) => {
      if (failed) failed(error);
      else console.error(error);
    });
  }

  /** The same, as a promise. `progressed` is called with the bytes that have come. */
  override async loadAsync(address: string, progressed?: (event: ProgressEvent) => void): Promise<Data> {
    const { crossOrigin, manager, options, requestHeader, signal, timeout, withCredentials } = this;
    const whole = LoaderUtils.resolveURL(address, this.path);
    const ended = signal ? AbortSignal.any([signal, this.ending.signal]) : this.ending.signal;
    const requests = { crossOrigin, manager, requestHeader, signal: ended, timeout, withCredentials };
    const data = await this.begin(whole, { ...options, ...requests, received: progressed });
    await data.complete;
    return data;
  }
}

/** Loads an export of one bake. */
export class RadTexLoader extends OwnLoader<RadTex> {
  protected override begin(address: string, options: LoadOptions): Promise<RadTex> {
    return loadRadTex(address, options);
  }
}

/** Loads an export of a whole scene, or of one bake. */
export class RadTexSceneLoader extends OwnLoader<RadTexScene> {
  protected override begin(address: string, options: LoadOptions): Promise<RadTexScene> {
    return loadRadTexScene(address, options);
  }
}
