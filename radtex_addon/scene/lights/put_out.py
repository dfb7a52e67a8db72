# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light a scratch scene by some lamps alone, in all of Cycles's passes.

Cycles splits only the combined pass by light groups. Where the passes of diffuse or glossy light are needed,
all other light has to be taken away: that of materials and of instanced lamps.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, cast

import bpy

from ...core.errors import InputError
from ...core.messages import Setting, do
from .lamps import WORLD, light_only
from .light import without_emission


@contextmanager
def lit_by_lamps_alone(scratch: bpy.types.Scene, names: Sequence[str]) -> Iterator[None]:
    """Light a scratch scene as `lamps.light_only` does, but so that no pass has any other light.

    Meanwhile, materials that glow and the data of lamps are exchanged for dark copies wherever they are used;
    at the end all users have their own again. Raises InputError as `light_only` does, and if what glows is
    linked from another file, whose users cannot be changed.
    """
    light_only(scratch, names, group=False)
    if WORLD in names:
        yield
        return
    for item in scratch.collection.objects:  # the lamps that are lit are copies: they keep their own data
        if item.type == "LIGHT":
            cast(Any, item).data = cast(bpy.types.ID, item.data).copy()
    kept = {item.data for item in scratch.collection.objects if item.type == "LIGHT"}
    dark = [*_materials(), *_lamps(kept)]
    _check_users([block for block, _ in dark], names)
    try:
        for block, copy in dark:
            block.user_remap(copy)
        yield
    finally:
        for block, copy in dark:
            copy.user_remap(block)


def _check_users(blocks: Sequence[bpy.types.ID], names: Sequence[str]) -> None:
    """Raises InputError if something that is linked from another file uses one of the blocks."""
    for block, users in bpy.data.user_map(subset=list(blocks)).items():
        linked = next((cast(Any, user).library for user in users if cast(Any, user).library), None)
        if linked is not None:
            raise InputError(
                f"'{block.name}' of {linked.filepath} gives light, which cannot be left out of a bake of "
                f"{', '.join(names)} alone",
                do("make what uses it local"),
                do("choose layout buckets", Setting.LAYOUT, value="buckets"),
            )


def _materials() -> Iterator[tuple[Any, Any]]:
    for material in list(bpy.data.materials):
        if material.users and (dark := without_emission(material)) != material:
            yield material, dark


def _lamps(kept: set[Any]) -> Iterator[tuple[Any, Any]]:
    for lamp in list(bpy.data.lights):
        if lamp.users and lamp not in kept:
            dark: Any = bpy.data.lights.new("RadTex dark", lamp.type)
            dark.energy = 0
            yield lamp, dark
