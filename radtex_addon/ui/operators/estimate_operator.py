# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator that estimates how long a bake will take."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..jobs import estimates
from ..panel.labels import duration, remark
from ..settings.chosen_objects import chosen_names
from .bake_operator import can_bake, shown

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems


class RADTEX_OT_estimate(bpy.types.Operator):
    """Find out how long the bake will take, by two small ones: some seconds"""

    bl_idname = "radtex.estimate"
    bl_label = "Estimate Time"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        if estimates.asking():
            cls.poll_message_set("It is being estimated")
            return False
        return can_bake(cls, context)

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import InputError, RadTexError
        from ..panel.layouts import chosen_layouts
        from ..settings.request import spec_of, values_of
        from ..settings.surfaces import have_own_atlases

        scene, layer = shown(context)
        names = chosen_names(scene, layer)
        try:
            values = values_of(scene.radtex)  # type: ignore[attr-defined]  # ours
            spec = spec_of(values)
            if not have_own_atlases(values, spec, len(names)):
                raise InputError(
                    "only the time of whole objects with atlases of their own is estimated: "
                    "switch One Atlas off, and choose no Split"
                )
            bakes = [(name, choice.spec) for name, choice in chosen_layouts(scene, names, values, spec)]
            if not bpy.app.background:
                estimates.ask(scene, bakes)
                return {"FINISHED"}
            estimates.probe_now(scene, bakes)
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        seconds = estimates.seconds_known(scene, bakes)
        assert seconds is not None  # probe_now has just probed every bake
        self.report({"INFO"}, f"About {duration(seconds)}")
        return {"FINISHED"}
