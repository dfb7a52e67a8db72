// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// What the package offers.

export { type Device, deviceOf, thisDevice } from "./device";
export { type Filter, filtersOf } from "./filters";
export { type Kind, KINDS } from "./kinds";
export { type LoadOptions, loadRadTex, type RadTex } from "./load";
export { type Manifest, readManifest } from "./manifest";
export { flatMaterial, type MaterialOptions, RadTexMaterial } from "./material";
export { type MirrorState, RadTexMirror } from "./mirror";
export { Problem } from "./problem";
export { RadTexObject } from "./radtex_object";
export { type Sun } from "./sun";
