# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The documentation as a code host shows it: links lead somewhere, pages and figures are reached.

.ci/build_docs.py checks the site that is made of it.
"""

from __future__ import annotations

import importlib.util
import re
import subprocess
from collections import Counter
from functools import cache
from pathlib import Path
from types import ModuleType
from urllib.parse import unquote

import pytest

pytestmark = pytest.mark.one_blender

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PICTURES = {".png", ".webp", ".svg", ".gif", ".jpg"}
_CODE = re.compile(r"^( *)(```+|~~~+|:::+).*?^\1\2 *$", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"\]\((?![a-z]+:)([^)\s]+)\)|<img[^>]* src=\"(?![a-z]+:)([^\"]+)\"")
_CODE_FILE = re.compile(r"`((?:[\w.]+/)+\w+\.(?:py|c|ts))`")
_HEADING = re.compile(r"^#{1,6} +(.+?) *#*$", re.MULTILINE)
_TOCTREE = re.compile(r"^```\{toctree\}\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def markdown_files() -> list[Path]:
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.md"]
    listed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    return [ROOT / name for name in listed if (ROOT / name).exists()]


@cache
def anchors(page: Path) -> frozenset[str]:
    """A page's headings as GitHub names them: lower case, no punctuation, a number where one comes again."""
    seen: Counter[str] = Counter()
    found = set()
    for heading in _HEADING.findall(without_fences(page.read_text(encoding="utf-8"))):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        slug = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
        found.add(f"{slug}-{seen[slug]}" if seen[slug] else slug)
        seen[slug] += 1
    return frozenset(found)


def without_fences(text: str) -> str:
    """The text without fenced code; what stands between colons is no code."""
    return _CODE.sub(lambda found: found[0] if found[2].startswith(":") else "", text)


def dead_links(page: Path) -> list[str]:
    dead = []
    for link in _LINK.finditer(without_fences(page.read_text(encoding="utf-8"))):
        target, _, anchor = unquote(link[1] or link[2]).partition("#")
        path = (page.parent / target).resolve() if target else page
        if not path.exists() or (anchor and path.suffix == ".md" and anchor not in anchors(path)):
            dead.append(link[1] or link[2])
    return dead


def test_every_relative_link_leads_to_a_file_and_a_heading() -> None:
    files = markdown_files()
    assert len(files) > 40
    assert {str(page.relative_to(ROOT)): dead for page in files if (dead := dead_links(page))} == {}


def test_every_page_of_docs_is_in_a_list_of_pages() -> None:
    listed = {DOCS / "index.md"}
    for page in DOCS.rglob("*.md"):
        for entries in _TOCTREE.findall(page.read_text(encoding="utf-8")):
            lines = (line for line in entries.splitlines() if line and not line.startswith(":"))
            names = (re.sub(r".*<(.*)>$", r"\1", line) for line in lines)
            listed |= {page.parent / f"{name}.md" for name in names}
    assert set(DOCS.rglob("*.md")) == listed


def test_every_figure_is_shown() -> None:
    """But for the pictures of a listing, which docs/release.md names with their sizes."""
    shown = {
        (page.parent / (link[1] or link[2])).resolve()
        for page in markdown_files()
        for link in _LINK.finditer(page.read_text(encoding="utf-8"))
    }
    figures = {path for path in (DOCS / "figures").rglob("*") if path.suffix in PICTURES}
    listing = {path.name for path in figures if path.name.startswith("listing-")}
    release = (DOCS / "release.md").read_text(encoding="utf-8")
    assert {name for name in listing if f"docs/figures/{name}`" not in release} == set()
    assert {path.name for path in figures - shown} - listing == set()


def check_site() -> ModuleType:
    spec = importlib.util.spec_from_file_location("check_site", ROOT / ".ci/check_site.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_check_of_the_site_finds_what_is_missing(tmp_path: Path) -> None:
    links = ("other.html#there", "#here", "other.html#gone", "gone.html", "https://other.example/gone")
    anchors_to = "".join(f'<a href="{link}">x</a>' for link in links)
    (tmp_path / "index.html").write_text(f'<h1 id="here">x</h1>{anchors_to}<img src="gone.png">')
    (tmp_path / "other.html").write_text('<h1 id="there">x</h1>')
    dead = check_site().dead_links(tmp_path)
    assert [line.split(": ")[1] for line in dead] == ["gone.html", "gone.png", "other.html#gone"]


def test_files_of_code_that_pages_name_are_there() -> None:
    """But for pages in docs/project, which tell of earlier states."""
    roots = (ROOT, ROOT / "radtex_addon", ROOT / "radtex_addon/forms/layered", ROOT / "shaders")
    pages = [page for page in markdown_files() if page.parent.name != "project"]
    named = {(page.name, name) for page in pages for name in _CODE_FILE.findall(page.read_text("utf-8"))}
    assert len(named) > 50
    missing = {
        (page, name)
        for page, name in named
        if "NAME" not in name and not any((root / name).is_file() for root in roots)
    }
    assert not missing
