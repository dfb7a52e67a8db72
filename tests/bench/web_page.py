# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How long a visitor waits for the web page: bytes, and seconds to the first picture and to the whole.

    python -m tests.bench.web_page FOLDER … [--megabits 9] [--latency 40] [--repeats 3]

Each FOLDER is a web export, also of an earlier RadTex: its page is opened in Chromium with an empty cache,
over a line of so many megabits a second, so many milliseconds from the server. The first picture is when the
object is drawn at all, the whole when all its textures are. A page that marks no first picture has only the
whole. Chromium draws without a GPU here: what it takes for that is in the times, and the same for all.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, sync_playwright

from tests.real.browser import SOFTWARE_GL, chromium, served
from tests.real.root import PROGRAMS, Root, ready_root

_MARKS = """
    () => Object.fromEntries(performance.getEntriesByType("mark").map((mark) => [mark.name, mark.startTime]))
"""
_FRAMES = """
    async (count) => {
        const times = [];
        for (let frame = 0; frame < count; frame++) {
            const begin = performance.now();
            radtex.pixels();
            times.push(performance.now() - begin);
        }
        return times;
    }
"""
_PATIENCE = 600_000  # milliseconds


def visit(browser: Browser, address: str, megabits: float, latency: float) -> dict[str, Any]:
    """Open the page once, with an empty cache. Returns bytes, textures, seconds, ms of a frame."""
    tab = browser.new_context(viewport={"width": 1000, "height": 700})
    try:
        page = tab.new_page()
        page.set_default_timeout(_PATIENCE)
        line = tab.new_cdp_session(page)
        line.send("Network.enable")
        received = []
        line.on("Network.loadingFinished", lambda event: received.append(event["encodedDataLength"]))
        bits = megabits * 1e6 / 8
        line.send(
            "Network.emulateNetworkConditions",
            {"offline": False, "latency": latency, "downloadThroughput": bits, "uploadThroughput": bits},
        )
        page.goto(address, wait_until="commit")
        page.wait_for_function("window.radtex", timeout=_PATIENCE)
        whole = page.evaluate("async () => { await radtex.ready; return performance.now() }")
        marks = page.evaluate(_MARKS)
        frames = page.evaluate(_FRAMES, 5)
        page.wait_for_timeout(500)  # the page tells its memory a moment after a frame
        textures = page.text_content("#memory") or ""
        first = marks.get("radtex-first")
        return {
            "bytes": sum(received),
            "textures": textures,
            "first": None if first is None else first / 1000,
            "whole": whole / 1000,
            "frame": statistics.median(frames),
        }
    finally:
        tab.close()


def main() -> None:
    """Print a line for each folder."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--megabits", type=float, default=9)
    parser.add_argument("--latency", type=float, default=40)
    parser.add_argument("--repeats", type=int, default=3)
    asked = parser.parse_args()
    path, _ = ready_root(PROGRAMS)
    with (
        tempfile.TemporaryDirectory() as exchange,
        sync_playwright() as driver,
        chromium(Root(path, Path(exchange)), driver.chromium, *SOFTWARE_GL) as browser,
    ):
        for folder in asked.folders:
            with served(folder) as address:
                visits = [
                    visit(browser, f"{address}/", asked.megabits, asked.latency) for _ in range(asked.repeats)
                ]
            print(told(folder, visits), flush=True)


def told(folder: Path, visits: list[dict[str, Any]]) -> str:
    """One line: medians of all visits."""

    def median(key: str) -> float:
        return float(statistics.median(each[key] for each in visits))

    first = "-" if visits[0]["first"] is None else f"{median('first'):.1f} s"
    size = median("bytes") / 1e6
    return (
        f"{folder.name}: {size:.2f} MB, first picture {first}, whole {median('whole'):.1f} s, "
        f"a frame {median('frame'):.0f} ms, {visits[0]['textures']}"
    )


if __name__ == "__main__":
    main()
