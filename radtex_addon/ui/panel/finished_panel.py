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
from ..settings.chosen_objects import nothing_chosen
from .fitting import draw_button, draw_text
from .labels import capitalized, iface_
from .main_panel import Sidebar, drawn
from .next_buttons import draw_action
from .panel_state import Forecast, Next

# Operator and icon, and texts of which the first one is drawn that fits.
_MENUS = (
    ("radtex.apply_to_copy", "DUPLICATE", "Apply to a Copy", "To a Copy", "Copy"),
    ("radtex.make_asset", "ASSET_MANAGER", "Make Asset", "Asset"),
)
_AFTERWARDS = (
    "radtex.compare",
    "radtex.show_in_browser",
    "radtex.export",
    "radtex.open_folder",
    "radtex.delete_bake",
)


class RADTEX_PT_afterwards(Sidebar, bpy.types.Panel):
    """What to do with a finished bake"""

    bl_label = "Finished Bake"
    bl_order = 10

    def draw(self, context: bpy.types.Context | None) -> None:
        layout: Any = self.layout
        found = drawn(self, context)[2]
        layout.use_property_split = False
        item, scene = (context.active_object, context.scene) if context is not None else (None, None)
        nothing = found is not None and nothing_is_baked(found, item)
        if found is not None and found.copies:
            draw_text(layout, iface_("These are for the bake's object: select the original"), "INFO")
        whole = layout.column()
        whole.enabled = there = found is not None and bool(found.objects) and not nothing
        draw_switch(whole, item)
        if context is not None and there:
            draw_shading(whole, context.space_data)
        column = whole.column()
        for name, icon, *texts in _MENUS:
            draw_button(column, name, icon, *map(iface_, texts), menu="shader")
        for operator in _AFTERWARDS:
            draw_action(column, operator, fit=True)
        draw_layers(whole, item)
        if nothing:
            draw_text(layout, iface_("Nothing of it is baked yet"), "INFO")
        elif found is not None and not (found.objects or found.copies) and scene is not None:
            draw_text(layout, capitalized(iface_(nothing_chosen(scene))), "INFO")


def nothing_is_baked(found: Forecast, item: bpy.types.Object | None) -> bool:
    """Whether no bake of the chosen objects is there, as far as is known, and none of `item` is shown."""
    from ...preview.swap import is_on

    shown = found.shown or (item is not None and is_on(item))
    return found.next is Next.BAKE and not found.finished and not found.unfinished and not shown


CLASSES = (
    RADTEX_OT_preview_toggle,
    RADTEX_OT_compare,
    RADTEX_OT_show_comparison,
    RADTEX_OT_export,
    RADTEX_PT_afterwards,
)
