// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// For gltf-transform: a .glb keeps its bakes, and what their lookups need, through its commands and functions.

import {
  type Accessor,
  Extension,
  ExtensionProperty,
  type Graph,
  type IProperty,
  type Material,
  type Nullable,
  type Property,
  PropertyType,
  type ReaderContext,
  type Texture,
  TextureChannel,
  TextureInfo,
  type vec4,
  type WriterContext,
} from "@gltf-transform/core";

const EXTENSION = "RADTEX_radiance_texture";
const UNLIT = "KHR_materials_unlit";
const DRACO = "KHR_draco_mesh_compression";
const BYTE = 5120; // glTF's componentType of whole numbers of 8 bits
const FLOAT = 5126;

const { R, G, B } = TextureChannel;
const COLOUR = { channels: R | G | B, isColor: true };
const NORMAL = { channels: R | G | B };
const METAL = { channels: G | B };

const AGAIN =
  "begin with RadTex's export, register RadTexRadianceTexture for each step, and install gltf-transform beside radtex-three";
const SCALED =
  "is in whole numbers, which scale its node, and so its normal map: leave positions as they are, as by --compress false";

type MaterialDef = NonNullable<WriterContext["jsonDoc"]["json"]["materials"]>[number];

/** What the extension says of a material: docs/gltf/RADTEX_radiance_texture. */
export type Facts = Record<string, unknown>;

interface IRadianceTexture extends IProperty {
  facts: Facts;
  unlit: boolean;
  unlitProperty: ExtensionProperty;
  baseColorFactor: vec4;
  metallicFactor: number;
  roughnessFactor: number;
  baseColorTexture: Texture;
  baseColorTextureInfo: TextureInfo;
  metallicRoughnessTexture: Texture;
  metallicRoughnessTextureInfo: TextureInfo;
  normalTexture: Texture;
  normalTextureInfo: TextureInfo;
  frameNormalTexture: Texture;
  frameNormalTextureInfo: TextureInfo;
}

/**
 * A material's bake. In a file it lies on the base colour's texture info; here it lies on the material.
 *
 * `prune()` looks for what a material uses in the material and its extensions alone. It removes NORMAL where a material is
 * unlit, TANGENT where nothing is a normal texture, UV maps that no texture has, and textures of one colour. So this holds
 * the material's textures, and one of them once more as the normal texture of the bake's UV map; and it takes
 * KHR_materials_unlit away from the material. All is put back when the file is written.
 */
export class RadianceTexture extends ExtensionProperty<IRadianceTexture> {
  public static override readonly EXTENSION_NAME = EXTENSION;
  declare public readonly extensionName: typeof EXTENSION;
  declare public readonly propertyType: "RadianceTexture";
  declare public readonly parentTypes: [PropertyType.MATERIAL];

  protected init(): void {
    const fixed = { extensionName: EXTENSION, propertyType: "RadianceTexture", parentTypes: [PropertyType.MATERIAL] };
    Object.assign(this, fixed);
  }

  protected override getDefaults(): Nullable<IRadianceTexture> {
    const info = (name: string): TextureInfo => new TextureInfo(this.graph, name);
    return {
      ...(super.getDefaults() as IProperty),
      facts: {},
      unlit: false,
      unlitProperty: null,
      baseColorFactor: [1, 1, 1, 1],
      metallicFactor: 1,
      roughnessFactor: 1,
      baseColorTexture: null,
      baseColorTextureInfo: info("baseColorTextureInfo"),
      metallicRoughnessTexture: null,
      metallicRoughnessTextureInfo: info("metallicRoughnessTextureInfo"),
      normalTexture: null,
      normalTextureInfo: info("normalTextureInfo"),
      frameNormalTexture: null,
      frameNormalTextureInfo: info("frameNormalTextureInfo"),
    };
  }

  /** The extension's JSON. Its textures lie beside the file, and are none of the document's. */
  public getFacts(): Facts {
    return this.get("facts");
  }

