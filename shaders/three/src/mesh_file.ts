// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The exported .glb: its meshes, their materials' numbers, and the flat lightmap.

import { Mesh, type MeshBasicMaterial, type Object3D, type Texture } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

import { fetchBytes } from "./fetching.js";
import { fileName, type Manifest } from "./manifest.js";
import { Problem } from "./problem.js";
import type { BakedMesh } from "./radtex_object.js";

export const EXTENSION = "RADTEX_radiance_texture";

/** One bake of a .glb: its meshes, the flat lightmap's texture, and what our extension says. */
export interface MeshOfBake {
  parts: BakedMesh[];
  map: Texture;
  facts: Manifest | undefined;
}

/** Fetch and read a .glb. Throws a Problem where it is missing, damaged, or lacks what lookups need. */
export async function loadMeshFile(url: URL): Promise<Object3D> {
  const bytes = await fetchBytes(url, "high");
  let scene;
  try {
    ({ scene } = await new GLTFLoader().parseAsync(bytes.buffer, ""));
  } catch {
    throw new Problem(`${fileName(url)} is damaged: it cannot be read as glTF`, "Copy it once more, or export again.");
  }
  scene.updateMatrixWorld(true);
  return scene;
}

/** The bake below an object of a .glb that was loaded from `url`. Throws a Problem where it lacks what lookups need. */
export function bakeBelow(root: Object3D, url: URL): MeshOfBake {
  const parts: BakedMesh[] = [];
  let map: Texture | null = null;
  let facts: Manifest | undefined;
  root.traverse((each) => {
    if (!(each instanceof Mesh)) return;
    const mesh = each as Mesh<Mesh["geometry"], MeshBasicMaterial>;
    const { userData } = mesh.material;
    facts ??= (userData["gltfExtensions"] as Record<string, Manifest> | undefined)?.[EXTENSION];
    map ??= mesh.material.map;
    parts.push({ mesh, number: (userData["radtex_material"] as number | undefined) ?? 0 });
  });
  const wanted = ["position", "normal", "uv", "tangent"];
  const lacking = wanted.filter((name) => parts.some(({ mesh }) => !mesh.geometry.hasAttribute(name)));
  if (parts.length && !map) lacking.push("its flat lightmap");
  if (!parts.length || lacking.length || !map) {
    throw new Problem(`${fileName(url)} lacks ${lacking.join(" and ") || "a mesh"}`, "Export the object again.");
  }
  return { parts, map, facts };
}
