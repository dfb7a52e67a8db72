# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tell that jobs have ended where the sidebar is hidden: a message in the status bar, a line in the 3D view.

Blender has no notifications of the desktop, in 4.5 or 5.2, so that is all there is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import bpy

from .fitting import fitting
from .labels import duration, iface_, remark
from .redraw import redraw_views, views

if TYPE_CHECKING:
    from ...worker.job import Job

TAB = "RadTex"  # of the sidebar
_ROOM = 220.0  # pixels of a 3D view's header for the line
_header: Any = bpy.types.VIEW3D_HT_header  # the stubs type append's argument too narrowly
_DONE = {
    "bake": "Baked {}",
    "comparison": "Compared {}",
    "export": "Exported {}",
    "preparation": "Prepared {} for a farm",
    "assembly": "Assembled {}",
}


@dataclass(frozen=True)
class End:
    """What jobs have come to: a line, whether any of them failed, and their numbers."""

    text: str
    failed: bool
    jobs: frozenset[int]


@dataclass
class _Shown:
    end: End | None = None  # what the 3D views' headers show


_shown = _Shown()


def end_of(ended: Sequence[Job]) -> End | None:
    """What to say of jobs that have ended since nothing ran; None if all of them were cancelled."""
    done = [job for job in ended if job.state == "done"]
    failed = [job for job in ended if job.state == "failed"]
    numbers = frozenset(job.number for job in ended)
    if failed:
        text = iface_("{} failed: {}").format(_named(failed[0]), remark(failed[0].message, failed[0].out))
        if len(done) + len(failed) > 1:
            several = iface_("{} of {} jobs failed").format(len(failed), len(done) + len(failed))
            text = f"{several}. {text}"
        return End(text, True, numbers)
    if not done:
        return None
    took = sum(job.took or 0.0 for job in done)
    told = iface_("Done {} jobs").format(len(done))
    if len(done) == 1:
        told = iface_(_DONE[done[0].work]).format(_named(done[0]))
    return End(iface_("{} in {}").format(told, duration(took)), False, numbers)


def tell(ended: Sequence[Job]) -> None:
    """Say what jobs have come to, now that none is left to do, unless the preferences say not to.

    There is no line where some 3D view shows the list of jobs.
    """
    from ..operators.undo import in_a_window
    from ..settings.preferences import preferred

    end = end_of(ended) if preferred().notify else None
    if end is None:
        return
    if not any(map(shows_jobs, views())):
        _shown.end = end
        redraw_views()
    if not bpy.app.background:
        operators: Any = bpy.ops.radtex  # type: ignore[attr-defined]  # ours, not Blender's
        with in_a_window():
            operators.tell_end("INVOKE_DEFAULT", text=f"RadTex: {end.text}", failed=end.failed)


def forget(numbers: frozenset[int] | None = None) -> None:
    """Take the line away, unless it is about one of the jobs with these numbers, which are on the list."""
    if _shown.end is not None and (numbers is None or not _shown.end.jobs & numbers):
        _shown.end = None
        redraw_views()


def draw_end(header: Any, context: bpy.types.Context) -> None:
    """In a 3D view's header, say what has ended, unless the view's sidebar shows the jobs by now."""
    end = _shown.end
    if end is None or shows_jobs(context.area):
        return
    row = header.layout.row(align=True)
    icon = "ERROR" if end.failed else "CHECKMARK"
    row.operator("radtex.show_jobs", text=fitting(_ROOM, end.text), icon=icon, translate=False)
    row.operator("radtex.show_jobs", text="", icon="X").show = False


def told() -> str:
    """What the headers say, in full; empty if nothing."""
    return "" if _shown.end is None else _shown.end.text


def shows_jobs(area: bpy.types.Area | None) -> bool:
    """Whether this 3D view's sidebar is open at RadTex's tab."""
    sidebar = sidebar_of(area)
    return sidebar is not None and sidebar.width > 1 and sidebar.active_panel_category == TAB


def sidebar_of(area: bpy.types.Area | None) -> bpy.types.Region | None:
    """The sidebar of a 3D view; None for anything else."""
    if area is None or area.type != "VIEW_3D":
        return None
    return next((region for region in area.regions if region.type == "UI"), None)


def register() -> None:
    """Add the line to the 3D views' headers."""
    _header.append(draw_end)


def unregister() -> None:
    """Take it away again."""
    _header.remove(draw_end)
    _shown.end = None


def _named(job: Job) -> str:
    """What a job is about: its object, or how many bakes an export is of."""
    names = job.object.split(", ")
    return job.object if len(names) < 3 else iface_("{} and {} more").format(names[0], len(names) - 1)
