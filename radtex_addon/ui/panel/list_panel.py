# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel of the bake list: objects in the order in which they are baked."""

from __future__ import annotations

from typing import Any, cast

import bpy

from ..jobs.jobs import is_being_baked
from ..operators.list_operators import (
    RADTEX_OT_list_add,
    RADTEX_OT_list_clear,
    RADTEX_OT_list_move,
    RADTEX_OT_list_remove,
    RADTEX_OT_show_settings,
)
from ..settings.chosen_objects import chosen_by
from ..settings.object_settings import by_settings, settings_for
from .fitting import ICON, draw_button, fitting, shortened, sidebar_room
from .labels import iface_
from .main_panel import Sidebar
from .panel_state import cached_forecast

_ROWS = 4
_NAME = 40.0  # pixels that a name needs, or else it has no icon
_BESIDE_A_NAME = 3  # square buttons: its box to tick, its pin, and those beside the list


class RADTEX_UL_listed(bpy.types.UIList):
    """The objects of the bake list"""

    def draw_item(  # type: ignore[override]  # the stubs of the two Blenders differ
        self,
        context: bpy.types.Context,
        layout: Any,
        data: Any,
        item: Any,
        icon: int | None,
        active_data: Any,
        active_property: str | None,
    ) -> None:
        row = layout.row(align=True)
        if item.item is None or not item.item.users_collection:
            text = fitting(sidebar_room(icon=True, buttons=2), iface_("Deleted object"), iface_("Deleted"))
            row.label(text=text, icon="ERROR", translate=False)
            return
        row.prop(item, "use", text="")
        settings = settings_for(cast(bpy.types.Scene, context.scene), item.item.name)
        busy = is_being_baked(item.item.name, settings)
        beside = _BESIDE_A_NAME - buttons_below()
        pinned = sidebar_room(buttons=beside) >= _NAME  # else the pin above has to do
        room = sidebar_room(buttons=beside - (not pinned) + busy)
        has_room = room - ICON > _NAME
        icon_beside = "OUTLINER_OB_MESH" if has_room else "NONE"
        text = shortened(item.item.name, room - ICON if has_room else room)
        row.label(text=text, icon=icon_beside, translate=False)
        own = item.item.radtex
        if busy:
            row.label(text="", icon="RENDER_STILL")
        if pinned:
            row.prop(own, "use", text="", icon="PINNED" if own.use else "UNPINNED", emboss=False)


class RADTEX_PT_list(Sidebar, bpy.types.Panel):
    """Objects to bake, the first one first"""

    bl_label = "Bake List"
    bl_parent_id = "RADTEX_PT_bake"

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        scene = context.scene if context is not None else None
        return scene is not None and chosen_by(scene).source == "list"

    def draw(self, context: bpy.types.Context | None) -> None:
        layout: Any = self.layout
        assert context is not None  # Blender always gives one
        chosen = chosen_by(cast(bpy.types.Scene, context.scene))
        below = buttons_below()
        row = layout.column() if below else layout.row()
        row.template_list("RADTEX_UL_listed", "", chosen, "listed", chosen, "active", rows=_ROWS)
        buttons = row.row(align=True) if below else row.column(align=True)
        buttons.operator("radtex.list_add", text="", icon="ADD").what = "SELECTED"
        buttons.operator("radtex.list_remove", text="", icon="REMOVE")
        if not below:
            buttons.separator()
        buttons.operator("radtex.list_move", text="", icon="TRIA_UP").way = "UP"
        buttons.operator("radtex.list_move", text="", icon="TRIA_DOWN").way = "DOWN"
        row = layout.row(align=True)
        texts = (iface_("Add Collection"), iface_("Collection"), iface_("Add"))
        button = draw_button(row, "radtex.list_add", "OUTLINER_COLLECTION", *texts, buttons=1)
        button.what = "COLLECTION"
        row.operator("radtex.list_clear", text="", icon="TRASH")


def buttons_below() -> bool:
    """Whether the list's buttons are below it, since names would have no room beside them."""
    return sidebar_room(buttons=_BESIDE_A_NAME) < _NAME


class RADTEX_MT_settings_of(bpy.types.Menu):
    """Show the settings by which these objects are baked"""

    bl_label = "Settings"

    def draw(self, context: bpy.types.Context | None) -> None:
        assert context is not None  # Blender always gives one
        scene, layer = cast(bpy.types.Scene, context.scene), cast(bpy.types.ViewLayer, context.view_layer)
        found = cached_forecast(scene, layer)
        for settings, names in by_settings(scene, found.objects if found is not None else ()):
            if not names:
                continue
            text, icon = names[0], "PINNED"
            if settings == scene.radtex:  # type: ignore[attr-defined]  # ours, not Blender's
                more = iface_(" and {} more").format(len(names) - 1) if len(names) > 1 else ""
                text, icon = iface_("Scene's settings: {}").format(names[0]) + more, "SCENE_DATA"
            layout: Any = self.layout
            button = layout.operator("radtex.show_settings", text=text, icon=icon, translate=False)
            button.object = names[0]


CLASSES = (
    RADTEX_OT_show_settings,
    RADTEX_MT_settings_of,
    RADTEX_OT_list_add,
    RADTEX_OT_list_remove,
    RADTEX_OT_list_move,
    RADTEX_OT_list_clear,
    RADTEX_UL_listed,
    RADTEX_PT_list,
)
