# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Check a UV layer of the user's to bake on: every texel must belong to one place of the surface."""

from __future__ import annotations

import logging

import numpy as np

from ...core.arrays import Floats, Ints
from ...core.errors import InputError
from ...core.islands import areas_on_surface, find_overlap, signed_areas, uv_islands, weld
from ...core.messages import Setting, do, leave_out
from ...core.texel_map import triangle_of_texels
from ..mesh.evaluated import EvaluatedMesh

log = logging.getLogger(__name__)

_WASTEFUL = 0.5  # of the atlas: a layer that covers less would waste most texels
_OUTSIDE = 1e-5  # how far outside 0..1 counts as rounding
_NO_AREA = 1e-12  # of the unit square
_TOLERATED = 1e-3  # share of the surface without area in uv; share of the covered area that is covered twice


def user_uv(evaluated: EvaluatedMesh, layer: str) -> Floats:
    """The coordinates of the UV layer called `layer`, checked: (F, 3, 2) float32 in 0..1, v up.

    Raises InputError for a layer that is missing, empty, outside 0..1 or not finite, that overlaps (how much
    and where) or leaves part of the surface without area. A few triangles without area, or slivers that
    overlap, pass with a warning.
    """
    if layer not in evaluated.uv_layers:
        known = " or ".join(f"'{name}'" for name in evaluated.uv_layers)
        remedy = do(f"choose {known}") if known else leave_out(Setting.UV, to="to have one made")
        raise InputError(f"object '{evaluated.name}' has no UV layer '{layer}' in renders", remedy)
    uv = evaluated.uv(layer)
    where = f"UV layer '{layer}' of object '{evaluated.name}'"
    if not np.isfinite(uv).all():
        raise InputError(f"{where} has coordinates that are not finite: unwrap it anew")
    _check_area(evaluated, uv, where)
    _check_bounds(uv, where)
    check_apart(uv, where)
    return np.clip(uv, 0.0, 1.0)


def why_unfit(evaluated: EvaluatedMesh, layer: str, texels: int, padding: int) -> str | None:
    """Why a UV layer that nobody named is not fit to bake `texels` x `texels` on; None if it is fit.

    It is where `user_uv` takes it without a warning, its islands are `padding` texels apart, and the atlas
    is not mostly empty. What is returned goes on after "it …".
    """
    uv = evaluated.uv(layer).astype(np.float64)
    area = np.abs(signed_areas(uv))
    if not np.isfinite(uv).all() or (area < _NO_AREA).any():
        return "gives some triangles no area"
    if uv.min() < -_OUTSIDE or uv.max() > 1 + _OUTSIDE:
        return "reaches outside 0..1"
    if area.sum() < _WASTEFUL:
        return f"covers only {area.sum():.0%} of the atlas"
    if find_overlap(uv).fraction > 0:
        return "overlaps"
    triangle = triangle_of_texels(uv, texels, texels)
    island = uv_islands(weld(evaluated.position)[evaluated.triangles], uv)
    if _closest(np.where(triangle >= 0, island[triangle], -1), padding):
        return f"has islands that are less than {padding} of {texels} texels apart"
    return None


def _closest(island: Ints, padding: int) -> bool:
    """Whether texels (H, W) of two islands lie so close that fewer than `padding` texels are between them."""
    height, width = island.shape
    for down in range(padding + 1):
        for right in range(-padding if down else 1, padding + 1):
            one = island[: height - down, max(-right, 0) : width - max(right, 0)]
            other = island[down:, max(right, 0) : width - max(-right, 0)]
            if ((one >= 0) & (other >= 0) & (one != other)).any():
                return True
    return False


def _check_area(evaluated: EvaluatedMesh, uv: Floats, where: str) -> None:
    lost = np.abs(signed_areas(uv.astype(np.float64))) < _NO_AREA
    if lost.all():
        raise InputError(f"{where} is empty (no triangle has area)", do("unwrap it"), leave_out(Setting.UV))
    surface = areas_on_surface(evaluated.world_position, evaluated.triangles)
    if not surface.any():
        raise InputError(f"object '{evaluated.name}' has faces, but no area to bake: give it a size")
    share = float(surface[lost].sum() / surface.sum())
    if share > _TOLERATED:
        raise InputError(
            f"{where} gives no area to {np.count_nonzero(lost)} of {len(lost)} triangles,"
            f" {share:.1%} of the surface: unwrap those faces"
        )
    if lost.any():
        log.warning("%s gives no area to %d of %d triangles", where, np.count_nonzero(lost), len(lost))


def _check_bounds(uv: Floats, where: str) -> None:
    low, high = uv.min(axis=(0, 1)), uv.max(axis=(0, 1))
    if low.min() < -_OUTSIDE or high.max() > 1 + _OUTSIDE:
        raise InputError(
            f"{where} reaches outside 0..1, from ({low[0]:.3g}, {low[1]:.3g}) to"
            f" ({high[0]:.3g}, {high[1]:.3g})",
            do("pack its islands into the unit square"),
            do("bake tile by tile", Setting.SPLIT, value="udim"),
        )


def check_apart(uv: Floats, where: str) -> None:
    """Raise InputError if uv triangles (F, 3, 2) overlap; of slivers only warn. `where` names the layer."""
    overlap = find_overlap(uv)
    if overlap.fraction == 0:
        return
    u, v = overlap.worst_uv
    found = f"overlaps in {overlap.fraction:.2%} of its area, worst at uv ({u:.3f}, {v:.3f})"
    if overlap.fraction > _TOLERATED:
        raise InputError(f"{where} {found}, {overlap.depth} triangles deep: separate its islands")
    log.warning("%s %s: those texels show one of the places", where, found)
