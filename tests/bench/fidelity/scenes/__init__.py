# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes to measure bakes by, each with cameras to tune on and cameras that no choice is tuned on.

Everywhere coloured things stand beside the object, seen reflected with parallax, under an HDRI that Blender
ships; a patterned floor lies close below it.
"""

from __future__ import annotations

from collections.abc import Callable

from .meshes import SUBJECT
from .seven import SEVEN
from .stage import PIXELS, Stage

__all__ = ["PIXELS", "SCENES", "SUBJECT", "Stage"]

SCENES: dict[str, Callable[[], Stage]] = SEVEN
