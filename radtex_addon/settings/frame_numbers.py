# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of an animation: parse lists of them, and make a specification for each."""

from __future__ import annotations

import re
from dataclasses import replace

from ..core.errors import InputError
from .spec import BakeSpec

_MOST = 100_000  # in one range


def parse_frames(words: str) -> tuple[int, ...]:
    """The frames in a list such as 1,5,10-20, in its order, without duplicates. Raises InputError."""
    frames: list[int] = []
    for word in words.split(","):
        found = re.fullmatch(r"\s*(\d+)(?:-(\d+))?\s*", word)
        first, last = (int(found[1]), int(found[2] or found[1])) if found else (0, -1)
        if not first <= last < first + _MOST:
            raise InputError(f"frames {words}: give frames' numbers, such as 1,5,10-20")
        frames += range(first, last + 1)
    return tuple(dict.fromkeys(frames))


def of_frames(spec: BakeSpec, frames: tuple[int, ...]) -> tuple[BakeSpec, ...]:
    """The specification of each frame's bake.

    Several frames share the unwrap of the first, unless `spec` names a UV layer or the frame to unwrap at.
    Raises InputError for a frame outside Blender's range.
    """
    unwrap_at = spec.unwrap_at
    if unwrap_at is None and len(frames) > 1 and spec.uv_layer is None:
        unwrap_at = frames[0]
    return tuple(replace(spec, frame=frame, unwrap_at=unwrap_at) for frame in frames)
