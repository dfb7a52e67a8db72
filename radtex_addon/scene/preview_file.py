# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Load the baked copy from a saved preview; at exit the open file is unchanged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
from mathutils import Matrix

from ..core.errors import FormatError, InputError
from ..core.frame import normalised
from ..core.messages import Setting, do
from ..core.surface import SurfaceMesh
from ..formats.disk.path_checks import check_loadable
from .mesh.copy import MATRIX, NORMAL, SIGN, TANGENT, material_numbers
from .mesh.joined import joined_copy, values_in
from .mesh.mesh_parts import PART
from .scratch import new_data_removed, remove_scene

_SHEARED = 1e-5  # times a matrix's largest value: how far location, rotation and scale may deviate from it


@contextmanager
def baked_copy(
    preview: Path,
    names: Sequence[str],
    uv_layer: str,
    part: int | None = None,
    more_layers: Sequence[str] = (),
) -> Iterator[tuple[bpy.types.Scene, bpy.types.Object]]:
    """The baked copy called `names[0]` of a preview's .blend, alone in a scene of its own, as it was baked.

    It has its place from the bake, without parent, animation and constraints; a matrix that shears is applied
    to the mesh. Several copies, which share an atlas, are joined into one object whose mesh is in world
    space, with `more_layers` of UVs; so is part number `part` of a split bake. All loaded data are removed at
    exit. Raises InputError if there is no preview, FormatError if Blender cannot read it or if it is not of a
    bake on `uv_layer`.
    """
    check_preview(preview)
    with appended(preview, names) as loaded:
        wanted = (NORMAL, TANGENT, SIGN, uv_layer, *(() if part is None else (PART,)))
        copies = [_checked(preview, name, item, wanted) for name, item in zip(names, loaded, strict=True)]
        scene = cast("bpy.types.Scene", bpy.data.scenes.new("RadTex copy"))
        try:
            for copy in copies:
                scene.collection.objects.link(copy)
            scene.view_layers[0].update()
            alone = len(copies) == 1 and part is None
            for copy in copies:
                settle(copy, copy.data, _matrix_at_bake(copy), whole=not alone)
            found = copies[0] if alone else _joined(scene, copies, uv_layer, part, more_layers)
            scene.view_layers[0].update()
            yield scene, found
        finally:
            remove_scene(scene)


def _checked(
    preview: Path, name: str, found: bpy.types.Object | None, wanted: Sequence[str]
) -> bpy.types.Object:
    if found is None or not isinstance(found.data, bpy.types.Mesh):
        raise FormatError(
            f"{preview} holds no mesh '{name}'", do("bake it again with a preview", Setting.SAVE_PREVIEW)
        )
    mesh: Any = found.data
    lacking = [each for each in wanted if each not in mesh.attributes]
    if lacking:
        raise FormatError(
            f"{preview} is of another bake: its mesh lacks '{lacking[0]}'",
            do("bake it again with a preview", Setting.SAVE_PREVIEW),
        )
    return found


def _joined(
    scene: bpy.types.Scene,
    copies: Sequence[bpy.types.Object],
    uv_layer: str,
    part: int | None,
    more_layers: Sequence[str],
) -> bpy.types.Object:
    """Replace the copies in the scene by one object that joins them."""
    found = joined_copy(copies, uv_layer, part, more_layers)
    for copy in copies:
        scene.collection.objects.unlink(copy)
    scene.collection.objects.link(found)
    return found


def _matrix_at_bake(copy: bpy.types.Object) -> Matrix:
    mesh: Any = copy.data
    if MATRIX in mesh:
        return Matrix(np.array(mesh[MATRIX]).reshape(4, 4).tolist())
    return copy.matrix_world.copy()


