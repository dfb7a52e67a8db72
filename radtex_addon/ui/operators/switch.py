# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the buttons that show a bake instead of its object, and those that change the viewport shading."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, TypeGuard

import bpy

from ..panel.fitting import ICON, draw_button, draw_text, side_by_side, sidebar_room, text_width
from ..panel.labels import iface_

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

_PREVIEW = "radtex.preview_toggle"
LARGE = 1.5  # height of the button for the next step, relative to a normal button
_BLIND = ("WIREFRAME", "SOLID")  # viewport shadings that do not show materials
# Shadings, and texts of which the first one is drawn that fits.
_SEEING = (("MATERIAL", "Material Preview", "Material"), ("RENDERED", "Rendered"))


def draw_switch(layout: Any, item: bpy.types.Object | None, *, large: bool = True) -> None:
    """Draw the preview button, pressed if the bake of `item` is shown.

    The `large` one is the panel's, which has `draw_shading` below it.
    """
    from ...preview.swap import is_on

    pressed = item is not None and is_on(item)
    if large:
        row = layout.row()
        row.scale_y = LARGE
        texts = iface_("Preview Bake"), iface_("Preview")
        switch = draw_button(row, _PREVIEW, _icon(pressed), *texts, boxed=False, depress=pressed)
    else:
        switch = layout.operator(_PREVIEW, icon=_icon(pressed), depress=pressed)
    switch.action, switch.offer = "TOGGLE", not large


def draw_small_switch(layout: Any, item: bpy.types.Object | None, files: Sequence[Path]) -> Any:
    """Draw the icon that shows the bake with these `files`; returns its operator's properties.

    It is pressed only if that bake is the one that is shown, and shows it in the place of any other.
    """
    from ...preview.swap import is_on, shows_any_of

    switched = item is not None and is_on(item)
    pressed = item is not None and switched and shows_any_of(item, files)
    switch = layout.operator(_PREVIEW, text="", icon=_icon(pressed), depress=pressed)
    switch.action = "ON" if switched and not pressed else "TOGGLE"
    return switch


def _icon(pressed: bool) -> str:
    return "HIDE_OFF" if pressed else "HIDE_ON"


def draw_layers(layout: Any, item: bpy.types.Object | None) -> None:
    """Draw a menu to show a single layer, if the bake of `item` is shown and has layers."""
    from ...preview.swap import copy_of
    from ...preview.variant import kept_variant

    copy = None if item is None else copy_of(item)
    if copy is not None and kept_variant(copy).layers:
        layout.operator_menu_enum("radtex.preview_toggle", "layer", text="Layer").action = "ON"


def draw_show(layout: Any) -> Any:
    """Draw the icon that shows one of several bakes of an object; returns its operator's properties."""
    switch = layout.operator(_PREVIEW, text="", icon="HIDE_OFF")
    switch.action = "ON"
    return switch


def is_blind(space: bpy.types.Space | None) -> TypeGuard[bpy.types.SpaceView3D]:
    """Whether this is a 3D view whose shading shows no materials, and so no bake."""
    return isinstance(space, bpy.types.SpaceView3D) and space.shading.type in _BLIND


def blind_view(context: bpy.types.Context) -> bpy.types.SpaceView3D | None:
    """The 3D view in which a bake is shown but not seen, because of the shading; None if it is seen.

    That is the view that was clicked in. Elsewhere, as in a menu of another editor, it is the largest of the
    window's views, if no view of any window shows materials.
    """
    space = context.space_data
    if isinstance(space, bpy.types.SpaceView3D):
        return space if is_blind(space) else None
    manager, window = context.window_manager, context.window
    if manager is None or window is None:
        return None
    areas = [area for one in manager.windows for area in one.screen.areas if area.type == "VIEW_3D"]
    if not all(is_blind(area.spaces.active) for area in areas):
        return None
    here = [area for area in window.screen.areas if area.type == "VIEW_3D"]
    largest = max(here, key=lambda area: area.width * area.height, default=None)
    found = None if largest is None else largest.spaces.active
    return found if is_blind(found) else None


def blind_line(space: bpy.types.SpaceView3D) -> str:
    """That the view's shading shows no bake, in a line."""
    name = iface_("Wireframe") if space.shading.type == "WIREFRAME" else iface_("Solid")
    return iface_("{} shows no bake. Look in:").format(name)


def draw_shading(layout: Any, space: bpy.types.Space | None) -> None:
    """Draw buttons for the shadings that show a bake, if that of the view does not."""
    if not is_blind(space):
        return
    draw_text(layout, blind_line(space), "INFO", boxed=False)
    row, share = side_by_side(layout, [iface_(texts[0]) for _, *texts in _SEEING])
    row.use_property_split = False
    draw_shadings(row, space, sidebar_room(boxed=False) * share - ICON)


def draw_shadings(layout: Any, space: bpy.types.SpaceView3D, room: float = math.inf) -> None:
    """Draw the two buttons alone, with texts that fit into `room`, or with icons where none does."""
    for shading, *texts in _SEEING:
        text = next((text for text in map(iface_, texts) if text_width(text) <= room), "")
        layout.prop_enum(space.shading, "type", shading, text=text, translate=False)
