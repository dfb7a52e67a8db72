# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Preflight checks: the memory that a bake's images take in a report or a render, beside Blender's own."""

from __future__ import annotations

from collections.abc import Iterable

from ..formats.disk.memory import check_allowed
from ..formats.sidecar_file import AnySidecar, opened
from ..forms import form_in

_JUDGED = 16  # bytes per pixel while a report reads the images
_SHOWN = 28  # bytes per pixel in Blender and Cycles together


def check_judged(sidecar: AnySidecar, allowed_mb: int | None) -> None:
    """Make sure that a report fits into memory. Raises as `check_allowed` does, and FormatError."""
    file = opened(sidecar)
    needed = _pixels(file) * _JUDGED
    check_allowed(f"a report on {sidecar}", needed, allowed_mb)


def check_shown(sidecars: Iterable[AnySidecar], allowed_mb: int | None) -> None:
    """Make sure that a render of bakes fits into memory. Raises as `check_allowed` does, and FormatError."""
    named = tuple(sidecars)
    needed = sum(_pixels(sidecar) for sidecar in named) * _SHOWN
    check_allowed(f"a picture of {', '.join(map(str, named))}", needed, allowed_mb)


def _pixels(sidecar: AnySidecar) -> int:
    """The number of pixels in a bake's images, without its extra layers."""
    file = opened(sidecar)
    shapes = form_in(file.facts).shapes(file)
    return sum(width * height for width, height, _ in shapes.values())
