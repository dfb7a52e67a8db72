# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators on finished bakes have in common: whose bake, where it is, and asking first."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, StringProperty

from .bake_lookup import has_meshes

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems


class OfBake:
    """Not registered itself: operators take its properties, and its poll."""

    if TYPE_CHECKING:  # what an instance holds; Blender makes it from the annotations below
        object: str
        bake: str
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

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        """Whether there is something to show."""
        return has_meshes(cls, context)  # type: ignore[arg-type]  # who takes this is an operator


class MayWait:
    """Not registered itself: operators that let a worker work take its property."""

    if TYPE_CHECKING:  # what an instance holds; Blender makes it from the annotation below
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
        """Whether to work here and now."""
        return bpy.app.background or self.wait


class AsksFirst:
    """Not registered itself: a click opens the operator's settings, a script runs it at once."""

    def invoke(
        self, context: bpy.types.Context | None, event: bpy.types.Event | None
    ) -> set[OperatorReturnItems]:
        """Ask for the settings."""
        assert context is not None  # Blender always gives one
        assert context.window_manager is not None  # there is one wherever a click comes from
        return context.window_manager.invoke_props_dialog(self)  # type: ignore[arg-type]  # an operator, as above
