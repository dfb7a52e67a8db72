// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Khronos's glTF validator on one file, as JSON: node validate.mjs FILE.glb FOLDER-WITH-NODE_MODULES

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const [, , file, folder] = process.argv;
const validator = createRequire(`${folder}/package.json`)("gltf-validator");
const report = await validator.validateBytes(new Uint8Array(readFileSync(file)), { uri: file });
process.stdout.write(JSON.stringify(report));
