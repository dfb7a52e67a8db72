// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The exported .glb: its meshes, their materials' numbers, and the flat lightmap.

import {
  LoadingManager,
  type Material,
  Mesh,
  type MeshBasicMaterial,
  MeshStandardMaterial,
  type Object3D,
  type Texture,
} from "three";
import { type GLTF, GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

import { fetchBytes, fileName } from "./fetching.js";
import type { Manifest } from "./manifest.js";
import { Problem } from "./problem.js";
import type { MaterialImages } from "./parts.js";
import type { BakedMesh } from "./radtex_object.js";
import type { Requests } from "./requests.js";

export const EXTENSION = "RADTEX_radiance_texture";

/** One bake of a .glb: its meshes, and the flat lightmap's texture, which lies beside it where materials are images. */
export interface MeshOfBake {
  parts: BakedMesh[];
  map: Texture | null;
}

/** The part of a .glb's JSON that is read here. */
interface Document {
  materials: MaterialOfFile[];
}

interface MaterialOfFile {
  pbrMetallicRoughness: { baseColorTexture?: { extensions?: Record<string, Manifest> } };
}

/** A .glb: its objects, and what our extension says of each material. */
export interface MeshFile {
  root: Object3D;
  factsOf: (material: Material) => Manifest | undefined;
}

/** Fetch and read a .glb. Throws a Problem where it is missing or damaged. */
export async function loadMeshFile(url: URL, requests?: Requests): Promise<MeshFile> {
  const bytes = await fetchBytes(url, "high", requests);
  let gltf: GLTF;
  try {
    gltf = await new GLTFLoader(ofItself()).parseAsync(bytes.buffer, "");
  } catch {
    throw new Problem(`${fileName(url)} is damaged: it cannot be read as glTF`, "Copy it once more, or export again.");
  }
  const { parser, scene } = gltf;
  scene.updateMatrixWorld(true);
  return { root: scene, factsOf: factsIn(parser) };
}

/** What our extension says of a material that a parser of GLTFLoader's made; nobody has checked it. */
export function factsIn(parser: GLTF["parser"]): (material: Material) => Manifest | undefined {
  const materials: Partial<MaterialOfFile>[] = (parser.json as Partial<Document>).materials ?? [];
  return (material) => {
    const number = parser.associations.get(material)?.materials;
    const found = number === undefined ? undefined : materials[number];
    return found?.pbrMetallicRoughness?.baseColorTexture?.extensions?.[EXTENSION];
  };
}

/** Lets a .glb have what is inside it alone, as RadTex writes it: a stranger's may name any server. */
function ofItself(): LoadingManager {
  return new LoadingManager().setURLModifier((url) => {
    if (/^(blob|data):/.test(url)) return url;
    throw new Error(`it names another file, ${url}`);
  });
}

/** A bake below an object of a .glb that was loaded from `url`. Throws a Problem where it lacks what lookups need. */
export function bakeBelow(root: Object3D, url: URL): MeshOfBake {
  const meshes: Mesh[] = [];
  root.traverse((each) => {
    if (each instanceof Mesh) meshes.push(each);
  });
  return bakeOf(meshes, url);
}

/** The bake of these meshes. Throws a Problem as `bakeBelow` does. */
export function bakeOf(meshes: readonly Mesh[], url: URL): MeshOfBake {
  const parts: BakedMesh[] = [];
  let map: Texture | null = null;
  for (const each of meshes) {
    const mesh = each as Mesh<Mesh["geometry"], MeshBasicMaterial>;
    const number = (mesh.material.userData["radtex_material"] as number | undefined) ?? 0;
    const images = imagesOf(each);
    if (!images) map ??= mesh.material.map;
    const opaque = mesh.material.userData["radtex_opaque"] === true;
    parts.push(images ? { mesh, number, images, opaque } : { mesh, number, opaque });
  }
  const wanted = ["position", "normal", "uv", "tangent"];
  const lacking = wanted.filter((name) => parts.some(({ mesh }) => !mesh.geometry.hasAttribute(name)));
  if (parts.some(({ images }) => !images) && !map) lacking.push("its flat lightmap");
  if (!parts.length || lacking.length) {
    throw new Problem(`${fileName(url)} lacks ${lacking.join(" and ") || "a mesh"}`, "Export the object again.");
  }
  return { parts, map };
}

/**
 * The images that show a mesh's material; null if it is shown by the bake's maps. Their coordinates, the mesh's first,
 * become its attribute `uv_images`, and the bake's, its second, become `uv`.
 */
function imagesOf(mesh: Mesh): MaterialImages | null {
  const { geometry, material } = mesh;
  if (!(material instanceof MeshStandardMaterial) || !geometry.hasAttribute("uv1")) return null;
  if (!geometry.hasAttribute("uv_images")) {
    geometry.setAttribute("uv_images", geometry.getAttribute("uv"));
    geometry.setAttribute("uv", geometry.getAttribute("uv1"));
    geometry.deleteAttribute("uv1");
  }
  return { base: material.map, metal: material.metalnessMap, bump: material.normalMap };
}
