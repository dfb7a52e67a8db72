// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// From an address to objects in a scene.

import { Group, type LoadingManager, type Material, type Mesh, type Object3D, SRGBColorSpace, Texture } from "three";

import { type Device, thisDevice } from "./device.js";
import { fetchBytes, fileName, fileUrl } from "./fetching.js";
import { entriesOf, loadTextures, type TextureOptions } from "./load_textures.js";
import { checkManifest, type Manifest, readAnyManifest, readManifest } from "./manifest.js";
import { bakeBelow, loadMeshFile, type MeshFile } from "./mesh_file.js";
import type { Nodes } from "./material.js";
import type { Bake } from "./parts.js";
import { Problem } from "./problem.js";
import { RadTexObject } from "./radtex_object.js";
import { type RequestOptions, Requests } from "./requests.js";
import { sunUniforms } from "./sun.js";
import type { BakeTexture } from "./textures.js";

const IMAGES = 3; // of a material that is shown by its own

type Textures = Map<string, BakeTexture>;

export interface LoadOptions extends TextureOptions, RequestOptions {
  /** What the device takes; by default this one is asked. */
  device?: Device;
  /** Exports of the same surface lit by one lamp each, by names of yours, to be mixed by `object.lamps`. */
  lamps?: Readonly<Record<string, string | URL>>;
  /** Whether the textures are loaded again by themselves after the graphics device was taken away and came back; true by default. */
  restore?: boolean;
  /** For WebGPURenderer: `nodes` of radtex-three/webgpu. */
  nodes?: Nodes;
}

/** A bake that can be drawn. */
export interface RadTex {
  /** Shows the flat lightmap at first, and the radiance from when `complete` is fulfilled. */
  object: RadTexObject;
  manifest: Manifest;
  /**
   * Fulfilled when all textures are there, or the device cannot take them: `object.problem` says why then. Rejected with
   * a Problem for a file that is missing or damaged.
   */
  complete: Promise<void>;
  /** Load the textures again, of the object and its clones: for another renderer, or with `restore: false`. As `complete`. */
  reload: () => Promise<void>;
}

/** Several bakes that can be drawn. */
export interface RadTexScene {
  /** Holds all of `parts`. */
  object: Group;
  name: string;
  parts: RadTexObject[];
  /** As of one bake; each part shows its radiance as soon as its own textures, and images, are there. */
  complete: Promise<void>;
  reload: () => Promise<void>;
}

/**
 * Load an export of RadTex by the address of its NAME.export.json or NAME.glb, relative to the page.
 *
 * Fulfilled as soon as the object can be drawn with its flat lightmap; await `complete` for the whole. Rejected with a
 * Problem, whose `message` and `remedy` are for people, where a file is missing, damaged, or of a newer version.
 */
export async function loadRadTex(address: string | URL, options: LoadOptions = {}): Promise<RadTex> {
  return held(address, options.manager, () => radTexOf(address, options));
}

async function radTexOf(address: string | URL, options: LoadOptions): Promise<RadTex> {
  const url = addressOf(address);
  const device = options.device ?? (options.nodes?.device ?? thisDevice)();
  const asked = { ...options, requests: new Requests(options) };
  const [manifest, early] = url.pathname.endsWith(".glb")
    ? await manifestOfMesh(url, asked.requests)
    : [await readManifest(url, asked.requests), null];
  return loadOne(manifest, url, device, asked, early);
}

/** Load an export of one bake, with `lamps`, or of several by the address of its NAME.export.json. Rejected as `loadRadTex`. */
export async function loadRadTexScene(address: string | URL, options: LoadOptions = {}): Promise<RadTexScene> {
  return held(address, options.manager, () => sceneOf(address, options));
}

async function sceneOf(address: string | URL, options: LoadOptions): Promise<RadTexScene> {
  const url = addressOf(address);
  const device = options.device ?? (options.nodes?.device ?? thisDevice)();
  const requests = new Requests(options);
  const manifest = await readAnyManifest(url, requests);
  if (!("scene" in manifest)) {
    const { object: part, complete, reload } = await loadOne(manifest, url, device, { ...options, requests });
    return { object: new Group().add(part), name: manifest.name, parts: [part], complete, reload };
  }
  if (Object.keys(options.lamps ?? {}).length) {
    throw new Problem(
      `${manifest.name} is a whole scene, to which lamps cannot be added`,
      "Load the export of one object, or leave the lamps out.",
    );
  }
  const manifests = manifest.scene;
  const asked = { ...options, requests };
  const load = (): Promise<Textures>[] => loadAll(manifests, url, device, asked);
  const mesh = fileUrl(manifest.mesh, url);
  const [{ root, images, imagesAgain }, loading] = await afterMesh(mesh, requests, load);
  const parts = await Promise.all(
    manifests.map(async (part) => {
      const { parts: meshes, map } = bakeBelow(nodeOf(root, part.node, mesh), mesh);
      return new RadTexObject(part, meshes, map ?? (await flatOf(part, url, requests)), [], options.nodes);
    }),
  );
  const object = new Group();
  object.name = manifest.name;
  object.add(...parts);
  const taken = async (coming: Promise<Textures>[], shown: Promise<void>): Promise<void> => {
    const whole = parts.map(async (part, place) => {
      if (part.images.size) await shown;
      return alone(coming[place] as Promise<Textures>);
    });
    await Promise.all(parts.map((part, place) => completed(part, whole[place] as Promise<[Textures]>)));
  };
  const reload = oneAtATime(() => {
    const once = again(options);
    return taken(loadAll(manifests, url, device, once), imagesAgain(once.requests));
  });
  for (const part of parts) known(part, url, options, reload);
  return { object, name: manifest.name, parts, complete: taken(loading, images), reload };
}

