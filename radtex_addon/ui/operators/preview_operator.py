# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator that switches between an object and the preview of its bake."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ...settings.menu_items import LAYERS
from ..panel.labels import remark
from ..panel.panel_state import mark_stale
from ..settings.chosen_bakes import bakes_by_name, choose
from .bake_lookup import bake_called, bake_location, in_object_mode, originals, sharing, sidecars_of
from .bake_operator import shown
from .operator_mixins import OfBake
from .switch import blind_line, blind_view, draw_shadings
from .undo import push_step

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
    bl_options = {"REGISTER"}  # pushes its own undo step: see undo.py

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        action: str
        layer: str
        offer: bool
        _on: bool  # whether bakes were just shown
    else:
        _on = False
        action: EnumProperty(
            name="Action",
            description="What to show",
            items=_ACTIONS,
            default="TOGGLE",
            options={"SKIP_SAVE"},
        )
        layer: EnumProperty(
            name="Layer",
            description="What of the bake's light to show, of one with layers. They are shown opaque",
            items=(("whole", "Whole", "All light"), *LAYERS),
            default="whole",
            options={"SKIP_SAVE"},
        )
        offer: BoolProperty(
            name="Offer Shadings",
            description="After a click in a view whose shading shows no bake, offer others at the mouse",
            default=True,
            options={"SKIP_SAVE", "HIDDEN"},
        )

    def invoke(
        self, context: bpy.types.Context | None, event: bpy.types.Event | None
    ) -> set[OperatorReturnItems]:
        """Toggle, and offer other shadings if the view's shows no bake."""
        done = self.execute(context)
        if "FINISHED" in done and self._on and self.offer and context is not None:
            _offer_shadings(context)
        return done

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import RadTexError
        from ...preview.swap import is_on, switch_off

        scene, layer = shown(context)
        try:
            self.check_files()
            items = originals(layer, self.object, scene, self.bake)
            off = self.action == "OFF" or (self.action == "TOGGLE" and all(map(is_on, items)))
            if not off:
                self._switch_on(context, items, bake_called(layer, self.object, scene, self.bake))
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        for item in items if off else ():
            switch_off(item)
        self._on = not off
        push_step(self.bl_label)
        return {"FINISHED"}

    def _switch_on(self, context: bpy.types.Context | None, items: list[bpy.types.Object], bake: str) -> None:
        """Show every bake found in `bake`; if one fails, switch the others off again. Raises RadTexError."""
        from ...core.errors import RadTexError
        from ...preview.swap import is_on, switch_all_on, switch_off

        wanted = [item for item in items if self.action == "ON" or not is_on(item)]
        before = [item for item in wanted if is_on(item)]
        sidecars, errors = sidecars_of(shown(context)[0], wanted, bake)
        layer = None if self.layer == "whole" else self.layer
        made = []
        try:
            for sidecar in dict.fromkeys(sidecars.values()):
                made += switch_all_on(
                    [item for item in wanted if sidecars.get(item) == sidecar], sidecar, layer
                )
        except RadTexError:
            for preview in made:
                if preview.original not in before:
                    switch_off(preview.original)
            raise
        if context is not None and blind_view(context) is not None:
            self.report(
                {"INFO"}, "Shade the view by Material Preview or Rendered: this shading shows no bake"
            )
        for error in errors:
            self.report({"WARNING"}, remark(error))
        for name in (preview.original.name for preview in made if preview.moved):
            self.report({"WARNING"}, f"{name} has moved since the bake: it shows the light of its old place")


class RADTEX_OT_choose_bake(bpy.types.Operator):
    """Use this bake with the buttons below. If one is shown in the object's place, show this one instead"""

    bl_idname = "radtex.choose_bake"
    bl_label = "Choose Bake"
    bl_options = {"REGISTER"}  # pushes its own undo step: see undo.py

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        object: str
        called: str
    else:
        object: StringProperty(
            name="Object",
            description="Name of the object, or of the atlas that objects share",
            options={"SKIP_SAVE"},
        )
        called: StringProperty(
            name="Bake",
            description="What the bake's files are called, such as Vase.final",
            options={"SKIP_SAVE"},
        )

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        """Whether Blender is in Object Mode, where a bake may be shown in the place of another."""
        return in_object_mode(cls, context)

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import InputError, RadTexError
        from ...preview.swap import switch_all_on
        from ...report.shown import shown_bake

        scene, layer = shown(context)
        try:
            place = bake_location(scene, "", self.object)
            found = bakes_by_name(place, self.object)
            if self.called not in [one.called for one in found]:
                names = ", ".join(f"'{one.called}'" for one in found) or "none with a name of its own"
                raise InputError(f"{place} holds no bake '{self.called}' of '{self.object}': it has {names}")
            if items := self._shown(scene, layer):
                switch_all_on(items, shown_bake(place, self.object, self.called))
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            mark_stale()  # the panel offered what is not there
            return {"CANCELLED"}
        choose(scene, self.object, self.called, found)
        push_step(self.bl_label)
        return {"FINISHED"}

    def _shown(self, scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
        """The objects of the bake in whose place one is shown."""
        from ...preview.swap import is_on

        names = sharing(layer, self.object, scene, "") or (self.object,)
        return [item for item in layer.objects if item.name in names and is_on(item)]


def _offer_shadings(context: bpy.types.Context) -> None:
    """At the mouse, offer the shadings that show a bake, if that of the view does not."""
    space = blind_view(context)
    if space is None or context.window_manager is None or bpy.app.background:
        return

    def draw(menu: Any, _: bpy.types.Context) -> None:
        draw_shadings(menu.layout, space)

    context.window_manager.popup_menu(draw, title=blind_line(space), icon="INFO")
