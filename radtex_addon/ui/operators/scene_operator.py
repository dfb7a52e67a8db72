# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator that bakes a whole scene, or much of it, into a few atlases, and its dialog."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty, EnumProperty

from ..panel.labels import expected_range, iface_, remark
from ..settings.chosen_objects import chosen_by, selected_meshes
from .bake_operator import bake_here, can_bake, check_plan, questions, show_objects, shown
from .export_dialog import WIDTH
from .instances_operator import join_and_tell, selected_owners, told_owners
from .operator_mixins import Foresees, MayWait, draw_lines
from .undo import push_step

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bpy.stub_internal.rna_enums import OperatorReturnItems

    from ...job.bake_plan import BakePlan
    from ...job.bake_request import BakeRequest
    from ...job.left_out import Found
    from ...job.scene_atlases import SceneAtlas

_WHAT = (
    ("ALL", "All", "Every mesh of the scene that renders"),
    ("COLLECTION", "Collection", "The collection that the panel has chosen, or else the active one"),
    ("SELECTED", "Selected", "The selected meshes"),
)
PATIENCE = 1.0  # seconds that sorting out may take before bakes are queued; each bake checks its object again
_MOST = 8  # lines of a sort in the dialog


class RADTEX_OT_bake_scene(Foresees, MayWait, bpy.types.Operator):
    """Bake the scene in one go: floor and walls share an atlas, and near things share a few others"""

    bl_idname = "radtex.bake_scene"
    bl_label = "Bake the Scene"
    bl_options = {"REGISTER"}

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        what: str
        again: bool
        join: bool
    else:
        what: EnumProperty(
            name="Bake",
            description="Which objects are baked",
            items=_WHAT,
            default="ALL",
            options={"SKIP_SAVE"},
        )
        again: BoolProperty(
            name="Bake Again",
            description="Replace finished bakes. Otherwise these stay, and what was begun is gone on with",
            default=False,
            options={"SKIP_SAVE"},
        )

        join: BoolProperty(
            name="Join Instances",
            description="Make meshes of the instances of collections and of geometry nodes, and bake these; "
            "the objects that show them are hidden, which Undo takes back. Otherwise instances are not baked",
            default=True,
            options={"SKIP_SAVE"},
        )

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        return can_bake(cls, context)

    def invoke(
        self, context: bpy.types.Context | None, event: bpy.types.Event | None
    ) -> set[OperatorReturnItems]:
        """Show the atlases, their texels and the time, and ask."""
        assert context is not None  # Blender always gives one
        assert context.window_manager is not None  # a click implies a window
        self.check(context)
        return context.window_manager.invoke_props_dialog(
            self, width=WIDTH, title=iface_("Bake the Scene"), confirm_text=iface_("Bake")
        )

    def draw(self, context: bpy.types.Context | None) -> None:
        layout: Any = self.layout
        layout.prop(self, "what", expand=True)
        layout.prop(self, "again")
        layout.prop(self, "join")
        draw_lines(layout, self._lines)

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import RadTexError
        from ...job.bake_plan import check_apart
        from ...job.left_out import left_out_lines
        from ..jobs import jobs

        scene, layer = shown(context)
        try:
            if (owners := self._owners(scene, layer)) and (made := join_and_tell(self, scene, owners)):
                for name in made if self.what == "SELECTED" else ():
                    scene.objects[name].select_set(True, view_layer=layer)
                push_step("Join Instances")
            found = self._found(scene, layer, inf if self.at_once else PATIENCE)
            show_objects(scene, found.kept)
            plans, atlases = self._plans(scene, found.kept)
            for line in left_out_lines(found.left_out):
                self.report({"INFO"}, remark(line))
            for atlas in atlases:
                self.report({"INFO"}, remark(atlas.told))
            check_apart(plans)
            for plan in plans:
                check_plan(scene, plan)
            names = [name for atlas in atlases for name in atlas.objects]
            if not plans:
                self.report({"INFO"}, "The scene is baked: no bake is left to do")
            elif self.at_once:
                bake_here(self, scene, plans, names)
            else:
                jobs.submit(scene, plans, names)
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def _found(self, scene: bpy.types.Scene, layer: bpy.types.ViewLayer, patience: float) -> Found:
        """The objects to bake, and those that cannot be. Raises InputError if there are none."""
        from ...core.errors import InputError
        from ...preview.swap import original_of
        from ..panel.request_checks import sort_out

        names = sorted({(original_of(item) or item).name for item in self._chosen(scene, layer)})
        if not names:
            raise InputError("there is no mesh to bake that is seen in renders: choose others")
        found = sort_out(scene, names, patience=patience, evaluate=self.at_once)
        if not found.kept:
            raise InputError.of(found.left_out[0].why)
        return found

    def _chosen(self, scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
        from ...preview.collection_meshes import meshes_of

        if self.what == "SELECTED":
            return selected_meshes(layer)
        return meshes_of(self._collection(scene, layer), layer)

    def _collection(self, scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> bpy.types.Collection | None:
        if self.what == "ALL":
            return scene.collection
        active = layer.active_layer_collection
        return chosen_by(scene).collection or (None if active is None else active.collection)

    def _owners(self, scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
        """The objects whose instances are to become meshes."""
        from ...scene.mesh.instance_parts import shows_instances
        from ...scene.objects import is_rendered

        if not self.join:
            return []
        if self.what == "SELECTED":
            return selected_owners(layer)
        collection = self._collection(scene, layer)
        if collection is None:
            return []
        return [item for item in collection.all_objects if shows_instances(item) and is_rendered(item, layer)]

    def _plans(
        self, scene: bpy.types.Scene, names: Sequence[str], *, guess: bool = False
    ) -> tuple[list[BakePlan], tuple[SceneAtlas, ...]]:
        """The plans of bakes that are to be made, and the atlases of the scene. Raises InputError.

        Objects with settings of their own are baked by these, each into an atlas of its own.
        """
        from ...job.bake_plan import plan_bakes

        requests, atlases = requests_and_atlases(scene, names, again=self.again)
        plans = [plan_bakes(scene, request, guess=guess) for request in requests]
        return [plan for plan in plans if self.again or not plan.is_done], atlases

    def _foreseen(self, context: bpy.types.Context | None) -> tuple[tuple[str, str], ...]:
        """What the dialog says of the bakes, a line each, with its icon."""
        from ...core.errors import RadTexError
        from ...job.left_out import left_out_lines
        from ..jobs import estimates

        scene, layer = shown(context)
        try:
            found = self._found(scene, layer, PATIENCE)
            plans, atlases = self._plans(scene, found.kept, guess=True)
            bakes = [bake for plan in plans for bake in plan.wanted]
            known = estimates.seconds_known(scene, bakes) if bakes else None
            asked = questions(plans)
        except RadTexError as error:
            return ((remark(error), "ERROR"),)
        owners = self._owners(scene, layer)
        lines = [(told_owners(owners), "OUTLINER_OB_GROUP_INSTANCE")] if owners else []
        lines += [(remark(atlas.told), "TEXTURE") for atlas in atlases[:_MOST]]
        if more := len(atlases[_MOST:]):
            lines.append((iface_("and {} more").format(more), "BLANK1"))
        if not bakes:
            lines.append((iface_("All of it is baked"), "CHECKMARK"))
        elif known is not None:
            told = iface_("{} bakes are left to do, in {}")
            lines.append((told.format(len(bakes), expected_range(known.range)), "TIME"))
        lines += [(question, "ERROR") for question in asked[:_MOST]]
        return (*lines, *((remark(line), "INFO") for line in left_out_lines(found.left_out)[:_MOST]))


def requests_and_atlases(
    scene: bpy.types.Scene, names: Sequence[str], *, again: bool
) -> tuple[list[BakeRequest], tuple[SceneAtlas, ...]]:
    """The requests that bake these objects, and the scene's atlases among them. Raises InputError."""
    from ...job.assets import read_shown
    from ...job.scene_atlases import find_scene_atlases, requests_of
    from ..settings.object_settings import by_settings
    from ..settings.request import request_of, values_of

    requests: list[BakeRequest] = []
    atlases: list[SceneAtlas] = []
    for settings, group in by_settings(scene, names):
        course = {"together": "off", "overwrite": again, "resume": not again}
        request = request_of(values_of(settings) | course, group)
        found = find_scene_atlases(scene, request, read_shown(scene)) if settings == scene.radtex else ()  # type: ignore[attr-defined]  # ours, not Blender's
        atlases += found
        requests += requests_of(request, found)
    return requests, tuple(atlases)
