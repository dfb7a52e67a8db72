# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Selected objects that have no mesh to bake: what they are, and what to do about it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import bpy

from ...scene.surfaces import may_have_faces

CONVERT = "object.convert"
_CONVERTED = ("CURVES", "POINTCLOUD")
_CALLED = {
    "CURVES": "hair curves",
    "POINTCLOUD": "a point cloud",
    "VOLUME": "a volume",
    "GREASEPENCIL": "a drawing",
    "LIGHT": "a light",
    "LIGHT_PROBE": "a light probe",
    "CAMERA": "a camera",
    "ARMATURE": "an armature",
    "LATTICE": "a lattice",
    "SPEAKER": "a speaker",
    "EMPTY": "an empty",
}


@dataclass(frozen=True)
class NotBaked:
    """Why selected objects are not baked, in one line, and the button that helps: its operator and its text.

    `operator` is empty if no button helps.
    """

    text: str
    operator: str = ""
    button: str = ""


def not_baked(items: Iterable[bpy.types.Object]) -> tuple[NotBaked, ...]:
    """A line for each sort of selected object that is no mesh, with the first one's name."""
    chosen = list(items)
    others = [item for item in chosen if not may_have_faces(item)]
    convertible = [item for item in others if item.type in _CONVERTED]
    instances = [item for item in others if item.type == "EMPTY" and item.instance_type == "COLLECTION"]
    rest = [item for item in others if item not in convertible and item not in instances]
    found = []
    if convertible:
        text = f"{_named(convertible)}: it has no faces. Convert it, or a copy of it"
        alone = len(others) == len(chosen)  # converting applies the modifiers of all selected meshes
        found.append(NotBaked(text, CONVERT, "Convert to Mesh") if alone else NotBaked(text))
    if instances:
        text = f"'{instances[0].name}' shows a collection's instances, which are no objects. Join them"
        found.append(NotBaked(text, "radtex.join_instances", "Join Instances"))
    if rest:
        found.append(NotBaked(_without_mesh(rest, alone=len(others) == len(chosen))))
    return tuple(found)


def _without_mesh(items: list[bpy.types.Object], *, alone: bool) -> str:
    """The line on objects that never have a mesh; if nothing else is selected, with what to select."""
    named = _named(items)
    if not alone:
        return f"Left out: {named}"
    if len(items) > 1:
        return f"{named}: they have no surface to bake. Select meshes"
    if items[0].type == "LIGHT":
        return f"{named}, and has no surface to bake. Select the meshes that are to show its light"
    return f"{named}, and has no mesh. Select a mesh"


def _named(items: list[bpy.types.Object]) -> str:
    """The first object of each sort, and how many more of it there are."""
    sorts: dict[str, list[str]] = {}
    for item in items:
        sorts.setdefault(_CALLED.get(item.type, "no mesh"), []).append(item.name)
    return ", ".join(
        f"'{first}' is {called}" + (f" (and {len(others)} more such)" if others else "")
        for called, (first, *others) in sorts.items()
    )
