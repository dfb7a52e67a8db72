# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects of which renders show faces: meshes, and curves, surfaces, texts and metaballs as they evaluate."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import bpy

MADE_TO_MESHES = frozenset({"CURVE", "SURFACE", "FONT", "META"})  # types; renders list their meshes, too
_SURFACES = MADE_TO_MESHES | {"MESH"}


def may_have_faces(item: bpy.types.Object) -> bool:
    """Whether an object is of a type of which renders show faces."""
    return item.type in _SURFACES


def is_own_mesh(instance: bpy.types.DepsgraphObjectInstance) -> bool:
    """Whether that is the mesh that Blender makes of a curve, surface, text or metaball, in its own place.

    A depsgraph lists it as an instance of the object, beside that.
    """
    owner, item = instance.parent, instance.object
    if not instance.is_instance or owner is None or item is None or owner.type not in MADE_TO_MESHES:
        return False
    return item.original == owner.original and instance.matrix_world == owner.matrix_world


@contextmanager
def shown_mesh(evaluated: bpy.types.Object) -> Iterator[Any]:
    """The mesh that an evaluated object shows, while the context lasts; None if it has none."""
    if isinstance(evaluated.data, bpy.types.Mesh):
        yield evaluated.data
        return
    try:
        made = evaluated.to_mesh()
    except RuntimeError:  # a metaball whose faces are another one's
        made = None
    try:
        yield made
    finally:
        evaluated.to_mesh_clear()
