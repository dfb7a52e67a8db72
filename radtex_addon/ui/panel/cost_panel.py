# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel with the estimated cost of the bake: files, memory, paths and time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from ..jobs import estimates
from ..settings.chosen_objects import nothing_chosen
from .fitting import draw_button, draw_text, fits_beside, fitting, sidebar_room
from .labels import capitalized, duration, expected_range, iface_, number, remark, size
from .main_panel import Sidebar, drawn

if TYPE_CHECKING:
    from ...settings.cost import Cost
    from ...settings.estimate import Basis
    from .panel_state import Forecast


_NAMED = 12  # most atlases that have a line each
_BASES = {
    "baked": "from earlier bakes of it",
    "measured": "measured",
    "others": "roughly, from other bakes here",
    "nothing": "very roughly: nothing was baked here",
}


class RADTEX_PT_cost(Sidebar, bpy.types.Panel):
    """What the bake takes at most, of disk, memory and time"""

    bl_label = "Time and Size"
    bl_parent_id = "RADTEX_PT_bake"
    bl_options: Any = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context | None) -> None:
        layout, _, found = drawn(self, context)
        if found is None:
            draw_text(layout, iface_("Working it out"))
            return
        if not found.objects and context is not None and context.scene is not None:
            draw_text(layout, capitalized(iface_(nothing_chosen(context.scene))), "INFO")
            return
        if found.cost is None:
            draw_text(layout, iface_("Not known for these settings"))
            return
        for line in told_made(found):
            draw_text(layout, line, boxed=False)
        if found.atlases > 1:
            draw_text(layout, iface_("For each object, at most:"), boxed=False)
        shown = figures(found.cost)
        if found.range is not None:
            shown.append((iface_("Time, all"), expected_range(found.range)))
        beside = all(fits_beside(label, [value]) for label, value in shown)
        for label, value in shown:
            _draw_figure(layout, label, value, beside)
        if found.range is not None and found.basis is not None:
            draw_text(layout, told_basis(found.basis), boxed=False)
        _draw_button(layout)
        if failed := estimates.message():
            draw_text(layout, remark(failed), "ERROR")


def told_made(found: Forecast) -> list[str]:
    """What the bake makes, where, and how large all of it is at most; the first atlases by name."""
    if not found.made:
        return []
    count = max(found.bakes, len(found.made) + found.unseen)
    whole = sum(one.disk for one in found.made)
    if found.unseen:
        whole += found.unseen * max(one.disk for one in found.made)
    lines = [
        iface_("1 texture, at most {} on disk").format(size(whole))
        if count == 1
        else iface_("{} textures, at most {} on disk").format(count, size(whole))
    ]
    left = _NAMED
    for folder in dict.fromkeys(one.folder for one in found.made):
        lines.append(iface_("in {}").format(_shown_folder(folder)))
        shown = [one for one in found.made if one.folder == folder][:left]
        left -= len(shown)
        lines += [iface_("{}: {} × {} texels").format(one.name, one.texels, one.texels) for one in shown]
    if more := len(found.made) + found.unseen - (_NAMED - left):
        lines.append(iface_("and {} more").format(more))
    return lines


def _shown_folder(folder: Path) -> str:
    """The folder as short as can be: beside the .blend without what both have in common."""
    home = Path(bpy.data.filepath).parent
    if bpy.data.filepath and folder.is_relative_to(home):
        return f"//{folder.relative_to(home).as_posix()}"
    return str(folder)


def told_basis(basis: Basis) -> str:
    """How far the expected time can be trusted."""
    if basis == "measured" and (took := estimates.took()) is not None:
        return iface_("measured, in {}").format(duration(took))
    return iface_(_BASES[basis])


def _draw_button(layout: Any) -> None:
    """Draw the button that measures, or while it does how far it is and a button to cancel it."""
    if not estimates.asking():
        draw_button(layout, "radtex.estimate", "TIME", iface_("Estimate Time"), iface_("Estimate"))
        return
    row = layout.row(align=True)
    done, total = estimates.progress()
    counted = iface_("{} of {}").format(done, total)
    text = fitting(sidebar_room(buttons=1), iface_("Measuring {} of {}").format(done, total), counted)
    row.progress(factor=(done - 1) / max(total, 1), text=text, translate=False)
    row.operator("radtex.cancel_estimate", text="", icon="X")


def figures(cost: Cost) -> list[tuple[str, str]]:
    """Label and value of each of a cost's figures, in the panel's order."""
    return [
        (iface_("Largest image"), f"{cost.side} × {cost.side}"),
        (iface_("On disk"), size(cost.disk)),
        (iface_("On the GPU"), size(cost.gpu)),
        (iface_("In memory"), size(cost.memory)),
        (iface_("Paths"), number(cost.paths)),
    ]


def _draw_figure(layout: Any, label: str, value: str, beside: bool) -> None:
    """Draw a value beside its name, or both in one text."""
    if not beside:
        draw_text(layout, f"{label}: {value}", boxed=False)
        return
    split = layout.split(factor=0.4)
    name = split.row()
    name.alignment = "RIGHT"
    name.label(text=label, translate=False)
    split.label(text=value, translate=False)
