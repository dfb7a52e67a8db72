# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake operator, for the panel's button and for scripts."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import bpy
from bpy.props import BoolProperty, StringProperty

from ..panel.forecast import chosen_objects
from ..panel.labels import remark
from ..settings.bake_settings import NAMES, BakeSettings

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems

    from ...job.bake_plan import BakePlan

_PATIENCE = 1.0  # seconds that the check before queuing may take; each bake checks its object again


class RADTEX_OT_bake(BakeSettings, bpy.types.Operator):
    """Bake the selected objects' light in every direction into texture atlases, path traced by Cycles"""

    bl_idname = "radtex.bake"
    bl_label = "Bake Radiance Texture"
    bl_options = {"REGISTER"}

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        object: str
        wait: bool
    else:
        object: StringProperty(
            name="Object",
            description="Name of the object to bake. Left empty, all selected meshes are baked",
            options={"SKIP_SAVE"},
        )
        wait: BoolProperty(
            name="Wait",
            description="Bake here and now, so that a script finds the files afterwards. Without a window "
            "that is always so",
            default=False,
            options={"SKIP_SAVE"},
        )

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        return can_bake(cls, context)

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        # Imported here so that OpenEXR is loaded with the first bake, not when Blender starts.
        from ...core.errors import RadTexError
        from ...job.bake_plan import plan_bakes
        from ..panel.remedies import check_left
        from ..settings.request import request_of, values_with

        scene, layer = shown(context)
        names = (self.object,) if self.object else chosen_objects(layer)
        given = (name for name in NAMES if self.properties.is_property_set(name))
        try:
            request = request_of(values_with(scene.radtex, self, given), names)  # type: ignore[attr-defined]  # ours
            plan = plan_bakes(scene, request)
            check_left(plan)
            for told in (plan.skipped, *plan.layout_lines):
                if told:
                    self.report({"INFO"}, remark(told))
            _check(scene, plan)
            if bpy.app.background or self.wait:
                self._bake(scene, plan)
            else:
                _submit(scene, plan)
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def _bake(self, scene: bpy.types.Scene, plan: BakePlan) -> None:
        """Bake in this process and report each object."""
        from ...bake.progress import finished
        from ...job.bake_plan import steps_of_bakes
        from ...job.variants import variant_of

        for name, spec, steps in steps_of_bakes(scene, plan):
            finished(steps)
            told = (f"Baked {name}", spec.part, variant_of(spec))
            self.report({"INFO"}, ", ".join(word for word in told if word))


def _submit(scene: bpy.types.Scene, plan: BakePlan) -> None:
    """Queue the bakes as background jobs."""
    from ..jobs import jobs

    jobs.submit(scene, plan)


def can_bake(operator: type[bpy.types.Operator], context: bpy.types.Context | None) -> bool:
    """Poll: whether there is a mesh to bake; sets the operator's message if not."""
    layer = context.view_layer if context is not None else None
    if layer is None or not chosen_objects(layer):
        operator.poll_message_set("Select a mesh object to bake its radiance texture")
        return False
    return True


def shown(context: bpy.types.Context | None) -> tuple[bpy.types.Scene, bpy.types.ViewLayer]:
    """The scene and view layer that an operator runs in."""
    assert context is not None  # Blender always gives one
    return cast(bpy.types.Scene, context.scene), cast(bpy.types.ViewLayer, context.view_layer)


def _check(scene: bpy.types.Scene, plan: BakePlan) -> None:
    """Check for errors before baking. Raises InputError with the first one found."""
    from ...core.errors import InputError
    from ...job.bake_plan import preflight

    if errors := preflight(scene, plan, _PATIENCE).errors:
        raise InputError.of(errors[0])
