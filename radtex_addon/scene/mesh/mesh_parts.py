# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Split a surface into parts with an atlas each: by material, or by UDIM tile."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import bpy
import numpy as np

from ...core.arrays import Bools, Floats, Ints
from ...core.errors import InputError
from ...settings.parts import Split, tile_name, tile_place
from .copy import write_face_numbers
from .evaluated import EvaluatedMesh

PART = "radtex_part"  # attribute of the baked copy's faces: the number of each face's part
NO_MATERIAL = "none"  # name of the part of faces without a material
_EDGE = 1e-4  # of a tile's side: how far a face may reach across its border, by rounding
_NOTHING = 1e-7  # of a tile's area: at most this much counts as none, because of rounding

Parts = dict[str, Bools]  # for each part's name its triangles (F,)


def parts_of(mesh: EvaluatedMesh, split: Split, uv_layer: str | None) -> Parts:
    """The parts of a mesh by name: each has a triangle, and no triangle is in two parts.

    Materials are in the order of their slots, tiles in the order of their numbers. Raises InputError for a UV
    layer that is missing, or whose triangles do not lie in tiles.
    """
    if split is Split.MATERIAL:
        return _materials(mesh)
    assert uv_layer is not None  # every specification that splits by tiles has a UV layer
    return _tiles(mesh, uv_layer)


def _materials(mesh: EvaluatedMesh) -> Parts:
    found: Parts = {}
    for index in np.unique(mesh.material_index):
        material = mesh.materials[index] if mesh.materials else None
        name = NO_MATERIAL if material is None else material.name
        faces = mesh.material_index == index
        found[name] = found[name] | faces if name in found else faces
    return found


def _tiles(mesh: EvaluatedMesh, layer: str) -> Parts:
    where = f"UV layer '{layer}' of object '{mesh.name}'"
    if layer not in mesh.uv_layers:
        known = ", ".join(f"'{name}'" for name in mesh.uv_layers) or "none"
        raise InputError(f"object '{mesh.name}' has no UV layer '{layer}' in renders: it has {known}")
    uv = mesh.uv(layer).astype(np.float64)
    if not np.isfinite(uv).all():
        raise InputError(f"{where} has coordinates that are not finite: unwrap it anew")
    place = np.floor(uv.mean(axis=1)).astype(np.int64)
    moved = _in_filled_tiles(uv, place)
    reach = uv - place[:, None]
    astray = ((reach < -_EDGE) | (reach > 1 + _EDGE)).any(axis=(1, 2)) & (moved == place).all(axis=1)
    if astray.any():
        count = int(np.count_nonzero(astray))
        raise InputError(f"{where} has {count} triangles across the border of a tile: move them into one")
    return {_tile(where, column, row): _in_tile(moved, column, row) for column, row in _sorted(moved)}


def _in_filled_tiles(uv: Floats, place: Ints) -> Ints:
    """The tiles (F, 2) of triangles with corners `uv` (F, 3, 2); `place` (F, 2) is the first guess.

    If the triangles of a tile have no area together, they are moved to the nearest tile with some area, since
    their tile's atlas would be empty. (Rounding down puts those on a tile's far edge into the next tile.)
    """
    first, second = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    area = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / 2
    tiles = np.array(_sorted(place), dtype=np.int64)
    members = [_in_tile(place, column, row) for column, row in tiles]
    filled = np.array([area[some].sum() > _NOTHING for some in members])
    found = place.copy()
    if filled.any():
        for some in (some for some, has in zip(members, filled, strict=True) if not has):
            away = np.abs(tiles[filled] + 0.5 - uv[some].mean(axis=(0, 1))).max(axis=1)
            found[some] = tiles[filled][away.argmin()]
    return found


def _sorted(place: Ints) -> list[tuple[int, int]]:
    return sorted({(int(x), int(y)) for x, y in place}, key=lambda each: (each[1], each[0]))


def _in_tile(place: Ints, column: int, row: int) -> Bools:
    found: Bools = (place == [column, row]).all(axis=1)
    return found


def _tile(where: str, column: int, row: int) -> str:
    try:
        return tile_name(column, row)
    except ValueError as error:
        raise InputError(f"{where}: {error}; move those faces to tile 1001 or beyond") from None


def taken(mesh: EvaluatedMesh, faces: Bools) -> EvaluatedMesh:
    """The mesh with only the triangles where `faces` (F,) is True; all vertices stay."""
    attributes = tuple(
        attribute if attribute.domain == "POINT" else replace(attribute, values=attribute.values[faces])
        for attribute in mesh.attributes
    )
    return replace(
        mesh,
        triangles=mesh.triangles[faces],
        normal=mesh.normal[faces],
        material_index=mesh.material_index[faces],
        attributes=attributes,
    )


def in_first_tile(mesh: EvaluatedMesh, layer: str, tile: str) -> EvaluatedMesh:
    """The mesh with a UV layer's coordinates moved from a UDIM tile to 0..1."""
    place = np.array(tile_place(tile), dtype=np.float32)
    attributes = tuple(
        replace(attribute, values=_moved(attribute.values, place)) if attribute.name == layer else attribute
        for attribute in mesh.attributes
    )
    return replace(mesh, attributes=attributes)


def _moved(uv: Floats, place: Floats) -> Floats:
    moved: Floats = np.clip((uv - place).astype(np.float32), 0.0, 1.0)
    return moved


def number_parts(mesh: bpy.types.Mesh, parts: Sequence[Bools]) -> Ints:
    """Write the number of each face's part to a baked copy, and return it, (F,); `parts` are (F,) each."""
    numbers = np.zeros(len(mesh.polygons), dtype=np.int32)
    for index, faces in enumerate(parts):
        numbers[faces] = index
    write_face_numbers(mesh, PART, numbers)
    return numbers
