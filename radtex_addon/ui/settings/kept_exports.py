# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports that are made again after each bake. The scene keeps which bakes, for whom, where and how."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import StringProperty

from ...textures.export_spec import Target, export_facts
from ...textures.kept_exports import KEPT, KeptExport, kept_exports, real


class RADTEX_PG_kept_export(bpy.types.PropertyGroup):
    """An export that is made again whenever its bake is. `name` is the bake's, or the exported scene's"""

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        name: str
        sidecars: str
        folder: str
        scene_name: str
        spec: str
    else:
        sidecars: StringProperty(name="Bakes", description="The .json files of its bakes, a line each")
        folder: StringProperty(
            name="Folder",
            description="The folder that the export makes",
            subtype="DIR_PATH",
            options={"PATH_SUPPORTS_BLEND_RELATIVE"},
        )
        scene_name: StringProperty(
            name="Scene Name", description="What its bakes are exported as together. Empty for a single bake"
        )
        spec: StringProperty(name="Settings", description="The settings of the export, as JSON")


def rows_of(scene: bpy.types.Scene) -> Any:
    """The exports that the scene keeps, as Blender's collection of `RADTEX_PG_kept_export`."""
    return getattr(scene, KEPT)


def kept_export(row: RADTEX_PG_kept_export) -> KeptExport | None:
    """The export of a row; None if its settings cannot be read."""
    names = ("name", "sidecars", "folder", "scene_name", "spec")
    return KeptExport.of({name: getattr(row, name) for name in names})


def is_kept(
    scene: bpy.types.Scene, sidecars: Sequence[Path], target: Target, scene_name: str | None = None
) -> bool:
    """Whether an export for the target is made again after each bake: of one of these bakes by itself.

    With a `scene_name`, that as the scene of this name.
    """
    keys = {found.key for found in kept_exports(scene)}
    if scene_name is not None:
        return (target, scene_name, ()) in keys
    return any((target, None, (real(path),)) in keys for path in sidecars)


def keep(scene: bpy.types.Scene, export: KeptExport, *, relative: bool) -> None:
    """Keep an export, in the place of another of the same bake or scene for that target, or in that folder.

    With `relative`, its folder is found again after the .blend was moved together with it.
    """
    forget(scene, export)
    row = rows_of(scene).add()
    row.name = export.name
    row.sidecars = "\n".join(_stored(path, relative=True) for path in export.sidecars)
    row.folder = _stored(export.out, relative=relative)
    row.scene_name = export.scene or ""
    row.spec = json.dumps(export_facts(export.spec))


def forget(scene: bpy.types.Scene, export: KeptExport) -> bool:
    """Keep none of that bake or scene for that target, or in that folder; returns whether one was kept."""
    rows = rows_of(scene)
    same = [
        number
        for number, row in enumerate(rows)
        if (found := kept_export(row)) is not None
        and (found.key == export.key or real(found.out) == real(export.out))
    ]
    for number in reversed(same):
        rows.remove(number)
    return bool(same)


def _stored(path: Path, *, relative: bool) -> str:
    """The path for a row, relative to the .blend if that was saved, and on the same drive."""
    if relative and bpy.data.filepath:
        try:
            return bpy.path.relpath(str(path))
        except ValueError:  # on another drive
            pass
    return str(path.absolute())