/** The same, which a LoadingManager counts as one item more until it is complete: between two files nothing is finished. */
async function held<Data extends { complete: Promise<void> }>(
  address: string | URL,
  manager: LoadingManager | undefined,
  begin: () => Promise<Data>,
): Promise<Data> {
  if (!manager) return begin();
  const name = String(address);
  const failed = (error: unknown): never => {
    manager.itemError(name);
    manager.itemEnd(name);
    throw error;
  };
  manager.itemStart(name);
  const data = await begin().catch(failed);
  return { ...data, complete: data.complete.then(() => manager.itemEnd(name), failed) };
}

/** The same options for loading once more: who could end the load, or watched it, did so of the first. */
export function again(options: LoadOptions): LoadOptions {
  const requests = new Requests({ ...options, signal: undefined, received: undefined });
  return { ...options, requests, shared: undefined };
}

/** The same, but who asks for it while it goes on gets what goes on. */
export function oneAtATime(act: () => Promise<void>): () => Promise<void> {
  let running: Promise<void> | null = null;
  return () => (running ??= act().finally(() => (running = null)));
}

/** Let an object know where it is from. */
export function known(object: RadTexObject, url: URL, { restore = true }: LoadOptions, reload: () => Promise<void>): void {
  object.address = url.href;
  if (restore) object.recoverBy(reload);
}

/** The textures of a bake without lamps. */
export async function alone(textures: Promise<Textures>): Promise<[Textures]> {
  return [await textures];
}

/** The textures of several bakes; what they share is loaded once. */
function loadAll(manifests: readonly Manifest[], url: URL, device: Device, options: LoadOptions): Promise<Textures>[] {
  const shared = new Map<string, Promise<BakeTexture>>();
  const counts = manifests.map((part) => [0, entriesOf(part).length] as [number, number]);
  return manifests.map((part, place) => {
    const progressed = (done: number, all: number): void => {
      counts[place] = [done, all];
      options.progressed?.(...counts.reduce(([have, of], [more, further]) => [have + more, of + further], [0, 0]));
    };
    const textures = loadTextures(part, url, device, { ...options, progressed, shared });
    textures.catch(() => undefined); // `complete` tells it
    return textures;
  });
}

async function loadOne(
  manifest: Manifest,
  url: URL,
  device: Device,
  options: LoadOptions,
  early: MeshFile | null = null,
): Promise<RadTex> {
  const lamps = options.lamps ?? {};
  const load = (asked: LoadOptions): Promise<[Textures, ...Bake[]]> => {
    const loading = Promise.all([
      loadTextures(manifest, url, device, asked),
      ...Object.values(lamps).map((lamp) => loadLamp(addressOf(lamp), manifest, device, asked.requests)),
    ]).then((loaded) => {
      checkCount(manifest, loaded.slice(1) as Bake[], device);
      return loaded;
    });
    loading.catch(() => undefined); // `complete` tells it
    return loading;
  };
  const mesh = fileUrl(manifest.mesh, url);
  const [{ root, images, imagesAgain }, textures] = early
    ? [early, load(options)]
    : await afterMesh(mesh, options.requests, () => load(options));
  const { parts, map } = bakeBelow(root, mesh);
  const flat = map ?? (await flatOf(manifest, url, options.requests));
  const object = new RadTexObject(manifest, parts, flat, Object.keys(lamps), options.nodes);
  const reload = oneAtATime(() => {
    const once = again(options);
    const loading = Promise.all([load(once), imagesAgain(once.requests)]);
    return completed(object, loading.then(([loaded]) => loaded));
  });
  known(object, url, options, reload);
  return { object, manifest, complete: completed(object, images.then(() => textures)), reload };
}

