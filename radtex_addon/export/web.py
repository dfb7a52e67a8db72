# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The web page that shows an exported folder from any static server."""

from __future__ import annotations

import shutil
from pathlib import Path
from urllib.parse import quote

from ..core.errors import BakeError
from .manifest import EXTENSION
from .pack import Pack

BUILT = Path(__file__).with_name("web") / "built"  # .ci/build_web.py makes it of the sources beside
FILES = ("index.html", "viewer.css", "viewer.js", "LICENSES.txt")
_UNNAMED = '<meta name="radtex-bake" content="" />'


def write_web(pack: Pack, folder: Path) -> None:
    """Add the page to a pack's folder; its index.html names the pack's manifest.

    Raises BakeError where this copy of RadTex has no built page.
    """
    if missing := [name for name in FILES if not (BUILT / name).is_file()]:
        raise BakeError(f"the web page lacks {missing[0]}: build it with `uv run .ci/build_web.py`")
    for name in FILES:
        shutil.copyfile(BUILT / name, folder / name)
    page = folder / "index.html"
    before, unnamed, after = page.read_text(encoding="utf-8").partition(_UNNAMED)
    if not unnamed:
        raise BakeError("the web page is not of this version: build it with `uv run .ci/build_web.py`")
    named = _UNNAMED.replace('""', f'"{quote(f"{pack.name}.{EXTENSION}")}"')
    page.write_text(before + named + after, encoding="utf-8", newline="\n")
