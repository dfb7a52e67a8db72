# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel with the estimated cost of the bake: files, memory, paths and time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy

from ..jobs import estimates
from .draw_messages import draw_text
from .labels import duration, iface_, number, remark, size
from .main_panel import Sidebar, drawn

if TYPE_CHECKING:
    from ...bake.cost import Cost


class RADTEX_PT_cost(Sidebar, bpy.types.Panel):
    """What the bake takes at most, of disk, memory and time"""

    bl_label = "Time and Size"
    bl_parent_id = "RADTEX_PT_bake"
    bl_options: Any = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context | None) -> None:
        layout, _, found = drawn(self, context)
        if found is None or found.cost is None:
            layout.label(text="Not known for these settings" if found is not None else "Working it out")
            return
        if len(found.objects) > 1:
            layout.label(text="For each object, at most:")
        for label, value in figures(found.cost):
            _draw_figure(layout, label, value)
        if found.seconds is not None:
            _draw_figure(layout, iface_("Time, all"), iface_("about {}").format(duration(found.seconds)))
        text = iface_("Estimating…" if estimates.asking() else "Estimate Time")
        layout.operator("radtex.estimate", text=text, icon="TIME", translate=False)
        if failed := estimates.message():
            draw_text(layout, remark(failed), "ERROR")


def figures(cost: Cost) -> list[tuple[str, str]]:
    """Label and value of each of a cost's figures, in the panel's order."""
    return [
        (iface_("Largest image"), f"{cost.side} × {cost.side}"),
        (iface_("On disk"), size(cost.disk)),
        (iface_("On the GPU"), size(cost.gpu)),
        (iface_("In memory"), size(cost.memory)),
        (iface_("Paths"), number(cost.paths)),
    ]


def _draw_figure(layout: Any, label: str, value: str) -> None:
    split = layout.split(factor=0.4)
    name = split.row()
    name.alignment = "RIGHT"
    name.label(text=label, translate=False)
    split.label(text=value, translate=False)
