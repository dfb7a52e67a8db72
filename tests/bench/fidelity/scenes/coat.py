# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An open pot: a rough base under a sharp coat, its dark inside seen through a groove below the lid."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from .materials import assign, colour_by, patches, principled
from .meshes import Faces, Vertices, as_subject, joined, lathe, mesh_object, smooth_curve
from .stage import Stage, finish, start

_RIM = 0.45  # height of the pot's rim
_GROOVE = 0.09  # between rim and lid


def coat() -> Stage:
    """A pot of mottled rough glaze under a sharp coat, its lid on three feet, in a room with windows."""
    start("interior.exr", strength=0.9, turn=150)
    pot = as_subject(mesh_object("Pot", *joined(_pot(), _lid(), *map(_foot, range(3))), smooth=True))
    glaze = principled("Glaze", (0.5, 0.1, 0.05), Roughness=0.5, Coat_Weight=1.0, Coat_Roughness=0.01)
    mottles = ((0.3, (0.03, 0.16, 0.15)), (0.47, (0.07, 0.3, 0.25)), (0.56, (0.45, 0.35, 0.2)))
    colour_by(glaze, patches(glaze.node_tree), mottles)
    assign(pot, glaze)
    return finish("coat", pot)


def _pot() -> tuple[Vertices, Faces]:
    """Outer wall, rim and inner wall down to the inner bottom: closed below, open above."""
    keys = np.array(
        [
            (0.05, -0.75), (0.45, -0.75), (0.56, -0.72), (0.72, -0.5), (0.85, -0.1), (0.8, 0.25), (0.72, 0.4),
            (0.73, 0.44), (0.71, _RIM), (0.68, 0.43), (0.69, 0.34), (0.75, 0.2), (0.78, -0.1), (0.66, -0.45),
            (0.5, -0.64), (0.3, -0.68), (0.05, -0.68),
        ]
    )  # fmt: skip
    return lathe(smooth_curve(keys), segments=88, tip=0.0)


def _lid() -> tuple[Vertices, Faces]:
    """A domed lid with a knob, wider than the pot's mouth."""
    keys = np.array(
        [
            (0.05, 0.0), (0.5, 0.0), (0.72, 0.0), (0.77, 0.02), (0.76, 0.06), (0.6, 0.13), (0.3, 0.21),
            (0.12, 0.24), (0.1, 0.28), (0.17, 0.36), (0.12, 0.43), (0.03, 0.45),
        ]
    )  # fmt: skip
    keys[:, 1] += _RIM + _GROOVE
    return lathe(smooth_curve(keys), segments=88, tip=0.0)


def _foot(number: int) -> tuple[Vertices, Faces]:
    """One of three studs between rim and lid."""
    low, high, radius = _RIM - 0.02, _RIM + _GROOVE + 0.02, 0.025
    vertices, faces = lathe(np.array([(radius, low), (radius, high)]), segments=12, tip=0.0)
    x, y = (0.705 * f(2 * pi * number / 3 + 0.4) for f in (cos, sin))
    return [(x + px, y + py, z) for px, py, z in vertices], faces
