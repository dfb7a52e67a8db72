// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// three.js as anybody uses it: load a .glb, draw it, and tell what the screen would show.

import { Matrix4, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "three";
import { MeshoptDecoder } from "three/examples/jsm/libs/meshopt_decoder.module.js";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";

// The picture's bytes in [0, 1], float32 in base64, rows from the top; the camera as window.radtex takes it.
window.draw = async (file, [matrix, fovy, width, height]) => {
  const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder); // meshes of web exports are compressed
  const { scene: model } = await loader.loadAsync(file);
  const scene = new Scene().add(model);
  const camera = new PerspectiveCamera((fovy * 180) / Math.PI, width / height, 0.1, 100);
  new Matrix4().fromArray(matrix).transpose().decompose(camera.position, camera.quaternion, new Vector3());
  const canvas = document.getElementById("view");
  const renderer = new WebGLRenderer({ canvas, preserveDrawingBuffer: true });
  renderer.setSize(width, height);
  renderer.render(scene, camera);
  const gl = renderer.getContext();
  const bytes = new Uint8Array(width * height * 4);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  const values = new Float32Array(bytes.length);
  for (let row = 0; row < height; row++) {
    for (let k = 0; k < width * 4; k++) values[row * width * 4 + k] = bytes[(height - 1 - row) * width * 4 + k] / 255;
  }
  return btoa(Array.from(new Uint8Array(values.buffer), (byte) => String.fromCharCode(byte)).join(""));
};
