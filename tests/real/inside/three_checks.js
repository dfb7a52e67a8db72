// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// What tests ask of the page of docs/three.md: linear light of its scene, by one camera, by two eyes, of an instance.

import {
  ArrayCamera,
  FloatType,
  Fog,
  InstancedMesh,
  Matrix4,
  NoToneMapping,
  OrthographicCamera,
  PerspectiveCamera,
  Plane,
  Vector3,
  Vector4,
  WebGLRenderTarget,
} from "three";
import { KTX2Loader } from "three/addons/loaders/KTX2Loader.js";
import { loadRadTex } from "radtex-three";

function placed(camera, matrix) {
  new Matrix4().fromArray(matrix).transpose().decompose(camera.position, camera.quaternion, camera.scale);
  camera.updateMatrixWorld(true);
  return camera;
}

function perspective([matrix, fovy, width, height]) {
  const camera = new PerspectiveCamera((fovy * 180) / Math.PI, width / height, 0.05, 100);
  return placed(camera, matrix);
}

async function drawn(camera, width, height, screen = false) {
  const { scene, renderer } = await window.app;
  renderer.setAnimationLoop(null);
  scene.background = null;
  if (screen) return onScreen(scene, camera, renderer, width, height);
  const target = new WebGLRenderTarget(width, height, { type: FloatType });
  renderer.setRenderTarget(target);
  renderer.setClearColor(0, 0);
  renderer.clear();
  renderer.render(scene, camera);
  const values = new Float32Array(width * height * 4);
  renderer.readRenderTargetPixels(target, 0, 0, width, height, values);
  renderer.setRenderTarget(null);
  target.dispose();
  return encoded(values);
}

function onScreen(scene, camera, renderer, width, height) {
  renderer.setPixelRatio(1);
  renderer.setSize(width, height);
  renderer.setClearColor(0, 0);
  renderer.render(scene, camera);
  const gl = renderer.getContext();
  const bytes = new Uint8Array(width * height * 4);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  return encoded(Float32Array.from(bytes, (byte) => byte / 255));
}

function encoded(values) {
  const bytes = new Uint8Array(values.buffer);
  const parts = [];
  for (let begin = 0; begin < bytes.length; begin += 8192) {
    parts.push(String.fromCharCode(...bytes.subarray(begin, begin + 8192)));
  }
  return btoa(parts.join(""));
}

window.checks = {
  // Whether the shaders of the object's materials look a second lobe up, in the order of their numbers.
  secondLobes: async () => {
    const { object } = await window.app;
    const found = [];
    object.traverse(({ material }) => material && found.push(...[material].flat()));
    return found.map(({ fragmentShader }) => !fragmentShader.includes("#define RADTEX_SECOND_LOBE 0"));
  },
  // Load the page's bake once more, itself as a lamp of twice its light beside half of its own.
  addLamp: async () => {
    const { object, scene } = await window.app;
    const address = new URLSearchParams(location.search).get("bake");
    const { object: mixed, complete } = await loadRadTex(address, { lamps: { key: address } });
    await complete;
    mixed.own.setScalar(0.5);
    mixed.lamps.get("key").setScalar(2);
    scene.remove(object);
    scene.add(mixed);
  },

  one: (view, screen) => drawn(perspective(view), view[2], view[3], screen),

  // Two eyes side by side in one picture, as WebXR draws them.
  eyes: (left, right) => {
    const eyes = [left, right].map((view, place) => {
      const eye = perspective(view);
      eye.viewport = new Vector4(place * view[2], 0, view[2], view[3]);
      return eye;
    });
    const both = new ArrayCamera(eyes);
    placed(both, left[0]);
    both.projectionMatrix.copy(eyes[0].projectionMatrix);
    return drawn(both, 2 * left[2], left[3]);
  },

  // The object turned, moved and scaled with the camera: nothing may change.
  moved: async (view, matrix) => {
    const { object } = await window.app;
    const change = new Matrix4().fromArray(matrix).transpose();
    const camera = perspective(view);
    object.applyMatrix4(change);
    camera.applyMatrix4(change);
    camera.scale.set(1, 1, 1);
    camera.updateMatrixWorld(true);
    const made = await drawn(camera, view[2], view[3]);
    object.applyMatrix4(change.invert());
    return made;
  },

  // The same by an instance of its mesh, the object itself hidden.
  instance: async (view, matrix) => {
    const { object, scene } = await window.app;
    const change = new Matrix4().fromArray(matrix).transpose();
    const camera = perspective(view);
    camera.applyMatrix4(change);
    camera.scale.set(1, 1, 1);
    camera.updateMatrixWorld(true);
    object.updateMatrixWorld(true);
    const copies = object.meshes.map((mesh) => {
      const copy = new InstancedMesh(mesh.geometry, mesh.material, 1);
      copy.setMatrixAt(0, change.clone().multiply(mesh.matrixWorld));
      return copy;
    });
    object.visible = false;
    scene.add(...copies);
    const made = await drawn(camera, view[2], view[3]);
    scene.remove(...copies);
    object.visible = true;
    return made;
  },

  // An orthographic camera that sees `side` to each side of its middle.
  orthographic: (view, side) => {
    const camera = placed(new OrthographicCamera(-side, side, side, -side, 0.1, 100), view[0]);
    return drawn(camera, view[2], view[3]);
  },

  // What a plane across the world, `away` from its middle, leaves: set for all that is drawn, or for the material alone.
  clipped: async (view, away, local) => {
    const { object, renderer } = await window.app;
    const planes = [new Plane(new Vector3(0, 1, 0), away)];
    renderer.localClippingEnabled = local;
    if (local) for (const { material } of object.meshes) material.clippingPlanes = planes;
    else renderer.clippingPlanes = planes;
    const made = await drawn(perspective(view), view[2], view[3]);
    for (const { material } of object.meshes) material.clippingPlanes = null;
    renderer.clippingPlanes = [];
    return made;
  },

  // The object by a copy of its material, made before its textures are uploaded; then another object, which shows them too,
  // is disposed of.
  shared: async (view) => {
    const { object, scene } = await window.app;
    const address = new URLSearchParams(location.search).get("bake");
    const { object: other, complete } = await loadRadTex(address);
    await complete;
    for (const mesh of other.meshes) mesh.material = mesh.material.clone();
    scene.remove(object);
    scene.add(other);
    object.take(object.manifest, other.textures);
    object.dispose();
    return drawn(perspective(view), view[2], view[3]);
  },

  // Which of these files three.js's own loader takes: null, or what it says.
  stock: async (files) => {
    const { renderer } = await window.app;
    const loader = new KTX2Loader().detectSupport(renderer);
    const said = {};
    for (const file of files) {
      const load = loader.loadAsync(file);
      said[file] = await load.then((texture) => (texture.image.width > 0 ? null : "empty"), (error) => error.message);
    }
    return said;
  },

  fog: async (view, near, far) => {
    const { scene, renderer } = await window.app;
    const before = renderer.toneMapping;
    renderer.toneMapping = NoToneMapping;
    scene.fog = new Fog("#000000", near, far);
    const made = await drawn(perspective(view), view[2], view[3]);
    scene.fog = null;
    renderer.toneMapping = before;
    return made;
  },
};
