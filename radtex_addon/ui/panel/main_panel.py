# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar's tab "RadTex": objects, presets, quality, the button. Draws the cached `Forecast` only.

Nothing above the button changes its height by itself, so that the button stays under the mouse.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import bpy

from ...settings.presets import STOCK
from ..operators.switch import LARGE, draw_shading, draw_switch
from ..operators.texels_operator import is_on as texels_shown
from ..settings.bake_settings import BakeSettings
from ..settings.chosen_objects import chosen_by, nothing_chosen
from ..settings.object_settings import edited_settings, owner_of
from ..settings.presets import RADTEX_PT_presets, is_applied
from ..settings.seen_version import news, news_title
from .draw_messages import draw_remarks
from .fitting import (
    draw_button,
    draw_setting,
    draw_text,
    fit_in_a_row,
    fitting,
    shortened,
    side_by_side,
    sidebar_room,
    text_width,
)
from .job_ends import TAB
from .labels import capitalized, expected_range, iface_, size
from .next_buttons import bake_buttons, draw_action, draw_buttons, told_copies
from .panel_state import Forecast, Next, cached_forecast

if TYPE_CHECKING:
    from collections.abc import Sequence

_PRESETS_IN_A_ROW = 3
_ICON_IN_HEADER = 56.0  # pixels of the sidebar's room that the title and the icon need
_NAME = 60.0  # pixels that an object's name needs, or else it is on a line of its own
_ASSETS = 4  # lines on them


class Sidebar:
    """Mixin that places a panel in the 3D view's sidebar, tab RadTex."""

    bl_space_type: Any = "VIEW_3D"
    bl_region_type: Any = "UI"
    bl_category = TAB


class RADTEX_PT_bake(Sidebar, bpy.types.Panel):
    """What to bake, how well, and the button"""

    bl_label = "Bake"

    def draw_header_preset(self, context: bpy.types.Context | None) -> None:
        if sidebar_room() > _ICON_IN_HEADER:  # else it would be drawn over the title
            RADTEX_PT_presets.draw_panel_header(self.layout)

    def draw(self, context: bpy.types.Context | None) -> None:
        layout, settings, found = drawn(self, context)
        assert context is not None  # Blender always gives one
        scene = cast(bpy.types.Scene, context.scene)
        _draw_objects(layout, scene, context.active_object, found)
        if found is not None and found.copies:
            _draw_copies(layout, found)
            draw_news(layout)
            return
        _draw_whose(layout, settings, found)
        _draw_presets(layout.column(align=True), settings)
        column = layout.column(align=True)
        draw_setting(column, settings, settings.atlas_size)  # "texels" or "density"
        draw_setting(column, settings, "samples")
        _draw_buttons(layout, found)
        _draw_preview(layout, context, found)
        if reason := why_grey(scene, found):
            draw_text(layout, capitalized(reason), "INFO", boxed=False)
        if found is None:
            return
        if found.objects:
            draw_text(layout, time_and_size(found), boxed=False)
        _draw_assets(layout, settings, found)
        for line in what_is_there(found):
            draw_text(layout, line, "INFO", boxed=False)
        draw_remarks(layout, scene, settings, found)
        for line in found.sizes:
            draw_text(layout, line, "BLANK1", boxed=False)
        draw_news(layout)


def draw_news(layout: Any) -> None:
    """After an update, offer its changes until they are shown or dismissed."""
    if news():
        row = layout.box().row(align=True)
        draw_button(row, "radtex.show_changes", "INFO", news_title(), iface_("What's New"), buttons=1)
        row.operator("radtex.dismiss_changes", text="", icon="X")


def time_and_size(found: Forecast) -> str:
    """What the bake takes, in one line: time, where it was estimated, and a GPU's memory at most."""
    if found.cost is None or not found.objects:
        return ""
    told = iface_("at most {}").format(size(found.cost.gpu))
    if found.atlases > 1:
        told = iface_("at most {} each").format(size(found.cost.gpu))
    if found.range is not None:
        told = f"{expected_range(found.range)}, {told}"
    return capitalized(told)


def told_assets(found: Forecast) -> list[str]:
    """A line for each group of objects that are baked as one because they touch."""
    told = iface_("{} objects that touch are one asset, {}: {} × {} texels")
    shown = [
        told.format(each.objects, each.name, each.texels, each.texels) for each in found.assets[:_ASSETS]
    ]
    if more := len(found.assets) - len(shown):
        shown.append(iface_("and {} more").format(more))
    return shown


def _draw_assets(layout: Any, settings: BakeSettings, found: Forecast) -> None:
    """Say which objects are baked as one because they touch, and offer to choose otherwise, or to go back."""
    if not found.assets and (len(found.objects) < 2 or settings.together != "off"):
        return
    box = layout.box()
    for line in told_assets(found):
        draw_text(box, line, "LINKED")
    draw_setting(box, settings, "together", boxed=True)


