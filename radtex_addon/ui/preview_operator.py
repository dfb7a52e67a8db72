# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The switch between an object and its bake."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.props import EnumProperty

from .finding import originals, sidecars_of
from .of_bake import OfBake
from .operator import shown
from .words import remark

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems

_ACTIONS = (
    ("TOGGLE", "Toggle", "Show what is not shown; if all are, the objects themselves"),
    ("ON", "On", "Show the bake, read anew"),
    ("OFF", "Off", "Show the object itself"),
)


class RADTEX_OT_preview_toggle(OfBake, bpy.types.Operator):
    """Show the bake in the object's place, as it was lit. The object is hidden meanwhile, and unchanged"""

    bl_idname = "radtex.preview_toggle"
    bl_label = "Preview Bake"
    bl_options = {"REGISTER", "UNDO"}

    if TYPE_CHECKING:  # what an instance holds; Blender makes it from the annotations below
        action: str
    else:
        action: EnumProperty(
            name="Action",
            description="What to show",
            items=_ACTIONS,
            default="TOGGLE",
            options={"SKIP_SAVE"},
        )

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ..core.errors import RadTexError
        from ..preview.swap import is_on, switch_off

        scene, layer = shown(context)
        try:
            items = originals(layer, self.object)
            off = self.action == "OFF" or (self.action == "TOGGLE" and all(map(is_on, items)))
            if not off:
                self._switch_on(scene, items)
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        for item in items if off else ():
            switch_off(item)
        return {"FINISHED"}

    def _switch_on(self, scene: bpy.types.Scene, items: list[bpy.types.Object]) -> None:
        """Show every bake that there is, or none. Raises RadTexError."""
        from ..core.errors import RadTexError
        from ..preview.swap import is_on, switch_off, switch_on

        wanted = [item for item in items if self.action == "ON" or not is_on(item)]
        before = [item for item in wanted if is_on(item)]
        sidecars, errors = sidecars_of(scene, wanted, self.bake)
        made = []
        try:
            for item, sidecar in sidecars.items():
                made.append(switch_on(item, sidecar))
        except RadTexError:
            for preview in made:
                if preview.original not in before:
                    switch_off(preview.original)
            raise
        for error in errors:
            self.report({"WARNING"}, remark(error))
        for name in (preview.original.name for preview in made if preview.moved):
            self.report({"WARNING"}, f"{name} has moved since the bake: it shows the light of its old place")
