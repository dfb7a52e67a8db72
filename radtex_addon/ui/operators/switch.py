# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the buttons that show a bake instead of its object, and those that change the viewport shading."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeGuard

import bpy

from ..panel.fitting import draw_button, draw_text, side_by_side
from ..panel.labels import iface_

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

LARGE = 1.5  # height of the button for the next step, relative to a normal button
_BLIND = ("WIREFRAME", "SOLID")  # viewport shadings that do not show materials


def draw_switch(layout: Any, item: bpy.types.Object | None, files: Sequence[Path] = ()) -> Any:
    """Draw the preview button, pressed if the bake of `item` is shown; returns its operator's properties.

    With the `files` of one bake it is pressed only if that one is shown, and shows it instead of another.
    """
    from ...preview.swap import is_on, shows_any_of

    switched = item is not None and is_on(item)
    pressed = item is not None and switched and (not files or shows_any_of(item, files))
    row = layout.row()
    row.scale_y = LARGE
    icon = "HIDE_OFF" if pressed else "HIDE_ON"
    switch = draw_button(row, "radtex.preview_toggle", icon, *_preview(), depress=pressed)
    switch.action = "ON" if switched and not pressed else "TOGGLE"
    return switch


def draw_layers(layout: Any, item: bpy.types.Object | None) -> None:
    """Draw a menu to show a single layer, if the bake of `item` is shown and has layers."""
    from ...preview.swap import copy_of
    from ...preview.variant import kept_variant

    copy = None if item is None else copy_of(item)
    if copy is not None and kept_variant(copy).layers:
        layout.operator_menu_enum("radtex.preview_toggle", "layer", text="Layer").action = "ON"


def draw_show(layout: Any) -> Any:
    """Draw a button that shows one of several bakes of an object; returns its operator's properties."""
    switch = draw_button(layout, "radtex.preview_toggle", "HIDE_OFF", *_preview())
    switch.action = "ON"
    return switch


def is_blind(space: bpy.types.Space | None) -> TypeGuard[bpy.types.SpaceView3D]:
    """Whether this is a 3D view whose shading shows no materials, and so no bake."""
    return isinstance(space, bpy.types.SpaceView3D) and space.shading.type in _BLIND


def draw_shading(layout: Any, space: bpy.types.Space | None) -> None:
    """Draw Blender's shading buttons if the current shading does not show materials, and so no bake."""
    if not is_blind(space):
        return
    draw_text(layout, iface_("Seen in these shadings only:"), "INFO")
    shadings = (("MATERIAL", iface_("Material")), ("RENDERED", iface_("Rendered")))
    row, _ = side_by_side(layout, [name for _, name in shadings])
    row.use_property_split = False
    for shading, name in shadings:
        row.prop_enum(space.shading, "type", shading, text=name, translate=False)


def _preview() -> tuple[str, str]:
    """The preview button's text, and a shorter one."""
    return iface_("Preview Bake"), iface_("Preview")
