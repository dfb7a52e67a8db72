# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of a surface that have atlases of their own: a material each, or a UDIM tile."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import bpy
import numpy as np

from ...bake.parts import Split, tile_name, tile_place
from ...core.arrays import Bools, Floats, Ints
from ...core.errors import InputError
from .evaluated import EvaluatedMesh

PART = "radtex_part"  # an attribute of the baked copy's faces: the number of the part that each belongs to
NO_MATERIAL = "none"  # a part's name
_EDGE = 1e-4  # of a tile: how far a face may reach over by rounding
_NOTHING = 1e-7  # of a tile's area: what rounding makes of none

Parts = dict[str, Bools]  # by name, which triangles (F,) belong to each


def parts_of(mesh: EvaluatedMesh, split: Split, uv_layer: str | None) -> Parts:
    """The parts of a mesh by name, none without a triangle, and no triangle in two of them.

    Materials come in their slots' order, tiles in that of their numbers. Raises InputError for a UV layer
    that is missing, or not made of tiles.
    """
    if split is Split.MATERIAL:
        return _materials(mesh)
    assert uv_layer is not None  # a specification that is split by tiles has one
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
    """The tiles (F, 2) of triangles with corners `uv` (F, 3, 2), of which `place` (F, 2) is the first guess.

    One on a tile's far edge is in the next by rounding down. Where a tile's triangles have no area together,
    they belong to the nearest that has some, for the atlas of theirs would be empty.
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
    """The mesh with those of its triangles alone where `faces` (F,) is True; vertices stay."""
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
    """The mesh with the coordinates of a UV layer moved from a UDIM tile to 0..1."""
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
    """Write to a baked copy's faces which of the `parts`, (F,) each, they belong to; returns that, (F,)."""
    numbers = np.zeros(len(mesh.polygons), dtype=np.int32)
    for index, faces in enumerate(parts):
        numbers[faces] = index
    attribute: Any = mesh.attributes.get(PART) or mesh.attributes.new(PART, "INT", "FACE")
    attribute.data.foreach_set("value", numbers)
    return numbers
