# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of an object's bakes of several names *Finished Bake* is about: the scene keeps that."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import StringProperty

if TYPE_CHECKING:
    from ...report.finished_bake import NamedBake


class RADTEX_PG_chosen_bake(bpy.types.PropertyGroup):
    """The bake that was chosen of an object or a shared atlas, whose `name` this has"""

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        name: str
        called: str
        newest: str
    else:
        called: StringProperty(name="Bake", description="What the files of the chosen bake are called")
        newest: StringProperty(
            name="Newest", description="When the newest bake of the object was written, as it was chosen"
        )


def bakes_by_name(place: Path, name: str) -> tuple[NamedBake, ...]:
    """The bakes of an object or a shared atlas in a folder, the newest first.

    None where all of them are called as what they are of: then there is nothing to choose by name.
    """
    from ...report.finished_bake import named_bakes

    found = named_bakes(place, name) if place.is_dir() else ()
    return found if any(one.called != one.object for one in found) else ()


def chosen_bake(scene: bpy.types.Scene, name: str, found: Sequence[NamedBake]) -> NamedBake:
    """Of the bakes `found` of an object the one that was chosen, if none was made since; else the newest."""
    row = _rows(scene).get(name)
    if row is not None and row.newest == str(found[0].time):
        return next((one for one in found if one.called == row.called), found[0])
    return found[0]


def chosen_name(scene: bpy.types.Scene, place: Path, name: str) -> str:
    """What the chosen bake of an object in a folder is called; empty if `bakes_by_name` finds none."""
    found = bakes_by_name(place, name)
    return chosen_bake(scene, name, found).called if found else ""


def choose(scene: bpy.types.Scene, name: str, called: str, found: Sequence[NamedBake]) -> None:
    """Choose one of the bakes `found` of an object."""
    row = _rows(scene).get(name) or _rows(scene).add()
    row.name, row.called, row.newest = name, called, str(found[0].time)


def _rows(scene: bpy.types.Scene) -> Any:
    return scene.radtex_chosen_bakes  # type: ignore[attr-defined]  # ours, not Blender's
