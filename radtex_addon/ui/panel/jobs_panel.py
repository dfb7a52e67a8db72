# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel that lists jobs (bakes, comparisons, exports) with their progress or results."""

from __future__ import annotations

from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from ...bake.bake_title import bake_title
from ...settings.bake_names import OBJECT
from ...settings.menu_items import KINDS, TARGETS
from ..jobs import browser, job_files, jobs, pictures
from ..jobs.job_files import Fate
from ..operators.switch import draw_show, draw_small_switch
from .farm_panel import offer_again, offer_prepared, told_prepared
from .fitting import draw_button, draw_text, draw_title, fitting, side_by_side, sidebar_room
from .labels import duration, iface_, number, remark, size, stage, time_left_briefly, time_left_of
from .main_panel import Sidebar
from .next_buttons import draw_action

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from ...worker.job import Job, JobMap
    from ...worker.together import Together

_ICONS = {
    "waiting": "SORTTIME",
    "done": "CHECKMARK",
    "failed": "ERROR",
    "cancelled": "CANCEL",
    "left": "PAUSE",
}
_RUNNING = {
    "bake": "RENDER_STILL",
    "comparison": "IMAGE_REFERENCE",
    "export": "EXPORT",
    "preparation": "NETWORK_DRIVE",
    "assembly": "PACKAGE",
}
_TITLES = {
    "bake": "{}",
    "comparison": "{}, compared",
    "export": "{} for {}",
    "preparation": "{}, for a farm",
    "assembly": "{}, from a farm",
}
_FATES = {
    Fate.GONE: "Its files are no longer there",
    Fate.REPLACED: "Other files have replaced its own since",
}
_PAGES = 4  # most of an export's web pages that get a button each
_TARGETS = {identifier: name for identifier, name, _ in TARGETS}
_KINDS = {identifier: name for identifier, name, _ in KINDS}

_PICTURE = 8.0  # size of a job's thumbnail, relative to a button's height


class RADTEX_PT_jobs(Sidebar, bpy.types.Panel):
    """Bakes, comparisons, exports and farms that wait, run or have ended"""

    bl_label = "Jobs"
    bl_parent_id = "RADTEX_PT_bake"

    @classmethod
    def poll(cls, _: bpy.types.Context | None) -> bool:
        return bool(jobs.snapshot())

    def draw(self, context: bpy.types.Context | None) -> None:
        layout: Any = self.layout
        found = jobs.snapshot()
        _draw_all(layout.column(align=True), found)
        for job in in_order(found):
            _draw_job(layout.box().column(align=True), job)


def in_order(found: Iterable[Job]) -> list[Job]:
    """Those that run, wait, or were left by an ended Blender, in order; then what has ended, latest first."""
    found = list(found)
    first = [[job for job in found if job.state == state] for state in ("running", "waiting", "left")]
    ended = [job for job in found if job.ended and job.state != "left"]
    return [*chain.from_iterable(first), *reversed(ended)]


def _draw_all(column: Any, found: Sequence[Job]) -> None:
    """Draw the bar of bakes that were asked for together, and the buttons that cancel or clear several."""
    together = jobs.together()
    if any(not job.ended for job in found):
        draw_text(column, iface_("Quitting Blender stops them; the next start offers to go on"), "BLANK1")
    if together is not None:
        text = fitting(sidebar_room(), told_together(together), told_together_briefly(together))
        column.progress(factor=together.fraction, text=text, translate=False)
    if left := jobs.left():
        draw_text(column, told_left(len(left)), "INFO")
        several = (iface_("Go On with {}").format(len(left)),) * (len(left) > 1)
        draw_button(column, "radtex.go_on", "PLAY", *several, iface_("Go On"))
    ended = [job for job in found if job.ended and job.state != "left"]
    buttons = []
    if len([job for job in found if not job.ended]) > 1:
        buttons.append(("radtex.cancel", "CANCEL", iface_("Cancel All"), iface_("Cancel")))
    if ended:
        buttons.append(("radtex.clear_jobs", "TRASH", iface_("Clear Finished"), iface_("Clear")))
    if not buttons:
        return
    row, share = side_by_side(column, [texts[-1] for _, _, *texts in buttons])
    for name, icon, *texts in buttons:
        draw_button(row, name, icon, *texts, share=share)


