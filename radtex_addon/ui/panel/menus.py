# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""RadTex's operators in the 3D view's Object menu, where F3 finds them, and in a pie menu."""

from __future__ import annotations

from typing import Any

import bpy

from ..operators.switch import draw_switch
from ..settings.preferences import draw_links
from .labels import iface_
from .next_buttons import bake_buttons, draw_action, draw_buttons
from .panel_state import Forecast, cached_forecast

_FARM = (
    ("radtex.prepare_farm", "Prepare for a Farm…", "NETWORK_DRIVE"),
    ("radtex.assemble_farm", "Assemble a Farm…", "PACKAGE"),
)
_object_menu: Any = bpy.types.VIEW3D_MT_object  # the stubs type append's argument too narrowly


class RADTEX_MT_object(bpy.types.Menu):
    """Bake radiance textures, and show, compare and export them"""

    bl_label = "Radiance Texture"

    def draw(self, context: bpy.types.Context | None) -> None:
        layout: Any = self.layout
        found = _found(context)
        draw_buttons(layout, found, bake_buttons(found), grey=False)
        draw_action(layout, "radtex.bake_scene")
        layout.operator("radtex.join_instances", icon="OUTLINER_OB_GROUP_INSTANCE")
        layout.operator("radtex.show_texels", icon="TEXTURE")
        layout.operator("radtex.estimate", icon="TIME")
        layout.separator()
        draw_switch(layout, context.active_object if context is not None else None, large=False)
        layout.operator_menu_enum("radtex.apply_to_copy", "shader", icon="DUPLICATE")
        layout.operator_menu_enum("radtex.make_asset", "shader", icon="ASSET_MANAGER")
        for operator in ("radtex.compare", "radtex.show_in_browser", "radtex.export", "radtex.delete_bake"):
            draw_action(layout, operator)
        layout.separator()
        for operator, text, icon in _FARM:
            layout.operator(operator, text=iface_(text), icon=icon, translate=False)
        layout.separator()
        layout.operator_menu_enum("radtex.list_add", "what")
        layout.separator()
        draw_links(layout)


class RADTEX_MT_pie(bpy.types.Menu):
    """What is done most with radiance textures"""

    bl_label = "Radiance Texture"

    def draw(self, context: bpy.types.Context | None) -> None:
        pie: Any = self.layout.menu_pie()  # type: ignore[union-attr]  # Blender always sets it for drawing
        found = _found(context)
        first, *others = bake_buttons(found)
        if found is not None and found.copies:
            draw_buttons(pie, found, [first, *others], grey=False)
            return
        draw_action(pie, "radtex.export")  # left
        draw_switch(pie, context.active_object if context is not None else None, large=False)  # right
        draw_action(pie, "radtex.compare")  # bottom
        draw_buttons(pie, found, [first], grey=False)  # top
        draw_buttons(pie, found, others, grey=False)  # beside the top


def _found(context: bpy.types.Context | None) -> Forecast | None:
    """What the panel knows of the next bake, so that menus and panel say the same."""
    if context is None or context.scene is None or context.view_layer is None:
        return None
    return cached_forecast(context.scene, context.view_layer)


CLASSES = (RADTEX_MT_object, RADTEX_MT_pie)


def register() -> None:
    """Add RadTex's menu to the Object menu."""
    _object_menu.append(_draw_entry)


def unregister() -> None:
    """Take it away again."""
    _object_menu.remove(_draw_entry)


def _draw_entry(menu: Any, _: bpy.types.Context) -> None:
    menu.layout.separator()
    menu.layout.menu("RADTEX_MT_object", icon="TEXTURE")
