# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes in the place of instances, in the open scene: of a collection's, or of those that nodes make.

The object that shows the instances keeps its place and gives its name away, and is hidden. Lamps among its
instances become lamps of the scene.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from ..core.arrays import Floats
from ..core.messages import Message, do
from ..preview.light_linking import link_alike
from ..preview.swap import homes
from ..scene.mesh.copy import copy_object, plain_mesh
from ..scene.mesh.instance_parts import (
    Lamp,
    Owned,
    Part,
    joined_parts,
    read_owned,
    set_visibility,
    shows_instances,
)
from ..scene.objects import animates_visibility, is_linked, is_rendered
from ..scene.scratch import at_frame, find_view_layer, scratch_scene

_HIDDEN = " (instances)"  # is added to the name of the object that shows them
_RAYS = ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow")
_SHEARED = 1e-5  # relative to a matrix's largest value
_REAL = do("make instances real (Object > Apply)")


@dataclass(frozen=True)
class Joined:
    """Objects that were made in the place of the instances of the one called `name`."""

    name: str
    objects: tuple[str, ...]
    instances: int

    @property
    def told(self) -> str:
        """What was made, in a line."""
        what = f"{self.instances} instances: they are" if self.instances > 1 else "an instance: it is"
        if len(self.objects) == 1:
            return f"'{self.name}' shows {what} baked as one mesh"
        others = ", ".join(f"'{name}'" for name in self.objects[1:])
        return f"'{self.name}' shows {what} baked as {len(self.objects)} meshes, the others are {others}"


def join_instances(
    scene: bpy.types.Scene,
    items: Sequence[bpy.types.Object],
    frame: int | None = None,
    *,
    as_one: bool = False,
) -> tuple[list[Joined], list[Message]]:
    """Make meshes of the instances of those `items` that show any, at a `frame`; with messages on the others.

    With `as_one`, only where one object of the same name can take the place. Objects without instances stay
    as they are. The scene is changed for good. Raises BakeError where Blender does not render.
    """
    layer = find_view_layer(scene, None)
    owners = [item for item in dict.fromkeys(items) if shows_instances(item) and is_rendered(item, layer)]
    if not owners:
        return [], []
    with at_frame(scene, frame), scratch_scene(scene) as scratch:
        read = read_owned(scratch, owners)
        found = [(owned, () if owned.why_not else joined_parts(owned)) for owned in read]
    made, messages = [], []
    for owned, parts in found:
        if why := _why_not(owned, parts, as_one):
            problem = f"the instances that '{owned.owner.name}' shows are not baked: {why}"
            messages.append(Message(problem, (_REAL,)))
        elif parts:
            made.append(_replace(owned, parts))
    if made:
        layer.update()
    return made, messages


def _why_not(owned: Owned, parts: Sequence[Part], as_one: bool) -> str:
    if owned.why_not:
        return owned.why_not
    if is_linked(owned.owner):
        return "it is linked from another file, where nothing can be hidden"
    if animates_visibility(owned.owner):
        return "its visibility is animated"
    own = (part.mesh.matrix_world for part in parts if part.mesh.matrix_world is not owned.matrix)
    if any(map(_is_sheared, own)):
        return "one of them is sheared"
    if as_one and len(parts) > 1:
        return "its parts cannot be one mesh, as a material reads its object's own coordinates"
    return ""


def _is_sheared(matrix: Floats) -> bool:
    """Whether location, rotation and scale cannot express a matrix (4, 4)."""
    parts: Any = Matrix(matrix.tolist()).decompose()
    return bool(np.abs(np.array(Matrix.LocRotScale(*parts)) - matrix).max() > _SHEARED * np.abs(matrix).max())


def _replace(owned: Owned, parts: Sequence[Part]) -> Joined:
    """Put objects in the place of the owner, and hide it."""
    owner: Any = owned.owner
    name = owner.name
    owner.name = f"{name}{_HIDDEN}"
    made = []
    for number, part in enumerate(parts):
        called = name if not number else f"{name} {part.mesh.name}"
        made.append(_object_of(owned, part, called).name)
    for lamp in owned.lamps:
        _add_lamp(owned, lamp, name)
    owner.hide_render = owner.hide_viewport = True
    return Joined(name, tuple(made), owned.instances)


def _object_of(owned: Owned, part: Part, name: str) -> bpy.types.Object:
    """A mesh object that shows a part in the place of the owner."""
    mesh = plain_mesh(part.mesh)
    owner = owned.owner
    item = copy_object(owner, mesh)
    item.name = mesh.name = name
    link_alike(item, owner, homes(owner))
    set_visibility(item, part.seen_by)
    if owner.type == "EMPTY":
        item.display_type = "TEXTURED"
    if part.mesh.matrix_world is not owned.matrix:  # it is in its own space
        item.parent = None
        item.constraints.clear()
        item.animation_data_clear()
        item.matrix_world = Matrix(part.mesh.matrix_world.tolist())
    return item


def _add_lamp(owned: Owned, lamp: Lamp, name: str) -> None:
    """A lamp of the scene that shines as an instanced one."""
    of: Any = lamp.original
    item: Any = bpy.data.objects.new(f"{name} {of.name}", of.data)
    item.matrix_world = Matrix(lamp.matrix.tolist())
    link_alike(item, owned.owner, homes(owned.owner))
    for ray in _RAYS:
        setattr(item, f"visible_{ray}", getattr(of, f"visible_{ray}"))
    for linking in ("receiver_collection", "blocker_collection"):
        setattr(item.light_linking, linking, getattr(of.light_linking, linking))


def join_for(scene: bpy.types.Scene, names: Sequence[str], frame: int | None = None) -> None:
    """Let the scene have the objects that a bake of these `names` was of, as far as they were instances."""
    known = scene.objects
    if any(name not in known or shows_instances(known[name]) for name in names):
        join_instances(scene, list(known), frame)


def names_joined(joined: Sequence[Joined], names: Sequence[str]) -> Iterator[str]:
    """The names of objects, each followed by those that were made beside it."""
    beside = {one.name: one.objects[1:] for one in joined}
    for name in names:
        yield name
        yield from beside.get(name, ())
