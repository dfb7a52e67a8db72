# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The colour space in which Blender wrote a render, and how its colours become Rec.709.

A .blend works in linear Rec.709, or from Blender 5 on in Rec.2020 or ACEScg. Pictures of one layer are
converted when Blender writes them, those of several layers are not; each part says what its values are.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from ..core.arrays import Floats
from ..core.errors import FormatError
from .exr import REC_709, headers_of

_ATTRIBUTE = "colorInteropID"  # Blender 5's; earlier ones work in Rec.709
_NO_COLOUR = "data"
_CHROMATICITIES = {  # x, y of red, green, blue, white
    "lin_rec709_scene": REC_709,
    "lin_rec2020_scene": (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290),
    "lin_ap1_scene": (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767),  # ACEScg
}
KNOWN = frozenset(_CHROMATICITIES)
_BRADFORD = np.array([(0.8951, 0.2664, -0.1614), (-0.7502, 1.7135, 0.0367), (0.0389, -0.0685, 1.0296)])


def matrix_to_rec709(space: str) -> Floats:
    """(3, 3) float32 from colours of one of the KNOWN spaces to Rec.709; white stays white.

    By SMPTE RP 177 from the primaries, and Bradford's adaptation between whites, as OpenColorIO has it.
    """
    source, white = _to_xyz(_CHROMATICITIES[space])
    target, wanted = _to_xyz(REC_709)
    adapted = np.linalg.solve(_BRADFORD, np.diag(_BRADFORD @ wanted / (_BRADFORD @ white)) @ _BRADFORD)
    return np.linalg.solve(target, adapted @ source).astype(np.float32)


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


def converted(colours: Floats, matrix: Floats | None) -> Floats:
    """Colours (..., 3) by a matrix (3, 3); None leaves them as they are."""
    if matrix is None:
        return colours
    # channel by channel: what a matrix product makes of a colour may depend on how many there are
    red, green, blue = np.moveaxis(colours, -1, 0)
    mixed = [row[0] * red + row[1] * green + row[2] * blue for row in matrix.astype(colours.dtype)]
    return np.stack(mixed, axis=-1)


def _to_xyz(chromaticities: tuple[float, ...]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """The matrix from RGB to XYZ, and the white's XYZ."""
    x, y = np.array(chromaticities, dtype=np.float64).reshape(4, 2).T
    xyz = np.stack([x / y, np.ones(4), (1 - x - y) / y])
    white = xyz[:, 3]
    return xyz[:, :3] * np.linalg.solve(xyz[:, :3], white), white
