// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// How files are asked for: headers, credentials, a LoadingManager of three.js, progress in bytes, a time limit, an end.

import type { LoadingManager } from "three";

import { fileName, Problem } from "./problem.js";

export interface RequestOptions {
  /** Told of each file; changes addresses by its URL modifier. */
  manager?: LoadingManager | undefined;
  requestHeader?: Readonly<Record<string, string>> | undefined;
  /** Whether other servers get cookies: "anonymous" or "use-credentials", as of an image. */
  crossOrigin?: string | undefined;
  withCredentials?: boolean | undefined;
  /** Ends the load: it is rejected with the signal's reason, by default a DOMException called AbortError. */
  signal?: AbortSignal | undefined;
  /** Milliseconds after which a file fails of which nothing more arrives; 0, the default, waits for as long as the browser does. */
  timeout?: number | undefined;
  /** Called with the bytes that have come so far, of all files that were asked for so far. */
  received?: ((event: ProgressEvent) => void) | undefined;
}

/** The requests of one load. */
export class Requests {
  private readonly bytes = new Map<string, [come: number, all: number | null]>();
  private readonly late = new Map<string, Problem>();
  private readonly signal: AbortSignal | undefined; // the manager makes a new one after each abort
  private readonly headers: Headers;

  /** Throws a Problem for headers that cannot be sent. */
  constructor(private readonly options: RequestOptions = {}) {
    const { manager, requestHeader, signal } = options;
    this.signal = either(signal, manager?.abortController?.signal);
    try {
      this.headers = new Headers(requestHeader);
    } catch (error) {
      const reason = error instanceof Error ? error.message : String(error);
      throw new Problem(`The requestHeader cannot be sent: ${reason}`, "Headers take Latin letters, digits and signs alone.");
    }
  }

  /**
   * A file's answer, whose body may be read at once or while it comes. Throws what `fetch` does, or a Problem where nothing
   * comes in time; where reading it fails, `check` knows why.
   */
  async ask(url: URL, priority: RequestPriority): Promise<Response> {
    const { crossOrigin, manager, received, timeout, withCredentials } = this.options;
    const { headers } = this;
    const credentials = withCredentials || crossOrigin === "use-credentials" ? "include" : "same-origin";
    const address = manager?.resolveURL(url.href) ?? url.href;
    manager?.itemStart(url.href);
    try {
      const answer = await this.inTime(url, (ended) =>
        fetch(address, { priority, credentials, headers, signal: either(this.signal, ended) ?? null }),
      );
      if (!answer.ok || !answer.body) this.ended(url, !answer.ok);
      if (!answer.ok || !answer.body || !(manager || received || timeout)) return answer;
      return new Response(this.followed(url, answer.body, sizeOf(answer)), answer);
    } catch (error) {
      this.ended(url, true);
      throw error;
    }
  }

  /** Throws why reading a file failed, if that is known: the load was ended, or nothing came in time. */
  check(url: URL): void {
    this.signal?.throwIfAborted();
    const late = this.late.get(url.href);
    if (late) throw late;
  }

  /** The same bytes, of which the manager and `received` are told. */
  private followed(
    url: URL,
    body: ReadableStream<Uint8Array<ArrayBuffer>>,
    all: number | null,
  ): ReadableStream<Uint8Array<ArrayBuffer>> {
    const reader = body.getReader();
    let come = 0;
    let isOver = false;
    const over = (failed: boolean): void => {
      if (!isOver) this.ended(url, failed);
      isOver = true;
    };
    this.tell(url, come, all);
    return new ReadableStream({
      pull: async (into) => {
        try {
          const { done, value } = await this.inTime(url, () => reader.read());
          if (isOver) return; // nobody wanted more, meanwhile
          come += value?.byteLength ?? 0;
          this.tell(url, come, done ? come : all);
          if (value) into.enqueue(value);
          if (!done) return;
          into.close();
          over(false);
        } catch (error) {
          if (isOver) return;
          reader.cancel().catch(() => undefined);
          over(true);
          into.error(error);
        }
      },
      cancel: async (reason) => {
        over(false);
        await reader.cancel(reason);
      },
    });
  }

  private ended(url: URL, failed: boolean): void {
    const { manager } = this.options;
    if (failed) manager?.itemError(url.href);
    manager?.itemEnd(url.href);
  }

  private tell(url: URL, come: number, all: number | null): void {
    const { received } = this.options;
    if (!received) return;
    this.bytes.set(url.href, [come, all]);
    const files = [...this.bytes.values()];
    const loaded = files.reduce((sum, [of]) => sum + of, 0);
    const lengthComputable = files.every(([, of]) => of !== null);
    const total = lengthComputable ? files.reduce((sum, [, of]) => sum + (of ?? 0), 0) : 0;
    received(new ProgressEvent("progress", { lengthComputable, loaded, total }));
  }

  /** The same, unless it takes longer than it may: then it is ended, and a Problem is thrown. */
  private async inTime<Result>(url: URL, act: (ended?: AbortSignal) => Promise<Result>): Promise<Result> {
    const { timeout = 0 } = this.options;
    if (!timeout) return act();
    const ending = new AbortController();
    let timer = 0;
    const late = new Promise<never>((_, reject) => {
      timer = setTimeout(() => {
        const remedy = "The server or the connection is slow or gone: load it again, or allow more time by `timeout`.";
        const problem = new Problem(`${fileName(url)} does not come: nothing arrived for ${timeout / 1000} seconds`, remedy);
        this.late.set(url.href, problem);
        reject(problem);
        ending.abort();
      }, timeout);
    });
    try {
      return await Promise.race([act(ending.signal), late]);
    } finally {
      clearTimeout(timer);
    }
  }
}

/** How many bytes an answer has; null if it does not say so, or of others than are read. */
function sizeOf({ headers }: Response): number | null {
  const told = headers.has("Content-Encoding") ? 0 : Number(headers.get("Content-Length"));
  return told > 0 ? told : null;
}

/** A signal that is aborted with the first of two. */
function either(one: AbortSignal | undefined, other: AbortSignal | undefined): AbortSignal | undefined {
  return one && other ? AbortSignal.any([one, other]) : (one ?? other);
}
