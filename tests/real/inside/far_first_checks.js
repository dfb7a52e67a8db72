// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Print how many of 100 views lose a triangle, and how many draw a near one before a far one.

import { BufferAttribute, BufferGeometry, Mesh, OrthographicCamera, PerspectiveCamera, Vector3 } from "three";
import { sortTriangles } from "far_first";

const COUNT = 500;
let seed = 1;

function random() {
  seed = (seed * 16807) % 2147483647; // Park and Miller
  return seed / 2147483647;
}

const places = new Float32Array(9 * COUNT).map(random);
const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(places, 3));
const mesh = new Mesh(geometry);
const found = { lost: 0, disordered: 0 };
for (let view = 0; view < 100; view++) {
  const camera = view % 2 ? new OrthographicCamera() : new PerspectiveCamera();
  camera.position.set(4 * random() - 2, 4 * random(), 3);
  camera.lookAt(0.5, 0.5, 0.5);
  camera.updateMatrixWorld(true);
  sortTriangles(mesh, camera);
  const order = [...geometry.index.array];
  if (new Set(order).size !== 3 * COUNT) found.lost++;
  const away = Array.from({ length: COUNT }, (_, triangle) => {
    const middle = new Vector3();
    for (const vertex of order.slice(3 * triangle, 3 * triangle + 3)) {
      middle.addScaledVector(new Vector3().fromArray(places, 3 * vertex), 1 / 3);
    }
    return view % 2 ? -middle.applyMatrix4(camera.matrixWorldInverse).z : middle.distanceTo(camera.position);
  });
  if (away.some((distance, place) => place && distance > away[place - 1] + 1e-3)) found.disordered++;
}
console.log(JSON.stringify(found));
