# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The meshes that an unfinished bake began with: all its pieces are of these.

Blender may evaluate an object otherwise the next time, by rounding, and pieces must fit each other.
"""

from __future__ import annotations

from dataclasses import replace

from ..bake.piece_store import Arrays, PieceStore
from ..scene.mesh.evaluated import EvaluatedMesh

_ATTRIBUTE = "attribute {}"
_FIELDS = ("position", "triangles", "normal", "material_index")


def as_begun(mesh: EvaluatedMesh, store: PieceStore, name: str) -> EvaluatedMesh:
    """The mesh as the store has it in the piece `name`, where it goes on with a bake; else it gets the mesh.

    A mesh that no modifier makes is the same each time, and is not stored. All facts have to be set before.
    """
    if not mesh.made_of or not store.keeps:
        return mesh
    piece = store.get_or_make(name, lambda: _arrays_of(mesh))
    attributes = tuple(
        replace(attribute, values=piece[_ATTRIBUTE.format(attribute.name)]) for attribute in mesh.attributes
    )
    fields = {field: piece[field] for field in _FIELDS}
    return replace(mesh, **fields, attributes=attributes, texture_space=(piece["location"], piece["size"]))  # type: ignore[arg-type]  # all are arrays


def _arrays_of(mesh: EvaluatedMesh) -> Arrays:
    location, size = mesh.texture_space
    fields: Arrays = {field: getattr(mesh, field) for field in _FIELDS}
    attributes = {_ATTRIBUTE.format(attribute.name): attribute.values for attribute in mesh.attributes}
    return fields | attributes | {"location": location, "size": size}
