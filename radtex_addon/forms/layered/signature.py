# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of single texels, whose gutter shows which UV layer a layered bake is of."""

from __future__ import annotations

from pathlib import Path

from ...core.arrays import Floats
from ...formats.containers.exr import loss_of, stored_compression
from ...formats.image_files import layer_path
from .files.arrangement import IRRADIANCE
from .lookup.atlas import LayeredAtlas


def own_texels(path: Path, atlas: LayeredAtlas) -> tuple[Floats, float]:
    """Values (H, W, K) of the texels of the bake with the sidecar `path`, and their largest relative loss.

    The irradiance; where nothing is diffuse, and it is the same everywhere, the buckets of fewer texels.
    """
    if (atlas.irradiance != atlas.irradiance[0, 0]).any():
        return atlas.irradiance, loss_of(stored_compression(layer_path(path, IRRADIANCE)))
    return atlas.own.reshape(*atlas.own.shape[:2], -1), 0.0
