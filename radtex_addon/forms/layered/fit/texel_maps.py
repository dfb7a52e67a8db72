# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What maps of the material say of texels, and whether they are worth a texture."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

import numpy as np

from ....bake.plan import CapturePlan
from ....core import large_arrays
from ....core.arrays import Floats, Ints

_ROWS = 64  # of a map, in hand at once
_VARIES = 0.02  # standard deviation of the tint, above which it is kept
_TURNED = 2.0  # degrees between shading normals and the mesh's, in one texel of ten, from which they are kept


def shading_normals(
    plan: CapturePlan, fine: Mapping[str, Floats], coarse: Mapping[str, Floats], wanted: bool
) -> tuple[Floats, Floats | None]:
    """The texels' shading normals (K, 3), and their map (H', W', 3) where they are not the mesh's own.

    `fine` and `coarse` as in `Capture`; if they are not `wanted`, the mesh's.
    """
    mesh = plan.normals.astype(np.float32)
    found = coarse["normal"].reshape(-1, 3)[plan.texel].astype(np.float32)
    length = np.linalg.norm(found, axis=1, keepdims=True)
    found /= np.maximum(length, 1e-6)
    usable = (length[:, 0] > 0.5) & ((found * mesh).sum(axis=1) > 0)
    found = np.where(usable[:, None], found, mesh)
    turned = np.degrees(np.arccos(np.clip((found * mesh).sum(axis=1), -1, 1)))
    if not wanted or np.percentile(turned, 90) < _TURNED:
        return mesh, None
    return found, large_arrays.as_type(fine["normal"], np.float32)


def tints(
    plan: CapturePlan, material: Ints, fine: Mapping[str, Floats], coarse: Mapping[str, Floats], wanted: bool
) -> tuple[Floats, Floats | None]:
    """How glossy colours differ from the mean of their `material` (K,): of the texels (K, 3), and a map.

    The map (H', W', 3) is None where they do not differ, or are not `wanted`. Each of its texels is over the
    mean of its own material, which may be another one than that of the nearest coarse texel.
    """
    glossy = coarse["glossy"].reshape(-1, 3)[plan.texel].astype(np.float32)
    means = mean_colours(material, coarse["glossy"], plan, int(fine["material"].max()) + 1)
    tint = glossy / means[material]
    if not wanted or float(tint.std(axis=0).max()) < _VARIES:
        return np.ones_like(glossy), None

    def over_mean(some: slice) -> Floats:
        number = fine["material"][some, :, 0].astype(np.intp)
        found: Floats = (fine["glossy"][some] / means[number]).astype(np.float32)
        return found

    return tint, large_arrays.from_blocks(len(fine["glossy"]), over_mean, _ROWS)


def at_texels(image: Floats | None, plan: CapturePlan) -> Floats | None:
    """A map (H, W, C) at the plan's texels, (K, C) float32; None without one."""
    return None if image is None else image.reshape(-1, image.shape[2])[plan.texel].astype(np.float32)


def mean_colours(material: Ints, glossy: Floats, plan: CapturePlan, least: int = 0) -> Floats:
    """The mean glossy colour of each material, of the map `glossy` (H, W, 3): (M, 3), 1 without texels.

    `material` (K,) is that of the plan's texels; M is at `least` so much.
    """
    colour = glossy.reshape(-1, 3)[plan.texel].astype(np.float32)
    means = np.ones((max(int(material.max()) + 1, least), 3), dtype=np.float32)
    for number in np.unique(material):
        means[number] = np.maximum(colour[material == number].mean(axis=0), 1e-3)
    return means


def texel_middles(plan: CapturePlan) -> Floats:
    """The texture coordinates of a plan's texels, (K, 2) float32."""
    row, column = np.divmod(plan.texel, plan.layout.width)
    middles = np.stack([(column + 0.5) / plan.layout.width, (row + 0.5) / plan.layout.height], axis=1)
    return cast(Floats, middles.astype(np.float32))
