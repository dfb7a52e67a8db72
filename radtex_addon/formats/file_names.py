# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which file names a manifest may have. Anybody may have made it: no name in it leads out of its folder.

docs/format.md, "What a reader refuses", has the rule. The readers in other languages have it, too:
shaders/godot/addons/radtex/checks.gd, shaders/three/src/checks.ts, and the scripts for Unity and Unreal.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence

MOST_CHARACTERS = 255
FORBIDDEN = '<>:"/\\|?*'  # folders, drives, streams, wildcards, and what Windows has in no name
_CONTROLS = {"Cc", "Zl", "Zp"}  # control characters and line separators
_DEVICES = re.compile(r"(con|prn|aux|nul|com[0-9]|lpt[0-9]) *(\.|$)", re.IGNORECASE)


def is_plain_file(name: str, endings: Sequence[str]) -> bool:
    """Whether `name` is that of a file beside the manifest, with one of these endings, such as "ktx2"."""
    return (
        len(name) <= MOST_CHARACTERS
        and name.endswith(tuple(f".{ending}" for ending in endings))
        and is_plain_stem(name)
    )


def is_plain_stem(name: str) -> bool:
    """Whether files may have names that begin with `name`: it leads nowhere, and is one line of text."""
    return (
        name.strip() != ""
        and not name.startswith((".", " "))
        and not any(mark in FORBIDDEN or unicodedata.category(mark) in _CONTROLS for mark in name)
        and not _DEVICES.match(name)
    )
