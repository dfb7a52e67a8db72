// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// For three.js's GLTFLoader: the bakes of a .glb as radiance, in the place of their flat lightmaps.

import { type Material, Mesh, type Object3D } from "three";
import { MeshoptDecoder } from "three/addons/libs/meshopt_decoder.module.js";
import type { GLTF, GLTFLoaderPlugin, GLTFParser } from "three/addons/loaders/GLTFLoader.js";

import { thisDevice } from "./device.js";
import { fileUrl } from "./fetching.js";
import { alone, again, completed, flatOf, known, type LoadOptions, oneAtATime } from "./load.js";
import { loadTextures } from "./load_textures.js";
import { checkManifest, type Manifest } from "./manifest.js";
import { bakeOf, EXTENSION, factsIn } from "./mesh_file.js";
import { Problem, report } from "./problem.js";
import { RadTexObject } from "./radtex_object.js";
import { type RequestOptions, Requests } from "./requests.js";

/** Textures that several bakes have, by their addresses: each is loaded once. */
type Shared = NonNullable<LoadOptions["shared"]>;

export type PluginOptions = Omit<LoadOptions, "lamps" | "requests">;

/**
 * A plugin: `loader.register(radtex)`, or with options `loader.register((parser) => radtex(parser, options))`.
 *
 * What is loaded then has a RadTexObject in the place of each bake's meshes, with its textures; `gltf.userData.radtex` lists
 * them. A bake whose textures are missing, damaged or too much for the device keeps its flat lightmap: its `problem` says
 * why, and so does the console.
 */
export function radtex(parser: GLTFParser, options: PluginOptions = {}): GLTFLoaderPlugin {
  const settings = parser.options as ParserOptions;
  settings.meshoptDecoder ??= MeshoptDecoder; // which meshes of web exports may need
  return {
    name: EXTENSION,
    afterRoot: async (gltf: GLTF) => {
      const { crossOrigin, manager, path, requestHeader, withCredentials } = settings;
      const requests: RequestOptions = { crossOrigin, manager, requestHeader, withCredentials };
      const base = new URL(path || ".", document.baseURI);
      const bakes = gltf.scenes.flatMap((scene) => bakesBelow(scene, parser, base));
      const asked = { ...requests, shared: new Map(), ...options };
      const reloaded = inOneGo();
      const shown = await Promise.all(bakes.map((bake) => objectOf(bake, base, asked, reloaded)));
      const objects = shown.filter((each) => each !== null);
      if (gltf.animations.length) for (const each of objects) each.name = ""; // they move nodes, which they know by name
      gltf.userData["radtex"] = objects;
    },
  };
}

/** What a parser knows of its file; three.js's types have a part of it. */
type ParserOptions = GLTFParser["options"] & { withCredentials?: boolean };

/** A bake of the file, with its meshes, which lie side by side. */
interface FoundBake {
  manifest: Manifest;
  meshes: Mesh[];
}

/** The bakes of a scene. One that is damaged, or of a newer version, is told to the console, and stays as it is. */
function bakesBelow(scene: Object3D, parser: GLTFParser, base: URL): FoundBake[] {
  const factsOf = factsIn(parser);
  const found = new Map<string, FoundBake>();
  scene.updateMatrixWorld(true);
  scene.traverse((each) => {
    const facts = each instanceof Mesh ? factsOf(each.material as Material) : undefined;
    if (!facts) return;
    const isNode = parser.associations.get(each)?.nodes !== undefined; // else one of several primitives below a node
    const key = `${isNode ? each.uuid : each.parent?.uuid} ${facts.flat}`;
    try {
      const bake = found.get(key) ?? { manifest: checkManifest(facts, new URL(`${facts.mesh}`, base)), meshes: [] };
      bake.meshes.push(each as Mesh);
      found.set(key, bake);
    } catch (error) {
      if (!(error instanceof Problem)) throw error;
      report(error);
    }
  });
  return [...found.values()];
}

/** A bake as an object among its meshes' siblings, which does not move them; null if it lacks what it needs, as is told. */
async function objectOf(
  { manifest, meshes }: FoundBake,
  base: URL,
  options: LoadOptions,
  reloaded: () => Shared,
): Promise<RadTexObject | null> {
  const file = fileUrl(manifest.mesh, base);
  const requests = new Requests(options);
  const parent = meshes[0]?.parent as Object3D;
  let object: RadTexObject | null = null;
  try {
    const { parts, map } = bakeOf(meshes, file);
    const flat = map ?? (await flatOf(manifest, base, requests));
    object = placed(new RadTexObject(manifest, parts, flat, [], options.nodes), parent);
    await filled(object, base, file, { ...options, requests }, reloaded);
  } catch (error) {
    if (!(error instanceof Problem)) throw error;
    if (object) object.failed(error);
    else report(error);
  }
  return object;
}

/** Put an object below another, its meshes where they are. */
function placed(object: RadTexObject, parent: Object3D): RadTexObject {
  parent.add(object);
  const into = parent.matrixWorld.clone().invert();
  for (const mesh of object.meshes) mesh.applyMatrix4(into);
  object.updateMatrixWorld(true);
  return object;
}

/** Load an object's textures, and let it load them again. */
async function filled(
  object: RadTexObject,
  base: URL,
  file: URL,
  options: LoadOptions,
  reloaded: () => Shared,
): Promise<void> {
  const { manifest } = object;
  const device = options.device ?? (options.nodes?.device ?? thisDevice)();
  const load = (asked: LoadOptions): Promise<void> =>
    completed(object, alone(loadTextures(manifest, base, device, asked)));
  known(object, file, options, oneAtATime(() => load({ ...again(options), shared: reloaded() })));
  await load(options);
}

/** What bakes share that are loaded in one go, as all are when the graphics device came back. */
function inOneGo(): () => Shared {
  let shared: Shared | null = null;
  return () => {
    if (!shared) setTimeout(() => (shared = null));
    return (shared ??= new Map());
  };
}
