# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a specification has to know of the ways to store a bake: default sizes, and the options of each.

Files, costs, captures and previews of each way are in the folder `forms`.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class FormTraits:
    """Facts about one way to store a bake.

    `layout` is its name in the sidecar, `title` the one in messages. `cells`: the default bucket size;
    `border`: pixels around a bucket, both sides together. `channels`: of a cell while it is baked, None for
    light and its layers. `streams`: cells lie on disk during the bake, unless an earlier atlas is read.
    `by_paths`: fitted to single paths, whose number does not depend on the cells. Options: a `source`,
    single `lamps`, a `shared_atlas`, `layers`, `accumulates`, a `farm`, the `panoramic` capture, and a limit
    of size or quality (`condenses`).
    """

    layout: str
    title: str
    cells: int = 8
    border: int = 0
    channels: int | None = None
    streams: bool = True
    by_paths: bool = False
    source: bool = True
    lamps: bool = True
    shared_atlas: bool = True
    layers: bool = True
    accumulates: bool = True
    farm: bool = True
    panoramic: bool = True
    condenses: bool = False


def _shared(title: str, cells: int) -> FormTraits:
    return FormTraits(
        layout="shared",
        title=title,
        cells=cells,
        border=2,
        streams=False,
        by_paths=True,
        source=False,
        lamps=False,
        shared_atlas=False,
        layers=False,
        accumulates=False,
        farm=False,
        panoramic=False,
        condenses=True,
    )


BUCKETS = FormTraits("buckets", "layout buckets")
BITS = FormTraits("buckets", "bits", channels=1, panoramic=False)
AMBIENT = FormTraits("buckets", "ambient occlusion", channels=1, panoramic=False)
# 9 cells: odd, so that the creases of octahedral maps run through the middles of cells.
SPHERE = FormTraits("sphere", "spheres", cells=9, streams=False, panoramic=False)
SHARED = _shared("the shared layout", cells=16)
# 14 cells: with its border a bucket is 16 pixels wide, whole blocks of a compressed texture.
CONDENSED = _shared("the shared layout", cells=14)