def told_left(count: int) -> str:
    """How many jobs an ended Blender left."""
    if count == 1:
        return iface_("Blender ended before 1 of these was done")
    return iface_("Blender ended before {} of these were done").format(count)


def told_together(together: Together) -> str:
    """How many of several bakes are done, and the time left of all."""
    told = iface_("{} of {} bakes").format(together.done, together.count)
    return f"{told}, {time_left_of(together.left)}"


def told_together_briefly(together: Together) -> str:
    """The same in fewer words, for a bar too narrow for it."""
    told = iface_("{} of {}").format(together.done, together.count)
    left = time_left_briefly(together.left)
    return f"{told}, {left}" if left else told


def job_title(job: Job) -> str:
    """The job's title: that of the bake, and the work."""
    about = job.order.about
    kind = iface_(_KINDS[about]) if about in _KINDS else ""
    name = bake_title(
        job.order.called or job.object, part=job.order.part, kind=kind, variant=job.order.variant
    )
    folders = set(job.order.facts.get("folders", ()))  # of a scene all bakes have the same
    if (count := len(folders or job.order.facts.get("names", ()))) > 1:
        name = iface_("{} bakes").format(count)
    title = iface_(_TITLES[job.work]).format(name, _TARGETS.get(about, ""))
    if _is_of_other_file(job):
        return f"{title} ({_file_of(job)})"
    return title


def phrase(job: Job) -> str:
    """The job's state or stage, and the time left."""
    if job.cancelling and not job.ended:
        return iface_("Stopping")
    if job.state == "left":
        return iface_("Begun, not finished" if job.begun else "Not begun")
    if job.state != "running":
        return iface_(job.state.value.capitalize())
    return f"{stage(job.stage)}, {time_left_of(job.left)}"


def phrase_briefly(job: Job) -> str:
    """The same of a running job in fewer words, for a bar too narrow for it."""
    if job.cancelling or job.state != "running":
        return phrase(job)
    return time_left_briefly(job.left) or f"{job.fraction:.0%}"


def _draw_job(column: Any, job: Job) -> None:
    """Draw a job's name and state, its bar while it runs, and unless it is folded all that is known of it."""
    folded, row = jobs.is_folded(job), column.row(align=True)
    if job.state == "waiting":
        row.label(text="", icon="BLANK1")
    else:
        arrow = "RIGHTARROW" if folded else "DOWNARROW_HLT"
        row.operator("radtex.fold_job", text="", icon=arrow, emboss=False).number = job.number
    whole = draw_title(row, job_title(job), _ICONS.get(job.state, _RUNNING[job.work]), buttons=2)
    if job.ended:
        row.operator("radtex.clear_jobs", text="", icon="X", emboss=False).number = job.number
    else:
        row.operator("radtex.cancel", text="", icon="X").number = job.number
    if job.state == "running":
        text = fitting(sidebar_room(), phrase(job), phrase_briefly(job))
        column.progress(factor=job.fraction, text=text, translate=False)
    if folded:
        return
    if not whole:
        draw_text(column, job_title(job))
    if job.ended:
        _draw_ended(column, job)
    elif job.state == "running":
        _draw_map(column, job, pictures.icon(job))
    _draw_warnings(column, job)


def _draw_ended(column: Any, job: Job) -> None:
    """Draw what a job made, how it ended, and what can be done now."""
    if job.state == "done":  # the icon shows the state, so no text
        for line in results(job, jobs.snapshot()):
            draw_text(column, line, "BLANK1")
    if job.map is not None:
        _draw_map(column, job, 0)
    if job.state == "done":
        if job_files.fate(job.number) is Fate.THERE:
            _OFFERS[job.work](column, job)
        return
    row, share = side_by_side(column, [phrase(job), iface_("Resume")])
    row.label(text=phrase(job), icon="BLANK1", translate=False)
    if job.state == "left":
        if jobs.left(job.number):
            draw_button(row, "radtex.go_on", "PLAY", iface_("Go On"), share=share).number = job.number
    elif _can_resume(job):
        _ask_to_resume(draw_button(row, "radtex.bake", "PLAY", iface_("Resume"), share=share), job)
    if job.state == "failed":
        _draw_failure(column, job)


