// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// What went wrong, in words for the person before the screen.

/** An error that the page shows: a headline, and what to do about it. */
export class Problem extends Error {
  /** `ofDevice`: another device can do it. */
  constructor(
    headline: string,
    readonly remedy: string,
    readonly ofDevice = false,
  ) {
    super(headline);
    this.name = "Problem";
  }
}

/** The last part of an address, as a person would name the file. */
export function fileName(url: URL): string {
  return plainText(url.pathname.split("/").pop() ?? "") || url.href;
}

/** Part of an address as people read it; as it is where it is encoded in another way. */
export function plainText(encoded: string): string {
  try {
    return decodeURIComponent(encoded);
  } catch {
    return encoded;
  }
}

/** Write a problem to the browser's console, with what to do about it. */
export function report(problem: Problem): void {
  console.error(`RadTex: ${problem.message}. ${problem.remedy}`);
}

/** Whatever was thrown, as a Problem. */
export function asProblem(error: unknown): Problem {
  if (error instanceof Problem) return error;
  const reason = error instanceof Error ? error.message : String(error);
  return new Problem("The page failed", `${reason}. Reload it; should that not help, export the object again.`);
}
