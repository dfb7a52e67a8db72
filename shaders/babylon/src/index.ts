// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// What the package offers.

export { Problem } from "../../three/src/problem.js";
export { registerRadTex } from "./extension.js";
export { RadTexMaterial } from "./material.js";
