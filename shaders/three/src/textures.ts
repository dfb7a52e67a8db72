// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Textures on the GPU, without three.js's own upload: it knows neither all formats nor mip levels of arrays.

import { ExternalTexture, type WebGLRenderer } from "three";

import { levelBytes, type Pixels } from "./containers.js";
import type { TextureEntry } from "./manifest.js";
import { Problem, report } from "./problem.js";
import { uploaded, withStateKept } from "./upload.js";

/** Pixels on a device, and what frees them there. */
export interface OnDevice {
  handle: object;
  free: () => void;
}

/** What counts a renderer's textures. */
interface Counter {
  memory: { textures: number };
}

/** A texture that shaders read. It is uploaded when a renderer first draws with it. */
export class BakeTexture {
  /** What uniforms hold. */
  readonly texture = new ExternalTexture();
  readonly isArray: boolean;
  /** How many mip levels it has, with the finest. */
  readonly levels: number;
  /** On the GPU. */
  readonly bytes: number;
  private made: OnDevice | null = null;
  private device: object | null = null; // a WebGL context, or a device of WebGPU
  private counter: Counter | null = null; // a context which was restored has another
  private refused: Problem | null = null;
  private blended: boolean | null = null;
  private users = 0;

  /** `pixels` in a format that the device takes; `fileBytes` is the size of the file that they are from. */
  constructor(
    readonly entry: TextureEntry,
    private pixels: Pixels | null,
    readonly fileBytes: number,
  ) {
    if (!pixels) throw new Error("a texture needs pixels");
    this.isArray = pixels.layers > 0;
    this.levels = pixels.levels.length;
    this.bytes = pixels.levels.reduce((total, _, level) => total + levelBytes(pixels, level), 0);
  }

  /** Put it onto the renderer's GPU, once. Throws a Problem where it does not fit there, or is on another renderer's. */
  upload(renderer: WebGLRenderer): void {
    this.uploadTo(renderer.getContext() as WebGL2RenderingContext, renderer.info);
  }

  /** The same by a context; `info` is its renderer's, null if that counts textures itself. */
  uploadTo(gl: WebGL2RenderingContext, info: Counter | null): void {
    if (gl.isContextLost()) return;
    const isNew = this.device !== gl;
    this.put(gl, info, (pixels) => {
      const handle = uploaded(gl, pixels, this.entry);
      return { handle, free: () => gl.deleteTexture(handle) };
    });
    if (isNew && this.blended !== null) this.blendLevels(this.blended);
  }

  /** Put it onto a device, once, by `make`, which gets its pixels. Throws the Problem that this throws, or if it is on another. */
  put(device: object, info: Counter | null, make: (pixels: Pixels) => OnDevice): void {
    this.texture.sourceTexture = (this.device === device ? this.made?.handle : null) as never; // three.js asks for it whenever it draws
    if (this.device === device) return;
    if (this.refused) throw this.refused;
    if (!this.pixels) {
      throw new Problem(
        `${this.entry.file} is on the graphics device of another renderer, which drew it first`,
        "Load the bake once for each renderer by loadRadTex; where the first renderer is gone, call reload().",
      );
    }
    try {
      this.made = make(this.pixels);
    } catch (error) {
      if (error instanceof Problem) this.refused = error;
      throw error;
    }
    this.device = device;
    this.counter = info;
    if (info) info.memory.textures++;
    this.texture.sourceTexture = this.made.handle as never;
    this.pixels = null;
  }

  /** Whether it is on the GPU of the renderer that has this canvas. */
  isOn(canvas: EventTarget | null): boolean {
    return this.device !== null && "canvas" in this.device && this.device.canvas === canvas;
  }

  /** Let an array of slices blend its mip levels, or keep to the finest. */
  blendLevels(blend: boolean): void {
    this.blended = blend;
    const gl = this.device as WebGL2RenderingContext | null;
    const handle = this.made?.handle as WebGLTexture | undefined;
    if (!gl || !handle || !("texParameteri" in gl)) return;
    withStateKept(gl, this.isArray, () => {
      const target = this.isArray ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D;
      gl.bindTexture(target, handle);
      gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, blend ? gl.LINEAR_MIPMAP_LINEAR : gl.LINEAR);
      const anisotropic = gl.getExtension("EXT_texture_filter_anisotropic");
      if (!anisotropic) return;
      const most = blend ? Math.min(8, gl.getParameter(anisotropic.MAX_TEXTURE_MAX_ANISOTROPY_EXT) as number) : 1;
      gl.texParameterf(target, anisotropic.TEXTURE_MAX_ANISOTROPY_EXT, most);
    });
  }

  /** One more object shows it. */
  use(): void {
    this.users++;
  }

  /** An object shows it no longer: it is freed with the last one. */
  release(): void {
    if (--this.users <= 0) this.dispose();
  }

  /** Free the GPU's memory, whoever shows it. */
  private dispose(): void {
    this.made?.free();
    if (this.made && this.counter) this.counter.memory.textures--;
    this.texture.sourceTexture = null;
    this.texture.dispose();
    this.made = this.pixels = null;
  }
}

/**
 * Upload what a frame is about to show. What fails is told to `failed`, else to the console, once; it throws no Problem,
 * which would end the page's frames.
 */
export function uploadForFrame<Renderer = WebGLRenderer>(
  textures: Iterable<BakeTexture>,
  renderer: Renderer,
  failed = reportOnce,
  upload = (texture: BakeTexture, to: Renderer): void => texture.upload(to as WebGLRenderer),
): void {
  for (const texture of textures) {
    try {
      upload(texture, renderer);
    } catch (error) {
      if (!(error instanceof Problem)) throw error;
      failed(error);
    }
  }
}

const reported = new Set<string>();

function reportOnce(problem: Problem): void {
  if (reported.has(problem.message)) return;
  reported.add(problem.message);
  report(problem);
}
