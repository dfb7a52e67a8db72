# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator that does what a message in the panel asks for: it sets one of the settings."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import StringProperty

from ..panel.panel_state import mark_stale
from ..settings.bake_settings import NAMES
from ..settings.object_settings import settings_for
from .bake_operator import shown
from .undo import push_step

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems


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
