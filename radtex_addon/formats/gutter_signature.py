# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Per-texel values of a stored bake, whose gutter shows which UV layer it was baked with."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..core.arrays import Floats
from ..core.shared import SharedAtlas
from .condensed_files import read_texture
from .containers.exr import Compression, stored_compression
from .image_files import layer_path
from .packing import IRRADIANCE, WEIGHTS
from .shared_files import texture_path
from .shared_sidecar import SharedSidecar

_DWAA, _BC6H = 0.05, 0.1  # with 0.1 for BC6H the right UV layer's gutter agrees by 90 %, a wrong one's by 83


def loss_of(compression: Compression | None) -> float:
    """Largest relative difference that lossy compression makes between two equal values."""
    return _DWAA if compression is Compression.DWAA else 0.0


def own_texels(path: Path, atlas: SharedAtlas, sidecar: SharedSidecar) -> tuple[Floats, float]:
    """Per-texel values (H, W, K) in the bake of `read_shared(path)`, and their `loss_of`.

    For a condensed bake with lobes that is a label, equal for texels with the same mixtures; otherwise the
    irradiance, or the ends of a lobe if nothing is diffuse and the irradiance is the same everywhere. Raises
    FormatError for files that cannot be read.
    """
    if sidecar.condensed is not None:
        return (_mixtures(path, sidecar), 0.0) if sidecar.lobes else (atlas.irradiance, _BC6H)
    if atlas.lobes and np.ptp(atlas.irradiance.reshape(-1, 3), axis=0).max() == 0:
        return atlas.lobes[0].ends.reshape(
            *atlas.irradiance.shape[:2], -1
        ), 0.0  # ends are stored without loss
    return atlas.irradiance, loss_of(stored_compression(layer_path(path, IRRADIANCE)))


def _mixtures(path: Path, sidecar: SharedSidecar) -> Floats:
    """A label (H, W, 1) for each texel, equal where the weights and clusters of all lobes are equal."""
    bake = sidecar.bake
    stored = [
        read_texture(texture_path(path, layer), layer, width, height).reshape(bake.height, bake.width, -1)
        for layer, (width, height, _) in sidecar.shapes.items()
        if layer.endswith(WEIGHTS)
    ]
    every = np.concatenate(stored, axis=2)
    _, number = np.unique(every.reshape(-1, every.shape[2]), axis=0, return_inverse=True)
    return number.reshape(bake.height, bake.width, 1).astype(np.float32)
