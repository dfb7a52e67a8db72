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
  Texture,
} from "three";
import { MeshoptDecoder } from "three/addons/libs/meshopt_decoder.module.js";
import { type GLTF, GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

import { type Arriving, fetchArriving, fileName } from "./fetching.js";
import type { Manifest } from "./manifest.js";
import { Problem } from "./problem.js";
import type { MaterialImages } from "./parts.js";
import type { BakedMesh } from "./radtex_object.js";
import { Requests } from "./requests.js";

export const EXTENSION = "RADTEX_radiance_texture";
const UNLIT = "KHR_materials_unlit";
const MESHOPT = "EXT_meshopt_compression";
const READ = ["KHR_mesh_quantization", MESHOPT];
const MAGIC = 0x46546c67;
const JSON_CHUNK = 0x4e4f534a;
const BINARY_CHUNK = 0x004e4942;
const HEAD = 20; // bytes before a .glb's JSON
const CHUNK = 8; // and before what is in a further chunk
const PIXEL = // a white one, as a PNG
  "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR42mP4DwABAQEAHLCMmQAAAABJRU5ErkJggg==";

/** One bake of a .glb: its meshes, and the flat lightmap's texture, which lies beside it where materials are images. */
export interface MeshOfBake {
  parts: BakedMesh[];
  map: Texture | null;
}

/** Which texture of a file each of three.js's is of. */
type Associations = GLTF["parser"]["associations"];

/** The part of a .glb's JSON that is read here. */
interface Document {
  buffers: { byteLength: number }[];
  bufferViews: ViewOfFile[];
  extensionsRequired: string[];
  images: { bufferView?: number; mimeType?: string; name?: string; uri?: string }[];
  materials: MaterialOfFile[];
  textures: { source?: number }[];
}

interface ViewOfFile {
  buffer: number;
  byteOffset?: number;
  byteLength: number;
  extensions?: Record<string, ViewOfFile>;
}

interface MaterialOfFile {
  extensions?: Record<string, unknown>;
  pbrMetallicRoughness: { baseColorTexture?: { index: number; extensions?: Record<string, Manifest> } };
}

/** A .glb: its objects, and what our extension says of each material. */
export interface MeshFile {
  root: Object3D;
  factsOf: (material: Material) => Manifest | undefined;
  /** Fulfilled when materials have their own images, which may come after the mesh; before, each is one pixel. */
  images: Promise<void>;
  /** The same, for which the file is fetched once more where its images did not come, as after a broken connection. */
  imagesAgain: (requests?: Requests) => Promise<void>;
}

/**
 * Fetch and read a .glb, of which the images of materials may come later. Throws a Problem where it is missing or damaged,
 * and the signal's reason where the load was ended.
 *
 * `came` is called when the mesh has come, before it is read.
 */
export async function loadMeshFile(
  url: URL,
  requests = new Requests(),
  came: () => void = () => undefined,
): Promise<MeshFile> {
  const file = await fetchArriving(url, "high", requests);
  let gltf: GLTF;
  let late: LateImages | null = null;
  try {
    late = await LateImages.of(file);
    const bytes = late ? await late.meshAlone() : (await file.first(Infinity)).slice();
    came();
    gltf = await new GLTFLoader(ofItself()).setMeshoptDecoder(MeshoptDecoder).parseAsync(bytes.buffer, "");
  } catch (error) {
    const problem = error instanceof Problem ? error : damaged(url, await requiredBy(file));
    file.cancel();
    requests.check(url);
    throw problem;
  } finally {
    late?.revoke();
  }
  const { parser, scene } = gltf;
  const images = late ? shown(late, parser.associations, file, url, requests) : Promise.resolve();
  let latest = images;
  const imagesAgain = (asked = new Requests()): Promise<void> => {
    const once = async (): Promise<void> => {
      const whole = await fetchArriving(url, "low", asked);
      await shown(late as LateImages, parser.associations, whole, url, asked);
    };
    latest = latest.catch(once);
    latest.catch(() => undefined);
    return latest;
  };
  images.catch(() => undefined); // whoever waits for them is told
  scene.updateMatrixWorld(true);
  return { root: scene, factsOf: factsIn(parser), images, imagesAgain };
}

/** Give textures their pictures, which are still coming. Throws as `loadMeshFile`. */
async function shown(late: LateImages, made: Associations, file: Arriving, url: URL, requests: Requests): Promise<void> {
  try {
    await late.into(made, await file.first(Infinity));
  } catch (error) {
    file.cancel();
    requests.check(url);
    throw error instanceof Problem ? error : damaged(url, []);
  }
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

/** Why a file that came could not be read; `required` are the extensions that it says it needs. */
function damaged(url: URL, required: readonly string[]): Problem {
  const other = required.filter((name) => !READ.includes(name));
  if (!other.length) {
    return new Problem(`${fileName(url)} is damaged: it cannot be read as glTF`, "Copy it once more, or export again.");
  }
  return new Problem(
    `${fileName(url)} needs ${other.join(" and ")}, which is not read here`,
    `Store the mesh without it: ${READ.join(" and ")} are read, which an export for the web has.`,
  );
}

async function requiredBy(file: Arriving): Promise<string[]> {
  try {
    const { document } = await headOf(file);
    return document.extensionsRequired ?? [];
  } catch {
    return [];
  }
}

/** The JSON of a .glb, and where its binary chunk begins. Throws for a file that is none. */
async function headOf(file: Arriving): Promise<{ document: Partial<Document>; begin: number }> {
  const head = await file.first(HEAD);
  const numbers = new DataView(head.buffer, head.byteOffset, head.byteLength);
  if (numbers.getUint32(0, true) !== MAGIC) throw new Error("it is no .glb");
  const length = numbers.getUint32(12, true);
  const text = (await file.first(HEAD + length)).subarray(HEAD);
  if (text.length !== length) throw new Error("it is cut short");
  return { document: JSON.parse(new TextDecoder().decode(text)) as Partial<Document>, begin: HEAD + length + CHUNK };
}

/** The images at the end of a .glb that are not needed to draw its mesh with the flat lightmap. */
class LateImages {
  private readonly pixels: string[] = []; // addresses, which `revoke` ends

  private constructor(
    private readonly file: Arriving,
    private readonly document: Document,
    private readonly begin: number,
    private readonly end: number,
    private readonly late: ReadonlySet<number>,
  ) {}

  /** Those of a file that is coming; null if there are none. Throws for a file that is damaged. */
  static async of(file: Arriving): Promise<LateImages | null> {
    const { document: found, begin } = await headOf(file);
    const { bufferViews: views = [], images = [], materials = [], textures = [] } = found;
    const flat = materials.flatMap(({ extensions, pbrMetallicRoughness }) => {
      const index = extensions?.[UNLIT] ? pbrMetallicRoughness?.baseColorTexture?.index : undefined;
      return index === undefined ? [] : [textures[index]?.source];
    });
    const late = new Set(images.flatMap((image, at) => (image.bufferView === undefined || flat.includes(at) ? [] : [at])));
    const behind = new Set([...late].map((at) => images[at]?.bufferView));
    const ends = views.flatMap((view, at) => {
      const { buffer, byteOffset = 0, byteLength } = view.extensions?.[MESHOPT] ?? view;
      return behind.has(at) || buffer ? [] : [byteOffset + byteLength];
    });
    const document = { ...found, bufferViews: views, images, textures } as Document;
    return late.size ? new LateImages(file, document, begin, Math.max(0, ...ends), late) : null;
  }

  /** The .glb with a pixel in the place of each of them. */
  async meshAlone(): Promise<Uint8Array<ArrayBuffer>> {
    const { begin, document, end, file, late } = this;
    const binary = (await file.first(begin + end)).subarray(begin);
    if (binary.length !== end) throw new Error("it is cut short");
    const images = document.images.map((image, at) => (late.has(at) ? { name: image.name, uri: this.pixel() } : image));
    const [, ...others] = document.buffers;
    const json = { ...document, images, buffers: [{ byteLength: end }, ...others] };
    const text = new TextEncoder().encode(JSON.stringify(json));
    const [jsonLength, binaryLength] = [text, binary].map(({ length }) => Math.ceil(length / 4) * 4) as [number, number];
    const bytes = new Uint8Array(HEAD + jsonLength + CHUNK + binaryLength);
    const words = new DataView(bytes.buffer);
    [MAGIC, 2, bytes.length, jsonLength, JSON_CHUNK].forEach((word, at) => words.setUint32(4 * at, word, true));
    bytes.fill(0x20, HEAD, HEAD + jsonLength);
    bytes.set(text, HEAD);
    words.setUint32(HEAD + jsonLength, binaryLength, true);
    words.setUint32(HEAD + jsonLength + 4, BINARY_CHUNK, true);
    bytes.set(binary, HEAD + jsonLength + CHUNK);
    return bytes;
  }

  /** A pixel at an address of its own: GLTFLoader makes one texture of all images that have the same. */
  private pixel(): string {
    const bytes = Uint8Array.from(atob(PIXEL), (letter) => letter.charCodeAt(0));
    const address = URL.createObjectURL(new Blob([bytes], { type: "image/png" }));
    this.pixels.push(address);
    return address;
  }

  /** Free the pixels, when the mesh has been read. */
  revoke(): void {
    for (const address of this.pixels) URL.revokeObjectURL(address);
  }

  /** Give textures that a GLTFLoader made of `meshAlone` their pictures of the whole file. */
  async into(made: Associations, bytes: Uint8Array<ArrayBuffer>): Promise<void> {
    const pictures = new Map<number, ImageBitmap>();
    for (const at of this.late) {
      const { bufferView, mimeType = "" } = this.document.images[at] as Document["images"][number];
      const { byteOffset = 0, byteLength } = this.document.bufferViews[bufferView as number] as ViewOfFile;
      const data = bytes.subarray(this.begin + byteOffset, this.begin + byteOffset + byteLength);
      const untouched = { colorSpaceConversion: "none", premultiplyAlpha: "none" } as const;
      pictures.set(at, await createImageBitmap(new Blob([data], { type: mimeType }), untouched));
    }
    const concerned = [...made].flatMap(([texture, { textures: number }]) => {
      const picture = number === undefined ? undefined : pictures.get(this.document.textures[number]?.source as number);
      return picture && texture instanceof Texture ? [[texture, picture] as const] : [];
    });
    for (const [texture] of concerned) texture.dispose(); // where the pixel was drawn, it has storage of its size alone
    for (const [texture, picture] of concerned) {
      texture.image = picture;
      texture.needsUpdate = true;
    }
  }
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
  if (!(material instanceof MeshStandardMaterial)) return null;
  if (!geometry.hasAttribute("uv_images")) { // else the mesh, or another with its geometry, was here before
    if (!geometry.hasAttribute("uv1")) return null;
    geometry.setAttribute("uv_images", geometry.getAttribute("uv"));
    geometry.setAttribute("uv", geometry.getAttribute("uv1"));
    geometry.deleteAttribute("uv1");
  }
  return { base: material.map, metal: material.metalnessMap, bump: material.normalMap };
}