def _draw_failure(column: Any, job: Job) -> None:
    """Draw why a job failed, and what can be done about it."""
    draw_text(column, remark(job.message, job.out), "BLANK1")
    texts = (iface_("Copy Report"), iface_("Report"))
    draw_button(column, "radtex.copy_report", "COPYDOWN", *texts).number = job.number
    if job.work == "assembly" and not jobs.is_superseded(job):
        offer_again(column, job)


def _ask_to_resume(button: Any, job: Job) -> None:
    """Let the operator go on with the job's bake: of its object, or of those that share its atlas."""
    order = job.order
    button.part, button.resume, button.overwrite = order.part, True, False
    spec = order.facts["spec"]
    if spec["density"] is None:  # those of a shared atlas, or of a scene's, are not the panel's
        button.texels = spec["texels"]
    if (called := spec.get("bake_name", OBJECT)) != OBJECT:  # by the settings as they were
        button.bake_name = called
    if not order.shared:
        button.object = job.object
        return
    button.objects = "\n".join(order.shared)
    button.together, button.atlas_name = "one", job.object


def _can_resume(job: Job) -> bool:
    """Whether to offer to go on with a bake that was cancelled or failed.

    Not once a later job has gone on with it or replaced it, nor while another file is open, whose object of
    that name would be baked.
    """
    return job.work == "bake" and not _is_of_other_file(job) and not jobs.is_superseded(job)


def _is_of_other_file(job: Job) -> bool:
    """Whether another .blend is open than that of the job; if that was never saved, this is not known."""
    blend = job.order.facts.get("of_blend", "")
    return bool(blend) and blend != bpy.data.filepath


def _file_of(job: Job) -> str:
    """The name of the job's .blend file; empty if that was never saved."""
    return Path(job.order.facts.get("of_blend", "")).name


def results(job: Job, others: Iterable[Job]) -> list[str]:
    """Figures of a finished job in lines: its time, the size of its files, and what a comparison found."""
    told = [] if job.took is None else [duration(job.took)]
    if (fate := job_files.fate(job.number)) is not Fate.THERE:
        return [*told, iface_(_FATES[fate])]
    sizes = job_files.sizes(job.number) if job.work in ("bake", "assembly") else ()
    if sizes:
        told.append(iface_("{} in {} files").format(size(sum(sizes)), len(sizes)))
    if job.work == "export" and "bytes" in job.facts:
        told.append(size(job.facts["bytes"]))
    compared = _comparison_of(job, others)
    if compared is not None:
        told.append(iface_("{:.1f} dB").format(compared.facts["psnr"]))
    lines = [", ".join(told)] if told else []
    if job.work == "preparation":
        lines += told_prepared(job.facts)
    if clamped := job.facts.get("clamped"):
        text = iface_(
            "{} values were brighter than the file holds, and were cut off (32-bit Floats keeps them)"
        )
        lines.append(text.format(number(clamped)))
    return lines


def _comparison_of(job: Job, others: Iterable[Job]) -> Job | None:
    """The latest comparison of the object with this bake, of those on the list after it."""
    found = [
        other
        for other in others
        if other.work == "comparison"
        and other.state == "done"
        and other.number > job.number
        and other.facts.get("psnr") is not None
        and job.object in other.object.split(", ")
        and _is_with(other, job)
    ]
    return found[-1] if found and job.work == "bake" else None


def _is_with(comparison: Job, bake: Job) -> bool:
    """Whether a comparison of the object is with this bake of it, as far as is known."""
    sidecars = {Path(path).name for path in comparison.order.facts.get("sidecars", ()) if path}
    return not sidecars or any(path.name in sidecars for path in bake.files)


def _draw_map(column: Any, job: Job, light: int) -> None:
    """Draw the figures of the job's UV map, which unfold its picture, or the icon `light`, if any."""
    if job.map is not None:
        texts = (map_figures(job.map), iface_("Map"))
        _draw_fold(column, "radtex.fold_map", texts, folded=not pictures.is_unfolded(job)).number = job.number
    unfolded = pictures.unfolded_map(job)
    if picture := light if unfolded is None else unfolded.icon_id:
        column.template_icon(picture, scale=_PICTURE)


def _draw_fold(column: Any, operator: str, texts: Sequence[str], *, folded: bool) -> Any:
    """Draw a line whose arrow shows more or hides it; returns its operator's properties."""
    row = column.row(align=True)
    row.alignment = "LEFT"
    arrow = "RIGHTARROW" if folded else "DOWNARROW_HLT"
    return draw_button(row, operator, arrow, *texts, emboss=False)


