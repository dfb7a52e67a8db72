# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh of a finished bake, for `drawing`, from its saved preview."""

from __future__ import annotations

from typing import Any, cast

import bpy
import numpy as np
import numpy.typing as npt

from radtex_addon.report.finished_bake import Finished
from radtex_addon.scene.mesh.copy import NORMAL, SIGN, TANGENT, material_numbers
from radtex_addon.scene.preview_file import baked_copy
from tests.bench.drawing import Model


def read_model(bake: Finished) -> Model:
    """The baked copy, or several that share an atlas, as one; triangles in the order of their materials."""
    names, uv_map = bake.sidecar.surfaces, bake.sidecar.uv_map
    with baked_copy(bake.preview, names, uv_map) as (_, copy):
        mesh = cast(bpy.types.Mesh, copy.data)
        matrix = np.array(copy.matrix_world, dtype=np.float64)
        index = _values(mesh.loops, "vertex_index", 1)[:, 0].astype(int)
        place = _values(mesh.vertices, "co", 3)[index] @ matrix[:3, :3].T + matrix[:3, 3]
        attributes = cast(Any, mesh).attributes
        normal, tangent = (_values(attributes[name].data, "vector", 3) for name in (NORMAL, TANGENT))
        sign = _values(attributes[SIGN].data, "value", 1) * np.sign(np.linalg.det(matrix))
        uv = _values(attributes[uv_map].data, "vector", 2)
        material = material_numbers(mesh)
    normal, tangent = normal @ np.linalg.inv(matrix[:3, :3]), tangent @ matrix[:3, :3].T
    corners = np.concatenate([place, normal, tangent, sign, uv], axis=1).astype(np.float32)
    order = np.argsort(material, kind="stable")
    corners = np.ascontiguousarray(corners.reshape(-1, 3, 12)[order].reshape(-1, 12))
    return Model.of(corners, tuple((3 * np.bincount(material)).tolist()))


def _values(items: Any, field: str, width: int) -> npt.NDArray[np.float64]:
    values = np.empty(len(items) * width, dtype=np.int32 if field == "vertex_index" else np.float32)
    items.foreach_get(field, values)
    return values.reshape(-1, width).astype(np.float64)
