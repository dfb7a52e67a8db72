# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators on the bake list: add objects, take one off, move it, clear the list."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import bpy
from bpy.props import EnumProperty, StringProperty

from ..panel.panel_state import mark_stale
from ..settings.chosen_objects import chosen_by, selected_meshes
from .bake_lookup import in_object_mode
from .bake_operator import shown
from .undo import push_step

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems

_ADDED = (
    ("SELECTED", "Selected", "The selected meshes"),
    ("COLLECTION", "Collection", "Every mesh of the active collection, and of those in it"),
)
_WAYS = (("UP", "Up", "Bake it earlier"), ("DOWN", "Down", "Bake it later"))


class RADTEX_OT_list_add(bpy.types.Operator):
    """Add objects to the end of the bake list; those that are on it stay where they are"""

    bl_idname = "radtex.list_add"
    bl_label = "Add to Bake List"
    bl_options = {"REGISTER"}  # pushes its own undo step: see undo.py

    if TYPE_CHECKING:
        what: str
    else:
        what: EnumProperty(
            name="Objects", description="Which objects to add", items=_ADDED, default="SELECTED"
        )

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...preview.collection_meshes import meshes_of
        from ...preview.swap import original_of

        scene, layer = shown(context)
        chosen = chosen_by(scene)
        found = selected_meshes(layer)
        if self.what == "COLLECTION":
            active = layer.active_layer_collection
            found = meshes_of(active.collection if active is not None else None, layer)
        listed = {row.item for row in chosen.listed}
        new = dict.fromkeys(item for one in found if (item := original_of(one) or one) not in listed)
        if not new:
            self.report({"WARNING"}, "All of them are on the list" if found else "There is no mesh to add")
            return {"CANCELLED"}
        for item in new:
            chosen.listed.add().item = item
        chosen.active = len(chosen.listed) - 1
        return _done(self.bl_label)


class _OnRow:
    """Mixin of operators that need a marked row of the list."""

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        """Whether a row is marked; sets the operator's message if not."""
        chosen = chosen_by(shown(context)[0])
        if 0 <= chosen.active < len(chosen.listed):
            return True
        cast(Any, cls).poll_message_set("The bake list is empty: add objects to it")
        return False


class RADTEX_OT_list_remove(_OnRow, bpy.types.Operator):
    """Take the marked object off the bake list; the object stays"""

    bl_idname = "radtex.list_remove"
    bl_label = "Remove from Bake List"
    bl_options = {"REGISTER"}

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        chosen = chosen_by(shown(context)[0])
        chosen.listed.remove(chosen.active)
        chosen.active = max(0, min(chosen.active, len(chosen.listed) - 1))
        return _done(self.bl_label)


class RADTEX_OT_list_move(_OnRow, bpy.types.Operator):
    """Bake the marked object earlier or later"""

    bl_idname = "radtex.list_move"
    bl_label = "Move in Bake List"
    bl_options = {"REGISTER"}

    if TYPE_CHECKING:
        way: str
    else:
        way: EnumProperty(name="Way", description="Where to move it", items=_WAYS, default="UP")

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        chosen = chosen_by(shown(context)[0])
        to = chosen.active + (1 if self.way == "DOWN" else -1)
        if not 0 <= to < len(chosen.listed):
            return {"CANCELLED"}
        chosen.listed.move(chosen.active, to)
        chosen.active = to
        return _done(self.bl_label)


class RADTEX_OT_list_clear(_OnRow, bpy.types.Operator):
    """Take all objects off the bake list; the objects stay"""

    bl_idname = "radtex.list_clear"
    bl_label = "Clear Bake List"
    bl_options = {"REGISTER"}

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        chosen = chosen_by(shown(context)[0])
        chosen.listed.clear()
        chosen.active = 0
        return _done(self.bl_label)


class RADTEX_OT_show_settings(bpy.types.Operator):
    """Show the settings by which the object is baked: it is marked in the bake list, or made active"""

    bl_idname = "radtex.show_settings"
    bl_label = "Show Settings"
    bl_options = {"REGISTER", "INTERNAL"}  # pushes its own undo step: see undo.py

    if TYPE_CHECKING:
        object: str
    else:
        object: StringProperty(
            name="Object",
            description="Name of the object whose settings the panel shows then",
            options={"SKIP_SAVE"},
        )

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        return chosen_by(shown(context)[0]).source == "list" or in_object_mode(cls, context)

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...preview.swap import copy_of, original_of

        scene, layer = shown(context)
        chosen = chosen_by(scene)
        if chosen.source == "list":
            items = [row.item and (original_of(row.item) or row.item) for row in chosen.listed]
            rows = [number for number, item in enumerate(items) if item and item.name == self.object]
            if not rows:
                self.report({"ERROR"}, f"'{self.object}' is not on the bake list: add it first")
                return {"CANCELLED"}
            chosen.active = rows[0]
            return _done(self.bl_label)
        item = layer.objects.get(self.object)
        if item is None:
            self.report({"ERROR"}, f"view layer '{layer.name}' has no object '{self.object}': name another")
            return {"CANCELLED"}
        layer.objects.active = copy_of(item) or item
        return _done(self.bl_label)


def _done(label: str) -> set[OperatorReturnItems]:
    mark_stale()
    push_step(label)
    return {"FINISHED"}
