# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene against which a bake is judged: with the bake's lamps, and its source instead of the object."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bpy

from ..formats.sidecar import Sidecar
from ..scene.lights.lamps import light_only
from ..scene.mesh.cage import take_cage_out, take_out
from ..scene.mesh.source_hits import find_source
from ..scene.proxy_content import EVERYTHING, show_content_only
from ..scene.regroup import leave_alone
from ..scene.scratch import scene_copied


@dataclass(frozen=True, eq=False)
class Reference:
    """Two scratch scenes: `pictured` is path traced, `before` holds what may hide the baked surface."""

    pictured: bpy.types.Scene
    before: bpy.types.Scene


@contextmanager
def reference_of(scratch: bpy.types.Scene, original: bpy.types.Object, bake: Sidecar) -> Iterator[Reference]:
    """Change a scratch scene so that it renders what a `bake` of its object `original` shows.

    For a bake from a source, the source renders, the object and a cage do not; for a bake of some lamps, only
    these give light; of a bake that was made alone, no other object renders. The scratch scene is not
    restored. Raises InputError for a missing source or lamp.
    """
    if bake.alone:
        source = () if bake.source is None else (bake.source.object_name, bake.source.cage)
        leave_alone(scratch, {original.name, *bake.surfaces, *source})
    if bake.source is None:
        _light(scratch, bake)
        yield Reference(scratch, scratch)
        return
    detailed = find_source(scratch, original, bake.source.object_name)
    with scene_copied(scratch) as before:
        for scene in (scratch, before):
            show_content_only(scene, original, EVERYTHING)
            if bake.source.cage is not None:
                take_cage_out(scene, bake.source.cage)
        take_out(before, detailed)
        _light(scratch, bake)
        yield Reference(scratch, before)


def _light(scratch: bpy.types.Scene, bake: Sidecar) -> None:
    if bake.lights:
        light_only(scratch, bake.lights, denoised=True)
