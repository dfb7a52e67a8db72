// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Khronos's glTF validator on files, as a list in JSON: node validate.mjs FOLDER-WITH-NODE_MODULES FILE.glb...

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const [, , folder, ...files] = process.argv;
const validator = createRequire(`${folder}/package.json`)("gltf-validator");
const reports = files.map((uri) => validator.validateBytes(new Uint8Array(readFileSync(uri)), { uri, maxIssues: 0 }));
process.stdout.write(JSON.stringify(await Promise.all(reports)));
