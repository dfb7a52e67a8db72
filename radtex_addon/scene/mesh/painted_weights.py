# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Painted weights: a vertex group that says where an unwrap gives more or fewer texels.

An evaluated mesh carries them as the attribute WEIGHT of its vertices, so that they stay with these whatever
is done to the mesh, and count in its digest.
"""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from ...core.arrays import Floats
from ...core.errors import InputError
from .attribute_arrays import bulk

if TYPE_CHECKING:
    from .evaluated import EvaluatedMesh

WEIGHT = "radtex_texel_weight"
UNPAINTED = 0.5  # the weight of what is not in the group: as many texels as without it


def group_weights(mesh: Any, group: int, missing: float) -> Floats:
    """The weights (V,) of a Blender mesh's vertices in a group, by its index; `missing` of others."""
    found = np.full(len(mesh.vertices), missing)
    for number, vertex in enumerate(mesh.vertices):
        for element in vertex.groups:
            if element.group == group:
                found[number] = element.weight
    return found


def read_weights(rendered: bpy.types.Object, mesh: Any, name: str) -> Floats | None:
    """The weights (V, 1) float32, 0 to 1, that an evaluated object's `mesh` has in the group called `name`.

    Geometry nodes may make a float attribute of points instead of a group. None if there is neither.
    """
    group = rendered.vertex_groups.get(name)
    if group is not None:
        found = group_weights(mesh, group.index, UNPAINTED)
    else:
        attribute = mesh.attributes.get(name)
        if attribute is None or (attribute.domain, attribute.data_type) != ("POINT", "FLOAT"):
            return None
        found = bulk(attribute.data, "value", 1, np.float32)
    weights: Floats = np.clip(np.nan_to_num(found, nan=UNPAINTED), 0, 1).astype(np.float32)[:, None]
    return weights


def painted_triangles(meshes: Sequence[EvaluatedMesh]) -> Floats | None:
    """The mean weights (F,) of the meshes' triangles, one mesh after another; None if none was painted."""
    found = [_of_mesh(mesh) for mesh in meshes]
    if all(weights is None for weights in found):
        return None
    pairs = zip(meshes, found, strict=True)
    return np.concatenate(
        [np.full(len(mesh.triangles), UNPAINTED) if some is None else some for mesh, some in pairs]
    )


def _of_mesh(mesh: EvaluatedMesh) -> Floats | None:
    for attribute in mesh.attributes:
        if attribute.name == WEIGHT:
            found: Floats = attribute.values[:, 0].astype(np.float64)[mesh.triangles].mean(axis=1)
            return found
    return None


def check_painted(items: Sequence[bpy.types.Object], others: Iterable[bpy.types.Object], name: str) -> None:
    """Raise InputError if neither the `items` to bake nor the `others` of the scene have such a vertex group.

    Those of several bakes may have it on some objects alone. The objects are not evaluated: one with geometry
    nodes passes, since these may make it in renders.
    """
    if any(_has(item, name) or _may_make_it(item) for item in items):
        return
    if not any(_has(each, name) for each in others):
        raise InputError(f"{_titles(items)} has no vertex group '{name}' for texel weights: {_known(items)}")


def unpainted_warning(items: Sequence[bpy.types.Object], name: str) -> str:
    """The warning about a bake none of whose objects has the group in renders."""
    return f"{_titles(items)} has no vertex group '{name}' in renders: it gets its texels as without one"


def weights_digest(item: bpy.types.Object, name: str) -> str:
    """A digest of what is painted on an object itself, before its modifiers; "" if nothing is."""
    if not _has(item, name):
        return ""
    data: Any = item.data
    weights = group_weights(data, item.vertex_groups[name].index, UNPAINTED).astype(np.float32)
    return hashlib.sha256(weights.tobytes()).hexdigest()


def _has(item: bpy.types.Object, name: str) -> bool:
    return item.type == "MESH" and name in item.vertex_groups


def _may_make_it(item: bpy.types.Object) -> bool:
    return any(modifier.type == "NODES" for modifier in item.modifiers)


def _titles(items: Collection[bpy.types.Object]) -> str:
    return "object " + " or ".join(f"'{item.name}'" for item in items)


def _known(items: Iterable[bpy.types.Object]) -> str:
    names = dict.fromkeys(group.name for item in items for group in item.vertex_groups)
    return f"it has {', '.join(map(repr, names))}" if names else "paint one, or leave it out"
