// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// For three.js's WebGPURenderer: materials of nodes that show a bake, by WGSL, or by GLSL where it draws by WebGL 2.

import {
  type Color,
  DynamicDrawUsage,
  type InstancedMesh,
  InterleavedBufferAttribute,
  Matrix3,
  Matrix4,
  type OrthographicCamera,
  REVISION,
  type Texture,
} from "three";
import { InterpolationSamplingMode, InterpolationSamplingType, NodeMaterial } from "three/webgpu";

import { deviceForNodes, type GpuRenderer, uploadByNodes } from "./gpu_textures.js";
import { type Frame, loadOf, LookupNode, type Nodal, type Place, tsl } from "./lookup_node.js";
import type { Manifest } from "./manifest.js";
import { hasAlpha, type Look, type MaterialOptions, type Nodes, plainLook, sidesOf } from "./material.js";
import type { Bake } from "./parts.js";
import { Problem } from "./problem.js";
import { wgslRefuses } from "./wgsl.js";

const OLDEST = 186; // of three.js's revisions

/** The option `nodes` of all that loads a bake: it is drawn by three.js's WebGPURenderer then, and by no other. */
export const nodes: Nodes = {
  surface: (bake, options) => new RadTexNodeMaterial(bake, options),
  flat: (manifest, map, baked, look) => {
    if (Number.parseInt(REVISION) < OLDEST) {
      const here = `three.js 0.${REVISION} has not all that radtex-three/webgpu is made of`;
      throw new Problem(here, `Install three.js 0.${OLDEST} or later, or leave nodes out and draw by WebGLRenderer.`);
    }
    return new FlatNodeMaterial(manifest, map, baked, look);
  },
  device: deviceForNodes,
  upload: (texture, renderer) => uploadByNodes(texture, renderer as GpuRenderer),
  depth: (side) => {
    const material = new NodeMaterial();
    Object.assign(material, { side, colorWrite: false, allowOverride: false, polygonOffset: true, polygonOffsetUnits: 2 });
    material.fragmentNode = tsl.vec4(0);
    return material;
  },
  drawDepth: (renderer, mesh, scene, camera, material) => {
    const { onBeforeRender } = mesh;
    mesh.onBeforeRender = () => undefined;
    const { lighting } = renderer as Nodal;
    (renderer as Nodal).renderObject(mesh, scene, camera, mesh.geometry, material, null, lighting.getNode(scene), null, "depth");
    mesh.onBeforeRender = onBeforeRender;
  },
  refusal: (bake, layer, renderer) => {
    if (!(renderer as GpuRenderer).backend?.isWebGPUBackend) return null;
    const reason = wgslRefuses(bake, layer);
    if (!reason) return null;
    return new Problem(
      `${bake.manifest.name} is shown by its flat lightmap: RadTex has no WGSL for ${reason}`,
      "Draw it by WebGL 2: new WebGPURenderer({ forceWebGL: true }), or WebGLRenderer without nodes.",
    );
  },
};

// What a WebGLRenderer, which does not take nodes, draws in the one frame before the flat lightmap is shown: nothing.
const NOTHING = {
  vertexShader: "void main() { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); }",
  fragmentShader: "void main() { gl_FragColor = vec4(0.0); }",
  uniforms: {},
  defines: {},
};

/** A material of a baked surface. `opacity` below 1 needs `transparent`, as in all of three.js's materials. */
abstract class SurfaceNodeMaterial extends NodeMaterial {
  readonly blended: boolean;
  readonly #look: Look; // what three.js's copy() does not see

  /** `shown` gives a surface's light, premultiplied by alpha. */
  constructor(manifest: Manifest, shown: (surface: Place) => Nodal, baked: Matrix4, look: Look, blended: boolean) {
    super();
    this.#look = look;
    this.blended = blended;
    this.fog = true;
    this.premultipliedAlpha = true;
    this.transparent = blended;
    this.forceSinglePass = true; // triangles of what is clear are in order
    this.side = sidesOf(manifest);
    Object.assign(this, NOTHING);
    const exposure = tsl.uniform(look.exposure.value).onObjectUpdate(() => look.exposure.value);
    const clear = blended && manifest.bake.kind !== "proxy";
    this.colorNode = tsl.Fn((builder: Nodal) => {
      const seen = shown(placeOf(baked, builder)).toVar();
      const light = seen.rgb.mul(exposure.mul(tsl.uniform(look.tint))).toVar();
      const empty = clear ? seen.a.max(brightest(light)).lessThan(0.002) : tsl.bool(false);
      empty.or(opacityOf(builder).lessThanEqual(0)).discard(); // else it would hide what lies behind
      return tsl.vec4(light, blended ? seen.a : 1);
    })();
  }

