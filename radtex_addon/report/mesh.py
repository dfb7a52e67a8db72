# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the baked copy's mesh again, with the UV layer on which it was baked.

A UV layer that the bake made is stored in the preview only. Unwrapping is deterministic, so the layer can be
made again. A layer is accepted only if it agrees with the atlas's gutter: texels that no island touches are
copies of the nearest texel that an island touches.
"""

from __future__ import annotations

from collections.abc import Generator
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ..bake.piece_store import NO_STORE
from ..bake.progress import finished
from ..core.arrays import Floats
from ..core.errors import FormatError, InputError
from ..core.gutter import LEAST_AGREEMENT
from ..core.messages import Setting, do
from ..prepare.detailed import Detailed, read_detailed
from ..prepare.faces import all_once, find_once, seen_backs
from ..prepare.unwrapping import unwrap_mesh
from ..scene.mesh.backs import with_twins
from ..scene.mesh.copy import baked_mesh, surface_mesh
from ..scene.mesh.evaluated import EvaluatedMesh, evaluate
from ..scene.mesh.materials import write_material_numbers
from ..scene.preview_file import appended
from ..scene.scratch import new_data_removed
from ..scene.uv.unwrap_options import UnwrapOptions
from ..scene.uv.uv_layer import user_uv
from ..settings.spec import Unwrap
from .finished_bake import Finished
from .gbuffer import BakedSurface
from .report_progress import ReportStep, ReportTask, steps_of
from .shared_atlas import Parts

_SURE = 0.93  # share of the gutter that agrees; less than 1, as the bake also fills texels that are hidden
_SAME = 1e-5  # relative to the object's size: vertices that moved less count as unmoved


@dataclass(frozen=True, eq=False)
class SurfaceFound:
    """The surface of a bake; `uv_layer` is the object's own layer, None if `unwrap` made the layer.

    `parts` tells the objects apart, if there are several.
    """

    surface: BakedSurface
    uv_layer: str | None
    unwrap: Unwrap
    parts: Parts | None = None


def find_mesh(
    scratch: bpy.types.Scene, original: bpy.types.Object, bake: Finished, options: UnwrapOptions
) -> Generator[ReportStep, None, SurfaceFound]:
    """Find the surface of `bake` on the object `original` of a scratch scene.

    Tries the object's own layer with the sidecar's name, the layer in the preview beside the bake, and each
    unwrap method with the `options`. Returns the first layer that fits for sure, else the best one that may
    fit. Yields progress. Raises InputError if no layer fits, or if what it was baked from is missing.
    """
    evaluated = evaluate(scratch, original, bake.sidecar.texel_weights or None)
    (evaluated,) = all_once([evaluated], [find_once(evaluated)])
    if bake.form.traits.backs and bake.unwrapped:
        (seen,), _ = finished(seen_backs(scratch, [original], [evaluated], bake.backs))
        evaluated = with_twins(evaluated, seen)
    detailed = None
    if bake.form.traits.by_paths:
        detailed = read_detailed(scratch, original, bake.spec(device="cpu"), NO_STORE)
    best: tuple[float, SurfaceFound] | None = None
    with closing(_layers(evaluated, bake, options)) as layers:
        for found in layers:
            if isinstance(found, ReportStep):
                yield found
                continue
            surface, agreement = _surface(evaluated, found.uv, bake, detailed)
            if best is None or agreement > best[0]:
                best = agreement, SurfaceFound(surface, found.own, found.unwrap)
            if agreement >= _SURE:
                break
    if best is None or best[0] < LEAST_AGREEMENT:
        raise InputError(
            f"object '{original.name}' does not fit {bake.file}: it was changed since, or unwrapped with "
            "another padding or by another Blender",
            do("bake it again with a preview", Setting.SAVE_PREVIEW),
        )
    return best[1]


@dataclass(frozen=True, eq=False)
class _Layer:
    """A UV layer (F, 3, 2) that may be the baked one; `own` is the `uv_layer` of `SurfaceFound`."""

    uv: Floats
    own: str | None
    unwrap: Unwrap


def _layers(
    evaluated: EvaluatedMesh, bake: Finished, options: UnwrapOptions
) -> Generator[ReportStep | _Layer, None, None]:
    yield ReportStep(ReportTask.FIND_MESH, 0, 1)
    own = bake.sidecar.uv_map
    if own in evaluated.uv_layers or not bake.unwrapped:
        yield _Layer(user_uv(evaluated, own), own, Unwrap.AUTO)
    if not bake.unwrapped:
        return
    uv = _uv_of_preview(bake, evaluated)
    if uv is not None:
        yield _Layer(uv, None, Unwrap.UVUNWRAP)
    for unwrap in (Unwrap.AUTO, Unwrap.UVUNWRAP, Unwrap.XATLAS, Unwrap.BLENDER):
        uv = yield from _unwrapped(evaluated, bake, unwrap, options)
        if uv is not None:
            yield _Layer(uv, None, unwrap)


def _surface(
    evaluated: EvaluatedMesh, uv: Floats, bake: Finished, detailed: Detailed | None
) -> tuple[BakedSurface, float]:
    """The surface with a UV layer, and how well the layer agrees with the atlas's gutter, 0 to 1.

    Its materials are those of the `detailed` object, if it is given.
    """
    layer = bake.sidecar.uv_map
    with new_data_removed():
        mesh = baked_mesh(evaluated, uv, layer)
        surface = surface_mesh(evaluated, mesh, layer)
        if detailed is not None and bake.sidecar.source is not None:
            write_material_numbers([mesh], [detailed.materials(surface, bake.sidecar.source.extrusion)])
        return BakedSurface(mesh, evaluated.matrix_world, layer), bake.agreement(surface)


def _unwrapped(
    evaluated: EvaluatedMesh, bake: Finished, unwrap: Unwrap, options: UnwrapOptions
) -> Generator[ReportStep | _Layer, None, Floats | None]:
    """The UV layer that an unwrap method makes, None if it is for an atlas of another size."""
    width, height = bake.sidecar.width, bake.sidecar.height
    try:
        made = yield from steps_of(unwrap_mesh(evaluated, max(width, height), unwrap, options))
    except InputError:  # too many islands for so few texels: this unwrap did not make the atlas
        return None
    return made.uv if (made.width, made.height) == (width, height) else None


def _uv_of_preview(bake: Finished, evaluated: EvaluatedMesh) -> Floats | None:
    """The UV layer in the saved preview; None if there is no preview, or its triangles differ."""
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
