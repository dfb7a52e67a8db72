// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// What the package offers.

export { type Device, deviceOf, thisDevice } from "./device.js";
export { type Filter, filtersOf } from "./filters.js";
export { type PluginOptions, radtex } from "./gltf_plugin.js";
export { type Kind, KINDS } from "./kinds.js";
export { type LoadOptions, loadRadTex, loadRadTexScene, type RadTex, type RadTexScene } from "./load.js";
export { type LoaderOptions, RadTexLoader, RadTexSceneLoader } from "./loader.js";
export { type Manifest, readManifest, type SceneManifest } from "./manifest.js";
export { flatMaterial, type Look, type MaterialOptions, type Nodes, RadTexMaterial, type Surface, SurfaceMaterial } from "./material.js";
export { type MirrorState, RadTexMirror } from "./mirror.js";
export { Problem } from "./problem.js";
export { RadTexObject } from "./radtex_object.js";
export { type RequestOptions } from "./requests.js";
export { type Sun } from "./sun.js";
