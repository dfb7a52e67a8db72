# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How much memory an export takes, beside Blender itself, estimated from what the sidecar says."""

from __future__ import annotations

from pathlib import Path

from ..formats.json_reader import Facts
from ..formats.shadow_files import KIND as SHADOW
from ..formats.shared_files import expanded_bytes, read_shared_sidecar
from ..formats.shared_sidecar import LAYOUT as SHARED
from ..formats.sidecar import read_sidecar
from ..formats.transfer_files import LAYOUT as SPHERE
from ..formats.transfer_files import read_transfer_sidecar

_LEAST = 192 * 2**20  # of any export: a few bands of rows, the mesh, its file
_TEXEL = 80  # bytes of one, for the flat lightmap and what finds it out to be of this mesh
_PIXEL = 16  # bytes of one: four floats
_WHOLE = 3  # copies of an image that is read whole


def needed_bytes(sidecar: Path, facts: Facts) -> int:
    """The most memory that an export of the bake with this sidecar takes, whose `facts` are known.

    Raises FormatError for a sidecar that cannot be read.
    """
    if facts.text("layout") == SHARED:
        shared = read_shared_sidecar(sidecar)
        values = sum(width * height * channels for width, height, channels in shared.shapes.values())
        expanded = expanded_bytes(shared) if shared.condensed is not None else 0
        return _LEAST + _WHOLE * (values * _PIXEL // 4 + expanded)
    if facts.text("layout") == SPHERE:
        stored = read_transfer_sidecar(sidecar).stored
        return _LEAST + _WHOLE * stored.pixel_width * stored.pixel_height * _PIXEL
    bake = read_sidecar(sidecar)
    texels = bake.width * bake.height
    if bake.kind == SHADOW:
        return _LEAST + _WHOLE * texels * bake.bucket**2 * _PIXEL // 4
    return _LEAST + _TEXEL * texels