/** An address relative to the page. Throws a Problem where it is none. */
function addressOf(address: string | URL): URL {
  if (URL.canParse(address, document.baseURI)) return new URL(address, document.baseURI);
  throw new Problem(`“${address}” is no address`, "Give that of a NAME.export.json or NAME.glb, relative to the page.");
}

/** The mesh, and what `load` gives; that begins when the mesh has come, which is seen first. */
async function afterMesh<T>(url: URL, requests: Requests | undefined, load: () => T): Promise<[MeshFile, T]> {
  let loading: T | undefined;
  const file = await loadMeshFile(url, requests, () => (loading = load()));
  return [file, loading as T];
}

/** What a .glb says of its bake, and its contents. */
async function manifestOfMesh(url: URL, requests: Requests): Promise<[Manifest, MeshFile]> {
  const file = await loadMeshFile(url, requests);
  const meshes = bakeBelow(file.root, url).parts.map(({ mesh }) => mesh);
  const facts = meshes.map(({ material }) => file.factsOf(material as Material));
  const manifest = checkManifest(facts[0], url);
  const together = meshes.every(({ matrixWorld }) => matrixWorld.equals((meshes[0] as Mesh).matrixWorld));
  if (!together || facts.some((other) => other?.flat !== manifest.flat)) {
    throw new Problem(`${fileName(url)} is of several bakes`, "Load its NAME.export.json by loadRadTexScene.");
  }
  return [manifest, file];
}

/** The flat lightmap's texture, of the file beside the manifest at `base`, as a .glb that embeds it gives it. */
export async function flatOf(manifest: Manifest, base: URL, requests?: Requests): Promise<Texture> {
  const url = fileUrl(manifest.flat, base);
  const bytes = await fetchBytes(url, "high", requests);
  try {
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }), {
      colorSpaceConversion: "none",
      premultiplyAlpha: "none",
    });
    const texture = new Texture(bitmap);
    texture.colorSpace = SRGBColorSpace;
    texture.flipY = false;
    texture.needsUpdate = true;
    return texture;
  } catch {
    throw new Problem(`${fileName(url)} is damaged: it is no picture`, "Copy it once more, or export again.");
  }
}

/** The node that the .glb calls so: GLTFLoader gives names without what three.js cannot have in them. */
function nodeOf(root: Object3D, name: string, url: URL): Object3D {
  let found: Object3D | undefined;
  root.traverse((each) => {
    if (each.userData["name"] === name) found ??= each;
  });
  if (found) return found;
  throw new Problem(`${fileName(url)} has no node “${name}”`, "Export the scene again.");
}

/** The textures of a lamp's export. Throws a Problem if that is of another surface than `main`. */
async function loadLamp(url: URL, main: Manifest, device: Device, requests?: Requests): Promise<Bake> {
  const manifest = await readManifest(url, requests);
  const { kind, layout, texels } = manifest.bake;
  if (kind !== main.bake.kind || layout !== main.bake.layout || String(texels) !== String(main.bake.texels)) {
    throw new Problem(
      `${manifest.name} is not a lamp of ${main.name}: it is ${sortOf(manifest)}, and not ${sortOf(main)}`,
      "Bake the lamps of one object in one go, with --lights each.",
    );
  }
  if (Boolean(manifest.images) !== Boolean(main.images)) {
    throw new Problem(
      `${manifest.name} is not a lamp of ${main.name}: only one of them has materials by their own images`,
      "Export all of them with the same --image-limit.",
    );
  }
  return { manifest, textures: await loadTextures(manifest, url, device, { requests }), sun: sunUniforms() };
}

/** What lamps have in common, in words. */
function sortOf({ bake: { kind, layout, texels } }: Manifest): string {
  return `of kind ${kind}, ${layout}, ${texels.join(" × ")} texels`;
}

/** Throws a Problem for more lamps than a shader of the device has textures for. */
function checkCount(main: Manifest, lamps: readonly Bake[], device: Device): void {
  const manifests = [main, ...lamps.map(({ manifest }) => manifest)];
  const count = manifests.reduce((sum, { shader, images }) => {
    const replaced = images && !shader?.layers.includes("colour") ? IMAGES : 0;
    return sum + replaced + (shader?.layers.length ?? 1);
  }, 0);
  if (count <= device.mostTextures) return;
  throw new Problem(
    `${main.name} and ${lamps.length} lamps are ${count} textures in one shader; this device takes ${device.mostTextures}`,
    "Load fewer lamps, or export them in the layout buckets.",
    true,
  );
}

/** Give an object its textures when they and its lamps' have come. */
export async function completed(object: RadTexObject, loading: Promise<[Textures, ...Bake[]]>): Promise<void> {
  try {
    const [textures, ...lamps] = await loading;
    object.receive(textures, lamps);
  } catch (error) {
    if (!(error instanceof Problem) || !error.ofDevice) throw error;
    object.refuse(error);
  }
}
