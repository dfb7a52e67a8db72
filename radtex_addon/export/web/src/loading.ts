// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// From an address to a viewer.

import { Mesh, NoColorSpace, type Texture, TextureLoader, WebGLRenderer } from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";

import { fetchBytes, fileUrl } from "./fetching";
import { fileName, readManifest } from "./manifest";
import { Problem } from "./problem";
import { loadTextures } from "./textures";
import { Viewer } from "./viewer";

/** Load the bake that the address or the page itself names, and show it in `stage`. */
export async function load(
  stage: HTMLElement,
  canvas: HTMLCanvasElement,
  tell: (step: string) => void,
): Promise<[Viewer, URL]> {
  const renderer = rendererOn(canvas);
  const url = manifestUrl();
  tell("Reading the manifest");
  const manifest = await readManifest(url);
  tell("Loading the mesh");
  const meshes = await loadMeshes(fileUrl(manifest.mesh, url));
  const flat = await loadFlat(fileUrl(manifest.flat, url));
  tell("Loading textures");
  const textures = await loadTextures(renderer, manifest, url, (done, all) => tell(`Loading textures: ${done} of ${all}`));
  tell("Compiling shaders");
  await new Promise((resolve) => setTimeout(resolve)); // let the words appear
  return [new Viewer(renderer, stage, manifest, meshes, textures, flat), url];
}

/** ?bake=<name>.export.json, or what the export wrote into index.html. */
function manifestUrl(): URL {
  const own = document.querySelector<HTMLMetaElement>('meta[name="radtex-bake"]')?.content;
  const asked = new URLSearchParams(location.search).get("bake") || own;
  if (!asked) {
    throw new Problem(
      "This page does not know which bake to show",
      "Name its manifest in the address: ?bake=Vase.export.json",
    );
  }
  return new URL(asked, location.href);
}

function rendererOn(canvas: HTMLCanvasElement): WebGLRenderer {
  const context = canvas.getContext("webgl2", { alpha: true, antialias: true, powerPreference: "high-performance" });
  if (!context) {
    throw new Problem(
      "This browser has no WebGL 2",
      "Use a browser of the last few years, and see that its settings allow hardware acceleration.",
    );
  }
  if (!context.getExtension("EXT_color_buffer_float")) {
    throw new Problem("This device cannot draw to floating-point textures", "Open the page on another device.");
  }
  const renderer = new WebGLRenderer({ canvas, context });
  renderer.autoClear = false;
  renderer.setClearColor(0, 0);
  renderer.debug.onShaderError = (gl, _program, _vertex, fragment) => {
    const log = gl.getShaderInfoLog(fragment)?.split("\n")[0] ?? "no reason given";
    throw new Problem("This device does not compile the page's shaders", log);
  };
  return renderer;
}

async function loadMeshes(url: URL): Promise<Mesh[]> {
  const bytes = await fetchBytes(url);
  let scene;
  try {
    ({ scene } = await new GLTFLoader().parseAsync(bytes.buffer, ""));
  } catch {
    throw new Problem(`${fileName(url)} is damaged: it cannot be read as glTF`, "Copy it once more, or export again.");
  }
  scene.updateMatrixWorld(true);
  const meshes: Mesh[] = [];
  scene.traverse((each) => {
    if (!(each instanceof Mesh)) return;
    const mesh = each as Mesh;
    const own = Array.isArray(mesh.material) ? mesh.material[0] : mesh.material;
    mesh.userData["radtexMaterial"] = (own?.userData["radtex_material"] as number | undefined) ?? 0;
    meshes.push(mesh);
  });
  const wanted = ["position", "normal", "uv", "tangent"];
  const lacking = wanted.filter((name) => meshes.some((mesh) => !mesh.geometry.hasAttribute(name)));
  if (!meshes.length || lacking.length) {
    throw new Problem(`${fileName(url)} lacks ${lacking.join(" and ") || "a mesh"}`, "Export the object again.");
  }
  return meshes;
}

async function loadFlat(url: URL): Promise<Texture> {
  const bytes = await fetchBytes(url);
  const address = URL.createObjectURL(new Blob([bytes]));
  try {
    const end = new TextDecoder("latin1").decode(bytes.subarray(-8, -4));
    if (end !== "IEND") throw new Error("browsers show a PNG that is cut short without a word");
    const texture = await new TextureLoader().loadAsync(address);
    texture.colorSpace = NoColorSpace; // the shader decodes it
    texture.flipY = true;
    return texture;
  } catch {
    throw new Problem(`${fileName(url)} is damaged: it cannot be read as PNG`, "Copy it once more, or export again.");
  } finally {
    URL.revokeObjectURL(address);
  }
}
