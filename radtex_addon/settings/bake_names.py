# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake's files are called: a pattern, such as {object}.{quality}, whose tokens are filled in.

A brace that is no token's is written twice. `{object}` stays in the pattern to the end: an atlas's name may
be found late. All other tokens are filled in when the bakes are planned (`job.variants.named_in`).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..core.errors import InputError
from ..core.messages import Setting, do
from ..core.quoting import printable
from ..formats.sidecar import safe_name
from .presets import QUALITIES

if TYPE_CHECKING:
    from .spec import BakeSpec

OBJECT = "{object}"  # the pattern of files that are called as their object
TOKENS = {
    "object": "the object's name, or that of the atlas that objects share",
    "quality": f"the preset that the settings are: {', '.join(QUALITIES[:-1])}, else {QUALITIES[-1]}",
    "resolution": "texels along a side, such as 128, or of a density, such as 64-per-metre",
    "samples": "samples, as the settings have them",
    "scene": "the scene's name",
    "file": "the .blend's name",
}
LISTED = ", ".join(f"{{{token}}}" for token in TOKENS)

_PIECES = re.compile(r"\{\{|\}\}|\{([^{}]*)\}|[^{}]+|[{}]")
_FORBIDDEN = '<>:"/\\|?*#%'  # what file systems refuse, and what addresses on the web mean something by
_LONGEST = 90  # bytes of a pattern without its tokens: less than of a file's name


def check_pattern(pattern: str) -> None:
    """Raise InputError, which names what is wrong and lists the tokens, for what names no files."""
    usual = do("call it as the object", Setting.BAKE_NAME, value=OBJECT)
    if not pattern.strip():
        raise InputError(f"the bake's name is empty: its tokens are {LISTED}", usual)
    told = f"the bake's name {_shown(pattern)}"
    for piece in _PIECES.finditer(pattern):
        if piece[0] in "{}":
            raise InputError(
                f"{told} has a {piece[0]} without its counterpart (one that is meant is written twice): its "
                f"tokens are {LISTED}",
                usual,
            )
        if piece[1] is not None and piece[1] not in TOKENS:
            raise InputError(f"{told} has {_shown(piece[0])}, which is no token: there are {LISTED}", usual)
    literal = "".join(piece[0] for piece in _PIECES.finditer(pattern) if piece[1] is None)
    if found := [mark for mark in literal if mark in _FORBIDDEN]:
        raise InputError(
            f"{told} has {_shown(found[0])}, which files' names and addresses on the web do not take: leave "
            f"it out, or choose another folder for another place"
        )
    if len(literal.encode("utf-8", "surrogatepass")) > _LONGEST:
        raise InputError(f"{told} has more than {_LONGEST} bytes beside its tokens: make it shorter")
    sample = filled(fill(pattern, dict.fromkeys(TOKENS, "x")), "x")
    if safe_name(sample) != sample or sample.startswith("."):
        raise InputError(
            f"{told} cannot be that of files: it begins or ends with a full stop or a blank, has an "
            "invisible character, or is a name that Windows keeps for itself: choose another"
        )


def fill(pattern: str, values: Mapping[str, str]) -> str:
    """The pattern with these tokens filled in; others stay."""

    def told(piece: re.Match[str]) -> str:
        value = values.get(piece[1]) if piece[1] is not None else None
        return piece[0] if value is None else value.replace("{", "{{").replace("}", "}}")

    return _PIECES.sub(told, pattern)


def filled(pattern: str, name: str) -> str:
    """What files by a pattern are called, whose tokens but for `{object}`, the `name`, were filled in.

    Raises InputError for another token.
    """
    if pattern == OBJECT:
        return name
    whole = fill(pattern, {"object": name})
    words = []
    for piece in _PIECES.finditer(whole):
        if piece[1] is not None:
            raise InputError(f"{_shown(piece[0])} of the bake's name is not known here: leave it out")
        words.append(piece[0][0] if piece[0] in ("{{", "}}") else piece[0])
    return "".join(words)


def own_name(pattern: str, name: str) -> str:
    """As `filled`; empty if that is the object's `name`, as of bakes by the usual pattern."""
    called = filled(pattern, name)
    return "" if called == name else called


def tokens_of(spec: BakeSpec) -> dict[str, str]:
    """The values of tokens that the specification alone tells."""
    size = str(spec.texels) if spec.density is None else f"{spec.density:.6g}-per-metre"
    return {"resolution": size, "samples": str(spec.samples)}


def as_part(name: str) -> str:
    """A name of the user's as a part of files' names."""
    return "".join("_" if mark in _FORBIDDEN else mark for mark in safe_name(name))


def _shown(text: str) -> str:
    return f'"{printable(text)}"'
