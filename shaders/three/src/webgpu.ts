// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// What the package offers for three.js's WebGPURenderer: all that index.ts does, and nodes.

export * from "./index.js";
export { nodes } from "./nodes.js";
