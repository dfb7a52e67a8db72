# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mixins for operators on finished bakes: choice of the bake, waiting, and the settings dialog."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, IntProperty, StringProperty

from ..panel.redraw import redraw
from .bake_lookup import has_meshes

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems


class OfBake:
    """Mixin with the properties that name a bake, and a poll; not registered itself."""

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        object: str
        bake: str
        job: int
    else:
        object: StringProperty(
            name="Object",
            description="Name of the object. Left empty, all selected meshes are meant",
            options={"SKIP_SAVE"},
        )
        bake: StringProperty(
            name="Bake",
            description="A bake's folder, or its .json file. Left empty, the scene's output folder",
            subtype="FILE_PATH",
            options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
        )
        job: IntProperty(
            name="Job",
            description="The number of the job whose files must still be there. 0 checks nothing",
            default=0,
            min=0,
            options={"SKIP_SAVE", "HIDDEN"},
        )

    def check_files(self) -> None:
        """Raise InputError if the files are no longer those of the job whose button was pressed."""
        from ...core.errors import InputError
        from ..jobs.job_files import Fate, fate_now

        if self.job and (found := fate_now(self.job)) is not Fate.THERE:
            redraw()
            done = "deleted" if found is Fate.GONE else "replaced by others"
            raise InputError(f"the files of this job have been {done} since")

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        """Whether a mesh is selected, in Object Mode."""
        return has_meshes(cls, context)  # type: ignore[arg-type]  # the class that uses the mixin is an operator


class OfJob:
    """Mixin with the property that names a job on the list; not registered itself."""

    if TYPE_CHECKING:  # type of the property that Blender creates from the annotation below
        number: int
    else:
        number: IntProperty(name="Number", description="The job's number", min=1, options={"SKIP_SAVE"})


class MayWait:
    """Mixin with the property `wait`, for operators that use a worker; not registered itself."""

    if TYPE_CHECKING:  # type of the property that Blender creates from the annotation below
        wait: bool
    else:
        wait: BoolProperty(
            name="Wait",
            description="Work here and now, so that a script finds the result afterwards. Without a window "
            "that is always so",
            default=False,
            options={"SKIP_SAVE", "HIDDEN"},
        )

    @property
    def at_once(self) -> bool:
        """Whether to work in this process, and not in a worker."""
        return bpy.app.background or self.wait


class AsksFirst:
    """Mixin that opens a dialog with the operator's settings on a click; scripts run it directly."""

    def invoke(
        self, context: bpy.types.Context | None, event: bpy.types.Event | None
    ) -> set[OperatorReturnItems]:
        """Open the settings dialog."""
        assert context is not None  # Blender always gives one
        assert context.window_manager is not None  # a click implies a window
        return context.window_manager.invoke_props_dialog(self)  # type: ignore[arg-type]  # an operator, as above
