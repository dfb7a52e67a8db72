# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Make reStructuredText of docstrings, which are plain text with names between backticks and lists."""

from __future__ import annotations

import re
from enum import Enum
from typing import Any

from sphinx.application import Sphinx

_NAME = re.compile(r"`([^`]+)`")
_SPECIAL = re.compile(r"([\\*|_])")
_ITEM = re.compile(r"^(\s*)\\\* ", re.MULTILINE)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension; called by Sphinx."""
    app.setup_extension("sphinx.ext.autodoc")
    app.connect("autodoc-process-docstring", _process)
    app.connect("autodoc-process-signature", _sign)
    return {"parallel_read_safe": True}


def _process(_app: Sphinx, _what: str, _name: str, _of: object, _options: Any, lines: list[str]) -> None:
    lines[:] = restructured("\n".join(lines)).split("\n")


def _sign(
    _app: Sphinx,
    _what: str,
    _name: str,
    of: object,
    _options: Any,
    arguments: str | None,
    returned: str | None,
) -> tuple[str | None, str | None]:
    """Leave out what an enum is called with: its members say that."""
    return ("", None) if isinstance(of, type) and issubclass(of, Enum) else (arguments, returned)


def restructured(text: str) -> str:
    """A docstring as reStructuredText of as many lines."""
    parts = _NAME.split(text)  # every other one is code
    shown = (f"\\ ``{part}``\\ " if k % 2 else _SPECIAL.sub(r"\\\1", part) for k, part in enumerate(parts))
    return _ITEM.sub(r"\1* ", "".join(shown))