def what_is_there(found: Forecast) -> list[str]:
    """What the files and jobs that are there mean for the next bake, a line each; no errors."""
    lines = []
    if found.busy:
        several, one = iface_("{} of {} objects are being baked"), iface_("{} of {} objects is being baked")
        text = (one if len(found.busy) == 1 else several).format(len(found.busy), len(found.objects))
        lines.append(text if len(found.objects) > 1 else iface_("It is being baked"))
    if found.next is Next.RESUME and found.unfinished:
        several, one = iface_("{} of {} bakes are not finished"), iface_("{} of {} bakes is not finished")
        text = (one if found.unfinished == 1 else several).format(found.unfinished, found.bakes)
        lines.append(text if found.bakes > 1 else iface_("Its bake is not finished"))
    elif found.next is Next.RESUME:
        several, one = iface_("{} of {} bakes are there"), iface_("{} of {} bakes is there")
        lines.append((one if found.finished == 1 else several).format(found.finished, found.bakes))
    elif found.next is Next.REPLACE:
        lines.append(_replaced(found))
    return lines


def _replaced(found: Forecast) -> str:
    there = found.finished + found.unfinished
    if found.bakes > 1 and there:
        told = iface_("{} of {} bakes are there: they will be replaced")
        all_there = iface_("{} bakes are there: they will be replaced")
        return all_there.format(there) if there == found.bakes else told.format(there, found.bakes)
    if found.unfinished:
        return iface_("An unfinished bake by other settings is there: it will be replaced")
    if found.finished:
        return iface_("It has a bake: that will be replaced")
    return iface_("Files of its name are there: they will be replaced")


def _draw_objects(
    layout: Any, scene: bpy.types.Scene, active: bpy.types.Object | None, found: Forecast | None
) -> None:
    """One line: what is baked, how that is chosen, and whether the active object has its own settings."""
    chosen = chosen_by(scene)
    names = found.objects if found is not None else ()
    shown = names or (tuple(one.name for one in found.copies) if found is not None else ())
    pinned: Any = owner_of(scene, active, names)
    room = sidebar_room(icon=True, buttons=2 if pinned is None else 3)
    named = row = layout.row(align=True)
    row.use_property_split = False
    if room < _NAME and chosen.source != "collection":  # the name has a line of its own
        room, row = sidebar_room(icon=True, boxed=False), layout.row(align=True)
        row.use_property_split = False
    if chosen.source == "collection":
        row.prop(chosen, "collection", text="")
    elif shown:
        several = iface_("{} objects").format(len(shown)), str(len(shown))
        text = shortened(shown[0], room) if len(shown) == 1 else fitting(room, *several)
        named.label(text=text, icon="OUTLINER_OB_MESH", translate=False)
    else:
        text = iface_("no object") if chosen.source == "list" else iface_(nothing_chosen(scene))
        named.label(text=fitting(room, capitalized(text), iface_("Nothing")), icon="INFO", translate=False)
    row.prop(chosen, "source", text="", icon_only=True)
    if pinned is not None:
        row.prop(pinned.radtex, "use", text="", icon="PINNED" if pinned.radtex.use else "UNPINNED")


def why_grey(scene: bpy.types.Scene, found: Forecast | None) -> str:
    """Why the large button is grey; empty if it is not, or its text, an error or the line above says why."""
    if found is None:
        return iface_("looking at what is chosen")
    if found.next is not Next.NOTHING or found.objects or chosen_by(scene).source == "selection":
        return ""
    return iface_(nothing_chosen(scene))


def _draw_whose(layout: Any, settings: BakeSettings, found: Forecast | None) -> None:
    """One line, always there: whose settings are shown; where others are used, a menu goes to those."""
    names, own = (found.objects, found.own) if found is not None else ((), ())
    shown = settings.id_data if isinstance(settings.id_data, bpy.types.Object) else None
    opens = bool(own) and not (shown is not None and len(names) == 1)
    room = sidebar_room(buttons=1 if opens else 0, boxed=False)
    text = fitting(room, *told_whose(None if shown is None else shown.name, names, own))
    row = layout.row()
    if opens:
        row.menu("RADTEX_MT_settings_of", text=text, translate=False)
    else:
        row.label(text=text, translate=False)


