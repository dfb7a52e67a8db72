# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Capture radiance together with its light passes, from the same paths."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np

from ..bake.layers import Layer, captured
from ..bake.plan import CapturePlan, Tile
from ..core.arrays import Floats
from ..settings.kinds import Kind
from .capture_settings import keep_passes
from .passes import attributes_of, light_of
from .portal import PortalCapture


class PassesCapture:
    """Captures a kind of radiance in a scratch scene, with the passes that layers are made of."""

    def __init__(
        self,
        scene: bpy.types.Scene,
        plan: CapturePlan,
        kind: Kind,
        layers: Sequence[Layer],
        samples: int,
        seed: int,
        folder: Path,
        whole: bool = False,
    ) -> None:
        """Arguments as for `PortalCapture`; `layers` are the layers of the bake."""
        self._layers = captured(layers)
        self._portal = PortalCapture(scene, plan, kind, samples, seed, folder, whole=whole)
        keep_passes(scene, tuple(name for layer in self._layers for name in attributes_of(layer)))

    def render(self, tile: Tile) -> Floats:
        """Cells of the tile's texels as in `Capture.render`: RGBA, then three channels for each layer."""
        passes = self._portal.render_passes(tile)
        return np.concatenate([passes.whole, *(light_of(passes, layer) for layer in self._layers)], axis=-1)