def settle(copy: bpy.types.Object, mesh: Any, matrix: Matrix, whole: bool = False) -> None:
    """Put a baked copy at `matrix`, on its own: no parent, constraints or animation.

    The matrix is applied to the mesh and its frame if `whole`, or if location, rotation and scale cannot
    express it.
    """
    copy.parent = None
    copy.constraints.clear()
    copy.animation_data_clear()
    if whole or is_sheared(matrix):
        give_to_mesh(matrix, mesh)
        matrix = Matrix.Identity(4)
    copy.matrix_world = matrix


def is_sheared(matrix: Matrix) -> bool:
    """Whether location, rotation and scale cannot express the matrix, as below a stretched parent."""
    parts: Any = matrix.decompose()
    gap = np.abs(np.array(Matrix.LocRotScale(*parts)) - np.array(matrix)).max()
    return bool(gap > _SHEARED * np.abs(np.array(matrix)).max())


def give_to_mesh(matrix: Matrix, mesh: Any) -> None:
    """Apply the matrix to the mesh and its frame."""
    turn = np.array(matrix.to_3x3())
    mirrored = np.linalg.det(turn) < 0
    for name, change in ((NORMAL, np.linalg.inv(turn)), (TANGENT, turn.T)):
        data = mesh.attributes[name].data
        moved = normalised(values_in(data, "vector", 3).astype(np.float64) @ change)
        data.foreach_set("vector", np.ascontiguousarray(moved, dtype=np.float32).ravel())
    if mirrored:
        data = mesh.attributes[SIGN].data
        data.foreach_set("value", -values_in(data, "value", 1).ravel())
        mesh.flip_normals()
    mesh.transform(matrix)


def check_preview(preview: Path) -> None:
    """Raise InputError if there is no saved preview."""
    if not preview.is_file():
        raise InputError(
            f"{preview} is missing, which holds the mesh",
            do("bake it again with a preview", Setting.SAVE_PREVIEW),
        )


@contextmanager
def appended(
    blend: Path, names: Sequence[str], keep: Sequence[bpy.types.ID] = ()
) -> Iterator[list[bpy.types.Object | None]]:
    """Append the objects `names` of a .blend, to no scene, and remove them at exit; None for missing ones.

    Only data-blocks in `keep` (a list that may grow inside) stay, with those that they use. Raises
    InputError for a name that Blender does not understand, FormatError if it cannot read the file.
    """
    check_loadable(blend)
    libraries: Any = bpy.data.libraries
    before = set(libraries)
    with new_data_removed(keep):
        try:
            try:
                with libraries.load(str(blend.absolute())) as (there, wanted):
                    there_are = [name for name in names if name in there.objects]
                    wanted.objects = list(there_are)
            except OSError as error:
                raise FormatError(f"{blend} is no .blend that this Blender reads: bake it again") from error
            found = dict(zip(there_are, wanted.objects, strict=True))
            yield [found.get(name) for name in names]
        finally:
            for library in set(libraries) - before:  # appended data do not need it
                libraries.remove(library)


def surface_of(copy: bpy.types.Object, uv_layer: str) -> SurfaceMesh:
    """A loaded baked copy as arrays in world space, like `surface_mesh` during a bake."""
    mesh: Any = copy.data
    matrix = np.array(copy.matrix_world, dtype=np.float64)
    turn = matrix[:3, :3]
    place = values_in(mesh.vertices, "co", 3)
    mirrored = np.linalg.det(turn) < 0
    normal, tangent, sign, uv = (
        values_in(mesh.attributes[name].data, field, width).reshape(-1, 3, width)
        for name, field, width in (
            (NORMAL, "vector", 3),
            (TANGENT, "vector", 3),
            (SIGN, "value", 1),
            (uv_layer, "vector", 2),
        )
    )
    return SurfaceMesh(
        position=place @ turn.T + matrix[:3, 3],
        triangles=values_in(mesh.loops, "vertex_index", 1, np.int32).reshape(-1, 3),
        normal=normal.astype(np.float64) @ np.linalg.inv(turn),
        tangent=tangent.astype(np.float64) @ turn.T,
        sign=sign[..., 0] * (-1.0 if mirrored else 1.0),
        uv=uv,
        material=material_numbers(mesh),
    )
