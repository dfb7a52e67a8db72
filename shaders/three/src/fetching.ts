// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Files from the server.

import { Problem } from "./problem.js";

/** The address of a file that lies beside the manifest. */
export function fileUrl(file: string, manifest: URL): URL {
  return new URL(encodeURIComponent(file), manifest);
}

/** The last part of an address, as a person would name the file. */
export function fileName(url: URL): string {
  return decodeURIComponent(url.pathname.split("/").pop() ?? "") || url.href;
}

/** A file's bytes. Throws a Problem where it cannot be had. */
export async function fetchBytes(url: URL, priority: RequestPriority = "auto"): Promise<Uint8Array<ArrayBuffer>> {
  let response: Response;
  try {
    response = await fetch(url, { priority });
  } catch {
    throw new Problem(`${fileName(url)} could not be reached`, "Is the server still running? Reload the page.");
  }
  if (response.status === 404) {
    throw new Problem(
      `${fileName(url)} is missing`,
      `The server has no ${decodeURIComponent(url.pathname)}: put all files of the export into one folder.`,
    );
  }
  if (!response.ok) {
    throw new Problem(
      `${fileName(url)} was refused: ${response.status} ${response.statusText}`.trim(),
      "Ask whoever runs the server.",
    );
  }
  try {
    return new Uint8Array(await response.arrayBuffer());
  } catch {
    throw new Problem(`${fileName(url)} came only in part`, "The connection broke: reload the page.");
  }
}
