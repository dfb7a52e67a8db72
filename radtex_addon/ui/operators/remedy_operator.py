# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that do what a message in the panel asks for: set one of the settings, or a scale that is 0."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import bpy
from bpy.props import StringProperty

from ..panel.panel_state import mark_stale
from ..settings.bake_settings import NAMES
from ..settings.chosen_objects import chosen_names
from ..settings.object_settings import settings_for
from .bake_operator import shown
from .undo import push_step

if TYPE_CHECKING:
    from collections.abc import Iterable

    from bpy.stub_internal.rna_enums import OperatorReturnItems

_ZERO = 1e-9  # of the largest scale: so flat that Cycles has no normals (`scene.mesh.mesh_checks`)


class RADTEX_OT_apply_remedy(bpy.types.Operator):
    """Change the setting as the message says"""

    bl_idname = "radtex.apply_remedy"
    bl_label = "Apply Remedy"
    bl_options = {"REGISTER", "INTERNAL"}  # pushes its own undo step: see undo.py

    if TYPE_CHECKING:
        object: str
        name: str
        value: str
    else:
        object: StringProperty(
            name="Object",
            description="The object whose settings are changed, if it has its own; else the scene's are",
            options={"SKIP_SAVE"},
        )
        name: StringProperty(name="Name", description="The setting's name", options={"SKIP_SAVE"})
        value: StringProperty(
            name="Value",
            description="What it is set to. Left empty, its default",
            options={"SKIP_SAVE"},
        )

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        settings: Any = settings_for(shown(context)[0], self.object)
        if self.name not in NAMES:
            self.report({"ERROR"}, f"There is no setting '{self.name}'")
            return {"CANCELLED"}
        if not self.value:
            settings.property_unset(self.name)
        else:
            try:
                setattr(settings, self.name, self._typed(settings.bl_rna.properties[self.name].type))
            except (TypeError, ValueError):
                self.report({"ERROR"}, f"{self.name} cannot be '{self.value}'")
                return {"CANCELLED"}
        mark_stale()
        push_step(self.bl_label)
        return {"FINISHED"}

    def _typed(self, kind: str) -> Any:
        """The value as the setting's type; raises ValueError."""
        if kind == "BOOLEAN":
            return self.value == "True"
        return {"INT": int, "FLOAT": float}.get(kind, str)(self.value)


class RADTEX_OT_fix_scale(bpy.types.Operator):
    """Set the scale to 1 along each axis along which it is 0: what is flat like that cannot be baked"""

    bl_idname = "radtex.fix_scale"
    bl_label = "Set Zero Scale to 1"
    bl_options = {"REGISTER", "INTERNAL"}  # pushes its own undo step: see undo.py

    if TYPE_CHECKING:
        objects: str
    else:
        objects: StringProperty(
            name="Objects",
            description="Names of the objects, a line each. Left empty, what the panel has chosen",
            options={"SKIP_SAVE"},
        )

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...scene.objects import is_linked

        scene, layer = shown(context)
        names = self.objects.splitlines() or chosen_names(scene, layer)
        found: list[Any] = [layer.objects.get(name) for name in names]
        items = [item for item in found if item is not None and has_zero_scale(item)]
        linked = [item.name for item in items if is_linked(item)]
        for item in items:
            if not is_linked(item):
                item.scale, item.delta_scale = _without_zeros(item.scale), _without_zeros(item.delta_scale)
        layer.update()
        left = [item.name for item in items if has_zero_scale(item)]
        if left:
            why = "it is linked: change it in its own file" if linked else "drivers or animation set it"
            self.report({"ERROR"}, f"The scale of '{left[0]}' stays 0: {why}")
        if len(left) == len(items):
            if not items:
                self.report({"ERROR"}, "No scale is 0: there is nothing to set")
            return {"CANCELLED"}
        mark_stale()
        push_step(self.bl_label)
        return {"FINISHED"}


def has_zero_scale(item: bpy.types.Object) -> bool:
    """Whether the object's own scale, not its parent's, is 0 along an axis, or as good as that."""
    scales: list[list[float]] = [[*cast(Any, item.scale)], [*cast(Any, item.delta_scale)]]
    return any(_is_zero(value, scale) for scale in scales for value in scale)


def _without_zeros(scale: Iterable[float]) -> list[float]:
    values = list(scale)
    return [1.0 if _is_zero(value, values) else value for value in values]


def _is_zero(value: float, scale: Iterable[float]) -> bool:
    return abs(value) <= _ZERO * max(map(abs, scale))
