# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators to cancel jobs, clear the list and open output folders."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import IntProperty, StringProperty

from ..jobs import jobs, pictures
from ..panel.labels import remark
from ..panel.redraw import redraw
from .bake_lookup import bake_location
from .bake_operator import shown
from .operator_mixins import OfJob

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems


class RADTEX_OT_cancel(bpy.types.Operator):
    """End a bake, a comparison or an export that runs or waits; the scene is what it was"""

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
        if not any(job.ended for job in jobs.snapshot()):
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
