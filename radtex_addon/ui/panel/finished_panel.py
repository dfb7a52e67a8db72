# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel for finished bakes: show, compare, export.

What is there only while a bake is shown is drawn last, so that showing one moves no button.
"""

from __future__ import annotations

from typing import Any

import bpy

from ..operators.compare_operator import RADTEX_OT_compare, RADTEX_OT_show_comparison
from ..operators.export_operator import RADTEX_OT_export
from ..operators.preview_operator import RADTEX_OT_preview_toggle
from ..operators.switch import draw_layers, draw_shading, draw_switch
from .main_panel import Sidebar, drawn


class RADTEX_PT_afterwards(Sidebar, bpy.types.Panel):
    """What to do with a finished bake"""

    bl_label = "Finished Bake"
    bl_order = 10

    def draw(self, context: bpy.types.Context | None) -> None:
        layout: Any = self.layout
        found = drawn(self, context)[2]
        layout.use_property_split = False
        layout.enabled = found is not None and bool(found.objects)
        item = context.active_object if context is not None else None
        draw_switch(layout, item)
        column = layout.column()
        column.operator_menu_enum("radtex.apply_to_copy", "shader", icon="DUPLICATE")
        column.operator_menu_enum("radtex.make_asset", "shader", icon="ASSET_MANAGER")
        column.operator("radtex.compare", icon="IMAGE_REFERENCE")
        column.operator("radtex.show_in_browser", icon="URL")
        column.operator("radtex.export", text="Export…", icon="EXPORT")
        column.operator("radtex.open_folder", icon="FILE_FOLDER")
        column.operator("radtex.delete_bake", text="Delete Bake…", icon="TRASH")
        draw_layers(layout, item)
        if found is not None and found.shown and context is not None:
            draw_shading(layout.column(), context.space_data)


CLASSES = (
    RADTEX_OT_preview_toggle,
    RADTEX_OT_compare,
    RADTEX_OT_show_comparison,
    RADTEX_OT_export,
    RADTEX_PT_afterwards,
)
