# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Named regions of an object: vertex groups, boolean face attributes and materials."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, cast

import bpy
import numpy as np

from ...core.arrays import Bools, Floats
from ...core.errors import InputError
from .evaluated import find_rendered, render_with
from .painted_weights import group_weights

_HALF = 0.5  # a face is in a vertex group if its corners have this mean weight or more
_LISTED = 8  # names in a message
_OWN = ("sharp_face",)  # Blender's own attributes, which name no region


def check_where(items: Sequence[bpy.types.Object], name: str) -> None:
    """Raise InputError if none of the objects has a region called `name`.

    The objects are not evaluated: one with geometry nodes passes, since these may make attributes in renders.
    """
    if any(name in places_on(item) or _may_make_more(item) for item in items):
        return
    raise _nowhere(items, name)


def places_on(item: bpy.types.Object) -> dict[str, str]:
    """Names of an object's regions, and the kind of each in words, such as "vertex group"."""
    found = {slot.material.name: "material" for slot in item.material_slots if slot.material is not None}
    for attribute in getattr(item.data, "attributes", ()):
        if _is_of_faces(attribute) and not attribute.name.startswith(".") and attribute.name not in _OWN:
            found[attribute.name] = "boolean attribute"
    return found | {group.name: "vertex group" for group in item.vertex_groups}


def chosen_triangles(
    scratch: bpy.types.Scene, originals: Sequence[bpy.types.Object], name: str
) -> list[Bools]:
    """Which triangles of each object's evaluated mesh belong to the region called `name`: (F,) each.

    The triangles are in the order of `evaluated.evaluate`. A face is in a vertex group if the mean weight of
    its corners is a half or more. Raises InputError if no object has such a region, if an object has two, or
    if the region has no face.
    """

    def read(depsgraph: bpy.types.Depsgraph) -> list[Bools]:
        found, named = [], False
        for original in originals:
            rendered, _ = find_rendered(depsgraph, original)
            faces = None if rendered is None else _of_object(original.name, rendered, name)
            named = named or (faces is not None and faces[1])
            found.append(np.zeros(0, dtype=bool) if faces is None else faces[0])
        if not named:
            raise _nowhere(originals, name)
        return found

    found = render_with(scratch, read)
    if not any(faces.any() for faces in found):
        raise InputError(f"no face belongs to '{name}': put some there, or name another place")
    return found


def _of_object(title: str, rendered: bpy.types.Object, name: str) -> tuple[Bools, bool]:
    """The region's triangles (F,), and whether the object has such a region."""
    mesh = cast(Any, rendered.to_mesh())
    try:
        places = list(_places(rendered, mesh, name))
        if len(places) > 1:
            kinds = " and a ".join(kind for kind, _ in places)
            raise InputError(f"object '{title}' has a {kinds} called '{name}': rename one of them")
        mesh.calc_loop_triangles()
        polygon = np.empty(len(mesh.loop_triangles), dtype=np.int32)
        mesh.loop_triangles.foreach_get("polygon_index", polygon)
        chosen = places[0][1] if places else np.zeros(len(mesh.polygons), dtype=bool)
        return chosen[polygon], bool(places)
    finally:
        rendered.to_mesh_clear()


def _places(rendered: bpy.types.Object, mesh: Any, name: str) -> Iterator[tuple[str, Bools]]:
    """Yield each region of that name: its kind in words, and which polygons (P,) it has."""
    count = len(mesh.polygons)
    group = rendered.vertex_groups.get(name)
    if group is not None:
        yield "vertex group", _weights(mesh, group.index) >= _HALF
    attribute = mesh.attributes.get(name)
    if attribute is not None and _is_of_faces(attribute):
        values = np.empty(count, dtype=bool)
        attribute.data.foreach_get("value", values)
        yield "boolean attribute", values
    slots = [
        number
        for number, slot in enumerate(rendered.material_slots)
        if slot.material is not None and slot.material.name == name
    ]
    if slots:
        index = np.empty(count, dtype=np.int32)
        mesh.polygons.foreach_get("material_index", index)
        yield "material", np.isin(np.clip(index, 0, len(rendered.material_slots) - 1), slots)


def _weights(mesh: Any, group: int) -> Floats:
    """The mean weight of each polygon's corners, (P,)."""
    of_vertex = group_weights(mesh, group, 0.0)
    corner = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corner)
    start, total = (np.empty(len(mesh.polygons), dtype=np.int32) for _ in "ab")
    mesh.polygons.foreach_get("loop_start", start)
    mesh.polygons.foreach_get("loop_total", total)
    sums: Floats = np.add.reduceat(of_vertex[corner], start)
    return sums / total


def _is_of_faces(attribute: Any) -> bool:
    return bool(attribute.domain == "FACE" and attribute.data_type == "BOOLEAN")


def _may_make_more(item: bpy.types.Object) -> bool:
    return any(modifier.type == "NODES" for modifier in item.modifiers)


def _nowhere(items: Sequence[bpy.types.Object], name: str) -> InputError:
    names = list(dict.fromkeys(place for item in items for place in places_on(item)))
    known = ", ".join(f"'{place}'" for place in names[:_LISTED]) + (", …" if len(names) > _LISTED else "")
    titles = " or ".join(f"'{item.name}'" for item in items)
    return InputError(
        f"object {titles} has no vertex group, boolean face attribute or material '{name}': "
        f"it has {known or 'none of these'}"
    )
