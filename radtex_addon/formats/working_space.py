# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The colour space in which Blender wrote a render.

A .blend works in linear Rec.709, or from Blender 5 on in Rec.2020 or ACEScg. Pictures of one layer are
converted when Blender writes them, those of several layers are not; each part says what its values are.
"""

from __future__ import annotations

from pathlib import Path

from ..core.arrays import Floats
from ..core.colour_spaces import KNOWN, matrix_to_rec709
from ..core.errors import FormatError
from .exr import headers_of

_ATTRIBUTE = "colorInteropID"  # Blender 5's; earlier ones work in Rec.709
_NO_COLOUR = "data"


def render_matrix(path: Path) -> Floats | None:
    """From the colours in a picture that Blender rendered to Rec.709, (3, 3); None where they are that.

    Raises FormatError for a file that is no EXR, or whose colours are of a space that is not known.
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
