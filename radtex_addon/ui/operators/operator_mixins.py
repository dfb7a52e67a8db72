# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mixins for operators on finished bakes: choice of the bake, waiting, and the settings dialog."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, StringProperty

from .bake_lookup import has_meshes

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems


class OfBake:
    """Mixin with the properties that name a bake, and a poll; not registered itself."""

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
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
        """Whether a mesh is selected, in Object Mode."""
        return has_meshes(cls, context)  # type: ignore[arg-type]  # the class that uses the mixin is an operator


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
