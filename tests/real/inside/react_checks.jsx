// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// What tests ask of <RadTex>: they say which canvases there are and which bakes with which props, and get pictures.

import { Canvas, useLoader, useThree } from "@react-three/fiber";
import { Component, StrictMode, Suspense, useEffect, useRef } from "react";
import { createRoot } from "react-dom/client";
import { Problem, RadTexObject } from "radtex-three";
import { RadTex, useRadTex } from "radtex-three/r3f";
import { FloatType, Matrix4, PerspectiveCamera, WebGLRenderTarget } from "three";
import { MeshoptDecoder } from "three/addons/libs/meshopt_decoder.module.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const root = createRoot(document.getElementById("root"));
const told = { fallbacks: 0, clicks: [], refs: [], problems: [], stock: [], freed: new Map(), made: 0 };
const canvases = {}; // by their names, what each has: state, objects

// Every clone that is made, and how often each object is disposed of.
const { clone, dispose } = RadTexObject.prototype;
RadTexObject.prototype.clone = function (...settings) {
  const made = clone.apply(this, settings);
  told.freed.set(made, 0);
  told.made++;
  return made;
};
RadTexObject.prototype.dispose = function () {
  if (told.freed.has(this)) told.freed.set(this, told.freed.get(this) + 1);
  dispose.apply(this);
};

class Boundary extends Component {
  state = { problem: null };

  static getDerivedStateFromError(problem) {
    return { problem };
  }

  componentDidCatch(error) {
    told.problems.push([error instanceof Problem, error.message, error.remedy]);
  }

  render() {
    const { problem } = this.state;
    return problem ? <p id="problem">{`${problem.message}. ${problem.remedy}`}</p> : this.props.children;
  }
}

function Waiting() {
  useEffect(() => void told.fallbacks++, []);
  return null;
}

function Inside({ name, bakes }) {
  const state = useThree();
  const refs = useRef({});
  canvases[name] = { ...state, objects: refs.current };
  useEffect(() => {
    told.refs.push(Object.values(refs.current).map((object) => object instanceof RadTexObject));
  }, []);
  return bakes.map(({ id, stock, ...props }) =>
    stock ? (
      <Stock key={id} file={stock} />
    ) : (
      <RadTex
        key={id}
        ref={(object) => {
          if (object) refs.current[id] = object;
          else delete refs.current[id];
        }}
        onClick={({ object, eventObject }) => told.clicks.push([id, object.parent === eventObject])}
        {...props}
      />
    ),
  );
}

// The same file by a loader of three.js's.
function Stock({ file }) {
  const { scene } = useLoader(GLTFLoader, file, (loader) => loader.setMeshoptDecoder(MeshoptDecoder));
  const { object } = useRadTex(file);
  useEffect(() => void told.stock.push(scene.isObject3D, object.isRadTexObject), []);
  return null;
}

const camera = { position: [1.6, 0.9, 3.4], fov: 40 };

window.checks = {
  // Show these canvases and no others: lists of bakes by name.
  show: (shown, strict = false) => {
    const page = Object.entries(shown).map(([name, bakes]) => (
      <div key={name} id={name} style={{ width: 200, height: 200 }}>
        <Boundary key={told.problems.length}>
          <Canvas frameloop="demand" camera={camera} shadows>
            <Suspense fallback={<Waiting />}>
              <Inside name={name} bakes={bakes} />
            </Suspense>
          </Canvas>
        </Boundary>
      </div>
    ));
    for (const name of Object.keys(canvases)) if (!(name in shown)) delete canvases[name];
    root.render(strict ? <StrictMode>{page}</StrictMode> : page);
  },

  // Whether all bakes of a canvas are there.
  ready: (name, ids) => {
    const canvas = canvases[name];
    return canvas !== undefined && Object.keys(canvas.objects).sort().join() === [...ids].sort().join();
  },

  // Linear light of a canvas's scene, by a camera of tests; rows from the bottom.
  draw: ([matrix, fovy, width, height], name = "one") => {
    const { gl, scene } = canvases[name];
    const eye = new PerspectiveCamera((fovy * 180) / Math.PI, width / height, 0.05, 100);
    new Matrix4().fromArray(matrix).transpose().decompose(eye.position, eye.quaternion, eye.scale);
    const target = new WebGLRenderTarget(width, height, { type: FloatType });
    gl.setRenderTarget(target);
    gl.setClearColor(0, 0);
    gl.clear();
    gl.render(scene, eye);
    const values = new Float32Array(width * height * 4);
    gl.readRenderTargetPixels(target, 0, 0, width, height, values);
    gl.setRenderTarget(null);
    target.dispose();
    const bytes = new Uint8Array(values.buffer);
    const parts = [];
    for (let begin = 0; begin < bytes.length; begin += 8192) parts.push(String.fromCharCode(...bytes.subarray(begin, begin + 8192)));
    return btoa(parts.join(""));
  },

  // What a bake's object is like.
  object: (id, name = "one") => {
    const { position, rotation, scale, visible, meshes, tint, exposure, opacity, userData, children } = canvases[name].objects[id];
    return {
      position: position.toArray(),
      turn: rotation.toArray().slice(0, 3),
      scale: scale.toArray(),
      visible,
      shadows: meshes.map(({ castShadow }) => castShadow),
      look: [...tint.toArray(), exposure, opacity],
      note: userData.note ?? null,
      children: children.length - meshes.length,
    };
  },

  // Whether two bakes are two objects of the same geometry and textures.
  shared: (one, other, name = "one") => {
    const [first, second] = [one, other].map((id) => canvases[name].objects[id]);
    const same = (a, b) => a.length > 0 && a.every((each, place) => each === b[place]);
    return [
      first !== second,
      same(first.meshes.map(({ geometry }) => geometry), second.meshes.map(({ geometry }) => geometry)),
      same([...first.textures.values()], [...second.textures.values()]),
    ];
  },

  memory: (name = "one") => ({ ...canvases[name].gl.info.memory }),

  // How many clones were made, are in use, and were freed more than once.
  clones: () => {
    const counts = [...told.freed.values()];
    return [told.made, counts.filter((count) => !count).length, counts.filter((count) => count > 1).length];
  },

  told: () => ({ ...told, freed: null }),
  preload: (url) => RadTex.preload(url),
  clear: (url) => RadTex.clear(url),
};
