// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// For Babylon.js's glTF loader: the bakes of a .glb as radiance, in the place of their flat lightmaps.

import type { Engine } from "@babylonjs/core/Engines/engine.js";
import type { Material } from "@babylonjs/core/Materials/material.js";
import type { BaseTexture } from "@babylonjs/core/Materials/Textures/baseTexture.js";
import type { AbstractMesh } from "@babylonjs/core/Meshes/abstractMesh.js";
import { Logger } from "@babylonjs/core/Misc/logger.js";
import { WebRequest } from "@babylonjs/core/Misc/webRequest.js";
import type { Scene } from "@babylonjs/core/scene.js";
import type { IGLTFLoaderExtension } from "@babylonjs/loaders/glTF/2.0/glTFLoaderExtension.js";
import { registerGLTFExtension, unregisterGLTFExtension } from "@babylonjs/loaders/glTF/2.0/glTFLoaderExtensionRegistry.js";
import type { GLTFLoader } from "@babylonjs/loaders/glTF/2.0/glTFLoader.js";
import type { IMaterial } from "@babylonjs/loaders/glTF/2.0/glTFLoaderInterfaces.js";

import { deviceOf } from "../../three/src/device.js";
import { KINDS } from "../../three/src/kinds.js";
import { checkManifest, type Manifest } from "../../three/src/manifest.js";
import { Problem } from "../../three/src/problem.js";
import { Requests } from "../../three/src/requests.js";
import { RadTexMaterial } from "./material.js";
import { loadTexture } from "./textures.js";

const NAME = "RADTEX_radiance_texture";
const BEFORE = 100; // extensions that make a material, such as KHR_materials_unlit
const ELSEWHERE = "Show it by three.js with radtex-three, or by RadTex’s web page.";

/** A material of a bake, as the file has it, and as Babylon.js made it with the flat lightmap. */
interface FoundMaterial {
  facts: Manifest & { material?: number };
  number: number;
  opaque: boolean;
  flat: Material;
}

type Textures = ReadonlyMap<string, BaseTexture>;

/** What shows a bake's light, and what showed its flat lightmap. */
interface ShownMaterial {
  material: RadTexMaterial;
  flat: Material;
}

/** Shows bakes of the files that are loaded from now on. `failed` is told of those that cannot be shown, as the console is. */
export function registerRadTex(failed?: (problem: Problem) => void): void {
  unregisterGLTFExtension(NAME);
  registerGLTFExtension(NAME, true, (loader) => new RadTexExtension(loader, failed));
}

/**
 * Babylon.js makes one for each file. A bake that cannot be shown keeps its flat lightmap, which is what every viewer of
 * glTF shows; the console says why, and what to do.
 */
class RadTexExtension implements IGLTFLoaderExtension {
  readonly name = NAME;
  readonly order = BEFORE;
  enabled: boolean;
  private found: FoundMaterial[] = [];
  private meshes: AbstractMesh[] = [];
  private loader: GLTFLoader | null;

  constructor(
    loader: GLTFLoader,
    private readonly failed?: (problem: Problem) => void,
  ) {
    this.loader = loader;
    this.enabled = loader.isExtensionUsed(NAME);
    if (this.enabled) loader.parent.onMeshLoadedObservable.add((mesh) => this.meshes.push(mesh));
  }

  dispose(): void {
    this.loader = null;
    this.found = [];
    this.meshes = [];
  }

  /** Takes note of a bake's material, which others make. */
  loadMaterialPropertiesAsync(_context: string, material: IMaterial, made: Material): null {
    const facts = material.pbrMetallicRoughness?.baseColorTexture?.extensions?.[NAME] as FoundMaterial["facts"] | undefined;
    const { radtex_material: number = facts?.material ?? 0, radtex_opaque: opaque = false } = material.extras ?? {};
    if (facts) this.found.push({ facts, number, opaque, flat: made });
    return null;
  }

  /** All meshes have their places: show the bakes. */
  async onReady(): Promise<void> {
    const { loader } = this;
    if (!loader) return;
    const base = new URL(loader.rootUrl || ".", document.baseURI);
    const bakes = new Map<string, FoundMaterial[]>();
    for (const each of this.found) {
      const flat = String(each.facts.flat);
      bakes.set(flat, [...(bakes.get(flat) ?? []), each]);
    }
    const loaded = new Map<string, Promise<BaseTexture>>(); // what several bakes share is loaded once
    await Promise.all(
      [...bakes.values()].map(async (materials) => {
        try {
          await this.show(loader, materials, base, loaded);
        } catch (error) {
          if (!(error instanceof Problem)) throw error;
          this.failed?.(error);
          Logger.Error(`RadTex: ${error.message}. ${error.remedy}`);
        }
      }),
    );
    loaded.clear(); // what is asked for later is loaded again
  }

  /** Show a bake. Throws a Problem where that is not possible, and changes nothing then. */
  private async show(
    loader: GLTFLoader,
    materials: readonly FoundMaterial[],
    base: URL,
    loaded: Map<string, Promise<BaseTexture>>,
  ): Promise<void> {
    const { facts } = materials[0] as FoundMaterial;
    const file = new URL(encodeURIComponent(String(facts.mesh)), base);
    const manifest = checkManifest(facts, file);
    const scene = loader.babylonScene;
    const engine = scene.getEngine() as Engine;
    checkEngine(manifest, engine);
    checkBake(manifest, materials);
    const load = async (): Promise<Map<string, BaseTexture>> => {
      const device = deviceOf(engine._gl);
      const requests = new Requests({ requestHeader: WebRequest.CustomRequestHeaders });
      const wanted = manifest.bake.layout === "layered" ? manifest.shader?.layers : [manifest.bake.kind];
      const textures = (wanted ?? []).map(async (name): Promise<[string, BaseTexture]> => {
        const entry = manifest.textures[name];
        if (!entry) throw new Problem(`${manifest.mesh} names no texture “${name}”`, "Export the object again.");
        const texture = loaded.get(entry.file) ?? loadTexture(entry, base, scene, device, requests);
        loaded.set(entry.file, texture);
        return [name, await texture];
      });
      return new Map(await Promise.all(textures));
    };
    const textures = await load();
    const shown = materials.flatMap((material) => this.place(loader, manifest, material, textures));
    const again = async (): Promise<Map<string, BaseTexture>> => {
      setTimeout(() => loaded.clear()); // when all bakes of this file have asked
      return load();
    };
    recover(scene, shown, textures, again);
  }

