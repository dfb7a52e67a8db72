# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of the layered layout that a fit may leave out."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Parts:
    """Which parts of the layout are fitted: each may be left out, to see what it is worth."""

    own: bool = True
    rest: bool = True
    lamps: bool = True
    layers: bool = True
    tint: bool = True
    normals: bool = True
    second_lobe: bool = True
    widths: bool = True
    cells: bool = True
    smooth: bool = True


ALL_PARTS = Parts()
