// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// How long a frame takes that one object fills, by each of some materials of three.js on the same mesh.
//
// window.opened(address) loads an export; window.frame(way, side) draws a frame and returns its milliseconds, and
// window.look(way, side) the picture.

import {
  Box3,
  DirectionalLight,
  EquirectangularReflectionMapping,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  MeshPhysicalMaterial,
  MeshStandardMaterial,
  PerspectiveCamera,
  PMREMGenerator,
  Scene,
  Sphere,
  Vector3,
  WebGLRenderer,
} from "three";
import { RoomEnvironment } from "three/addons/environments/RoomEnvironment.js";
import { loadRadTexScene } from "radtex-three";

const FILLS = 0.55; // of the object's radius: the half height of what the camera sees of it

let found = null;

window.opened = async (address) => {
  const renderer = new WebGLRenderer({ preserveDrawingBuffer: true });
  renderer.setPixelRatio(1);
  const { object, complete } = await loadRadTexScene(address);
  await complete;
  const scene = new Scene();
  scene.add(object);
  const lamp = new DirectionalLight(0xffffff, 2);
  lamp.position.set(1, 2, 1);
  scene.add(lamp);
  scene.environment = new PMREMGenerator(renderer).fromScene(new RoomEnvironment()).texture;
  object.updateMatrixWorld(true);
  const ball = new Box3().setFromObject(object).getBoundingSphere(new Sphere());
  const camera = new PerspectiveCamera(20, 1, ball.radius / 100, ball.radius * 100);
  const away = (FILLS * ball.radius) / Math.tan((10 * Math.PI) / 180);
  camera.position.copy(ball.center).addScaledVector(new Vector3(0.45, 0.3, 1).normalize(), away);
  camera.lookAt(ball.center);
  const meshes = [];
  object.traverse((item) => {
    if (item.isMesh) meshes.push(item);
  });
  const own = new Map(meshes.map((mesh) => [mesh, mesh.material]));
  found = { renderer, scene, camera, meshes, own, others: {} };
  return meshes.length;
};

function images(material) {
  const values = material.uniforms ?? {};
  const read = (name) => values[`radtex_${name}_map`]?.value ?? null;
  return { map: read("base"), metalnessMap: read("metal"), roughnessMap: read("metal"), normalMap: read("bump") };
}

const WAYS = {
  basic: (maps) => new MeshBasicMaterial({ map: maps.map }),
  lambert: (maps) => new MeshLambertMaterial({ map: maps.map }),
  standard: (maps) => new MeshStandardMaterial({ ...maps, roughness: 0.4 }),
  physical: (maps) => new MeshPhysicalMaterial({ ...maps, roughness: 0.4 }),
  coated: (maps) => new MeshPhysicalMaterial({ ...maps, roughness: 0.4, clearcoat: 0.5, clearcoatRoughness: 0.1 }),
};

function temporal(material) {
  if (Array.isArray(material)) return material.map(temporal);
  const cheaper = material.clone();
  cheaper.defines = { ...cheaper.defines, RADTEX_TEMPORAL: "" };
  return cheaper;
}

function chosen(way) {
  for (const mesh of found.meshes) {
    const own = found.own.get(mesh);
    if (way === "radtex") mesh.material = own;
    else if (way === "temporal") mesh.material = found.others[`${way} ${mesh.uuid}`] ??= temporal(own);
    else {
      const key = `${way} ${mesh.uuid}`;
      const first = Array.isArray(own) ? own[0] : own;
      found.others[key] ??= WAYS[way](images(first));
      mesh.material = found.others[key];
    }
  }
}

function drawn(side) {
  const { renderer, scene, camera } = found;
  renderer.setSize(side, side);
  renderer.render(scene, camera);
  renderer.getContext().readPixels(0, 0, 1, 1, 0x1908, 0x1401, new Uint8Array(4));
}

window.frame = (way, side) => {
  chosen(way);
  const begin = performance.now();
  drawn(side);
  return performance.now() - begin;
};

window.look = (way, side) => {
  chosen(way);
  drawn(side);
  return found.renderer.domElement.toDataURL("image/png");
};