def map_figures(found: JobMap) -> str:
    """How many islands cover how much of the atlas, such as "41 islands cover 55 %"."""
    if found.islands == 1:
        return iface_("1 island covers {:.0%}").format(found.coverage)
    return iface_("{} islands cover {:.0%}").format(found.islands, found.coverage)


def _draw_warnings(column: Any, job: Job) -> None:
    """Draw the job's warnings; once it has ended, several are a line that unfolds them."""
    hidden = jobs.hides_warnings(job)
    if job.ended and len(job.warnings) > 1:
        texts = (iface_("{} warnings").format(len(job.warnings)), iface_("Warnings"))
        _draw_fold(column, "radtex.fold_warnings", texts, folded=hidden).number = job.number
    for warning in () if hidden else job.warnings:
        draw_text(column, remark(warning, job.out), "INFO")


def _offer_bake(column: Any, job: Job) -> None:
    """Draw buttons that show, compare and export this bake, whatever is selected, and open its folder."""
    buttons: list[Any] = []
    sidecar = str(next((path for path in job.files if path.suffix == ".json"), job.out))
    has_preview = any(path.name.endswith(".preview.blend") for path in job.files)
    name = (job.order.shared or (job.object,))[0]
    item: bpy.types.Object | None = bpy.data.objects.get(name)
    if has_preview and item is None:
        draw_text(column, _why_missing(job, name), "INFO")
    row = column.row(align=True)
    if has_preview and item is not None:
        small = draw_show(row) if job.order.variant else draw_small_switch(row, item, job.files)
        buttons += [small, draw_action(row, "radtex.compare", as_icon=True)]
    if has_preview:
        buttons += [
            draw_action(row, f"radtex.{name}", as_icon=True) for name in ("show_in_browser", "export")
        ]
    buttons.append(draw_action(row, "radtex.delete_bake", as_icon=True))
    for button in buttons:
        button.object, button.bake, button.job = job.object, sidecar, job.number
    draw_action(row, "radtex.open_folder", as_icon=True).directory = str(job.out)


def _why_missing(job: Job, name: str) -> str:
    """Why the bake's object `name` is not in the open file, and what to do to preview the bake."""
    if _is_of_other_file(job):
        return iface_("Open {} to preview it").format(_file_of(job))
    told = iface_("No object is called '{}' any more: give it that name again to preview this bake")
    return told.format(name)


def _offer_comparison(column: Any, job: Job) -> None:
    """Draw the figures of a finished comparison and the button for its pictures."""
    from ..jobs.comparison import figures

    for line in figures(job.facts):
        draw_text(column, line, "BLANK1")
    texts = (iface_("Show Pictures"), iface_("Pictures"))
    draw_button(column, "radtex.show_comparison", "IMAGE_DATA", *texts).number = job.number


def _offer_export(column: Any, job: Job) -> None:
    """Draw buttons that open the exported folder, or the one that several are in, and pages.

    The button of a page that is served has its address as its text, to be typed in if no browser opened. A
    line for it would move the buttons below.
    """
    several = len(job.files) > 1
    pages = job.files if job.order.about == "web" else ()
    for folder in pages[:_PAGES]:
        text = browser.known_address(folder).removeprefix("http://")
        texts = (text or folder.stem,) if text or several else (iface_("Show in Browser"), iface_("Browser"))
        page = draw_button(column, "radtex.show_in_browser", "URL", *texts)
        page.directory, page.job = str(folder), job.number
    opened = job.out if several else job.files[0]
    draw_action(column, "radtex.open_folder", fit=True).directory = str(opened)


def _offer_assembly(column: Any, job: Job) -> None:
    """Draw a bake's buttons, or for several where they are found."""
    if len(job.order.facts["names"]) == 1:
        _offer_bake(column, job)
        return
    draw_text(column, iface_("Finished Bake shows them, once they are chosen"), "INFO")
    draw_action(column, "radtex.open_folder", fit=True).directory = str(job.out)


_OFFERS = {
    "bake": _offer_bake,
    "comparison": _offer_comparison,
    "export": _offer_export,
    "preparation": offer_prepared,
    "assembly": _offer_assembly,
}
