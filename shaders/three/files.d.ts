// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// What esbuild makes of files that are no TypeScript.

declare module "*.glsl" {
  const text: string;
  export default text;
}

declare module "*.wgsl" {
  const text: string;
  export default text;
}

declare module "*.css";
