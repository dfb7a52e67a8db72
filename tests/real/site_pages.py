# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the docs site in Chromium: `uv run --group test python -m tests.real.site_pages OUT [PAGE …]`.

Opens pages of dist/site, which .ci/build_docs.py builds, as wide as a desktop's window and as a phone, and
writes OUT/PAGE-WIDTH.png. Without names it opens all of them. It says which are wider than their window, or
ask for a file that is not there; the exit code is then 1. `--dark` shows dark mode, `--search WORD` what the
search finds.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from playwright.sync_api import Browser, FloatRect, Page, Response, sync_playwright

from tests.real.browser import chromium, served
from tests.real.root import PROGRAMS, REPOSITORY, Root, ready_root

SITE = REPOSITORY / "dist/site"
WIDTHS = {1280: 900, 390: 844}  # pixels: windows' widths, and their heights
_REFUSED = 400  # the least status of an answer that is none
_LOWEST = 2400  # pixels of a page that a picture shows at most
_HANGS_OUT = """() => {
    const wide = document.documentElement.clientWidth;
    return document.documentElement.scrollWidth <= wide ? "" : [...document.querySelectorAll("article *")]
        .filter(one => one.getBoundingClientRect().right > wide + 1 && !one.closest(".table-wrapper, pre"))
        .slice(0, 3).map(one => `<${one.tagName.toLowerCase()} class="${one.className}">`).join(", ") || "?";
}"""


def main() -> int:
    """Take the pictures; returns the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("out", type=Path)
    parser.add_argument("pages", nargs="*", metavar="PAGE", help="such as index or reference/batch")
    parser.add_argument("--dark", action="store_true")
    parser.add_argument("--search", metavar="WORD", help="take a picture of the search for it, too")
    options = parser.parse_intermixed_args()  # pages may follow options
    options.out.mkdir(parents=True, exist_ok=True)
    every = [path.relative_to(SITE).with_suffix("").as_posix() for path in sorted(SITE.rglob("*.html"))]
    found = [f"{page}.html" for page in options.pages or every]
    found += [f"search.html?q={options.search}"] if options.search else []
    with (
        tempfile.TemporaryDirectory() as shared,
        sync_playwright() as driver,
        chromium(Root(ready_root(PROGRAMS)[0], Path(shared)), driver.chromium) as browser,
        served(SITE) as address,
    ):
        faults = list(pictures(browser, address, found, options.out, options.dark))
    print("\n".join(faults) or f"{len(found)} pages fit into {', '.join(map(str, WIDTHS))} pixels")
    return bool(faults)


def pictures(browser: Browser, address: str, pages: list[str], out: Path, dark: bool) -> Iterator[str]:
    """Write each page's pictures; yields a line for each fault."""
    for width, height in WIDTHS.items():
        tab = browser.new_context(
            viewport={"width": width, "height": height}, color_scheme="dark" if dark else "light"
        )
        page = tab.new_page()
        lost: list[str] = []
        _listen(page, lost)
        for name in pages:
            page.goto(f"{address}/{name}", wait_until="load")
            wide = page.evaluate(_HANGS_OUT)
            if wide:
                yield f"{name} is wider than {width} pixels: {wide}"
            yield from (f"{name}: {fault}" for fault in lost)
            lost.clear()
            stem = name.split(".html")[0].replace("/", "-")
            _picture(page, out / f"{stem}-{width}{'-dark' * dark}.png", width)
        tab.close()


def _listen(page: Page, lost: list[str]) -> None:
    """Append to `lost` what the page asks for in vain, and the errors of its scripts."""

    def answered(answer: Response) -> None:
        if answer.status >= _REFUSED:
            lost.append(answer.url)

    page.on("response", answered)
    page.on("pageerror", lambda error: lost.append(str(error)))


def _picture(page: Page, path: Path, width: int) -> None:
    page.wait_for_timeout(300)
    tall = int(page.evaluate("document.documentElement.scrollHeight"))
    clip = FloatRect(x=0, y=0, width=width, height=min(tall, _LOWEST))
    page.screenshot(path=path, full_page=True, clip=clip)


if __name__ == "__main__":
    sys.exit(main())
