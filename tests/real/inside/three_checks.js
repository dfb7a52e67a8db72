// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// What tests ask of the page of docs/three.md: linear light of its scene, by one camera, by two eyes, of an instance.

import {
  ArrayCamera,
  BatchedMesh,
  Color,
  FloatType,
  Fog,
  FrontSide,
  Group,
  InstancedMesh,
  LoadingManager,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  NoToneMapping,
  ObjectLoader,
  OrthographicCamera,
  PerspectiveCamera,
  Plane,
  PlaneGeometry,
  Scene,
  Vector3,
  Vector4,
  WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { KTX2Loader } from "three/addons/loaders/KTX2Loader.js";
import { MeshoptDecoder } from "three/addons/libs/meshopt_decoder.module.js";
import { loadRadTex, radtex, RadTexLoader, RadTexMirror, RadTexSceneLoader } from "radtex-three";

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

// A plane behind all that a camera sees, of an even grey.
function wall(view, grey) {
  if (!grey) return [];
  const material = new MeshBasicMaterial({ color: new Color(grey, grey, grey), toneMapped: false });
  const plane = new Mesh(new PlaneGeometry(200, 200), material);
  const { position, quaternion } = perspective(view);
  plane.quaternion.copy(quaternion);
  plane.position.copy(position).add(new Vector3(0, 0, -30).applyQuaternion(quaternion));
  return [plane];
}

// A picture's bytes, as one number; 0 for none.
function sumOf(texture) {
  if (!texture) return 0;
  const { width, height } = texture.image;
  const into = new OffscreenCanvas(width, height).getContext("2d");
  into.drawImage(texture.image, 0, 0);
  return into.getImageData(0, 0, width, height).data.reduce((sum, byte) => (sum * 31 + byte) % 4294967291, width);
}

const sumsOf = (images) => Object.fromEntries([...images].map(([number, all]) => [number, all.map(sumOf)]));

const imagesOf = (object) => sumsOf([...object.images].map(([number, { base, metal, bump }]) => [number, [base, metal, bump]]));

const asked = () => new URLSearchParams(location.search).get("bake");

// What the console is told as errors from now on.
function listened() {
  const said = [];
  const write = console.error;
  console.error = (...words) => {
    said.push(words.join(" "));
    write(...words);
  };
  return said;
}

// Have the graphics device taken away and given back; tells how many textures the object had meanwhile.
async function lostAndBack(view) {
  const { object, renderer } = await window.app;
  const gone = new Promise((done) => renderer.domElement.addEventListener("webglcontextlost", done));
  const back = new Promise((done) => renderer.domElement.addEventListener("webglcontextrestored", done));
  renderer.forceContextLoss();
  await gone;
  const count = object.textures.size;
  await checks.one(view);
  await new Promise((done) => setTimeout(done));
  renderer.forceContextRestore();
  await back;
  await checks.one(view);
  return count;
}

// Draw with something else in the object's place.
async function drawnInstead(view, ...others) {
  const { object, scene } = await window.app;
  object.visible = false;
  scene.add(...others);
  const made = await drawn(perspective(view), view[2], view[3]);
  scene.remove(...others);
  object.visible = true;
  return made;
}

// A bake that is loaded with nodes, a WebGPURenderer, and what gives two frames of it, the second one's rows from the bottom.
async function loadedForNodes(view, gpu, options) {
  const { WebGPURenderer } = await import("three/webgpu");
  const { nodes } = await import("radtex-three/webgpu");
  const { object, complete, reload } = await loadRadTex(asked(), { ...options, nodes });
  await complete;
  const renderer = new WebGPURenderer({ forceWebGL: !gpu });
  await renderer.init();
  const [, , width, height] = view;
  const target = new WebGLRenderTarget(width, height, { type: FloatType });
  const drawnBy = async (others, camera, fog = null) => {
    const scene = new Scene().add(...others);
    scene.fog = fog;
    for (let frame = 0; frame < 2; frame++) {
      renderer.setRenderTarget(target);
      renderer.setClearColor(0, 0);
      renderer.render(scene, camera);
      await new Promise((done) => setTimeout(done));
    }
    const rows = new Float32Array(await renderer.readRenderTargetPixelsAsync(target, 0, 0, width, height));
    if (!gpu) return encoded(rows);
    const turned = new Float32Array(rows.length);
    for (let row = 0; row < height; row++) {
      turned.set(rows.subarray(row * width * 4, (row + 1) * width * 4), (height - 1 - row) * width * 4);
    }
    return encoded(turned);
  };
  return { object, reload, drawnBy, renderer };
}

window.checks = {
  // A clone of a group that holds the object, in another place, with the camera: nothing may change.
  cloned: async (view, matrix) => {
    const { object, scene } = await window.app;
    const change = new Matrix4().fromArray(matrix).transpose();
    const camera = perspective(view);
    const group = new Group().add(object);
    const copy = group.clone();
    scene.add(object);
    copy.applyMatrix4(change);
    camera.applyMatrix4(change);
    camera.scale.set(1, 1, 1);
    camera.updateMatrixWorld(true);
    object.visible = false;
    scene.add(copy);
    const made = await drawn(camera, view[2], view[3]);
    scene.remove(copy);
    object.visible = true;
    copy.children[0].dispose();
    return made;
  },

  // What a clone shares with its original, and what it has for itself.
  shares: async () => {
    const { object } = await window.app;
    object.userData.note = "kept";
    const copy = object.clone();
    copy.tint.setRGB(0.5, 0.5, 0.5);
    copy.exposure = 3;
    copy.opacity = 0.5;
    copy.position.x = 7;
    const facts = {
      geometry: copy.meshes.every(({ geometry }, place) => geometry === object.meshes[place].geometry),
      textures: [...copy.textures.values()].every((each) => [...object.textures.values()].includes(each)),
      own: [object.tint.r, object.exposure, object.opacity, object.position.x],
      transparent: object.meshes.map(({ material }) => material.transparent),
      kept: copy.userData.note,
      again: copy.clone().exposure,
    };
    copy.dispose();
    return facts;
  },

  // A clone that was made while textures were loading, when its original is gone.
  cloneOfLoading: async (view) => {
    const { object: other, complete } = await loadRadTex(asked());
    const copy = other.clone();
    await complete;
    const { renderer } = await window.app;
    copy.prepare(renderer);
    other.dispose();
    other.dispose();
    const made = await drawnInstead(view, copy);
    copy.dispose();
    return made;
  },

  // How many textures and geometries three.js counts: without another object, with it, with its clone alone, without both.
  counted: async (view) => {
    const { renderer } = await window.app;
    const counts = [];
    const count = async (...others) => {
      await drawnInstead(view, ...others);
      counts.push([renderer.info.memory.textures, renderer.info.memory.geometries]);
    };
    await drawn(perspective(view), view[2], view[3]);
    await count();
    const { object: other, complete } = await loadRadTex(asked());
    await complete;
    const copy = other.clone();
    await count(other, copy);
    other.dispose();
    await count(copy);
    copy.dispose();
    await count();
    return { counts, own: other.manifest.textures };
  },

  // The object with other settings, before a grey plane, which is as bright as `backdrop`; 0 is none.
  looking: async (view, { own = [1, 1, 1], tint = [1, 1, 1], exposure = 1, opacity = 1 }, backdrop = 0, filter = null) => {
    const { object } = await window.app;
    const before = object.filter;
    if (filter) object.filter = filter;
    const copy = object.clone();
    object.filter = before;
    copy.own.fromArray(own);
    copy.tint.fromArray(tint);
    copy.exposure = exposure;
    copy.opacity = opacity;
    const made = await drawnInstead(view, copy, ...wall(view, backdrop));
    copy.dispose();
    return made;
  },

  // The same by a copy of a material, as of any of three.js's.
  lookingByMaterial: async (view, { tint, exposure, opacity }, backdrop) => {
    const { object } = await window.app;
    const copy = object.clone();
    for (const mesh of copy.meshes) {
      mesh.material = mesh.material.clone();
      mesh.material.tint.fromArray(tint);
      mesh.material.exposure = exposure;
      mesh.material.opacity = opacity;
      mesh.material.transparent = true;
    }
    const made = await drawnInstead(view, copy, ...wall(view, backdrop));
    copy.dispose();
    return made;
  },

  // Instances: the first far away, the second in the object's place, in a colour.
  tinted: async (view, colour) => {
    const { object } = await window.app;
    object.updateMatrixWorld(true);
    const copies = object.meshes.map((mesh) => {
      const copy = new InstancedMesh(mesh.geometry, mesh.material, 2);
      copy.setMatrixAt(0, new Matrix4().makeTranslation(0, 1000, 0));
      copy.setMatrixAt(1, mesh.matrixWorld);
      copy.setColorAt(0, new Color(1, 0, 0));
      copy.setColorAt(1, new Color(...colour));
      return copy;
    });
    return drawnInstead(view, ...copies);
  },

  // A BatchedMesh of three: one far away, one in the object's place and one behind it, each in a colour and with an opacity.
  batched: async (view, near, far, nearFirst, backdrop) => {
    const { object } = await window.app;
    object.updateMatrixWorld(true);
    const back = new Vector3().setFromMatrixColumn(perspective(view).matrixWorld, 2).multiplyScalar(-0.5);
    const copies = object.meshes.map((mesh) => {
      const count = mesh.geometry.getAttribute("position").count;
      const material = mesh.material.clone();
      material.transparent = true;
      material.side = FrontSide; // whose inside would be seen through it
      const copy = new BatchedMesh(3, count, mesh.geometry.index.count, material);
      const shape = copy.addGeometry(mesh.geometry);
      const place = (matrix, colour) => {
        const instance = copy.addInstance(shape);
        copy.setMatrixAt(instance, matrix);
        copy.setColorAt(instance, new Vector4(...colour));
      };
      const behind = new Matrix4().makeTranslation(back.x, back.y, back.z).multiply(mesh.matrixWorld);
      const both = [() => place(mesh.matrixWorld, near), () => place(behind, far)];
      for (const each of nearFirst ? both : both.reverse()) each();
      place(new Matrix4().makeTranslation(0, 1000, 0), [1, 0, 0, 1]);
      return copy;
    });
    const made = await drawnInstead(view, ...copies, ...wall(view, backdrop));
    for (const copy of copies) copy.dispose();
    return made;
  },

  // The object as JSON, within a scene; and what ObjectLoader makes of it.
  written: async () => {
    const { object } = await window.app;
    const copy = object.clone();
    copy.tint.setRGB(0.5, 1, 1);
    copy.position.x = 3;
    copy.add(new Group());
    const text = JSON.stringify(new Scene().add(copy).toJSON());
    copy.dispose();
    const read = (await new ObjectLoader().parseAsync(JSON.parse(text))).children[0];
    const { position, userData, name, children } = read;
    return { bytes: text.length, place: position.x, name, children: children.length, ...userData.radtex };
  },

  // What is seen while the graphics device is gone, as soon as it is back, and when textures have come again.
  lost: async (view) => {
    const { object, renderer } = await window.app;
    renderer.setAnimationLoop(null);
    const copy = object.clone();
    object.updateMatrixWorld(true);
    const instances = object.meshes.map((mesh) => {
      const instance = new InstancedMesh(mesh.geometry, mesh.material, 1);
      instance.setMatrixAt(0, mesh.matrixWorld);
      return instance;
    });
    const told = listened();
    await drawnInstead(view, ...instances);
    const flat = await lostAndBack(view);
    while (!object.textures.size) await new Promise((done) => setTimeout(done, 20));
    const again = await checks.one(view);
    const { memory } = renderer.info;
    const both = [...copy.textures.values()].every((each) => [...object.textures.values()].includes(each));
    copy.dispose();
    return { again, instances: await drawnInstead(view, ...instances), flat, both, told, problem: object.problem?.message ?? null, textures: memory.textures };
  },

  // The object without and with a mirror ball, its clone, and the object after the graphics device was lost.
  ball: async (view) => {
    const { object, renderer } = await window.app;
    renderer.setAnimationLoop(null);
    let early = null;
    const other = object.clone();
    other.forget();
    try {
      new RadTexMirror(other, other.filter);
    } catch (error) {
      early = `${error.message} ${error.remedy}`;
    }
    other.dispose();
    const bare = await checks.one(view);
    const ball = new RadTexMirror(object, object.filter);
    object.add(ball);
    ball.set({ place: new Vector3().setFromMatrixColumn(perspective(view).matrixWorld, 2).toArray(), radius: 0.4 });
    const one = await checks.one(view);
    const copy = object.clone();
    const cloned = await drawnInstead(view, copy);
    await lostAndBack(view);
    while (!object.textures.size) await new Promise((done) => setTimeout(done, 20));
    await checks.one(view); // in which the ball finds that it has other textures
    return { early, bare, one, cloned, after: await checks.one(view) };
  },

  // A second renderer draws the object, twice, then the first does: what is said, and what the first shows.
  twoRenderers: async (view) => {
    const { object, scene, renderer } = await window.app;
    const before = await checks.one(view);
    const told = listened();
    const second = new WebGLRenderer();
    for (let frame = 0; frame < 2; frame++) second.render(scene, perspective(view));
    const errors = [second.getContext().getError(), renderer.getContext().getError()];
    second.dispose();
    let thrown = null;
    try {
      object.prepare(second);
    } catch (error) {
      thrown = { name: error.name, remedy: error.remedy };
    }
    return { before, after: await checks.one(view), told, problem: object.problem.message, thrown, errors };
  },

  // What WebGPURenderer draws in three frames, by WebGL where there is no WebGPU; rows from the top.
  webgpu: async (view) => {
    const { object, scene } = await window.app;
    const { WebGPURenderer } = await import("three/webgpu");
    const renderer = new WebGPURenderer({ forceWebGL: true });
    await renderer.init();
    const told = listened();
    const target = new WebGLRenderTarget(view[2], view[3], { type: FloatType });
    scene.background = null;
    for (let frame = 0; frame < 3; frame++) {
      renderer.setRenderTarget(target);
      renderer.setClearColor(0, 0);
      renderer.render(scene, perspective(view));
      await new Promise((done) => setTimeout(done));
    }
    const values = await renderer.readRenderTargetPixelsAsync(target, 0, 0, view[2], view[3]);
    return { light: encoded(new Float32Array(values)), told, problem: object.problem?.message ?? null };
  },

  // What WebGPURenderer draws by nodes, by WebGPU or by WebGL 2, in other ways one by one; rows from the bottom.
  byNodes: async (view, gpu, ways) => {
    const told = listened();
    const lamps = ways.some(({ lamp }) => lamp) ? { lamp: asked() } : {};
    const { object, drawnBy, renderer } = await loadedForNodes(view, gpu, { lamps });
    const pictures = [];
    for (const { look = {}, change, kind = "object", colour = [1, 1, 1], backdrop = 0, fog, side } of ways) {
      const copy = object.clone();
      const { own = [1, 1, 1], tint = [1, 1, 1], exposure = 1, opacity = 1 } = look;
      copy.own.fromArray(own);
      copy.tint.fromArray(tint);
      copy.exposure = exposure;
      copy.opacity = opacity;
      const camera = side ? placed(new OrthographicCamera(-side, side, side, -side, 0.1, 100), view[0]) : perspective(view);
      copy.updateMatrixWorld(true);
      const moved = new Matrix4();
      if (change) {
        moved.fromArray(change).transpose();
        camera.applyMatrix4(moved);
        camera.scale.set(1, 1, 1);
        camera.updateMatrixWorld(true);
      }
      const shown = kind === "object" ? [copy] : copy.meshes.map((mesh) => {
        const matrix = moved.clone().multiply(mesh.matrixWorld);
        const far = new Matrix4().makeTranslation(0, 1000, 0);
        if (kind === "material") return Object.assign(new Mesh(mesh.geometry, mesh.material.clone()), { matrix, matrixAutoUpdate: false });
        if (kind === "instances") {
          const instances = new InstancedMesh(mesh.geometry, mesh.material, 2);
          [far, matrix].forEach((each, place) => instances.setMatrixAt(place, each));
          [[1, 0, 0], colour].forEach((each, place) => instances.setColorAt(place, new Color(...each)));
          return instances;
        }
        const batch = new BatchedMesh(2, mesh.geometry.getAttribute("position").count, mesh.geometry.index.count, mesh.material);
        const shape = batch.addGeometry(mesh.geometry);
        for (const [each, paint] of [[far, [1, 0, 0]], [matrix, colour]]) {
          const place = batch.addInstance(shape);
          batch.setMatrixAt(place, each);
          batch.setColorAt(place, new Vector4(...paint, 1));
        }
        return batch;
      });
      if (kind === "object" && change) copy.applyMatrix4(moved);
      const all = [...shown, ...wall(view, backdrop)];
      pictures.push(await drawnBy(all, camera, fog ? new Fog("#000000", ...fog) : null));
      copy.dispose();
    }
    const counts = [renderer.info.memory.textures];
    const textures = object.textures.size;
    object.dispose();
    counts.push(renderer.info.memory.textures);
    return { pictures, told, gpu: renderer.backend.isWebGPUBackend === true, counts, textures };
  },

  // What nodes show when textures were loaded once more, or another layer was shown meanwhile, and of two rows of instances.
  nodesLater: async (view, gpu) => {
    const told = listened();
    const { object, reload, drawnBy, renderer } = await loadedForNodes(view, gpu, {});
    object.prepare(renderer);
    const camera = perspective(view);
    object.updateMatrixWorld(true);
    const row = (count) => object.meshes.map((mesh) => {
      const instances = new InstancedMesh(mesh.geometry, mesh.material, count);
      for (let place = 0; place < count; place++) instances.setMatrixAt(place, new Matrix4().makeTranslation(0, 1000 + place, 0));
      if (count > 1) instances.setMatrixAt(count - 1, mesh.matrixWorld);
      return instances;
    });
    const rows = [...row(1), ...row(3)];
    const copies = object.meshes.map((mesh) => {
      const copy = new Mesh(mesh.geometry, mesh.material.clone());
      copy.applyMatrix4(mesh.matrixWorld);
      return copy;
    });
    const pictures = { rows: await drawnBy(rows, camera), copies: await drawnBy(copies, camera) };
    await reload();
    await drawnBy([...rows, ...copies], camera); // in which they notice
    Object.assign(pictures, { rowsAgain: await drawnBy(rows, camera), copiesAgain: await drawnBy(copies, camera) });
    const layer = object.lightLayers.at(-1);
    object.lightLayer = layer;
    await drawnBy([object], camera);
    const problem = object.problem?.message ?? null;
    object.lightLayer = "whole";
    pictures.whole = await drawnBy([object], camera);
    return { pictures, told, layer, problem, after: object.problem?.message ?? null };
  },

  // What WebGLRenderer shows of an object that was loaded with nodes.
  nodesElsewhere: async (view) => {
    const told = listened();
    const { nodes } = await import("radtex-three/webgpu");
    const { object, complete } = await loadRadTex(asked(), { nodes });
    await complete;
    await drawnInstead(view, object);
    await new Promise((done) => setTimeout(done));
    return { light: await drawnInstead(view, object), told, problem: object.problem?.message ?? null };
  },

  // The bake by a loader of three.js's kind, from another server that asks for a header; and all that it told.
  byLoader: async (view, server, name) => {
    const told = { started: [], ended: 0, finished: 0, modified: 0, progress: [] };
    const manager = new LoadingManager();
    manager.setURLModifier((url) => {
      if (url.includes("/moved/")) told.modified++;
      return url.replace("/moved/", "/");
    });
    manager.onStart = (url) => told.started.push(url);
    manager.onProgress = () => told.ended++;
    manager.onLoad = () => told.finished++;
    const loader = new RadTexLoader(manager).setPath(`${server}/moved/`).setRequestHeader({ "X-Key": "open" });
    const progress = ({ lengthComputable, loaded, total }) => told.progress.push([lengthComputable, loaded, total]);
    const { object } = await new Promise((done, failed) => loader.load(name, done, progress, failed));
    const files = object.memory.files;
    const scene = await new RadTexSceneLoader().setPath(`${server}/`).setRequestHeader({ "X-Key": "open" }).loadAsync(name);
    const light = await drawnInstead(view, object);
    object.dispose();
    return { light, files, parts: scene.parts.map(({ textures }) => textures.size), ...told };
  },

  // The images of each material as a load finds them, and as three.js's own loader does.
  ownImages: async (address, file) => {
    const { object, complete } = await loadRadTex(address);
    await complete;
    const { scene } = await new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).loadAsync(file);
    const stock = new Map();
    scene.traverse(({ geometry, material }) => {
      if (!geometry?.hasAttribute("uv1") || !material.isMeshStandardMaterial) return;
      const { map, metalnessMap, normalMap, userData } = material;
      stock.set(userData.radtex_material ?? 0, [map, metalnessMap, normalMap]);
    });
    const found = [imagesOf(object), sumsOf(stock)];
    object.dispose();
    return found;
  },

  // A load whose file breaks off the first time, and what is seen when it was loaded again: by then a frame had uploaded what
  // stands for the images. Beside it, the picture of a load that did not break off.
  brokenOff: async (view, address, whole) => {
    const { renderer } = await window.app;
    const { object, complete, reload } = await loadRadTex(address);
    const told = await complete.then(() => null, ({ message }) => message);
    for (const images of object.images.values()) for (const each of Object.values(images)) renderer.initTexture(each);
    await reload();
    const again = await drawnInstead(view, object);
    const error = renderer.getContext().getError();
    const other = await loadRadTex(whole);
    await other.complete;
    const wanted = await drawnInstead(view, other.object);
    const found = [imagesOf(object), imagesOf(other.object)];
    object.dispose();
    other.object.dispose();
    return { told, again, wanted, found, error };
  },

  // How often a manager hears that all is loaded: of the manifest's address, and of the mesh's.
  finished: async (...addresses) => {
    const counts = [];
    for (const address of addresses) {
      let count = 0;
      const manager = new LoadingManager();
      manager.onLoad = () => count++;
      const { object, complete } = await loadRadTex(address, { manager });
      await complete;
      counts.push(count);
      object.dispose();
    }
    return counts;
  },

  // The images of each object that three.js's own loader gives with the plugin, and how often each texture was asked for.
  imagesByGltf: async (file) => {
    performance.clearResourceTimings();
    const { userData } = await new GLTFLoader().register(radtex).loadAsync(file);
    const counts = {};
    for (const { name } of performance.getEntriesByType("resource")) {
      if (name.endsWith(".ktx2")) counts[name] = (counts[name] ?? 0) + 1;
    }
    const found = userData.radtex.map((object) => [imagesOf(object), object.textures.size, object.problem?.message ?? null]);
    for (const object of userData.radtex) object.dispose();
    return { found, counts };
  },

  // What a load that cannot succeed says, by its settings: names of setters, and what they take.
  failing: async (address, settings, abortAfter = null) => {
    const loader = new RadTexLoader(new LoadingManager());
    const errors = [];
    let finished = 0;
    loader.manager.onLoad = () => finished++;
    loader.manager.onError = (url) => errors.push(url.split("/").at(-1));
    for (const [name, value] of Object.entries(settings)) loader[name](value);
    const controller = new AbortController();
    const begin = performance.now();
    if (abortAfter === "signal") loader.setSignal(controller.signal);
    const end = { signal: () => controller.abort(), loader: () => loader.abort(), manager: () => loader.manager.abort() };
    if (abortAfter) setTimeout(end[abortAfter], 200);
    const error = await new Promise((done) => loader.load(address, () => done(null), undefined, done));
    const { name, message, remedy = null } = error;
    const seconds = (performance.now() - begin) / 1000;
    for (let turn = 0; turn < 50 && !finished; turn++) await new Promise((done) => setTimeout(done, 20));
    return { name, message, remedy, errors, finished, seconds };
  },

  // The bake's .glb by three.js's own loader with the plugin.
  byGltf: async (view, file) => {
    const told = listened();
    const { scene, userData } = await new GLTFLoader().register(radtex).loadAsync(file);
    const twin = scene.clone();
    const light = await drawnInstead(view, scene);
    const cloned = await drawnInstead(view, twin);
    const objects = userData.radtex.map(({ name, textures, problem }) => [name, textures.size, problem?.message ?? null]);
    scene.updateMatrixWorld(true);
    const names = [];
    scene.traverse(({ name }) => names.push(name));
    return { light, cloned, objects, told, names };
  },

  // The flat lightmap.
  flatly: async (view) => {
    const { object } = await window.app;
    const before = object.meshes.map(({ material }) => material);
    for (const mesh of object.meshes) mesh.material = object.flat;
    const made = await drawn(perspective(view), view[2], view[3]);
    object.meshes.forEach((mesh, place) => (mesh.material = before[place]));
    return made;
  },

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
    const address = asked();
    const { object: mixed, complete } = await loadRadTex(address, { lamps: { key: address } });
    await complete;
    mixed.own.setScalar(0.5);
    mixed.lamps.get("key").setScalar(2);
    scene.remove(object);
    scene.add(mixed);
    window.mixed = mixed;
  },

  // A clone of that, whose lamp has three times its light, while the original's is out.
  cloneOfMixed: async (view) => {
    const copy = window.mixed.clone();
    copy.lamps.get("key").setScalar(3);
    window.mixed.lamps.get("key").setScalar(0);
    window.mixed.visible = false;
    const made = await drawnInstead(view, copy);
    copy.dispose();
    return made;
  },

  // Instances of that, before and after the graphics device was lost.
  instancesOfMixed: async (view) => {
    const { mixed } = window;
    mixed.lamps.get("key").setScalar(2);
    mixed.visible = true;
    await checks.one(view);
    const instances = mixed.meshes.map((mesh) => {
      const instance = new InstancedMesh(mesh.geometry, mesh.material, 1);
      instance.setMatrixAt(0, mesh.matrixWorld);
      return instance;
    });
    const alone = async () => {
      mixed.visible = false;
      const made = await drawnInstead(view, ...instances);
      mixed.visible = true;
      return made;
    };
    const before = await alone();
    await lostAndBack(view);
    while (!mixed.textures.size) await new Promise((done) => setTimeout(done, 20));
    return [before, await alone()];
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
    const address = asked();
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
