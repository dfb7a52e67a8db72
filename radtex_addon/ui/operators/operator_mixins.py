# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mixins for operators on finished bakes: choice of the bake, waiting, and the settings dialog."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty, IntProperty, StringProperty

from ..panel.fitting import draw_wrapped
from ..panel.redraw import redraw
from .bake_lookup import has_meshes
from .export_dialog import WIDTH

if TYPE_CHECKING:
    from collections.abc import Iterable

    from bpy.stub_internal.rna_enums import OperatorReturnItems

_ICON = 40  # pixels beside a line of a dialog, for its icon


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


class Foresees:
    """Mixin for a dialog that says what the operator would do by `what`, `again` and `join`."""

    if TYPE_CHECKING:  # types of properties of the operator
        what: str
        again: bool
        join: bool
    _drawn: tuple[str, bool, bool] | None = None  # the choices that the lines are of
    _lines: tuple[tuple[str, str], ...] = ()  # what the dialog says, each with its icon

    def _foreseen(self, context: bpy.types.Context | None) -> tuple[tuple[str, str], ...]:
        """What to say by the choices, a line each, with its icon."""
        raise NotImplementedError

    def check(self, context: bpy.types.Context | None) -> bool:
        """Plan anew if the dialog's choices have changed; returns whether it has to be drawn again."""
        choices = self.what, self.again, self.join
        if self._drawn == choices:
            return False
        self._drawn, self._lines = choices, self._foreseen(context)
        return True


def draw_lines(layout: Any, lines: Iterable[tuple[str, str]]) -> None:
    """Draw a dialog's lines, each with its icon, wrapped."""
    column = layout.column(align=True)
    for line, icon in lines:
        draw_wrapped(column, line, icon, WIDTH - _ICON)


class AsksFirst:
    """Mixin that opens a dialog with the operator's settings on a click; scripts run it directly."""

    def invoke(
        self, context: bpy.types.Context | None, event: bpy.types.Event | None
    ) -> set[OperatorReturnItems]:
        """Open the settings dialog."""
        assert context is not None  # Blender always gives one
        assert context.window_manager is not None  # a click implies a window
        return context.window_manager.invoke_props_dialog(self)  # type: ignore[arg-type]  # an operator, as above
