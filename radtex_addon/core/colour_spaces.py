# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The linear working spaces of .blend files, and their conversion to Rec.709."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .arrays import Floats

REC_709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)  # x, y of red, green, blue, white
LUMINANCE = np.array([0.2126, 0.7152, 0.0722], dtype=np.float32)  # of Rec.709
_CHROMATICITIES = {  # x, y of red, green, blue, white
    "lin_rec709_scene": REC_709,
    "lin_rec2020_scene": (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290),
    "lin_ap1_scene": (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767),  # ACEScg
}
KNOWN = frozenset(_CHROMATICITIES)
_BRADFORD = np.array([(0.8951, 0.2664, -0.1614), (-0.7502, 1.7135, 0.0367), (0.0389, -0.0685, 1.0296)])


def matrix_to_rec709(space: str) -> Floats:
    """(3, 3) float32 from colours of one of the KNOWN spaces to Rec.709; white stays white.

    By SMPTE RP 177 from the primaries, with Bradford adaptation of the white point, as in OpenColorIO.
    """
    source, white = _to_xyz(_CHROMATICITIES[space])
    target, wanted = _to_xyz(REC_709)
    adapted = np.linalg.solve(_BRADFORD, np.diag(_BRADFORD @ wanted / (_BRADFORD @ white)) @ _BRADFORD)
    return np.linalg.solve(target, adapted @ source).astype(np.float32)


def converted(colours: Floats, matrix: Floats | None) -> Floats:
    """Colours (..., 3) multiplied by a matrix (3, 3), or unchanged if it is None."""
    if matrix is None:
        return colours
    # channel by channel: a matrix product may round a colour differently depending on the number of colours
    red, green, blue = np.moveaxis(colours, -1, 0)
    mixed = [row[0] * red + row[1] * green + row[2] * blue for row in matrix.astype(colours.dtype)]
    return np.stack(mixed, axis=-1)


def _to_xyz(chromaticities: tuple[float, ...]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """The matrix from RGB to XYZ, and the white's XYZ."""
    x, y = np.array(chromaticities, dtype=np.float64).reshape(4, 2).T
    xyz = np.stack([x / y, np.ones(4), (1 - x - y) / y])
    white = xyz[:, 3]
    return xyz[:, :3] * np.linalg.solve(xyz[:, :3], white), white