  public setFacts(facts: Facts): this {
    return this.set("facts", facts);
  }

  /** Whether the file's material has KHR_materials_unlit. */
  public getUnlit(): boolean {
    return this.get("unlit");
  }

  public setUnlit(unlit: boolean): this {
    return this.set("unlit", unlit);
  }

  /** The n of the bake's TEXCOORD_n. */
  public getTexCoord(): number {
    return this.getFacts()["images"] === true ? 1 : 0;
  }

  /** Whether the bake is looked up with a normal map, which its node must not scale. */
  public hasNormalMap(): boolean {
    return this.getRef("normalTexture") !== null;
  }

  /** Hold the textures that a material has now, and take KHR_materials_unlit away; `facts` and `unlit` are set before. */
  public hold(material: Material): this {
    this.setRef("unlitProperty", material.getExtension(UNLIT));
    material.setExtension(UNLIT, null);
    const base = material.getBaseColorTexture();
    this.set("baseColorFactor", material.getBaseColorFactor());
    this.set("metallicFactor", material.getMetallicFactor());
    this.set("roughnessFactor", material.getRoughnessFactor());
    this.setRef("baseColorTexture", base, COLOUR);
    copyInfo(this.getRef("baseColorTextureInfo"), material.getBaseColorTextureInfo());
    this.setRef("metallicRoughnessTexture", material.getMetallicRoughnessTexture(), METAL);
    copyInfo(this.getRef("metallicRoughnessTextureInfo"), material.getMetallicRoughnessTextureInfo());
    this.setRef("normalTexture", material.getNormalTexture(), NORMAL);
    copyInfo(this.getRef("normalTextureInfo"), material.getNormalTextureInfo());
    this.setRef("frameNormalTexture", base, NORMAL);
    this.getRef("frameNormalTextureInfo")?.setTexCoord(this.getTexCoord());
    return this;
  }

  /** Give the material back what `hold` took away from it. */
  public release(material: Material): void {
    const unlit = this.getRef("unlitProperty");
    if (unlit) material.setExtension(UNLIT, unlit);
  }

  /** Give the material's JSON what was taken from it, or what `prune()` has removed since. */
  public restore(material: Material, definition: MaterialDef, context: WriterContext): void {
    const shading = (definition.pbrMetallicRoughness ??= {});
    if (!material.getBaseColorTexture()) {
      const held = this.heldDef("baseColorTexture", context);
      if (held) Object.assign(shading, { baseColorTexture: held, baseColorFactor: this.get("baseColorFactor") });
    }
    if (!material.getMetallicRoughnessTexture()) {
      const held = this.heldDef("metallicRoughnessTexture", context);
      const factors = { metallicFactor: this.get("metallicFactor"), roughnessFactor: this.get("roughnessFactor") };
      if (held) Object.assign(shading, { metallicRoughnessTexture: held, ...factors });
    }
    if (!material.getNormalTexture()) {
      const held = this.heldDef("normalTexture", context);
      if (held) definition.normalTexture = { ...held, scale: material.getNormalScale() };
    }
    if (this.getUnlit()) definition.extensions = { ...definition.extensions, [UNLIT]: {} };
  }

  private heldDef(
    slot: "baseColorTexture" | "metallicRoughnessTexture" | "normalTexture",
    context: WriterContext,
  ): ReturnType<WriterContext["createTextureInfoDef"]> | null {
    const texture = this.getRef(slot);
    const info = this.getRef(`${slot}Info`);
    return texture && info && context.createTextureInfoDef(texture, info);
  }
}

function copyInfo(into: TextureInfo | null, from: TextureInfo | null): void {
  if (into && from) into.copy(from);
}

/**
 * RadTex's extension: `io.registerExtensions([...ALL_EXTENSIONS, RadTexRadianceTexture])`.
 *
 * Writing throws an Error, which says what to do, where a bake could not be looked up any more.
 */
