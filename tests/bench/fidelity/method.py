# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the bench measures: ways to bake an object and to look its radiance up."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import bpy
import numpy.typing as npt

from radtex_addon.report.gbuffer import Array, GBuffer

from .scenes import Stage


@dataclass(frozen=True, eq=False)
class Baked:
    """A baked object, ready to be looked at.

    `paths` and `seconds` say what the bake took, `bytes` what a GPU holds of it; `radiance` gives the light
    (N, 3), linear, along a G-buffer's rays, anything where they miss. `mesh` is the baked copy's,
    `matrix_world` its matrix, `uv_layer` the layer that was baked. With an `alpha`, which gives how much is
    hidden of what lies behind, (N,), radiance is premultiplied by that; without, it is of all that is seen.
    """

    paths: int
    seconds: float
    bytes: int
    radiance: Callable[[GBuffer], Array]
    mesh: bpy.types.Mesh
    matrix_world: npt.ArrayLike
    uv_layer: str
    alpha: Callable[[GBuffer], Array] | None = None


class Method(Protocol):
    """A way to bake: `bake` may write into `folder`, and leaves the stage's scene as it was."""

    @property
    def name(self) -> str: ...

    def bake(self, stage: Stage, folder: Path) -> Baked: ...
