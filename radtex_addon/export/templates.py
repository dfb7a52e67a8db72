# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fill in the @WORDS@ of the templates that exports are made of."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from ..core.errors import BakeError

_LEFT = re.compile(r"@[A-Z_]+@")


def filled(template: Path, words: Mapping[str, str]) -> str:
    """The text of a template with each @WORD@ replaced by its value in `words`.

    Raises BakeError if a word is left.
    """
    text = template.read_text(encoding="utf-8")
    if unknown := {word[1:-1] for word in _LEFT.findall(text)} - set(words):
        raise BakeError(f"{template} asks for {', '.join(sorted(unknown))}: install RadTex again")
    return _LEFT.sub(lambda word: words[word[0][1:-1]], text)


def write_text_file(path: Path, text: str) -> None:
    """Write a file of the folder that is being made, in UTF-8, its lines ended as on Linux."""
    path.write_text(text, encoding="utf-8", newline="\n")
