// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Write dist/LICENSES.txt: the licences of the packages that the bundles hold.

import { readFileSync, writeFileSync } from "node:fs";

const { dependencies } = JSON.parse(readFileSync("package.json", "utf8"));
const texts = Object.keys(dependencies).map((name) => {
  const text = readFileSync(`node_modules/${name}/LICENSE`, "utf8").trim();
  return `${"-".repeat(79)}\n${name}\n\n${text}\n`;
});
writeFileSync("dist/LICENSES.txt", `radtex-three.bundle.js and webgpu.bundle.js are MIT, as in LICENSE. They also hold:\n\n${texts.join("\n")}`);