export class RadTexRadianceTexture extends Extension {
  public static override readonly EXTENSION_NAME = EXTENSION;
  public override readonly extensionName = EXTENSION;

  /** A bake, to be set as an extension of a material. */
  public createRadianceTexture(): RadianceTexture {
    return new RadianceTexture(this.document.getGraph() as Graph<Property>);
  }

  /** Remove the extension from the document; materials are as they would be without it. */
  public override dispose(): void {
    for (const material of this.document.getRoot().listMaterials()) {
      material.getExtension<RadianceTexture>(EXTENSION)?.release(material);
    }
    super.dispose();
  }

  public override read(context: ReaderContext): this {
    for (const [place, definition] of (context.jsonDoc.json.materials ?? []).entries()) {
      const facts = definition.pbrMetallicRoughness?.baseColorTexture?.extensions?.[EXTENSION];
      const material = context.materials[place];
      if (!facts || !material) continue;
      const bake = this.createRadianceTexture();
      bake.setFacts(structuredClone(facts) as Facts);
      bake.setUnlit(definition.extensions?.[UNLIT] !== undefined);
      material.setExtension(EXTENSION, bake.hold(material));
    }
    return this;
  }

  public override write(context: WriterContext): this {
    const { json } = context.jsonDoc;
    const bakes = new Map<Material, RadianceTexture>();
    for (const material of this.document.getRoot().listMaterials()) {
      const bake = material.getExtension<RadianceTexture>(EXTENSION);
      const definition = json.materials?.[context.materialIndexMap.get(material) ?? -1];
      if (!bake || !definition) continue;
      bakes.set(material, bake);
      bake.restore(material, definition, context);
      const base = definition.pbrMetallicRoughness?.baseColorTexture;
      if (!base) throw new Error(`The material ${material.getName()} has lost its flat lightmap: ${AGAIN}.`);
      base.extensions = { ...base.extensions, [EXTENSION]: bake.getFacts() };
    }
    if ([...bakes.values()].some((bake) => bake.getUnlit())) {
      json.extensionsUsed = [...new Set([...(json.extensionsUsed ?? []), UNLIT])].sort();
    }
    if (bakes.size) this.check(bakes, context);
    return this;
  }

  /** Throw where a reader could not look bakes up in what is written; warn where they would be coarse. */
  private check(bakes: ReadonlyMap<Material, RadianceTexture>, context: WriterContext): void {
    const { json } = context.jsonDoc;
    if (json.extensionsUsed?.includes(DRACO)) {
      throw new Error("RadTex's loaders do not read Draco's compression: take meshopt in its place.");
    }
    const coarse = new Set<string>();
    for (const mesh of this.document.getRoot().listMeshes()) {
      const name = `the mesh ${mesh.getName() || "without a name"}`;
      for (const primitive of mesh.listPrimitives()) {
        const bake = bakes.get(primitive.getMaterial() as Material);
        if (!bake) continue;
        const maps = bake.getTexCoord() === 0 ? ["TEXCOORD_0"] : ["TEXCOORD_0", "TEXCOORD_1"];
        const wanted = ["POSITION", "NORMAL", "TANGENT", ...maps];
        const lacking = wanted.filter((each) => !primitive.getAttribute(each));
        if (lacking.length) {
          throw new Error(`${lacking.join(" and ")} of ${name} is lost, by which its bake is looked up: ${AGAIN}.`);
        }
        const [place, ...frame] = wanted.slice(0, 3).map((each) => {
          const accessor = primitive.getAttribute(each) as Accessor;
          return json.accessors?.[context.accessorIndexMap.get(accessor) ?? -1]?.componentType;
        });
        if (bake.hasNormalMap() && place !== FLOAT) throw new Error(`POSITION of ${name} ${SCALED}.`);
        if (frame.includes(BYTE)) coarse.add(name);
      }
    }
    for (const name of coarse) {
      context.logger.warn(`NORMAL and TANGENT of ${name} have 8 bits, which mirrors show: --meshopt-level medium has more.`);
    }
  }
}
