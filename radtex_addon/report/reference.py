# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene that a bake is judged by: its lamps lit, and what it shows in the place of who wears it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bpy

from ..formats.sidecar import Sidecar
from ..scene.lights.lamps import light_only
from ..scene.mesh.cage import take_cage_out, take_out
from ..scene.mesh.source import find_source
from ..scene.proxy_content import EVERYTHING, show_content_only
from ..scene.scratch import scene_copied


@dataclass(frozen=True, eq=False)
class Reference:
    """What is path traced, `pictured`, and what may stand `before` the baked surface: scratch scenes."""

    pictured: bpy.types.Scene
    before: bpy.types.Scene


@contextmanager
def reference_of(scratch: bpy.types.Scene, original: bpy.types.Object, bake: Sidecar) -> Iterator[Reference]:
    """Make a scratch scene show what a `bake` of its object `original` shows, the cells' own rays apart.

    A bake from a source shows that one, and neither the object nor a cage; a bake of some lamps has their
    light alone. The scratch scene stays so. Raises InputError for a source or a lamp that is not there.
    """
    if bake.source is None:
        _light(scratch, bake)
        yield Reference(scratch, scratch)
        return
    source = find_source(scratch, original, bake.source.object_name)
    with scene_copied(scratch) as before:
        for scene in (scratch, before):
            show_content_only(scene, original, EVERYTHING)
            if bake.source.cage is not None:
                take_cage_out(scene, bake.source.cage)
        take_out(before, source)
        _light(scratch, bake)
        yield Reference(scratch, before)


def _light(scratch: bpy.types.Scene, bake: Sidecar) -> None:
    if bake.lights:
        light_only(scratch, bake.lights, denoised=True)
