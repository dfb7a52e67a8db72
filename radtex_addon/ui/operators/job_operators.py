# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators to cancel jobs, clear the list and open output folders."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty, IntProperty, StringProperty

from ..jobs import jobs, pictures
from ..panel import job_ends
from ..panel.labels import remark
from ..panel.redraw import redraw, views
from .bake_lookup import bake_location
from .bake_operator import shown
from .operator_mixins import OfJob

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems

_DRAWN = 0.3  # seconds until a sidebar that was opened is drawn


class RADTEX_OT_cancel(bpy.types.Operator):
    """End a bake, a comparison, an export or a farm's job that runs or waits; the scene is what it was"""

    bl_idname = "radtex.cancel"
    bl_label = "Cancel"
    bl_options = {"INTERNAL"}

    if TYPE_CHECKING:
        number: int
    else:
        number: IntProperty(
            name="Number",
            description="The job's number; 0 cancels all",
            default=0,
            min=0,
            options={"SKIP_SAVE"},
        )

    @classmethod
    def poll(cls, _: bpy.types.Context | None) -> bool:
        if not jobs.busy():
            cls.poll_message_set("Nothing is being baked, compared or exported")
            return False
        return True

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        jobs.cancel(self.number or None)
        return {"FINISHED"}


class RADTEX_OT_cancel_here(bpy.types.Operator):
    """End all jobs, while the mouse is over the sidebar: anywhere else, Esc belongs to others"""

    bl_idname = "radtex.cancel_here"
    bl_label = "Cancel All"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        region = context.region if context is not None else None
        if region is None or region.type != "UI":
            cls.poll_message_set("Put the mouse over the sidebar to cancel by a key")
            return False
        return RADTEX_OT_cancel.poll(context)

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        jobs.cancel()
        return {"FINISHED"}


class RADTEX_OT_clear_jobs(bpy.types.Operator):
    """Take a job that has ended, or all such jobs, off the list; their files stay"""

    bl_idname = "radtex.clear_jobs"
    bl_label = "Clear Finished"
    bl_options = {"INTERNAL"}

    if TYPE_CHECKING:
        number: int
    else:
        number: IntProperty(
            name="Number",
            description="The job's number; 0 clears all that have ended",
            default=0,
            min=0,
            options={"SKIP_SAVE"},
        )

    @classmethod
    def poll(cls, _: bpy.types.Context | None) -> bool:
        if not any(job.ended for job in jobs.snapshot()):  # also those that are left, one by one
            cls.poll_message_set("No bake on the list has ended")
            return False
        return True

    @classmethod
    def description(cls, _: bpy.types.Context | None, properties: Any) -> str:
        """The tooltip, of one job or of all."""
        if properties.number:
            return "Take this job off the list; its files stay"
        return "Take all jobs that have ended off the list; their files stay"

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        jobs.forget_ended(self.number or None)
        redraw()
        return {"FINISHED"}


class RADTEX_OT_go_on(bpy.types.Operator):
    """Do what an earlier Blender left when it ended: what it had begun is resumed, whichever file is open"""

    bl_idname = "radtex.go_on"
    bl_label = "Go On"
    bl_options = {"INTERNAL"}

    if TYPE_CHECKING:
        number: int
    else:
        number: IntProperty(
            name="Number",
            description="The job's number; 0 goes on with all that are left",
            default=0,
            min=0,
            options={"SKIP_SAVE"},
        )

    @classmethod
    def poll(cls, _: bpy.types.Context | None) -> bool:
        if not jobs.left():
            cls.poll_message_set("No bake was left by a Blender that has ended")
            return False
        return True

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        if not jobs.left(self.number or None):
            self.report({"ERROR"}, f"Job {self.number} was not left: only those can be gone on with")
            return {"CANCELLED"}
        jobs.go_on(self.number or None)
        redraw()
        return {"FINISHED"}


class RADTEX_OT_copy_report(bpy.types.Operator):
    """Copy what a report of a bug needs: versions, system, graphics card, settings, and what the job said"""

    bl_idname = "radtex.copy_report"
    bl_label = "Copy Report"
    bl_options = {"INTERNAL"}

    if TYPE_CHECKING:
        number: int
    else:
        number: IntProperty(
            name="Number",
            description="The job's number; 0 copies versions, system and hardware alone",
            default=0,
            min=0,
            options={"SKIP_SAVE"},
        )

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ..jobs.bug_report import report_of

        assert context is not None  # Blender always gives one
        assert context.window_manager is not None  # as above
        job = next((job for job in jobs.snapshot() if job.number == self.number), None)
        context.window_manager.clipboard = report_of(job)
        told = "System information" if job is None else f"The report on {job.object}"
        self.report({"INFO"}, f"{told} is in the clipboard")
        return {"FINISHED"}


