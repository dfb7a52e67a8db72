# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The baked copy, read back from a saved preview; the session stays as it was."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ..core.errors import FormatError, InputError
from ..core.surface import SurfaceMesh
from .copy import NORMAL, SIGN, TANGENT
from .scratch import new_data_removed, remove_scene


@contextmanager
def baked_copy(preview: Path, name: str, uv_layer: str) -> Iterator[tuple[bpy.types.Scene, bpy.types.Object]]:
    """The baked copy called `name` of a preview's .blend, alone in a scene of its own, its matrix evaluated.

    All that was loaded goes away at exit. Raises InputError where there is no preview, FormatError where it
    is no .blend that this Blender reads, or not of a bake on `uv_layer`.
    """
    check_preview(preview)
    with appended(preview, name) as found:
        mesh: Any = found.data if found is not None else None
        if not isinstance(mesh, bpy.types.Mesh):
            raise FormatError(f"{preview} holds no mesh '{name}': bake it again with --save-preview")
        lacking = [wanted for wanted in (NORMAL, TANGENT, SIGN, uv_layer) if wanted not in mesh.attributes]
        if lacking:
            raise FormatError(
                f"{preview} is of another bake: its mesh lacks '{lacking[0]}'; bake again with --save-preview"
            )
        scene = cast("bpy.types.Scene", bpy.data.scenes.new("RadTex copy"))
        try:
            scene.collection.objects.link(cast("bpy.types.Object", found))
            scene.view_layers[0].update()
            yield scene, cast("bpy.types.Object", found)
        finally:
            remove_scene(scene)


def check_preview(preview: Path) -> None:
    """Raises InputError where there is no saved preview."""
    if not preview.is_file():
        raise InputError(f"{preview} is missing, which holds the mesh: bake it again with --save-preview")


@contextmanager
def appended(blend: Path, name: str) -> Iterator[bpy.types.Object | None]:
    """The object `name` of a .blend, in no scene, or None; all that was loaded goes away at exit.

    Raises FormatError for a file that this Blender does not read.
    """
    libraries: Any = bpy.data.libraries
    before = set(libraries)
    with new_data_removed():
        try:
            try:
                with libraries.load(str(blend)) as (there, wanted):
                    wanted.objects = [name] if name in there.objects else []
            except OSError as error:
                raise FormatError(f"{blend} is no .blend that this Blender reads: bake it again") from error
            yield wanted.objects[0] if wanted.objects else None
        finally:
            for library in set(libraries) - before:  # what is appended needs it no more
                libraries.remove(library)


def surface_of(copy: bpy.types.Object, uv_layer: str) -> SurfaceMesh:
    """A baked copy as arrays in world space, as `surface_mesh` makes them of a bake's own."""
    mesh: Any = copy.data
    matrix = np.array(copy.matrix_world, dtype=np.float64)
    turn = matrix[:3, :3]
    place = _values(mesh.vertices, "co", 3)
    mirrored = np.linalg.det(turn) < 0
    normal, tangent, sign, uv = (
        _values(mesh.attributes[name].data, field, width).reshape(-1, 3, width)
        for name, field, width in (
            (NORMAL, "vector", 3),
            (TANGENT, "vector", 3),
            (SIGN, "value", 1),
            (uv_layer, "vector", 2),
        )
    )
    return SurfaceMesh(
        position=place @ turn.T + matrix[:3, 3],
        triangles=_values(mesh.loops, "vertex_index", 1, np.int32).reshape(-1, 3),
        normal=normal.astype(np.float64) @ np.linalg.inv(turn),
        tangent=tangent.astype(np.float64) @ turn.T,
        sign=sign[..., 0] * (-1.0 if mirrored else 1.0),
        uv=uv,
    )


def _values(items: Any, field: str, width: int, dtype: type = np.float32) -> Any:
    values: Any = np.empty(len(items) * width, dtype=dtype)
    items.foreach_get(field, values)
    return values.reshape(-1, width)
