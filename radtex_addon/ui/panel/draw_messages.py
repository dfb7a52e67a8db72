# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw messages in the sidebar: wrapped text, with buttons that fix the problem right below."""

from __future__ import annotations

from typing import Any

import blf
import bpy

from ...core.messages import Message
from ..settings.bake_settings import BakeSettings
from ..settings.object_settings import by_settings, settings_for
from ..settings.preferences import addon_preferences
from .labels import remark
from .not_baked import CONVERT
from .panel_state import Forecast
from .remedies import offers

_UI_FONT = 0
_BESIDE = 86.0  # pixels of the sidebar's width not available to text: margins, icon, tabs
_NARROW = 160.0  # minimum text width in pixels; also used where there is no region


def draw_text(layout: Any, text: str, icon: str) -> None:
    """Draw a message on as many lines as the sidebar needs for it."""
    draw_wrapped(layout, text, icon, _room())


def draw_wrapped(layout: Any, text: str, icon: str, room: float) -> None:
    """Draw a text on lines of at most `room` pixels at UI scale 1; Blender's labels do not wrap."""
    column = layout.column(align=True)
    column.scale_y = 0.85
    for number, line in enumerate(wrapped(text, room)):
        column.label(text=line, icon=icon if number == 0 else "BLANK1", translate=False)


def wrapped(text: str, room: float) -> list[str]:
    """Split the text into lines of at most `room` pixels at UI scale 1; longer words are not broken."""
    preferences = bpy.context.preferences
    assert preferences is not None  # only restricted contexts have none
    blf.size(_UI_FONT, preferences.ui_styles[0].widget.points)
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and blf.dimensions(_UI_FONT, longer)[0] > room:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines


def left_out_of(found: Forecast) -> tuple[Message, ...]:
    """Lines on the meshes that a bake leaves out; none are loaded before the first."""
    if not found.left_out:
        return ()
    from ...job.left_out import left_out_lines

    return left_out_lines(found.left_out)


def draw_remarks(layout: Any, scene: bpy.types.Scene, settings: BakeSettings, found: Forecast) -> None:
    """Draw errors, what settles them, what is left out, and warnings.

    `settings` are those that the panel shows.
    """
    for message in found.errors:
        box = layout.box()
        draw_text(box, remark(message, found.folder), "ERROR")
        _draw_offers(box, scene, message, found)
    for message in left_out_of(found):
        draw_text(layout.box(), remark(message, found.folder), "INFO")
    for other in found.not_baked:
        box = layout.box()
        draw_text(box, other.text, "INFO")
        if other.operator:
            button = box.operator(other.operator, text=other.button)
            if other.operator == CONVERT:
                button.target = "MESH"
    if found.needs_folder:
        column = layout.column()
        column.operator("wm.save_as_mainfile", text="Save File…", icon="FILE_TICK")
        column.prop(settings, "directory", text="Folder")
    for message in found.warnings:
        box = layout.box()
        draw_text(box, remark(message, found.folder), "INFO")
        _draw_offers(box, scene, message, found)


def _draw_offers(box: Any, scene: bpy.types.Scene, message: Message, found: Forecast) -> None:
    """Draw buttons that do what a message says, where it is clear whose settings it is about."""
    if not found.objects or len(by_settings(scene, found.objects)) > 1:
        return
    settings, preferences = settings_for(scene, found.objects[0]), addon_preferences()
    for offer in offers(message, settings):
        if offer.preference:
            if preferences is not None:
                box.prop(preferences, offer.name)
        elif offer.text:
            button = box.operator("radtex.apply_remedy", text=offer.text, translate=False)
            button.object, button.name, button.value = found.objects[0], offer.name, offer.value
        elif not (offer.name == "directory" and found.needs_folder):  # which is drawn below
            box.prop(settings, offer.name)


def _room() -> float:
    """Width available to a message line in the current region, in pixels at UI scale 1."""
    region, preferences = bpy.context.region, bpy.context.preferences
    if region is None or preferences is None:
        return _NARROW
    return max(_NARROW, region.width / preferences.system.ui_scale - _BESIDE)
