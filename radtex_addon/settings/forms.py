# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of forms, the ways to store a bake: the default sizes and options that specifications need.

Everything else about a form, such as its files, capture and preview, is in the folder `forms`.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class FormTraits:
    """One row: facts about a form.

    * `name`: unique, also that of the form's folder; `layout`: as in sidecars; `title`: for messages.
    * `cells`: the default bucket size.
    * `channels`: of a cell while it is baked; None for light and its layers.
    * `streams`: cells are on disk during the bake, unless an earlier atlas is read.
    * `by_paths`: fitted to single paths, whose number does not depend on the cells.
    * Options that it can be baked with: `layers`, `accumulates`, `accumulates_parts` of the surface alone,
      `refreshes`, a `farm`, the `panoramic` capture, and `any_cells`.
    * Of its textures: `bits` in whole numbers; `arranges`: an export may choose arrangement and mip levels.
    * `backs`: faces that are seen from behind get texels of their own.
    """

    name: str
    layout: str
    title: str
    cells: int = 8
    channels: int | None = None
    streams: bool = True
    by_paths: bool = False
    layers: bool = True
    accumulates: bool = True
    refreshes: bool = True
    accumulates_parts: bool = True
    farm: bool = True
    panoramic: bool = True
    any_cells: bool = True
    bits: bool = False
    arranges: bool = True
    backs: bool = False


BUCKETS = FormTraits("buckets", "buckets", "layout buckets")
BITS = FormTraits("bits", "buckets", "bits", channels=1, panoramic=False, bits=True, arranges=False)
AMBIENT = FormTraits("ambient", "buckets", "ambient occlusion", channels=1, panoramic=False)
# 9 cells: odd, so that the creases of octahedral maps run through the middles of cells.
SPHERE = FormTraits(
    name="sphere",
    layout="sphere",
    title="spheres",
    cells=9,
    streams=False,
    layers=False,
    panoramic=False,
    arranges=False,
)
LAYERED = FormTraits(
    name="layered",
    layout="layered",
    title="the layered layout",
    cells=14,
    streams=False,
    by_paths=True,
    layers=False,
    refreshes=False,
    accumulates_parts=False,
    farm=False,
    panoramic=False,
    arranges=False,
    any_cells=False,
    backs=True,
)

# Why a form whose bakes can be accumulated is not refreshed; measured by `tests.bench.refreshing`.
NOT_REFRESHED = "since a few paths miss texels that show a change, and to bake those alone saves little time"

FORMS = (BUCKETS, BITS, AMBIENT, SPHERE, LAYERED)


def has_light_layers(layout: str) -> bool:
    """Whether "layers" in a sidecar with this layout lists light layers, not images of the form itself."""
    return any(form.layout == layout and form.layers for form in FORMS)
