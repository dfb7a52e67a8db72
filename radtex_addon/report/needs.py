# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How much memory it takes to judge a bake or to show it, beside Blender: its images lie in it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ..formats.disk.memory import check_allowed
from ..formats.sidecar import read_facts
from ..forms import form_in

_JUDGED = 16  # bytes of a pixel, while a report reads it
_SHOWN = 28  # as Blender has it, and Cycles beside


def check_judged(sidecar: Path, allowed_mb: int | None) -> None:
    """Make sure that a bake may be read for a report. Raises as `check_allowed` does, and FormatError."""
    needed = _pixels(sidecar) * _JUDGED + form_in(read_facts(sidecar)).expanded_bytes(sidecar)
    check_allowed(f"a report on {sidecar}", needed, allowed_mb)


def check_shown(sidecars: Iterable[Path], allowed_mb: int | None) -> None:
    """Make sure that Cycles may render bakes. Raises as `check_allowed` does, and FormatError."""
    named = tuple(sidecars)
    needed = sum(_pixels(sidecar) for sidecar in named) * _SHOWN
    check_allowed(f"a picture of {', '.join(map(str, named))}", needed, allowed_mb)


def _pixels(sidecar: Path) -> int:
    """Those of a bake's images, its layers left out."""
    shapes = form_in(read_facts(sidecar)).shapes(sidecar)
    return sum(width * height for width, height, _ in shapes.values())
