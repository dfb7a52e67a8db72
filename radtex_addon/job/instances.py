# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes in the place of instances, in the open scene: of a collection's, or of those that nodes make.

The object that shows the instances keeps its place and gives its name away, and is hidden. Lamps among its
instances become lamps of the scene.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, cast

import bpy
from mathutils import Matrix

from ..core.errors import InputError
from ..core.messages import Message, do
from ..preview.light_linking import link_alike
from ..preview.swap import homes, is_on, previews_not_rendered, stand_in
from ..scene.mesh.copy import plain_mesh
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
from ..scene.preview_file import is_sheared
from ..scene.scratch import find_view_layer, scratch_scene

_HIDDEN = " (instances)"  # is added to the name of the object that shows them
_NAMED = 50  # bytes of that name that are kept: Blender 4.5 has 63
_REAL = do("make instances real (Object > Apply)")


@dataclass(frozen=True)
class Joined:
    """Objects in the place of the instances of the one that was called `name`, and is `hidden` now."""

    name: str
    hidden: str
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
    scene: bpy.types.Scene, items: Sequence[bpy.types.Object]
) -> tuple[list[Joined], list[Message]]:
    """Make meshes of the instances of those `items` that show any, with messages on those that cannot be.

    Objects without instances stay as they are. The scene is changed for good. Raises BakeError where Blender
    does not render.
    """
    layer = find_view_layer(scene, None)
    owners = [item for item in dict.fromkeys(items) if shows_instances(item) and is_rendered(item, layer)]
    if not owners:
        return [], []
    with scratch_scene(scene) as scratch, previews_not_rendered(scratch):
        read = read_owned(scratch, owners)
    made, messages = [], []
    for owned in read:
        try:
            parts = _parts_of(owned)
        except InputError as error:
            problem = f"the instances that '{owned.owner.name}' shows are not baked: {error.message.problem}"
            messages.append(Message(problem, (_REAL,)))
        else:
            if parts:
                made.append(_replace(owned, parts))
    if made:
        layer.update()
    return made, messages


def _parts_of(owned: Owned) -> list[Part]:
    """The meshes that take the owner's place. Raises InputError, which says why there cannot be any."""
    owner = owned.owner
    if owned.why_not:
        raise InputError(owned.why_not)
    if is_linked(owner):
        raise InputError("it is linked from another file, where nothing can be hidden")
    if animates_visibility(owner):
        raise InputError("its visibility is animated")
    if owner.mode != "OBJECT":
        raise InputError("it is being edited")
    if shown := next((part for part in owned.parts if is_on(part.original)), None):
        raise InputError(f"'{shown.original.name}' among them is shown by its preview: switch that off")
    parts = joined_parts(owned)
    own = (part.mesh.matrix_world for part in parts if part.mesh.matrix_world is not owned.matrix)
    if any(is_sheared(Matrix(matrix.tolist())) for matrix in own):
        raise InputError("one of them is sheared")
    return parts


def _replace(owned: Owned, parts: Sequence[Part]) -> Joined:
    """Put objects in the place of the owner, and hide it."""
    owner: Any = owned.owner
    name = owner.name
    owner.name = name.encode()[:_NAMED].decode(errors="ignore") + _HIDDEN
    made = []
    for number, part in enumerate(parts):
        own = f"{number + 1}" if part.original == owner else part.original.name  # nodes make bare meshes
        called = f"{name} {own}" if number else name
        made.append(_object_of(owned, part, called).name)
    for lamp in owned.lamps:
        _add_lamp(owned, lamp, name)
    owner.hide_render = owner.hide_viewport = True
    return Joined(name, owner.name, tuple(made), owned.instances)


def _object_of(owned: Owned, part: Part, name: str) -> bpy.types.Object:
    """A mesh object that shows a part in the place of the owner."""
    mesh = plain_mesh(part.mesh)
    owner, of = owned.owner, cast(Any, part.original)
    item: Any = stand_in(owner, mesh)
    item.name = mesh.name = name
    link_alike(item, owner, homes(owner))
    set_visibility(item, part.seen_by)
    if any(part.linking):
        item.light_linking.receiver_collection, item.light_linking.blocker_collection = part.linking
    if owner.type == "EMPTY":
        item.display_type = "TEXTURED"
    if part.mesh.matrix_world is not owned.matrix:  # it is in its own space
        item.parent = None
        item.constraints.clear()
        item.animation_data_clear()
        item.matrix_world = Matrix(part.mesh.matrix_world.tolist())
        item.pass_index = of.pass_index
        for key in of.keys():  # noqa: SIM118 (of custom properties)
            item[key] = of[key]
    return cast(bpy.types.Object, item)


def _add_lamp(owned: Owned, lamp: Lamp, name: str) -> None:
    """A lamp of the scene that shines as an instanced one."""
    of: Any = lamp.original
    item: Any = bpy.data.objects.new(f"{name} {of.name}", of.data)
    item.matrix_world = Matrix(lamp.matrix.tolist())
    link_alike(item, owned.owner, homes(owned.owner))
    set_visibility(item, lamp.seen_by)
    for linking in ("receiver_collection", "blocker_collection"):
        setattr(item.light_linking, linking, getattr(of.light_linking, linking))


def join_for(scene: bpy.types.Scene, names: Sequence[str], frame: int | None = None) -> None:
    """Let the scene have the objects that a bake of these `names` was of, as far as they were instances.

    Those of a bake at a `frame` of its own were none.
    """
    known = scene.objects
    if frame is None and any(name not in known or shows_instances(known[name]) for name in names):
        join_instances(scene, list(known))


def names_joined(joined: Sequence[Joined], names: Sequence[str]) -> Iterator[str]:
    """The names of objects, each followed by those that were made beside it."""
    beside = {one.name: one.objects[1:] for one in joined}
    for name in names:
        yield name
        yield from beside.get(name, ())
