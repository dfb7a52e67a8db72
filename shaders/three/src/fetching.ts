// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Files from the server.

import { fileName, plainText, Problem } from "./problem.js";
import { Requests } from "./requests.js";

export { fileName } from "./problem.js";

/** The address of a file that lies beside the manifest. */
export function fileUrl(file: string, manifest: URL): URL {
  return new URL(encodeURIComponent(file), manifest);
}

/** A file's bytes. Throws a Problem where it cannot be had, and the signal's reason where the load was ended. */
export async function fetchBytes(
  url: URL,
  priority: RequestPriority = "auto",
  requests = new Requests(),
): Promise<Uint8Array<ArrayBuffer>> {
  const response = await answer(url, priority, requests);
  let bytes: Uint8Array<ArrayBuffer>;
  try {
    bytes = new Uint8Array(await response.arrayBuffer());
  } catch {
    requests.check(url);
    throw new Problem(`${fileName(url)} came only in part`, "The connection broke: reload the page.");
  }
  checkBeginning(bytes, url);
  return bytes;
}

/** The server's answer, where it has the file. Throws a Problem otherwise. */
async function answer(url: URL, priority: RequestPriority, requests: Requests): Promise<Response> {
  let response: Response;
  try {
    response = await requests.ask(url, priority);
  } catch {
    requests.check(url);
    throw new Problem(`${fileName(url)} could not be reached`, waysTo(url));
  }
  if (response.status === 404) {
    throw new Problem(
      `${fileName(url)} is missing`,
      `The server has no ${plainText(url.pathname)}: put all files of the export into one folder.`,
    );
  }
  if (!response.ok) {
    throw new Problem(
      `${fileName(url)} was refused: ${response.status} ${response.statusText}`.trim(),
      "Ask whoever runs the server; where it wants a header or a login, give `requestHeader` or `withCredentials`.",
    );
  }
  return response;
}

/** Throws a Problem for what servers send in the place of a file: none of an export's begins so. */
function checkBeginning(bytes: Uint8Array, url: URL): void {
  const beginning = new TextDecoder().decode(bytes.subarray(0, 64)).trimStart();
  if (!bytes.length) throw new Problem(`${fileName(url)} is empty`, "Copy it once more, or export again.");
  if (beginning.startsWith("<")) {
    throw new Problem(
      `${fileName(url)} is missing: the server sent a web page in its place`,
      "Put the export’s folder where your server takes files from, with Vite its folder “public”, and see that the address is right.",
    );
  }
  if (beginning.startsWith("version https://git-lfs")) {
    throw new Problem(
      `${fileName(url)} is not here yet: it is a pointer of Git LFS to it`,
      "Run git lfs pull in the folder that the server takes its files from.",
    );
  }
}

/** What to do about a file that cannot be reached: browsers do not tell a page why. */
function waysTo(url: URL): string {
  if (url.protocol === "file:") {
    return "Browsers do not let a page from the disk read files: serve its folder, by python -m http.server for one.";
  }
  if (url.origin === location.origin) return "Is the server still running? Reload the page.";
  return `Is ${url.host} running, and does it let pages of ${location.host} read its files (Access-Control-Allow-Origin)?`;
}
