// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The inspector: one point's bucket enlarged, the cell that is looked up in it, and the numbers.

import { FloatType, Mesh, PlaneGeometry, type RawShaderMaterial, RGBAFormat, Scene, UnsignedByteType, WebGLRenderTarget } from "three";

import { inspectorMaterial, type Stage } from "./inspector_material";
import { TONES } from "./tones";
import type { SurfacePoint, Viewer } from "./viewer";

const SYNTHETIC = 32; // cells a side of a layered bake's bucket, which is made for the inspector

/** What the inspector knows of a point; light is linear, premultiplied RGBA. */
export interface Inspection {
  uv: [number, number];
  texel: [number, number];
  cell: [number, number];
  /** The direction that is looked up, I or the sun's L, in the surface's frame. */
  incidence: number[];
  /** Where it lies in the bucket, in [-1, 1]^2: B. */
  square: number[];
  /** What the filter in use makes of the lookup, at the finest level. */
  light: number[];
  /** Cells a side. */
  side: number;
  /** Whether the bucket is stored so; that of a layered bake is looked up. */
  stored: boolean;
  /** All cells, the lowest row first. */
  bucket: Float32Array;
}

export class Inspector {
  point: SurfacePoint | null = null;
  inspection: Inspection | null = null;

  private readonly scene = new Scene();
  private readonly square = new Mesh(new PlaneGeometry());
  private readonly materials = new Map<string, RawShaderMaterial>();
  private readonly picture = document.createElement("canvas");
  private pictured = "";

  constructor(
    private readonly viewer: Viewer,
    private readonly canvas: HTMLCanvasElement,
  ) {
    this.square.frustumCulled = false; // its triangle is the vertex shader's
    this.scene.add(this.square);
  }

  /** Whether this device draws numbers. */
  get works(): boolean {
    return this.viewer.renderer.getContext().getExtension("EXT_color_buffer_float") !== null;
  }

  /** Look at a point of the surface from now on; null for none. */
  inspect(point: SurfacePoint | null): void {
    this.point = point;
    this.pictured = "";
    this.update();
  }

  /** Look again, the bake's textures having been exchanged. */
  forget(): void {
    for (const material of this.materials.values()) material.dispose();
    this.materials.clear();
    this.inspect(this.point);
  }

  /** Follow the camera and the settings. */
  update(): void {
    const { point, viewer } = this;
    if (!point?.part.textures.size) {
      this.inspection = null; // or there is nothing to look up: the device took no textures, or was taken away
      return;
    }
    const { bake } = point.part.manifest;
    const stored = bake.layout !== "layered";
    const side = stored ? bake.bucket : SYNTHETIC;
    const texel = point.uv.map((along, axis) => {
      const count = bake.texels[axis] as number;
      return Math.min(count - 1, Math.max(0, Math.floor(along * count)));
    }) as [number, number];
    const before = this.pictured;
    this.pictured = [...texel, ...point.uv, point.part.id, point.part.filter, viewer.tone, viewer.exposure].join();
    const numbers = this.rendered("probe", 3, 1) as Float32Array;
    const square = [...numbers.subarray(4, 6)];
    const cell = square.map((along) => Math.min(side - 1, Math.max(0, Math.floor(((along + 1) / 2) * side))));
    const fresh = this.pictured !== before || !this.inspection;
    this.inspection = {
      uv: point.uv,
      texel,
      cell: cell as [number, number],
      incidence: [...numbers.subarray(0, 3)],
      square,
      light: [...numbers.subarray(8, 12)],
      side,
      stored,
      bucket: fresh ? this.cells(texel, side) : (this.inspection as Inspection).bucket,
    };
    if (fresh) this.paint(texel, side);
    this.mark();
  }

  private cells(texel: [number, number], side: number): Float32Array {
    return this.rendered("bucket", side, side, texel, -1) as Float32Array;
  }

  /** The bucket as the screen shows it. */
  private paint(texel: [number, number], side: number): void {
    const tone = TONES.indexOf(this.viewer.tone);
    const shownCells = this.rendered("bucket", side, side, texel, tone) as Uint8Array;
    this.picture.width = this.picture.height = side;
    const image = new ImageData(side, side);
    for (let row = 0; row < side; row++) {
      image.data.set(shownCells.subarray((side - 1 - row) * side * 4, (side - row) * side * 4), row * side * 4);
    }
    for (let alpha = 3; alpha < image.data.length; alpha += 4) image.data[alpha] = 255;
    this.picture.getContext("2d")?.putImageData(image, 0, 0);
  }

  /** The picture, with the cell that is looked up and the very place in it. */
  private mark(): void {
    const context = this.canvas.getContext("2d");
    const at = this.inspection;
    if (!context || !at) return;
    const { width } = this.canvas;
    const one = width / at.side;
    const line = width / Math.max(1, this.canvas.clientWidth); // a CSS pixel
    context.imageSmoothingEnabled = false;
    context.drawImage(this.picture, 0, 0, width, width);
    const [x, y] = [at.cell[0] * one, (at.side - 1 - at.cell[1]) * one];
    for (const [colour, thick] of [["#000", 4], ["#fff", 2]] as const) {
      context.strokeStyle = colour;
      context.lineWidth = thick * line;
      context.strokeRect(x, y, one, one);
    }
    const [bx = 0, by = 0] = at.square;
    for (const [colour, radius] of [["#000", 4], ["#fff", 2.5]] as const) {
      context.fillStyle = colour;
      context.beginPath();
      context.arc(((bx + 1) / 2) * width, ((1 - by) / 2) * width, radius * line, 0, 2 * Math.PI);
      context.fill();
    }
  }

  /** What a stage draws: floats where the tone is -1, bytes of the screen else; the lowest row first. */
  private rendered(stage: Stage, width: number, height: number, texel = [0, 0], tone = -1): Float32Array | Uint8Array {
    const { viewer } = this;
    const { renderer } = viewer;
    const point = this.point as SurfacePoint;
    const material = this.material(stage);
    for (const texture of point.part.textures.values()) texture.upload(renderer); // where the flat lightmap alone was drawn
    const toViewer = viewer.camera.position.clone().sub(point.place).normalize();
    const values: Record<string, unknown> = {
      u_texel: texel,
      u_side: width,
      u_point: point.uv,
      u_normal: point.normal,
      u_tangent: point.tangent,
      u_viewer: toViewer.toArray(),
      u_place: point.place.toArray(),
      u_images: point.images,
      u_tone: tone,
      toneMappingExposure: renderer.toneMappingExposure,
    };
    for (const [name, value] of Object.entries(values)) {
      const uniform = material.uniforms[name];
      if (uniform) uniform.value = value;
    }
    const floats = tone < 0;
    const target = new WebGLRenderTarget(width, height, {
      type: floats ? FloatType : UnsignedByteType,
      format: RGBAFormat,
      depthBuffer: false,
    });
    const pixels = floats ? new Float32Array(width * height * 4) : new Uint8Array(width * height * 4);
    material.uniformsNeedUpdate = true;
    this.square.material = material;
    renderer.setRenderTarget(target);
    renderer.clear();
    renderer.render(this.scene, viewer.camera);
    renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
    renderer.setRenderTarget(null);
    target.dispose();
    return pixels;
  }

  private material(stage: Stage): RawShaderMaterial {
    const { material: number, part } = this.point as SurfacePoint;
    const key = `${stage} ${part.filter} ${part.id} ${number}`;
    const material = this.materials.get(key) ?? inspectorMaterial(part, part.filter, stage, number);
    this.materials.set(key, material);
    return material;
  }
}