class RADTEX_OT_tell_end(bpy.types.Operator):
    """Say in the status bar what jobs have come to"""

    bl_idname = "radtex.tell_end"
    bl_label = "Tell the End"
    bl_options = {"INTERNAL"}

    _timer: bpy.types.Timer | None = None

    if TYPE_CHECKING:
        text: str
        failed: bool
    else:
        text: StringProperty(name="Text", description="What to say", options={"SKIP_SAVE"})
        failed: BoolProperty(
            name="Failed", description="Whether it is a warning", default=False, options={"SKIP_SAVE"}
        )

    def invoke(
        self, context: bpy.types.Context | None, event: bpy.types.Event | None
    ) -> set[OperatorReturnItems]:
        """Wait for Blender's next event: what an operator says is shown only if Blender itself runs it."""
        assert context is not None  # Blender always gives one
        assert context.window_manager is not None  # as above
        self._timer = context.window_manager.event_timer_add(0.01, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(
        self, context: bpy.types.Context | None, event: bpy.types.Event | None
    ) -> set[OperatorReturnItems]:
        if event is None or event.type != "TIMER":
            return {"PASS_THROUGH"}
        self.cancel(context)
        self.execute(context)
        return {"FINISHED", "PASS_THROUGH"}

    def cancel(self, context: bpy.types.Context | None) -> None:
        """Remove the timer."""
        if self._timer is not None and context is not None and context.window_manager is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        self.report({"WARNING"} if self.failed else {"INFO"}, self.text)
        return {"FINISHED"}


class RADTEX_OT_show_jobs(bpy.types.Operator):
    """Show the list of jobs, in this 3D view's sidebar"""

    bl_idname = "radtex.show_jobs"
    bl_label = "Show Jobs"
    bl_options = {"INTERNAL"}

    if TYPE_CHECKING:
        show: bool
    else:
        show: BoolProperty(
            name="Show",
            description="Open the sidebar; else only take away the line that tells of jobs that have ended",
            default=True,
            options={"SKIP_SAVE"},
        )

    @classmethod
    def description(cls, _: bpy.types.Context | None, properties: Any) -> str:
        """The tooltip: of the line all that it says, for it may be cut, or of its cross."""
        if not properties.show:
            return "Take this line away"
        told = job_ends.told()
        return f"{told}\n{cls.__doc__}" if told else cls.__doc__ or ""

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        assert context is not None  # Blender always gives one
        job_ends.forget()
        if not self.show:
            return {"FINISHED"}
        space = context.space_data
        if not isinstance(space, bpy.types.SpaceView3D):
            self.report({"ERROR"}, "Put the mouse over a 3D view: its sidebar has the list of jobs")
            return {"CANCELLED"}
        space.show_region_ui = True
        assert context.area is not None  # the space is in one
        place = context.area.as_pointer()
        _open_tab(place)
        # Blender knows the tabs of a sidebar once it was drawn.
        bpy.app.timers.register(partial(_open_tab, place), first_interval=_DRAWN)
        return {"FINISHED"}


def _open_tab(place: int) -> None:
    """Open RadTex's tab in the sidebar of the 3D view at that address, if it is still there."""
    area = next((area for area in views() if area.as_pointer() == place), None)
    sidebar: Any = job_ends.sidebar_of(area)
    if sidebar is None:
        return
    with suppress(TypeError):  # it was never drawn
        sidebar.active_panel_category = job_ends.TAB
    sidebar.tag_redraw()


class RADTEX_OT_fold_job(OfJob, bpy.types.Operator):
    """Show what is known of the job and what can be done with it, or its name alone"""

    bl_idname = "radtex.fold_job"
    bl_label = "Details"
    bl_options = {"INTERNAL"}

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        jobs.fold(self.number)
        redraw()
        return {"FINISHED"}


class RADTEX_OT_fold_map(OfJob, bpy.types.Operator):
    """Show the map that is baked on: an island in one colour, darker where texels are denser. Or hide it"""

    bl_idname = "radtex.fold_map"
    bl_label = "Map"
    bl_options = {"INTERNAL"}

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        pictures.toggle_map(self.number)
        redraw()
        return {"FINISHED"}


class RADTEX_OT_fold_warnings(OfJob, bpy.types.Operator):
    """Show what the job warned of, or hide it"""

    bl_idname = "radtex.fold_warnings"
    bl_label = "Warnings"
    bl_options = {"INTERNAL"}

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        jobs.fold_warnings(self.number)
        redraw()
        return {"FINISHED"}


class RADTEX_OT_open_folder(bpy.types.Operator):
    """Show the folder in your file manager"""

    bl_idname = "radtex.open_folder"
    bl_label = "Open Folder"
    bl_options = {"INTERNAL"}

    if TYPE_CHECKING:
        directory: str
    else:
        directory: StringProperty(
            name="Folder",
            description="The folder to open. Left empty, the scene's output folder",
            subtype="DIR_PATH",
            options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
        )

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import RadTexError

        scene, _ = shown(context)
        try:
            folder = bake_location(scene, self.directory)
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        if not folder.is_dir():
            self.report({"ERROR"}, f"{folder} is not there yet: bake first")
            return {"CANCELLED"}
        bpy.ops.wm.path_open(filepath=str(folder))
        return {"FINISHED"}