  /** The colour that all its light is multiplied by. */
  get tint(): Color {
    return this.#look.tint;
  }

  /** The number that all its light is multiplied by, as by `toneMappingExposure`: 2 is a stop more. */
  get exposure(): number {
    return this.#look.exposure.value;
  }

  set exposure(exposure: number) {
    this.#look.exposure.value = exposure;
  }

  /** Fog acts on the light where it covers, and that may be more than its alpha says where it glows. */
  override setupOutput(builder: Nodal, given: Nodal): Nodal {
    const seen = given.toVar(); // three.js has multiplied it by what instances have, and alpha by opacities
    const opacity = opacityOf(builder);
    const alpha = this.blended ? seen.a.div(opacity.max(1e-6)) : tsl.float(1);
    const cover = this.blended ? alpha.max(brightest(seen.rgb)).clamp(1e-6, 1) : tsl.float(1);
    const straight = tsl.vec4(seen.rgb.div(cover), alpha);
    const fogged = this.fog ? (this as Nodal).setupFog(builder, straight) : straight;
    return tsl.vec4(fogged.rgb.mul(cover), alpha).mul(opacity);
  }

  /** As that of three.js, but that its look is its own. */
  override copy(source: this): this {
    const { colorNode } = this;
    super.copy(source);
    this.colorNode = colorNode;
    this.#look.own.copy(source.#look.own);
    this.#look.tint.copy(source.#look.tint);
    this.#look.exposure.value = source.#look.exposure.value;
    return this;
  }
}

/** A material's opacity, times that of an instance. */
function opacityOf({ object }: Nodal): Nodal {
  const { batchColor, materialOpacity } = tsl;
  return object.isBatchedMesh && object._colorsTexture ? materialOpacity.mul(batchColor.a) : materialOpacity;
}

/** The light of a bake, as it leaves its surface towards the camera. For a Mesh or an InstancedMesh of the bake's. */
class RadTexNodeMaterial extends SurfaceNodeMaterial {
  readonly isRadTexMaterial = true;
  readonly #bake: Bake;
  readonly #options: MaterialOptions;

  constructor(bake: Bake, options: MaterialOptions = {}) {
    const { baked = new Matrix4(), look = plainLook() } = options;
    const blended = hasAlpha(bake.manifest) && !options.opaque;
    const own = tsl.uniform(look.own);
    const shown = (surface: Place): Nodal => {
      const light = new LookupNode(bake, options, surface, look) as Nodal;
      return options.lamps?.length ? light : light.mul(tsl.vec4(own, 1)); // that of lamps is told apart
    };
    super(bake.manifest, shown, baked, look, blended);
    this.#bake = bake;
    this.#options = options;
  }

  /** Another one when the bake's textures were loaded once more. */
  override customProgramCacheKey(): string {
    return `${super.customProgramCacheKey()} ${loadOf(this.#bake)}`;
  }

  override clone(): this {
    return new RadTexNodeMaterial(this.#bake, { ...this.#options, look: plainLook() }).copy(this) as this;
  }
}

/** The flat lightmap on the mesh: what is seen until all textures are there. */
class FlatNodeMaterial extends SurfaceNodeMaterial {
  readonly #made: [Manifest, Texture, Matrix4];

  constructor(manifest: Manifest, map: Texture, baked = new Matrix4(), look = plainLook()) {
    const own = tsl.uniform(look.own);
    const shown = (): Nodal => {
      const texel = tsl.texture(map);
      return tsl.vec4(texel.rgb.mul(texel.a).mul(own).div(manifest.flat_scale || 1), texel.a);
    };
    super(manifest, shown, baked, look, manifest.bake.layout === "buckets");
    this.#made = [manifest, map, baked];
  }

