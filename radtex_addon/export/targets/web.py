# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The web page that shows an exported folder from any static server."""

from __future__ import annotations

import shutil
from pathlib import Path
from urllib.parse import quote

from ...core.errors import InputError
from ..export_manifest import EXTENSION
from ..pack import Pack, ScenePack
from . import Writer

BUILT = Path(__file__).parents[1] / "web" / "built"  # made by .ci/build_web.py of shaders/three
FILES = ("index.html", "viewer.css", "boot.js", "viewer.js", "viewer.js.gz", "LICENSES.txt")
# The first picture needs these: browsers fetch them while they still load the page's script.
_PRELOAD = '<link rel="preload" href="{}" as="fetch" crossorigin />'
_UNNAMED = '<meta name="radtex-bake" content="" />'


def check_page() -> None:
    """Raise InputError if this copy of RadTex has no built page, or one of another version."""
    if missing := [name for name in FILES if not (BUILT / name).is_file()]:
        raise InputError(f"the web page lacks {missing[0]}: build it with `uv run .ci/build_web.py`")
    if _UNNAMED not in (BUILT / "index.html").read_text(encoding="utf-8"):
        raise InputError("the web page is not of this version: build it with `uv run .ci/build_web.py`")


def write_web(pack: Pack | ScenePack, folder: Path) -> None:
    """Add the page (see `check_page`) to a pack's folder; its index.html names the manifest and the mesh."""
    for name in FILES:
        shutil.copyfile(BUILT / name, folder / name)
    page = folder / "index.html"
    manifest, mesh = _address(f"{pack.name}.{EXTENSION}"), _address(f"{pack.name}.glb")
    first = [manifest, mesh]
    if isinstance(pack, Pack) and pack.manifest.images:
        first.append(_address(pack.manifest.flat))  # else it is in the .glb
    named = [_UNNAMED.replace('""', f'"{manifest}"'), *(_PRELOAD.format(file) for file in first)]
    text = page.read_text(encoding="utf-8").replace(_UNNAMED, "\n    ".join(named))
    page.write_text(text, encoding="utf-8", newline="\n")


def _address(file: str) -> str:
    """As encodeURIComponent writes it: browsers take what was preloaded for that very address alone."""
    return quote(file, safe="!'()*")


WRITER = Writer(write_web, write_web, check_page)
