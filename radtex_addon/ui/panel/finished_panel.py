# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel for finished bakes: copy, compare, export. The button that shows them is in the main panel.

What is there only while a bake is shown is drawn last, so that showing one moves no button.
"""

from __future__ import annotations

from datetime import datetime
from typing import TYPE_CHECKING, Any

import bpy

from ..operators.compare_operator import RADTEX_OT_compare, RADTEX_OT_show_comparison
from ..operators.export_operator import RADTEX_OT_export
from ..operators.preview_operator import RADTEX_OT_choose_bake, RADTEX_OT_preview_toggle
from ..operators.switch import draw_layers
from ..settings.chosen_bakes import chosen_bake
from ..settings.chosen_objects import nothing_chosen
from .fitting import draw_button, draw_text
from .labels import capitalized, iface_
from .main_panel import Sidebar, drawn, may_be_shown
from .next_buttons import draw_action
from .panel_state import Forecast, cached_forecast

if TYPE_CHECKING:
    from ...report.finished_bake import NamedBake

_NAMED = 6  # bakes of several names that have a row each

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
        if found is not None and found.copies:
            draw_text(
                layout, iface_("These are for the bake's object: select the original"), "INFO", boxed=False
            )
        if found is not None and scene is not None:
            _draw_named(layout, found, scene, item)
        whole = layout.column()
        whole.enabled = there = found is not None and may_be_shown(found, item)
        column = whole.column()
        for name, icon, *texts in _MENUS:
            draw_button(column, name, icon, *map(iface_, texts), menu="shader", boxed=False)
        for operator in _AFTERWARDS:
            draw_action(column, operator, fit=True, boxed=False)
        draw_layers(whole, item)
        if found is not None and found.objects and not there:
            draw_text(layout, iface_("Nothing of it is baked yet"), "INFO", boxed=False)
        elif found is not None and not (found.objects or found.copies) and scene is not None:
            draw_text(layout, capitalized(iface_(nothing_chosen(scene))), "INFO", boxed=False)


class RADTEX_MT_bakes(bpy.types.Menu):
    """The bakes of the active object that the panel has no room for"""

    bl_label = "More Bakes"

    def draw(self, context: bpy.types.Context | None) -> None:
        assert context is not None  # Blender always gives one
        assert context.scene is not None  # as above
        assert context.view_layer is not None  # as above
        found = cached_forecast(context.scene, context.view_layer)
        if found is None or not found.named:
            return
        chosen = chosen_bake(context.scene, found.named_of[1], found.named)
        for one in found.named[_NAMED:]:
            texts = told_named(one)
            layout: Any = self.layout
            button = layout.operator(
                "radtex.choose_bake", text=texts[0], icon=_radio(one is chosen), translate=False
            )
            button.object, button.called = found.named_of[1], one.called


def _draw_named(layout: Any, found: Forecast, scene: bpy.types.Scene, item: bpy.types.Object | None) -> None:
    """Draw the bakes of the active object, the newest first, if any has a name of its own: one is chosen."""
    from ...preview.swap import original_of

    original = None if item is None else original_of(item)
    if not found.named or original is None or original.name != found.named_of[0]:
        return
    if original.name not in found.objects:  # which the buttons are about
        return
    chosen = chosen_bake(scene, found.named_of[1], found.named)
    column = layout.column(align=True)
    for one in found.named[:_NAMED]:
        texts, is_chosen = told_named(one), one is chosen
        button = draw_button(
            column, "radtex.choose_bake", _radio(is_chosen), *texts, depress=is_chosen, boxed=False
        )
        button.object, button.called = found.named_of[1], one.called
    if others := found.named[_NAMED:]:
        column.menu("RADTEX_MT_bakes", text=iface_("and {} more").format(len(others)), translate=False)
    if chosen in others:
        draw_text(layout, iface_("{} is chosen").format(chosen.called), "RADIOBUT_ON", boxed=False)


def told_named(bake: NamedBake) -> tuple[str, ...]:
    """What a bake is called, with when it was made and how good it is, and the same in fewer words."""
    when = datetime.fromtimestamp(bake.time / 1e9).astimezone()
    dated = f"{bake.called}, {when:%d %b, %H:%M}"
    return f"{dated}: {bake.quality}", dated, bake.called


def _radio(is_on: bool) -> str:
    return "RADIOBUT_ON" if is_on else "RADIOBUT_OFF"


CLASSES = (
    RADTEX_OT_preview_toggle,
    RADTEX_OT_choose_bake,
    RADTEX_MT_bakes,
    RADTEX_OT_compare,
    RADTEX_OT_show_comparison,
    RADTEX_OT_export,
    RADTEX_PT_afterwards,
)
