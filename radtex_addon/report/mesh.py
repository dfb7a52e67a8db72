# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The baked copy's mesh, found again: an atlas says itself which UV layer fits it.

A bake's own UV layer lies in no file but its preview. Unwraps are the same every time, so it can be made
again; what is found is believed only if the atlas's gutter agrees: texels that no island touches hold copies
of the nearest that one does.
"""

from __future__ import annotations

from collections.abc import Generator
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ..bake.spec import Unwrap
from ..core.arrays import Floats
from ..core.errors import FormatError, InputError
from ..core.gutter import LEAST_AGREEMENT, gutter_agreement
from ..core.texel_map import rasterise
from ..scene.mesh.copy import baked_mesh, surface_mesh
from ..scene.mesh.evaluated import EvaluatedMesh, evaluate
from ..scene.preview_file import appended
from ..scene.scratch import new_data_removed
from ..scene.uv.unwrap import unwrap_steps
from ..scene.uv.unwrap_options import UnwrapOptions
from ..scene.uv.uv_layer import user_uv
from .finished import Finished
from .gbuffer import BakedSurface
from .progress import Step, Task, steps_of

_SURE = 0.93  # of the gutter's values: all, but where the bake filled texels that nobody sees
_SAME = 1e-5  # of the object's size: vertices that have moved less have not moved


@dataclass(frozen=True, eq=False)
class Found:
    """The surface that a bake was baked on; `uv_layer` is the object's own, or None and `unwrap` made it."""

    surface: BakedSurface
    uv_layer: str | None
    unwrap: Unwrap


def find_mesh(
    scratch: bpy.types.Scene, original: bpy.types.Object, bake: Finished, padding: int
) -> Generator[Step, None, Found]:
    """Find the surface of `bake` on the object `original` of a scratch scene.

    Looks at the object's own layer of the sidecar's name, at the preview beside the bake, and at what each
    unwrap makes with `padding`: the first that surely fits, or else the best that may. Raises InputError
    where none does.
    """
    evaluated = evaluate(scratch, original)
    best: tuple[float, Found] | None = None
    with closing(_layers(evaluated, bake, padding)) as layers:
        for found in layers:
            if isinstance(found, Step):
                yield found
                continue
            surface, agreement = _surface(evaluated, found.uv, bake)
            if best is None or agreement > best[0]:
                best = agreement, Found(surface, found.own, found.unwrap)
            if agreement >= _SURE:
                break
    if best is None or best[0] < LEAST_AGREEMENT:
        raise InputError(
            f"object '{original.name}' does not fit {bake.path}: it was changed since, or unwrapped with "
            "another padding or by another Blender; bake it again, with --save-preview"
        )
    return best[1]


@dataclass(frozen=True, eq=False)
class _Layer:
    """A UV layer (F, 3, 2) that may be the baked one, and where it comes from as in `Found`."""

    uv: Floats
    own: str | None
    unwrap: Unwrap


def _layers(evaluated: EvaluatedMesh, bake: Finished, padding: int) -> Generator[Step | _Layer, None, None]:
    yield Step(Task.FIND_MESH, 0, 1)
    own = bake.sidecar.uv_map
    if own in evaluated.uv_layers or not bake.unwrapped:
        yield _Layer(user_uv(evaluated, own), own, Unwrap.XATLAS)
    if not bake.unwrapped:
        return
    uv = _uv_of_preview(bake, evaluated)
    if uv is not None:
        yield _Layer(uv, None, Unwrap.XATLAS)
    for unwrap in Unwrap:
        uv = yield from _unwrapped(evaluated, bake, unwrap, padding)
        if uv is not None:
            yield _Layer(uv, None, unwrap)


def _surface(evaluated: EvaluatedMesh, uv: Floats, bake: Finished) -> tuple[BakedSurface, float]:
    """The surface with a UV layer, and how well that agrees with the bake, 0 to 1."""
    layer = bake.sidecar.uv_map
    with new_data_removed():
        mesh = baked_mesh(evaluated, uv, layer)
        surface = surface_mesh(evaluated, mesh, layer)
        covered = rasterise(surface, bake.sidecar.width, bake.sidecar.height).covered
        agreement = gutter_agreement(covered, bake.texels, bake.loss)
        return BakedSurface(mesh, evaluated.matrix_world, layer), agreement


def _unwrapped(
    evaluated: EvaluatedMesh, bake: Finished, unwrap: Unwrap, padding: int
) -> Generator[Step | _Layer, None, Floats | None]:
    """What an unwrap makes of the mesh, if it is of the atlas's size."""
    width, height = bake.sidecar.width, bake.sidecar.height
    try:
        made = yield from steps_of(
            unwrap_steps(evaluated, max(width, height), unwrap, UnwrapOptions(padding=padding))
        )
    except InputError:  # too many islands for so few texels: this unwrap did not make the atlas
        return None
    return made.uv if (made.width, made.height) == (width, height) else None


def _uv_of_preview(bake: Finished, evaluated: EvaluatedMesh) -> Floats | None:
    """The layer of the mesh in the saved preview, if there is one and it shows the same triangles."""
    if not bake.preview.is_file():
        return None
    try:
        with appended(bake.preview, (bake.sidecar.object_name,)) as (found,):
            mesh = None if found is None else found.data
            if not isinstance(mesh, bpy.types.Mesh) or not _same_triangles(mesh, evaluated):
                return None
            return _layer(mesh, bake.sidecar.uv_map)
    except FormatError:  # no .blend, or one of a newer Blender
        return None


def _same_triangles(mesh: Any, evaluated: EvaluatedMesh) -> bool:
    position, triangles = evaluated.position, evaluated.triangles
    if len(mesh.vertices) != len(position) or len(mesh.loops) != triangles.size:
        return False
    there, corners = np.empty(position.size, np.float32), np.empty(triangles.size, np.int32)
    mesh.vertices.foreach_get("co", there)
    mesh.loops.foreach_get("vertex_index", corners)
    moved = np.abs(there.reshape(-1, 3) - position).max()
    return bool((corners == triangles.ravel()).all() and moved <= _SAME * np.ptp(position, axis=0).max())


def _layer(mesh: Any, name: str) -> Floats | None:
    layer = mesh.uv_layers.get(name)
    if layer is None:
        return None
    uv = np.empty(2 * len(mesh.loops), np.float32)
    layer.uv.foreach_get("vector", uv)
    return uv.reshape(-1, 3, 2)
