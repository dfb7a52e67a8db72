# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The colour space in which Blender wrote a render.

A .blend works in linear Rec.709, or from Blender 5 on also in Rec.2020 or ACEScg. Blender converts images of
one layer when it writes them, but not multilayer images; each part's header names its colour space.
"""

from __future__ import annotations

from pathlib import Path

from ..core.arrays import Floats
from ..core.colour_spaces import KNOWN, matrix_to_rec709
from ..core.errors import FormatError
from .containers.exr import headers_of

_ATTRIBUTE = "colorInteropID"  # Blender 5's; earlier ones work in Rec.709
_NO_COLOUR = "data"


def render_matrix(path: Path) -> Floats | None:
    """Matrix (3, 3) from the colours of an image that Blender rendered to Rec.709; None if they are Rec.709.

    Raises FormatError for a file that is no EXR, and for an unknown colour space or a mixture of several.
    """
    named = {str(header.get(_ATTRIBUTE, "")) for header in headers_of(path)} - {_NO_COLOUR, ""}
    if unknown := named - KNOWN:
        raise FormatError(
            f"{path} holds colours of the space '{min(unknown)}', which RadTex does not know: let the "
            ".blend work in Linear Rec.709, Linear Rec.2020 or ACEScg"
        )
    if len(named) > 1:
        raise FormatError(f"{path} mixes colours of {' and '.join(sorted(named))}: render it again")
    space = next(iter(named), "lin_rec709_scene")
    return None if space == "lin_rec709_scene" else matrix_to_rec709(space)