  override clone(): this {
    return new FlatNodeMaterial(...this.#made, plainLook()).copy(this) as this;
  }
}

function brightest(light: Nodal): Nodal {
  return light.r.max(light.g).max(light.b);
}

/** What surface.vert.glsl computes, for WebGLRenderer. */
function placeOf(baked: Matrix4, builder: Nodal): Place {
  const { attribute, cameraPosition, cameraWorldMatrix, cross, dot, float, mat3, modelWorldMatrixInverse, uniform } = tsl;
  const { varying, vec2, vec3, vec4 } = tsl;
  const has = (name: string): boolean => builder.hasGeometryAttribute(name);
  const between = (node: Nodal): Nodal =>
    varying(node).setInterpolation(InterpolationSamplingType.PERSPECTIVE, InterpolationSamplingMode.CENTROID);
  const moved = uniform(baked);
  const turn = mat3(moved);
  const upright = uniform(new Matrix3().getNormalMatrix(baked));
  const columns = columnsOf(builder);
  // From the scene's world to that of the bake: of a place, its last number 1, or of a direction, 0.
  const into = (of: Nodal): Nodal => {
    const here = modelWorldMatrixInverse.mul(of);
    if (!columns) return moved.mul(here).xyz;
    const [a, b, c, d] = columns.map(({ xyz }) => xyz);
    const away = here.xyz.sub(d.mul(here.w));
    const inverse = vec3(dot(cross(b, c), away), dot(cross(c, a), away), dot(cross(a, b), away));
    return moved.mul(vec4(inverse.div(dot(a, cross(b, c))), here.w)).xyz;
  };
  // The eye: its place, or where an orthographic camera looks from.
  const isPlace = uniform(1).onObjectUpdate(({ camera }: Frame) => ((camera as OrthographicCamera).isOrthographicCamera ? 0 : 1));
  const eye = vec4(isPlace.greaterThan(0.5).select(cameraPosition, cameraWorldMatrix.mul(vec4(0, 0, 1, 0)).xyz), isPlace);
  const place = between(moved.mul(vec4(attribute("position", "vec3"), 1)).xyz);
  const uv = attribute("uv", "vec2");
  const ofImages = has("uv_images"); // a normal map weighs one by the other, also where the node is scaled
  const normal = upright.mul(attribute("normal", "vec3"));
  const frame = has("tangent") ? attribute("tangent", "vec4") : vec4(1, 0, 0, 1);
  const along = turn.mul(frame.xyz);
  const side = frame.w.mul(float(Math.sign(baked.determinant())));
  return {
    place,
    uv: between(vec2(uv.x, float(1).sub(uv.y))), // glTF's v grows downwards
    images: ofImages ? between(attribute("uv_images", "vec2")) : vec2(0),
    normal: between(ofImages ? normal.normalize() : normal),
    tangent: between(vec4(ofImages ? along.normalize() : along, side)),
    V: between(into(eye)).sub(place.mul(isPlace)).normalize(),
    turned: (direction) => between(into(vec4(direction, 0))),
  };
}

/** The columns of an instance's matrix, if the object has instances. */
function columnsOf(builder: Nodal): Nodal[] | null {
  const { drawIndex, instanceIndex, int, ivec2, textureLoad, textureSize } = tsl;
  const { object } = builder;
  if (object.isBatchedMesh) {
    const entry = (texture: Texture, place: Nodal): Nodal => {
      const across = int(textureSize(textureLoad(texture), 0).x);
      return textureLoad(texture, ivec2(place.mod(across), place.div(across)));
    };
    const instance = int(entry(object._indirectTexture, int(builder.getDrawIndex() === null ? instanceIndex : drawIndex)).x);
    return [0, 1, 2, 3].map((column) => entry(object._matricesTexture, instance.mul(4).add(column)));
  }
  if (!object.isInstancedMesh) return null;
  builder.objectSpecific = true; // others that share the material have matrices of their own
  const { instanceMatrix } = object as InstancedMesh;
  const dynamic = instanceMatrix.usage === DynamicDrawUsage;
  const column = dynamic ? tsl.instancedDynamicBufferAttribute : tsl.instancedBufferAttribute;
  return [0, 4, 8, 12].map((first) => column(new InterleavedBufferAttribute(instanceMatrix as Nodal, 4, first)));
}
