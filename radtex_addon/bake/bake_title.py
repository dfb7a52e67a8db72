# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What people read of which bake is meant."""

from __future__ import annotations

from collections.abc import Sequence


def bake_title(name: str, *, part: str = "", kind: str = "", variant: str = "") -> str:
    """The object's or the atlas's name, and what tells its bakes apart: empty ones are left out."""
    return ", ".join(word for word in (name, part, kind, variant) if word)


def variant_title(frame: int | None, lights: Sequence[str]) -> str:
    """The frame and the lamps of a bake; empty if it is no variant."""
    words = [] if frame is None else [f"frame {frame}"]
    if lights:
        words.append(f"light of {', '.join(lights)}")
    return ", ".join(words)
