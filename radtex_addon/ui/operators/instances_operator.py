# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator that makes one mesh of the instances that an object shows, so that it can be baked."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..panel.labels import iface_, remark
from .bake_operator import shown
from .undo import push_step

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bpy.stub_internal.rna_enums import OperatorReturnItems


class RADTEX_OT_join_instances(bpy.types.Operator):
    """Make one mesh of the instances that a selected object shows in renders, and hide the object"""

    bl_idname = "radtex.join_instances"
    bl_label = "Join Instances"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        layer = context.view_layer if context is not None else None
        if layer is None or not selected_owners(layer):
            cls.poll_message_set("Select an object that shows a collection's instances, or those of nodes")
            return False
        return True

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import RadTexError

        scene, layer = shown(context)
        try:
            joined = join_and_tell(self, scene, selected_owners(layer))
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        made = [scene.objects[name] for name in joined]
        for item in layer.objects:
            item.select_set(item in made)
        if made:
            layer.objects.active = made[0]
            push_step("Join Instances")
        return {"FINISHED"} if made else {"CANCELLED"}


def selected_owners(layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
    """The selected objects that may show instances."""
    from ...scene.mesh.instance_parts import shows_instances

    return [item for item in layer.objects.selected if shows_instances(item)]


def join_and_tell(
    operator: bpy.types.Operator, scene: bpy.types.Scene, items: Sequence[bpy.types.Object]
) -> list[str]:
    """Join the instances that the items show; the operator reports it. Returns the names of the new objects.

    The caller pushes an undo step. Raises BakeError where Blender does not render.
    """
    from ...job.instances import join_instances

    joined, messages = join_instances(scene, items)
    for one in joined:
        operator.report({"INFO"}, remark(one.told))
    for message in messages:
        operator.report({"WARNING"}, remark(message))
    if not joined and not messages:
        operator.report({"INFO"}, iface_("They show no mesh as an instance: nothing was joined"))
    return [name for one in joined for name in one.objects]


def told_owners(items: Sequence[bpy.types.Object]) -> str:
    """A line on objects whose instances will be joined."""
    others = iface_(" and {} more").format(len(items) - 1) if len(items) > 1 else ""
    return iface_("Instances become meshes first: those of '{}'{}").format(items[0].name, others)
