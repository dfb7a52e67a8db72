# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The switch between objects and their bakes, and the shading in which one sees the difference."""

from __future__ import annotations

from typing import Any

import bpy

from .labels import iface_
from .messages import draw_text

LARGE = 1.5  # of a button that is the next step: times another's height
_BLIND = ("WIREFRAME", "SOLID")  # shadings that know no materials


def draw_switch(layout: Any, item: bpy.types.Object | None) -> Any:
    """The button, pressed where the bake of `item` is shown; returns its operator's properties."""
    from ..preview.swap import is_on

    pressed = item is not None and is_on(item)
    row = layout.row()
    row.scale_y = LARGE
    return row.operator("radtex.preview_toggle", icon="HIDE_OFF" if pressed else "HIDE_ON", depress=pressed)


def draw_layers(layout: Any, item: bpy.types.Object | None) -> None:
    """A menu of layers to show alone, where the bake of `item` is shown and has some."""
    from ..preview.swap import copy_of
    from ..preview.variant import kept_variant

    copy = None if item is None else copy_of(item)
    if copy is not None and kept_variant(copy).layers:
        layout.operator_menu_enum("radtex.preview_toggle", "layer", text="Layer").action = "ON"


def draw_show(layout: Any) -> Any:
    """The button that shows one of several bakes of an object; returns its operator's properties."""
    switch = layout.operator("radtex.preview_toggle", icon="HIDE_OFF")
    switch.action = "ON"
    return switch


def draw_shading(layout: Any, space: bpy.types.Space | None) -> None:
    """Blender's shading buttons, where a bake that is shown cannot be seen for the shading."""
    if not isinstance(space, bpy.types.SpaceView3D) or space.shading.type not in _BLIND:
        return
    draw_text(layout, iface_("Seen in these shadings only:"), "INFO")
    row = layout.row(align=True)
    row.use_property_split = False
    for shading, name in (("MATERIAL", "Material"), ("RENDERED", "Rendered")):
        row.prop_enum(space.shading, "type", shading, text=name)
