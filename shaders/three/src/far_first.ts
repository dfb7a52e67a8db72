// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The order of triangles that one sees through: far ones are drawn first, so that near ones cover them.

import { type BufferAttribute, type BufferGeometry, type Camera, type Mesh, Vector4 } from "three";

const BINS = 1 << 16; // of distances: a counting sort takes a few milliseconds for a hundred thousand triangles

const orders = new WeakMap<BufferGeometry, Order>();

/** Put a mesh's triangles in order for a camera, the far ones first, or the near ones. */
export function sortTriangles(mesh: Mesh, camera: Camera, nearFirst = false): void {
  const { geometry, matrixWorld } = mesh;
  const order = orders.get(geometry) ?? new Order(geometry);
  orders.set(geometry, order);
  const { elements } = camera.matrixWorld; // its place, or for an orthographic camera the way back from what it sees
  const eye = new Vector4().fromArray(elements, "isOrthographicCamera" in camera ? 8 : 12);
  order.sort(eye.applyMatrix4(matrixWorld.clone().invert()), nearFirst);
}

class Order {
  private readonly corners: ArrayLike<number>; // three vertices for each triangle, as they were loaded
  private readonly middles: Float32Array;
  private readonly distances: Float32Array;
  private readonly before = new Vector4(Infinity, 0, 0, 0);

  constructor(private readonly geometry: BufferGeometry) {
    this.corners = indexOf(geometry).array.slice();
    const places = geometry.getAttribute("position");
    const count = this.corners.length / 3;
    this.middles = new Float32Array(3 * count);
    this.distances = new Float32Array(count);
    for (let corner = 0; corner < 3 * count; corner++) {
      const vertex = this.corners[corner] as number;
      const first = corner - (corner % 3);
      this.middles[first]! += places.getX(vertex) / 3;
      this.middles[first + 1]! += places.getY(vertex) / 3;
      this.middles[first + 2]! += places.getZ(vertex) / 3;
    }
  }

  /** `eye` is a place in the geometry's own space, or where its fourth number is 0 a direction from far away. */
  sort(eye: Vector4, nearFirst: boolean): void {
    if (eye.equals(this.before)) return;
    this.before.copy(eye);
    const { corners, distances, middles } = this;
    let [least, most] = [Infinity, -Infinity];
    for (let triangle = 0; triangle < distances.length; triangle++) {
      const x = middles[3 * triangle] as number;
      const y = middles[3 * triangle + 1] as number;
      const z = middles[3 * triangle + 2] as number;
      const away = eye.w ? Math.hypot(x - eye.x, y - eye.y, z - eye.z) : -(x * eye.x + y * eye.y + z * eye.z);
      const distance = Math.fround(away); // as it is kept: a bin must not be below 0
      distances[triangle] = distance;
      least = Math.min(least, distance);
      most = Math.max(most, distance);
    }
    const scale = (BINS - 1) / Math.max(most - least, 1e-20);
    const binOf = (triangle: number): number => {
      const distance = distances[triangle] as number;
      return Math.floor((nearFirst ? distance - least : most - distance) * scale);
    };
    const starts = new Uint32Array(BINS + 1);
    for (let triangle = 0; triangle < distances.length; triangle++) starts[binOf(triangle) + 1]!++;
    for (let bin = 0; bin < BINS; bin++) starts[bin + 1]! += starts[bin] as number;
    const index = indexOf(this.geometry);
    for (let triangle = 0; triangle < distances.length; triangle++) {
      const place = starts[binOf(triangle)]!++;
      for (let corner = 0; corner < 3; corner++) {
        index.array[3 * place + corner] = corners[3 * triangle + corner] as number;
      }
    }
    index.needsUpdate = true;
  }
}

/** The triangles' vertices, written as 0, 1, 2, … where a mesh names none. */
function indexOf(geometry: BufferGeometry): BufferAttribute {
  if (!geometry.index) geometry.setIndex([...Array(geometry.getAttribute("position").count).keys()]);
  return geometry.index as BufferAttribute;
}