def told_whose(shown: str | None, names: Sequence[str], own: Sequence[str]) -> tuple[str, ...]:
    """Whose settings are shown, the longest wording first: those of the object `shown`, or the scene's.

    `names` are to be baked; those in `own` have settings of their own.
    """
    if shown is not None:
        alone = iface_("Settings of {}").format(shown)
        among = iface_("Settings of {}, 1 of {} objects").format(shown, len(names))
        short = iface_("{}'s").format(shown)
        return (among, alone, short) if len(names) > 1 else (alone, short)
    shortest = iface_("Scene's settings"), iface_("Scene's")
    if not own:
        return shortest
    if len(names) == 1:
        return iface_("Scene's settings; {} has its own").format(own[0]), *shortest
    told = iface_("Scene's settings; {} of {} objects have their own").format(len(own), len(names))
    short = iface_("Scene's settings; {} of {} have own").format(len(own), len(names))
    return (f"{told}: {', '.join(own)}", f"{short}: {', '.join(own)}", told, short, *shortest)


def _draw_presets(column: Any, settings: BakeSettings) -> None:
    """Draw RadTex's presets, the one that is set pressed."""
    count = fit_in_a_row([iface_(label) for _, label, _ in STOCK], _PRESETS_IN_A_ROW)
    for start in range(0, len(STOCK), count):
        row = column.row(align=True)
        for name, label, _ in STOCK[start : start + count]:
            pressed = is_applied(name, settings)
            row.operator("radtex.preset_apply", text=label, depress=pressed).name = name


def _draw_buttons(layout: Any, found: Forecast | None) -> None:
    """Draw the large button, and what goes beside it: to resume, or to bake what has changed."""
    buttons = bake_buttons(found)
    row, share = side_by_side(layout, [one.texts[-1] for one in buttons])
    row.scale_y = LARGE
    draw_buttons(row, found, buttons, share=share)
    beside = text_width(iface_("Scene…")) <= sidebar_room(buttons=1, boxed=False)
    row = layout.row(align=True) if beside else layout.column(align=True)
    draw_action(row, "radtex.bake_scene", fit=True, buttons=int(beside), boxed=False)
    row.operator("radtex.show_texels", text="", icon="TEXTURE", depress=texels_shown())
    doing = found.next if found is not None else Next.NOTHING
    can_choose = doing in (Next.RESUME, Next.REPLACE) and found is not None and not found.unfinished
    if found is not None and can_choose and found.finished > 1:
        _draw_changed(layout.row(align=True))


def _draw_preview(layout: Any, context: bpy.types.Context, found: Forecast | None) -> None:
    """Draw the button that shows a finished bake, and the shadings in which it is seen."""
    if found is None or not may_be_shown(found, context.active_object):
        return
    column = layout.column()
    draw_switch(column, context.active_object)
    draw_shading(column, context.space_data)


def may_be_shown(found: Forecast, item: bpy.types.Object | None) -> bool:
    """Whether bakes of the chosen objects are there, or may be where an error leaves that unknown.

    A bake of `item`, the active object, that is shown in its place counts, wherever it lies.
    """
    from ...preview.swap import is_on

    if not found.objects:
        return False
    unknown = found.next is Next.NOTHING and not found.needs_folder
    by_name = found.named and found.named_of[0] in found.objects  # called otherwise than the settings say
    there = found.finished or found.former or found.shown or by_name
    return unknown or bool(there) or (item is not None and is_on(item))


def _draw_changed(row: Any) -> None:
    """Draw the buttons that bake again what has changed, and what is affected by that."""
    texts = (iface_("Bake Changed"), iface_("Changed"))
    changed = draw_button(row, "radtex.bake", "FILE_TICK", *texts, buttons=1)
    affected = row.operator("radtex.bake", text="", icon="WORLD")
    for button, only in ((changed, "changed"), (affected, "affected")):
        button.only, button.show_object = only, True


def _draw_copies(layout: Any, found: Forecast) -> None:
    """Draw what is done with copies that show a bake; in the place of the button, for they are not baked."""
    column = layout.column(align=True)
    for number, line in enumerate(told_copies(found)):
        draw_text(column, line, "BLANK1" if number else "INFO", boxed=False)
    column = layout.column()
    draw_buttons(column, found, bake_buttons(found), share=1.0)


def drawn(
    panel: bpy.types.Panel, context: bpy.types.Context | None
) -> tuple[Any, BakeSettings, Forecast | None]:
    """The panel's layout with our options set, the settings to show, and the cached forecast, if any.

    The settings are those of the bake list's marked object, where the list is chosen, or else of the active
    one, if that object is among those to bake and has its own; else the scene's.
    """
    assert context is not None  # Blender always gives one
    scene, view_layer = cast(bpy.types.Scene, context.scene), cast(bpy.types.ViewLayer, context.view_layer)
    layout: Any = panel.layout
    layout.use_property_split = True
    layout.use_property_decorate = False  # a bake is not animated
    found = cached_forecast(scene, view_layer)
    names = found.objects if found is not None else ()
    return layout, edited_settings(scene, context.active_object, names), found
