// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// What tests ask of radtex-babylon: a .glb in a scene of either handedness, and pictures of it.

import { FreeCamera } from "@babylonjs/core/Cameras/freeCamera.js";
import { Engine } from "@babylonjs/core/Engines/engine.js";
import { ImportMeshAsync, LoadAssetContainerAsync } from "@babylonjs/core/Loading/sceneLoader.js";
import { RenderTargetTexture } from "@babylonjs/core/Materials/Textures/renderTargetTexture.js";
import { Color3, Color4 } from "@babylonjs/core/Maths/math.color.js";
import { Vector3 } from "@babylonjs/core/Maths/math.vector.js";
import { MeshoptCompression } from "@babylonjs/core/Meshes/Compression/meshoptCompression.js";
import { Scene } from "@babylonjs/core/scene.js";
import { Constants } from "@babylonjs/core/Engines/constants.js";
import "@babylonjs/core/Meshes/instancedMesh.js";
import "@babylonjs/loaders/glTF/2.0/index.js";
import { RadTexMaterial, registerRadTex } from "radtex-babylon";

let problems = [];
registerRadTex(({ name, message, remedy }) => problems.push([name, `${message}. ${remedy}`]));
MeshoptCompression.Configuration.decoder.url = "meshopt_decoder.js";

const canvas = document.getElementById("canvas");
const engine = new Engine(canvas, false, { preserveDrawingBuffer: true });
let scene = null;
let loaded = null;

// A camera of tests, in glTF's axes; the root of a file in a left-handed scene turns x around.
function eye([matrix, fovy]) {
  const axis = scene.useRightHandedSystem ? 1 : -1;
  const column = (k) => new Vector3(axis * matrix[k], matrix[4 + k], matrix[8 + k]);
  const camera = new FreeCamera("eye", column(3), scene);
  camera.upVector = column(1);
  camera.setTarget(column(3).subtract(column(2)));
  camera.fov = fovy;
  camera.minZ = 0.05;
  camera.maxZ = 100;
  return camera;
}

function encoded(values) {
  const bytes = new Uint8Array(values.buffer, values.byteOffset, values.byteLength);
  const parts = [];
  for (let begin = 0; begin < bytes.length; begin += 8192) parts.push(String.fromCharCode(...bytes.subarray(begin, begin + 8192)));
  return btoa(parts.join(""));
}

async function until(isSo) {
  const end = performance.now() + 30000;
  while (!isSo()) {
    if (performance.now() > end) throw new Error("it does not become ready");
    await new Promise((done) => setTimeout(done, 20));
  }
}

const ours = () => scene.meshes.filter(({ material }) => material instanceof RadTexMaterial);

window.checks = {
  // Load a .glb anew: how many meshes show radiance, and why others do not.
  load: async (file, rightHanded, apart = false) => {
    scene?.dispose();
    scene = new Scene(engine);
    scene.useRightHandedSystem = rightHanded;
    scene.clearColor = new Color4(0, 0, 0, 0);
    problems = [];
    const [folder, name] = [file.slice(0, file.lastIndexOf("/") + 1), file.slice(file.lastIndexOf("/") + 1)];
    const options = { rootUrl: folder || "./" };
    if (apart) {
      loaded = await LoadAssetContainerAsync(name, scene, options);
      const before = [scene.meshes.length, scene.materials.length, scene.textures.length];
      loaded.addAllToScene();
      return { before, shown: ours().length };
    }
    loaded = await ImportMeshAsync(name, scene, options);
    return { shown: ours().length, meshes: scene.meshes.length, problems };
  },

  // Linear light by a camera of tests; rows from the bottom.
  draw: async (view) => {
    const [, , width, height] = view;
    scene.imageProcessingConfiguration.applyByPostProcess = true; // so that materials give light
    engine.setSize(width, height); // which a target's cameras take their shape from
    const target = new RenderTargetTexture("target", { width, height }, scene, false, true, Constants.TEXTURETYPE_FLOAT);
    target.activeCamera = eye(view);
    target.renderList = scene.meshes;
    for (const node of [...scene.transformNodes, ...scene.meshes]) node.computeWorldMatrix(true); // as each frame does
    scene.activeCamera = target.activeCamera;
    scene.customRenderTargets = [];
    await until(() => target.isReadyForRendering());
    target.render();
    const values = await target.readPixels();
    target.dispose();
    target.activeCamera.dispose();
    scene.imageProcessingConfiguration.applyByPostProcess = false;
    return encoded(new Float32Array(values.buffer, values.byteOffset, width * height * 4));
  },

  // The same as the screen shows it, from 0 to 1.
  screen: async (view, settings = {}) => {
    Object.assign(scene.imageProcessingConfiguration, settings);
    const [, , width, height] = view;
    engine.setSize(width, height);
    scene.activeCamera = eye(view);
    await until(() => scene.isReady());
    scene.render();
    const gl = engine._gl;
    const bytes = new Uint8Array(width * height * 4);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return encoded(Float32Array.from(bytes, (byte) => byte / 255));
  },

  // Move the whole file with the camera's world, and its look.
  change: ({ position, scale, tint, exposure, culled }) => {
    const [root] = scene.rootNodes.filter(({ name }) => name === "__root__");
    if (position) root.position.fromArray(position);
    if (scale) root.scaling.scaleInPlace(scale);
    for (const { material } of ours()) {
      if (tint) material.tint = Color3.FromArray(tint);
      if (exposure) material.exposure = exposure;
      if (culled) material.backFaceCulling = true;
    }
  },

  // Give the meshes clones of their materials, in another tint.
  cloned: (tint) => {
    for (const mesh of ours()) {
      const before = mesh.material;
      mesh.material = before.clone("copy");
      mesh.material.tint.copyFromFloats(...tint);
      before.tint.copyFromFloats(0, 0, 0);
    }
  },

  // Draw instances in the meshes' places.
  instances: () => {
    for (const mesh of ours()) {
      const copy = mesh.createInstance("copy");
      copy.parent = mesh.parent;
      copy.position.copyFrom(mesh.position);
      copy.rotationQuaternion = mesh.rotationQuaternion?.clone() ?? null;
      copy.scaling.copyFrom(mesh.scaling);
      mesh.isVisible = false;
    }
  },

  // The graphics device is taken away and comes back: how many meshes show radiance meanwhile.
  lost: async () => {
    const lose = engine._gl.getExtension("WEBGL_lose_context");
    const gone = new Promise((done) => canvas.addEventListener("webglcontextlost", done, { once: true }));
    const back = new Promise((done) => engine.onContextRestoredObservable.addOnce(done));
    lose.loseContext();
    await gone;
    await new Promise((done) => setTimeout(done, 50));
    const shown = ours().length;
    lose.restoreContext();
    await back;
    return shown;
  },

  shown: () => ours().length,
  errors: () => engine._gl.getError(),
};
