# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Clear thick glass: a tumbler."""

from __future__ import annotations

import numpy as np

from .materials import assign, principled
from .meshes import as_subject, lathe, mesh_object, smooth_curve
from .stage import Stage, finish, start


def thick_glass() -> Stage:
    """A tumbler with a bottom a third as high as itself, of index of refraction 1.5, perfectly smooth."""
    start("courtyard.exr", strength=0.8, turn=160)
    outer = [(0.05, -0.8), (0.5, -0.8), (0.6, -0.77), (0.64, -0.68), (0.68, 0.0), (0.74, 0.7)]
    inner = [(0.74, 0.77), (0.7, 0.79), (0.66, 0.76), (0.57, 0.0), (0.5, -0.3), (0.35, -0.38), (0.05, -0.4)]
    profile = smooth_curve(np.array([*outer, *inner]))
    tumbler = as_subject(mesh_object("Tumbler", *lathe(profile, segments=96, tip=0.0), smooth=True))
    assign(tumbler, principled("Glass", (1, 1, 1), Transmission_Weight=1.0, IOR=1.5, Roughness=0.0))
    return finish("thick_glass", tumbler)
