# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw messages in the sidebar, with buttons that fix the problem right below."""

from __future__ import annotations

from typing import Any

import bpy

from ...core.messages import Message
from ..settings.bake_settings import BakeSettings
from ..settings.object_settings import by_settings, settings_for
from ..settings.preferences import addon_preferences, draw_memory
from .fitting import draw_button, draw_setting, draw_text
from .labels import iface_, remark
from .not_baked import CONVERT
from .panel_state import Forecast
from .remedies import offers


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
    if found.flat:
        text = (
            iface_("Set Zero Scale to 1")
            if len(found.flat) == 1
            else iface_("Set {} Zero Scales to 1").format(len(found.flat))
        )
        button = layout.operator("radtex.fix_scale", text=text, translate=False)
        button.objects = "\n".join(found.flat)
    for other in found.not_baked:
        box = layout.box()
        draw_text(box, other.text, "INFO")
        if other.operator:
            button = draw_button(box, other.operator, "NONE", other.button)
            if other.operator == CONVERT:
                button.target = "MESH"
    if found.needs_folder:
        column = layout.column()
        draw_button(column, "wm.save_as_mainfile", "FILE_TICK", iface_("Save File…"), iface_("Save…"))
        draw_setting(column, settings, "directory", text=iface_("Folder"))
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
            if preferences is not None and offer.name == "memory_mb":
                draw_memory(box, preferences)
            elif preferences is not None:
                draw_setting(box, preferences, offer.name, boxed=True)
        elif offer.text:
            button = draw_button(box, "radtex.apply_remedy", "NONE", offer.text)
            button.object, button.name, button.value = found.objects[0], offer.name, offer.value
        elif not (offer.name == "directory" and found.needs_folder):  # which is drawn below
            draw_setting(box, settings, offer.name, boxed=True)
