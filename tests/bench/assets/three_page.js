// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// A scene as a developer shows it with three.js alone: its own images in MeshPhysicalMaterial, lit by a probe.
//
// scene.glb is Blender's own export, probe.bin an equirectangular picture of what lies around the asset: half
// floats, RGBA, the lowest row first. window.picture(matrix, fovy, side) gives linear light.
//
// Where lights.json names light maps (width and height in texels, UV channel), light0.bin and so on hold
// the radiance of white paint, half floats, RGBA, rows as UVs run. A node's extra "light" is its map's number.
// All diffuse light then comes from the maps, and sky.bin, a picture like probe.bin, is the background.

import {
  Box3,
  DataTexture,
  EquirectangularReflectionMapping,
  FloatType,
  HalfFloatType,
  LinearFilter,
  LinearSRGBColorSpace,
  Matrix4,
  MeshPhysicalMaterial,
  MeshStandardMaterial,
  NoToneMapping,
  PCFSoftShadowMap,
  PerspectiveCamera,
  PMREMGenerator,
  RGBAFormat,
  Scene,
  ShaderChunk,
  Sphere,
  Vector3,
  WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";

const SHADOW = 4096; // pixels of a lamp's shadow map
const IMAGES = ["map", "normalMap", "metalnessMap", "roughnessMap", "aoMap", "emissiveMap", "lightMap"];
// What three.js takes of the probe's diffuse light: for matt surfaces, and for sheen, which has the light map's.
const PROBE_DIFFUSE = [
  "reflectedLight.indirectDiffuse += indirectDiffuse;",
  "sheenSpecularIndirect += irradiance * material.sheenColor * IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness ) * RECIPROCAL_PI;",
];

async function opened() {
  const renderer = new WebGLRenderer();
  renderer.toneMapping = NoToneMapping;
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = PCFSoftShadowMap;
  const scene = new Scene();
  const lights = await (await fetch("lights.json")).json();
  const maps = await Promise.all(lights.map(lightMap));
  const probe = await panorama("probe.bin");
  scene.background = maps.length ? await panorama("sky.bin") : probe;
  scene.environment = new PMREMGenerator(renderer).fromEquirectangular(probe).texture;
  const { scene: content } = await new GLTFLoader().loadAsync("scene.glb");
  scene.add(content);
  const lamps = [];
  content.traverse((item) => {
    if (item.isLight) lamps.push(item);
    if (!item.isMesh) return;
    item.castShadow = item.receiveShadow = true;
    item.material = physical(item.material, renderer.capabilities.getMaxAnisotropy());
    if (maps.length) light(item.material, maps[lightOf(item)]);
  });
  content.updateMatrixWorld(true);
  const whole = new Box3().setFromObject(content).getBoundingSphere(new Sphere());
  for (const lamp of lamps) castShadows(lamp, whole);
  return { renderer, scene };
}

async function panorama(file) {
  const values = await halfFloats(file);
  const height = Math.sqrt(values.length / 8);
  const made = texture(values, 2 * height, height);
  made.mapping = EquirectangularReflectionMapping;
  return made;
}

async function lightMap({ width, height, channel }, number) {
  const made = texture(await halfFloats(`light${number}.bin`), width, height);
  made.channel = channel;
  return made;
}

async function halfFloats(file) {
  return new Uint16Array(await (await fetch(file)).arrayBuffer());
}

function texture(values, width, height) {
  const made = new DataTexture(values, width, height, RGBAFormat, HalfFloatType);
  made.colorSpace = LinearSRGBColorSpace;
  made.minFilter = made.magFilter = LinearFilter;
  made.needsUpdate = true;
  return made;
}

function physical(standard, anisotropy) {
  const made = new MeshPhysicalMaterial();
  if (standard.isMeshPhysicalMaterial) made.copy(standard);
  else MeshStandardMaterial.prototype.copy.call(made, standard);
  made.defines = { STANDARD: "", PHYSICAL: "" };
  for (const name of IMAGES) if (made[name]) made[name].anisotropy = anisotropy;
  return made;
}

function lightOf(item) {
  return "light" in item.userData ? item.userData.light : lightOf(item.parent);
}

function light(material, map) {
  material.lightMap = map;
  material.lightMapIntensity = Math.PI; // three.js takes irradiance
  if (material.transparent && material.map && material.opacity === 1) {
    // leaves, which hide each other only if they are cut out
    material.transparent = false;
    material.depthWrite = true;
    material.alphaTest = 0.5;
  }
  material.onBeforeCompile = (shader) => {
    let chunk = ShaderChunk.lights_physical_pars_fragment;
    for (const line of PROBE_DIFFUSE) {
      if (!chunk.includes(line)) throw new Error(`this three.js has no line ${line}`);
      chunk = chunk.replace(line, "");
    }
    shader.fragmentShader = shader.fragmentShader.replace("#include <lights_physical_pars_fragment>", chunk);
  };
}

function castShadows(lamp, whole) {
  const { shadow } = lamp;
  lamp.castShadow = true;
  shadow.mapSize.set(SHADOW, SHADOW);
  shadow.normalBias = 0.02;
  if (!lamp.isDirectionalLight) return;
  const { camera } = shadow;
  const { center, radius } = whole;
  const place = lamp.getWorldPosition(new Vector3());
  const away = lamp.target.getWorldPosition(new Vector3()).sub(place).normalize();
  lamp.parent.worldToLocal(lamp.position.copy(center).addScaledVector(away, -2 * radius));
  lamp.updateMatrixWorld(true);
  [camera.left, camera.right, camera.bottom, camera.top] = [-radius, radius, -radius, radius];
  [camera.near, camera.far] = [radius, 3 * radius];
  shadow.bias = -4 / SHADOW;
}

const page = opened();

window.picture = async (matrix, fovy, side) => {
  const { renderer, scene } = await page;
  const camera = new PerspectiveCamera((fovy * 180) / Math.PI, 1, 0.001, 100);
  new Matrix4().fromArray(matrix).transpose().decompose(camera.position, camera.quaternion, camera.scale);
  const target = new WebGLRenderTarget(side, side, { type: FloatType, samples: 4 });
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  const values = new Float32Array(4 * side * side);
  renderer.readRenderTargetPixels(target, 0, 0, side, side, values);
  target.dispose();
  return base64(new Uint8Array(values.buffer));
};

function base64(bytes) {
  let text = "";
  for (let at = 0; at < bytes.length; at += 1 << 15) text += String.fromCharCode(...bytes.subarray(at, at + (1 << 15)));
  return btoa(text);
}

window.materials = async () => {
  const { scene } = await page;
  const found = {};
  scene.traverse(({ material }) => {
    if (material) found[material.name] = [material.type, ...IMAGES.filter((name) => material[name])];
  });
  return found;
};
