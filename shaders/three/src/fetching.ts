// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Files from the server.

import { fileName, plainText, Problem } from "./problem.js";
import { Requests } from "./requests.js";

export { fileName } from "./problem.js";

const BEGINNING = 64; // bytes that tell a web page from a file of ours

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
    throw inPart(url);
  }
  checkBeginning(bytes, url);
  return bytes;
}

/** A file that can be read while it comes. Throws as `fetchBytes` does. */
export async function fetchArriving(
  url: URL,
  priority: RequestPriority = "auto",
  requests = new Requests(),
): Promise<Arriving> {
  const response = await answer(url, priority, requests);
  const file = new Arriving(url, response.body, requests);
  try {
    checkBeginning(await file.first(BEGINNING), url);
  } catch (error) {
    file.cancel();
    throw error;
  }
  return file;
}

/** The bytes of a file that have come so far. */
export class Arriving {
  private bytes = new Uint8Array(1 << 16);
  private come = 0;
  private readonly reader: ReadableStreamDefaultReader<Uint8Array> | undefined;

  constructor(
    private readonly url: URL,
    body: ReadableStream<Uint8Array> | null,
    private readonly requests: Requests,
  ) {
    this.reader = body?.getReader();
  }

  /** The file's first bytes: so many, or all if it has fewer. Throws as `fetchBytes` where the connection breaks. */
  async first(count: number): Promise<Uint8Array<ArrayBuffer>> {
    while (this.come < count) {
      const { done, value } = (await this.reader?.read().catch(() => this.broken())) ?? { done: true };
      if (done || !value) break;
      this.add(value);
    }
    return this.bytes.subarray(0, Math.min(count, this.come));
  }

  /** Let no more of it come, where it is of no use: else a LoadingManager would wait for its end. */
  cancel(): void {
    this.reader?.cancel().catch(() => undefined);
  }

  private add(part: Uint8Array): void {
    const length = this.come + part.length;
    if (length > this.bytes.length) {
      const larger = new Uint8Array(Math.max(length, 2 * this.bytes.length));
      larger.set(this.bytes.subarray(0, this.come));
      this.bytes = larger;
    }
    this.bytes.set(part, this.come);
    this.come = length;
  }

  private broken(): never {
    this.requests.check(this.url);
    throw inPart(this.url);
  }
}

function inPart(url: URL): Problem {
  return new Problem(`${fileName(url)} came only in part`, "The connection broke: reload the page.");
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
  const beginning = new TextDecoder().decode(bytes.subarray(0, BEGINNING)).trimStart();
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
