// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The order of triangles that one sees through: far ones are drawn first, so that near ones cover them.

import { type BufferAttribute, type BufferGeometry, type Mesh, Vector3 } from "three";

const BINS = 1 << 16; // of distances: a counting sort takes a few milliseconds for a hundred thousand triangles

const orders = new WeakMap<Mesh, Order>();

/** Put a mesh's triangles in order for an eye at a place of the page's world. */
export function sortTriangles(mesh: Mesh, eye: Vector3): void {
  const order = orders.get(mesh) ?? new Order(mesh);
  orders.set(mesh, order);
  order.sort(eye);
}

class Order {
  private readonly corners: ArrayLike<number>; // three vertices for each triangle, as they were loaded
  private readonly middles: Float32Array;
  private readonly distances: Float32Array;
  private readonly before = new Vector3(Infinity, 0, 0);

  constructor(private readonly mesh: Mesh) {
    const { geometry } = mesh;
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

  sort(eye: Vector3): void {
    const near = eye.clone().applyMatrix4(this.mesh.matrixWorld.clone().invert());
    if (near.equals(this.before)) return;
    this.before.copy(near);
    const { corners, distances, middles } = this;
    let [least, most] = [Infinity, 0];
    for (let triangle = 0; triangle < distances.length; triangle++) {
      const x = (middles[3 * triangle] as number) - near.x;
      const y = (middles[3 * triangle + 1] as number) - near.y;
      const z = (middles[3 * triangle + 2] as number) - near.z;
      const distance = Math.sqrt(x * x + y * y + z * z);
      distances[triangle] = distance;
      least = Math.min(least, distance);
      most = Math.max(most, distance);
    }
    const scale = (BINS - 1) / Math.max(most - least, 1e-20);
    const binOf = (triangle: number): number => Math.floor((most - (distances[triangle] as number)) * scale);
    const starts = new Uint32Array(BINS + 1);
    for (let triangle = 0; triangle < distances.length; triangle++) starts[binOf(triangle) + 1]!++;
    for (let bin = 0; bin < BINS; bin++) starts[bin + 1]! += starts[bin] as number;
    const index = indexOf(this.mesh.geometry);
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
