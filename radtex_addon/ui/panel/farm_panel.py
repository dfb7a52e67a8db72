# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel for baking by several machines, and what the list of jobs says and offers of a farm."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from ..operators.farm_operators import RADTEX_OT_prepare_farm
from .fitting import draw_button, draw_text
from .labels import duration, iface_, size
from .main_panel import Sidebar
from .next_buttons import draw_action

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ...worker.job import Job

_LISTED = 4  # most files that are named in the panel


class RADTEX_PT_farm(Sidebar, bpy.types.Panel):
    """Bake on several machines at once: each does some of the tasks in a folder that all of them see"""

    bl_label = "Render Farm"
    bl_parent_id = "RADTEX_PT_bake"
    bl_options: Any = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context | None) -> None:
        layout: Any = self.layout
        draw_text(layout, iface_("Machines with RadTex share the work"))
        column = layout.column(align=True)
        texts = (iface_("Prepare for a Farm…"), iface_("Prepare…"))
        draw_button(column, "radtex.prepare_farm", "NETWORK_DRIVE", *texts)
        draw_button(column, "radtex.assemble_farm", "PACKAGE", iface_("Assemble…"))
        if not RADTEX_OT_prepare_farm.poll(context):
            draw_text(layout, iface_("Add a mesh object to prepare its bake"), "INFO")


def told_prepared(facts: Mapping[str, Any]) -> list[str]:
    """What a farm is that was prepared, by the `facts` of its job: tasks, size, time, and what travels."""
    times = dict(facts["expected"])
    lines = [
        iface_("{} tasks, {} to travel").format(facts["tasks"], size(facts["bytes"])),
        iface_("By typical times {} on 1 machine, {} on 4, {} on 16").format(
            *(duration(times[machines]) for machines in (1, 4, 16))
        ),
    ]
    carried = facts["carried"]
    if not carried:
        return [*lines, iface_("No other file of this machine travels with it")]
    if len(carried) > _LISTED:
        told = iface_("{} files of this machine travel with it: {} lists them")
        return [*lines, told.format(len(carried), Path(facts["listing"]).name)]
    return [*lines, iface_("Of this machine travel with it:"), *carried]


def offer_prepared(column: Any, job: Job) -> None:
    """Draw the buttons of a farm that was prepared: its folder, what machines run, and to assemble it."""
    farm = str(job.files[0])
    row = column.row(align=True)
    _draw_copy(row, farm, 1)
    draw_action(row, "radtex.open_folder", as_icon=True).directory = farm
    _draw_assemble(column, farm)


def offer_again(column: Any, job: Job) -> None:
    """Draw the buttons of a farm that could not be assembled: what machines run, and to try again."""
    farm = job.order.facts["farm"]
    _draw_copy(column, farm, 0)
    button = _draw_assemble(column, farm)
    if job.out != Path(farm).parent:
        button.into = str(job.out)


def _draw_copy(layout: Any, farm: str, buttons: int) -> None:
    texts = (iface_("Copy Command"), iface_("Command"))
    draw_button(layout, "radtex.copy_farm_command", "COPYDOWN", *texts, buttons=buttons).directory = farm


def _draw_assemble(layout: Any, farm: str) -> Any:
    button = draw_button(layout, "radtex.assemble_farm", "PACKAGE", iface_("Assemble"))
    button.directory = farm
    return button
