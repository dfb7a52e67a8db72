# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake operator, for the panel's button and for scripts."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import bpy
from bpy.props import BoolProperty, StringProperty

from .forecast import chosen_objects
from .labels import remark
from .settings import NAMES, BakeSettings

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems

    from .request import BakeRequest

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
        from ..core.errors import RadTexError
        from .request import BakeRequest, values_with

        scene, layer = shown(context)
        names = (self.object,) if self.object else chosen_objects(layer)
        given = (name for name in NAMES if self.properties.is_property_set(name))
        try:
            request = BakeRequest.of(values_with(scene.radtex, self, given))  # type: ignore[attr-defined]  # ours
            if told := request.left_out(scene, names):
                self.report({"INFO"}, remark(told))
            for line in request.layouts_told(scene, names):
                self.report({"INFO"}, remark(line))
            if bpy.app.background or self.wait:
                self._bake(scene, names, request)
            else:
                self._submit(scene, names, request)
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def _bake(self, scene: bpy.types.Scene, names: tuple[str, ...], request: BakeRequest) -> None:
        """Bake in this process and report each object."""
        from ..core.sampler import Filter
        from ..job import bake_object
        from ..job.variants import announce_all, variant_of
        from ..prepare.unwrapping import Unwraps

        _check(scene, names, request)
        preview = Filter.QUADRILINEAR if request.preview else None
        unwraps: Unwraps = {}
        bakes = request.bakes(scene, names)
        announce_all(bakes, request.folder, request.preview, request.targets, request.overwrite)
        for name, spec in bakes:
            bake_object(
                scene,
                name,
                spec,
                request.folder,
                preview=preview,
                overwrite=request.overwrite,
                resume=request.resume,
                unwraps=unwraps,
                exports=request.targets,
            )
            told = (f"Baked {name}", spec.part, variant_of(spec))
            self.report({"INFO"}, ", ".join(word for word in told if word))

    def _submit(self, scene: bpy.types.Scene, names: tuple[str, ...], request: BakeRequest) -> None:
        """Queue the bakes as background jobs."""
        from . import jobs

        _check(scene, names, request)
        jobs.submit(scene, names, request)


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


def _check(scene: bpy.types.Scene, names: tuple[str, ...], request: BakeRequest) -> None:
    """Check for errors before baking. Raises InputError with the first one found."""
    from ..core.errors import InputError

    if errors := request.preflight(scene, names, _PATIENCE).errors:
        raise InputError(errors[0])
