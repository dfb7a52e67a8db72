# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""RadTex's operators in the 3D view's Object menu, where F3 finds them, and in a pie menu."""

from __future__ import annotations

from typing import Any

import bpy

from ..settings.preferences import draw_links

_object_menu: Any = bpy.types.VIEW3D_MT_object  # the stubs type append's argument too narrowly


class RADTEX_MT_object(bpy.types.Menu):
    """Bake radiance textures, and show, compare and export them"""

    bl_label = "Radiance Texture"

    def draw(self, context: bpy.types.Context | None) -> None:
        layout: Any = self.layout
        layout.operator("radtex.bake", icon="RENDER_STILL")
        layout.operator("radtex.bake", text="Resume Bake", icon="PLAY").resume = True
        layout.operator_menu_enum("radtex.bake_scene", "what", icon="SCENE_DATA")
        layout.operator("radtex.join_instances", icon="OUTLINER_OB_GROUP_INSTANCE")
        layout.operator("radtex.show_texels", icon="TEXTURE")
        layout.operator("radtex.estimate", icon="TIME")
        layout.separator()
        layout.operator("radtex.preview_toggle", icon="HIDE_OFF")
        layout.operator_menu_enum("radtex.apply_to_copy", "shader", icon="DUPLICATE")
        layout.operator_menu_enum("radtex.make_asset", "shader", icon="ASSET_MANAGER")
        layout.operator("radtex.compare", icon="IMAGE_REFERENCE")
        layout.operator("radtex.show_in_browser", icon="URL")
        layout.operator("radtex.export", icon="EXPORT")
        layout.operator("radtex.delete_bake", text="Delete Bake…", icon="TRASH")
        layout.separator()
        layout.operator_menu_enum("radtex.list_add", "what")
        layout.separator()
        draw_links(layout)


class RADTEX_MT_pie(bpy.types.Menu):
    """What is done most with radiance textures"""

    bl_label = "Radiance Texture"

    def draw(self, context: bpy.types.Context | None) -> None:
        pie: Any = self.layout.menu_pie()  # type: ignore[union-attr]  # Blender always sets it for drawing
        pie.operator("radtex.export", text="Export…", icon="EXPORT")  # left
        pie.operator("radtex.preview_toggle", icon="HIDE_OFF")  # right
        pie.operator("radtex.compare", icon="IMAGE_REFERENCE")  # bottom
        pie.operator("radtex.bake", icon="RENDER_STILL")  # top


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
