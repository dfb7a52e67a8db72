# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes of meshes, hair and point clouds as arrays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

# How attributes are read and written in bulk: property, values per element, dtype.
ATTRIBUTE_LAYOUT: dict[str, tuple[str, int, type[np.generic]]] = {
    "FLOAT": ("value", 1, np.float32),
    "INT": ("value", 1, np.int32),
    "INT8": ("value", 1, np.int32),
    "BOOLEAN": ("value", 1, np.bool_),
    "FLOAT2": ("vector", 2, np.float32),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color_srgb", 4, np.float32),
    "INT32_2D": ("value", 2, np.int32),
    "INT16_2D": ("value", 2, np.int32),
    "QUATERNION": ("value", 4, np.float32),
}
PLACES = "position POINT FLOAT_VECTOR"  # the label of vertices' positions
_CORNERS = ".corner_vert"  # other attributes whose names begin with a dot only matter to the editor


@dataclass(frozen=True, eq=False)
class StoredArray:
    """The values (N,) of an attribute; `label` is its name, domain and type.

    For other data `label` and `domain` are empty.
    """

    label: str
    domain: str
    values: npt.NDArray[Any]


def stored_arrays(data: Any) -> Iterator[StoredArray]:
    """All attributes of a mesh, hair or a point cloud, and the first corners of a mesh's faces."""
    for layer in getattr(data, "attributes", ()):
        if (layer.name.startswith(".") and layer.name != _CORNERS) or layer.data_type not in ATTRIBUTE_LAYOUT:
            continue
        name, width, dtype = ATTRIBUTE_LAYOUT[layer.data_type]
        label = f"{layer.name} {layer.domain} {layer.data_type}"
        yield StoredArray(label, layer.domain, bulk(layer.data, name, width, dtype))
    if isinstance(data, bpy.types.Mesh):
        yield StoredArray("", "", bulk(data.polygons, "loop_start", 1, np.int32))


def bulk(collection: Any, name: str, width: int, dtype: type[np.generic]) -> npt.NDArray[Any]:
    """The values (N * width,) of a property of all items of a collection."""
    values = np.empty(len(collection) * width, dtype=dtype)
    collection.foreach_get(name, values)
    return values
