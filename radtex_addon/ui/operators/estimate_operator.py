# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that measure how long a bake will take, and that stop it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..jobs import estimates
from ..panel.labels import capitalized, expected_range, remark
from ..settings.chosen_objects import chosen_names, nothing_chosen
from .bake_operator import can_bake, shown

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems

    from ...job.variants import Bake


class RADTEX_OT_estimate(bpy.types.Operator):
    """Measure a small part of the bake to find out how long it will take: some seconds for each object"""

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
        from ...core.errors import RadTexError

        scene, layer = shown(context)
        try:
            bakes = _bakes(scene, chosen_names(scene, layer))
            if not bpy.app.background:
                estimates.ask(scene, bakes)
                return {"FINISHED"}
            estimates.probe_now(scene, bakes)
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        known = estimates.seconds_known(scene, bakes)
        assert known is not None  # there is an object to bake, as the poll says
        self.report({"INFO"}, capitalized(expected_range(known.range)))
        return {"FINISHED"}


def _bakes(scene: bpy.types.Scene, names: tuple[str, ...]) -> list[Bake]:
    """Names and specifications of the bakes; raises InputError for those that have no estimate."""
    from ...core.errors import InputError
    from ..panel.layouts import chosen_layouts
    from ..panel.request_checks import sort_out
    from ..settings.baked_groups import baked_groups
    from ..settings.request import spec_of

    if not names:
        raise InputError(nothing_chosen(scene))
    found = sort_out(scene, names)
    if not found.kept:
        raise InputError.of(found.left_out[0].why)
    bakes: list[Bake] = []
    for values, group, _ in baked_groups(scene, found.kept):
        spec = spec_of(values)
        if spec.split is not None:
            raise InputError("only the time of whole objects is estimated: choose no Split")
        bakes += [(name, choice.spec) for name, choice in chosen_layouts(scene, group, values, spec)]
    return bakes


class RADTEX_OT_cancel_estimate(bpy.types.Operator):
    """Stop finding out how long the bake will take"""

    bl_idname = "radtex.cancel_estimate"
    bl_label = "Cancel"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, _: bpy.types.Context | None) -> bool:
        if not estimates.asking():
            cls.poll_message_set("Nothing is being estimated")
            return False
        return True

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        estimates.cancel()
        return {"FINISHED"}
