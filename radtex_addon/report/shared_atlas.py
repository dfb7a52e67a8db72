# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface of several objects that share an atlas, from the preview that lies beside the bake."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np

from ..core.arrays import Floats, Ints
from ..core.errors import InputError
from ..core.gutter import LEAST_AGREEMENT
from ..core.messages import Setting, do
from ..prepare.faces import all_once, find_once
from ..scene.mesh.backs import fronts, twin_numbers
from ..scene.mesh.copy import OBJECT, face_numbers
from ..scene.mesh.evaluated import evaluate
from ..scene.objects import find_object
from ..scene.preview_file import baked_copy, surface_of
from .finished_bake import Finished
from .gbuffer import BakedSurface

_SAME = 1e-4  # of an object's size: how far its box may lie from that of its baked copy
_ANEW = do("bake it again with a preview", Setting.SAVE_PREVIEW)


@dataclass(frozen=True, eq=False)
class Parts:
    """The `names` of the objects that a surface is of, and whose each of its triangles is: `owner` (F,)."""

    names: tuple[str, ...]
    owner: Ints


def find_shared(scratch: bpy.types.Scene, bake: Finished) -> tuple[BakedSurface, Parts]:
    """The joined surface of the objects of a `bake`, which stand in a scratch scene as they were baked.

    Raises InputError if there is no preview, or if it or one of the objects is another than at the bake.
    """
    facts = bake.sidecar
    originals = [find_object(scratch, name) for name in facts.surfaces]
    with baked_copy(bake.preview, facts.surfaces, facts.uv_map) as (_, joined):
        whole = surface_of(joined, facts.uv_map)
        if bake.agreement(whole) < LEAST_AGREEMENT:
            raise InputError(f"{bake.preview} does not fit {bake.file}: it is of another bake", _ANEW)
        mesh = joined.data
        assert isinstance(mesh, bpy.types.Mesh)  # of baked copies
        surface = BakedSurface(mesh, np.eye(4), facts.uv_map)
        owner, twin = face_numbers(mesh, OBJECT), twin_numbers(mesh)
        own = np.ones(len(owner), dtype=bool) if twin is None else fronts(twin)
        corners = [
            whole.position[whole.triangles[own & (owner == number)]] for number in range(len(originals))
        ]
    _check_unchanged(scratch, originals, corners, bake)
    return surface, Parts(facts.surfaces, owner)


def _check_unchanged(
    scratch: bpy.types.Scene,
    originals: Sequence[bpy.types.Object],
    corners: Sequence[Floats],
    bake: Finished,
) -> None:
    """Raise InputError for an object that has more or fewer triangles than `corners` (F, 3, 3), or moved."""
    for original, there in zip(originals, corners, strict=True):
        mesh = evaluate(scratch, original)
        (mesh,) = all_once([mesh], [find_once(mesh)])
        here = mesh.world_position[mesh.triangles]
        size = float(np.ptp(here, axis=(0, 1)).max())
        if len(here) != len(there) or _apart(here, there) > _SAME * size:
            raise InputError(
                f"object '{original.name}' does not fit {bake.file}: it was changed since", _ANEW
            )


def _apart(one: Floats, other: Floats) -> float:
    """How far the boxes around two sets of corners (F, 3, 3) lie apart."""
    low = np.abs(one.min(axis=(0, 1)) - other.min(axis=(0, 1))).max()
    return float(max(low, np.abs(one.max(axis=(0, 1)) - other.max(axis=(0, 1))).max()))