  /** Give a material's meshes the bake's light; what they have now, and had. */
  private place(loader: GLTFLoader, manifest: Manifest, found: FoundMaterial, textures: Textures): ShownMaterial[] {
    const scene = loader.babylonScene;
    const root = loader.rootBabylonMesh?.computeWorldMatrix(true).clone().invert();
    const made: [baked: ReturnType<AbstractMesh["getWorldMatrix"]>, material: RadTexMaterial][] = [];
    for (const mesh of this.meshes.filter((each) => !each.isAnInstance && each.material === found.flat)) {
      const world = mesh.computeWorldMatrix(true);
      const baked = root ? world.multiply(root) : world.clone(); // as in the file: without what turns it for a left-handed scene
      let material = made.find(([other]) => other.equalsWithEpsilon(baked, 1e-6))?.[1];
      if (!material) {
        material = RadTexMaterial.of(found.flat.name, scene, manifest, found.number, baked);
        material.read(textures);
        made.push([baked, material]);
        loader.parent.onMaterialLoadedObservable.notifyObservers(material);
        if (!scene.meshes.includes(mesh)) scene.removeMaterial(material); // it is of an AssetContainer
      }
      mesh.material = material;
    }
    for (const texture of textures.values()) loader.parent.onTextureLoadedObservable.notifyObservers(texture);
    return made.map(([, material]) => ({ material, flat: found.flat }));
  }
}

/** Show the flat lightmap when the graphics device is taken away, and the light when the textures were loaded `again`. */
function recover(scene: Scene, shown: readonly ShownMaterial[], textures: Textures, again: () => Promise<Textures>): void {
  const engine = scene.getEngine();
  let waiting: [mesh: AbstractMesh, material: RadTexMaterial][] = [];
  const lost = engine.onContextLostObservable.add(() => {
    const flats = new Map<unknown, Material>(shown.flatMap(({ material, flat }) => [...material.clones].map((each) => [each, flat])));
    for (const mesh of scene.meshes.filter(({ isAnInstance, material }) => !isAnInstance && flats.has(material))) {
      waiting.push([mesh, mesh.material as RadTexMaterial]);
      mesh.material = flats.get(mesh.material) ?? null;
    }
  });
  const restored = engine.onContextRestoredObservable.add(() => {
    again().then(
      (loaded) => {
        for (const texture of textures.values()) texture.dispose();
        textures = loaded;
        for (const { material } of shown) for (const each of material.clones) each.read(textures);
        for (const [mesh, material] of waiting) mesh.material = material;
        waiting = [];
      },
      (error: unknown) => Logger.Error(`RadTex: ${error instanceof Error ? error.message : String(error)}. Reload the page.`),
    );
  });
  scene.onDisposeObservable.addOnce(() => {
    engine.onContextLostObservable.remove(lost);
    engine.onContextRestoredObservable.remove(restored);
  });
}

/** Throws a Problem for a renderer that takes no GLSL of WebGL 2. */
function checkEngine({ mesh }: Manifest, engine: Engine): void {
  if (!engine.isWebGPU && engine.version >= 2 && engine._gl) return;
  const which = engine.isWebGPU ? "WebGPUEngine" : "this engine";
  throw new Problem(
    `${mesh} is shown by its flat lightmap: ${which} does not take RadTex’s shaders, which are GLSL for WebGL 2`,
    "Draw it by Babylon.js’s Engine.",
    true,
  );
}

/** Throws a Problem for a bake that is not drawn here. */
function checkBake({ bake, mesh, shader, textures }: Manifest, materials: readonly FoundMaterial[]): void {
  const refuse = (reason: string, remedy: string): never => {
    throw new Problem(`${mesh} is shown by its flat lightmap: ${reason}`, remedy);
  };
  if (KINDS[bake.kind].way === "L" || bake.kind === "proxy") {
    refuse(`bakes of kind ${bake.kind} are not drawn in Babylon.js`, ELSEWHERE);
  }
  if (bake.layout === "layered") {
    if (shader?.materials.some((each) => "radtex_images" in each)) {
      refuse("its materials are images, which are not drawn in Babylon.js", "Export it again with --image-limit 0.");
    }
    if (textures["alpha"] && !materials.every(({ opaque }) => opaque)) {
      refuse("parts of it are clear, which are not drawn in Babylon.js", ELSEWHERE);
    }
    return;
  }
  const entry = textures[bake.kind];
  if (!entry) throw new Problem(`${mesh} names no texture “${bake.kind}”`, "Export the object again.");
  if (entry.layers > 1 || entry.arrangement !== "matrix") {
    refuse("its texture is an array, which is not drawn in Babylon.js", "Export it again with --arrangement matrix, and without --limit.");
  }
  if (entry.format === "RGBA16F" && bake.kind !== "ao") refuse("parts of it are clear, which are not drawn in Babylon.js", ELSEWHERE);
}
