# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The open file's working colour space: since Blender 5 linear Rec.709, Rec.2020 or ACEScg."""

from __future__ import annotations

from typing import Any, cast

import bpy
import numpy as np
from mathutils import Color

from ..core.colour_spaces import KNOWN
from ..core.errors import InputError

REC_709 = "Linear Rec.709"  # Blender's name, also of image colour spaces

Colour = tuple[float, float, float]


def working_space() -> str:
    """Blender's name of the working space; REC_709 before Blender 5."""
    found = _settings()
    return REC_709 if found is None else str(found.working_space)


def check_working_space() -> None:
    """Raise InputError if RadTex cannot convert from the working space, such as a custom OpenColorIO one."""
    found = _settings()
    if found is not None and found.working_space_interop_id not in KNOWN:
        raise InputError(
            f"the file works in the colour space '{found.working_space}', which RadTex does not know: choose "
            "Linear Rec.709, Linear Rec.2020 or ACEScg (Render Properties > Color Management > Working Space)"
        )


def rec709_primaries() -> tuple[Colour, Colour, Colour]:
    """Rec.709's red, green and blue as colours in the working space.

    If that is Rec.709 they are exact: Blender's conversion rounds, and a bright channel would visibly add to
    a dark one.
    """
    exact = working_space() == REC_709
    red, green, blue = (tuple(row.tolist()) if exact else _from_rec709(row) for row in np.eye(3))
    return red, green, blue


def _from_rec709(colour: Any) -> Colour:
    found = Color(colour.tolist()).from_rec709_linear_to_scene_linear()
    return float(found.r), float(found.g), float(found.b)


def _settings() -> Any:
    return getattr(cast(Any, bpy.data), "colorspace", None)  # Blender 5
