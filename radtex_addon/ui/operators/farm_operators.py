# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that prepare a farm, whose machines share the bakes, and that assemble what they have made."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ..jobs import farm_jobs, jobs
from ..panel.fitting import draw_wrapped
from ..panel.labels import expected_range, iface_, remark, size
from ..settings.chosen_objects import chosen_names, nothing_chosen
from .bake_operator import can_bake, check_plan, show_objects, shown
from .export_dialog import WIDTH
from .instances_operator import join_and_tell, told_owners
from .operator_mixins import Foresees, MayWait, draw_lines
from .scene_operator import PATIENCE, requests_and_atlases
from .undo import push_step

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bpy.stub_internal.rna_enums import OperatorReturnItems

    from ...core.sampler import Filter
    from ...farm.farm_folder import FarmFolder
    from ...job.bake_plan import BakePlan
    from ...job.bake_request import BakeRequest
    from ...job.left_out import Found
    from ...job.scene_atlases import SceneAtlas
    from ...job.variants import Bake

_WHAT = (
    ("CHOSEN", "What Is Chosen", "The objects that the panel has chosen: selection, collection or bake list"),
    ("ALL", "The Scene", "Every mesh of the scene that renders, as Bake the Scene bakes them"),
)
_MOST, _ICON = 8, 40  # lines of a sort in a dialog, and pixels beside each
_BAKED = "all of it is baked: switch Bake Again on to bake it anew"


@dataclass(frozen=True)
class _Planned:
    """What a farm is asked for: its `plans`, of bakes into the folder `out`; `left` more are finished.

    `there` of the bakes will replace others. `exports` says whether the settings ask for exports.
    """

    plans: tuple[BakePlan, ...]
    atlases: tuple[SceneAtlas, ...]
    out: Path
    preview: Filter | None
    left: int
    there: int
    exports: bool

    @property
    def bakes(self) -> list[Bake]:
        return [bake for plan in self.plans for bake in plan.wanted]

    @property
    def folder(self) -> Path:
        """The farm's folder."""
        from ...farm.prepare_tasks import tasks_folder
        from ...store.ownership import open_blend

        return tasks_folder(self.bakes, self.out, open_blend())


class RADTEX_OT_prepare_farm(Foresees, MayWait, bpy.types.Operator):
    """Write a folder of tasks: any machine with RadTex does any of them, and all are baked sooner"""

    bl_idname = "radtex.prepare_farm"
    bl_label = "Prepare for a Farm"
    bl_options = {"REGISTER"}

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        what: str
        again: bool
        join: bool
        overwrite: bool
        _there: bool  # whether the dialog says that an earlier farm is replaced
    else:
        _there = False
        what: EnumProperty(
            name="Bake",
            description="Which objects are baked",
            items=_WHAT,
            default="CHOSEN",
            options={"SKIP_SAVE"},
        )
        again: BoolProperty(
            name="Bake Again",
            description="Also bake what has a finished bake by the same settings. That is replaced when the "
            "farm is assembled",
            default=False,
            options={"SKIP_SAVE"},
        )
        join: BoolProperty(
            name="Join Instances",
            description="Of a scene, make meshes of the instances of collections and of geometry nodes "
            "first; Undo takes that back",
            default=True,
            options={"SKIP_SAVE"},
        )
        overwrite: BoolProperty(
            name="Overwrite",
            description="Replace an earlier farm in that folder, with all that its tasks have made. The "
            "dialog says where there is one",
            default=False,
            options={"SKIP_SAVE", "HIDDEN"},
        )

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        return can_bake(cls, context)

    def invoke(
        self, context: bpy.types.Context | None, event: bpy.types.Event | None
    ) -> set[OperatorReturnItems]:
        """Show the folder, the bakes and the time, and ask."""
        assert context is not None  # Blender always gives one
        assert context.window_manager is not None  # a click implies a window
        self.check(context)
        return context.window_manager.invoke_props_dialog(
            self, width=WIDTH, title=iface_("Prepare for a Farm"), confirm_text=iface_("Prepare")
        )

    def draw(self, context: bpy.types.Context | None) -> None:
        layout: Any = self.layout
        layout.prop(self, "what", expand=True)
        layout.prop(self, "again")
        if self.what == "ALL":
            layout.prop(self, "join")
        draw_lines(layout, self._lines)

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import RadTexError
        from ...job.left_out import left_out_lines

        scene, layer = shown(context)
        try:
            if (owners := self._owners(scene, layer)) and join_and_tell(self, scene, owners):
                push_step("Join Instances")
            found = self._found(scene, layer, inf if self.at_once else PATIENCE)
            show_objects(scene, found.kept)
            planned = self._planned(scene, found.kept)
            if not planned.bakes:
                self.report({"INFO"}, remark(_BAKED))
                return {"FINISHED"}
            self._check(scene, planned)
            for line in left_out_lines(found.left_out):
                self.report({"INFO"}, remark(line))
            overwrite = self.overwrite or self._there
            order = farm_jobs.preparation(
                scene, planned.bakes, planned.folder, planned.preview, overwrite=overwrite
            )
            if not self.at_once:
                jobs.add([order])
                return {"FINISHED"}
            done = farm_jobs.run_here(order)
            for message in done.warnings:
                self.report({"WARNING"}, remark(message))
            told = iface_("{}: {} tasks, {} to travel")
            self.report({"INFO"}, told.format(done.files[0], done.facts["tasks"], size(done.facts["bytes"])))
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def _check(self, scene: bpy.types.Scene, planned: _Planned) -> None:
        """Raises InputError for what a farm would fail at sooner or later."""
        from ...core.errors import InputError
        from ...core.messages import Setting, do
        from ...farm.farm_folder import check_no_farm
        from ...farm.prepare_tasks import check_farmed
        from ...job.variants import check_output_collisions

        check_farmed(planned.bakes)
        for plan in planned.plans:
            check_plan(scene, plan)
        check_output_collisions(planned.bakes, planned.out, planned.preview is not None)
        folder = planned.folder
        check_no_farm(folder)
        if farm_jobs.is_busy(folder.absolute()):
            raise InputError(f"{folder} is being prepared or assembled: wait for that, or cancel it")
        if folder.exists() and not (self.overwrite or self._there):
            raise InputError(
                f"{folder} is already there: assemble it first",
                do("replace it, with all that its tasks have made", Setting.OVERWRITE),
            )

    def _found(self, scene: bpy.types.Scene, layer: bpy.types.ViewLayer, patience: float) -> Found:
        """The objects to bake, and those that cannot be. Raises InputError if there are none."""
        from ...core.errors import InputError
        from ...preview.collection_meshes import meshes_of
        from ...preview.swap import original_of
        from ..panel.request_checks import sort_out

        if self.what == "ALL":
            every = meshes_of(scene.collection, layer)
            names = tuple(sorted({(original_of(item) or item).name for item in every}))
        else:
            names = chosen_names(scene, layer)
        if not names:
            nothing = "there is no mesh to bake that is seen in renders: choose others"
            raise InputError(nothing if self.what == "ALL" else nothing_chosen(scene))
        found = sort_out(scene, names, patience=patience, evaluate=self.at_once)
        if not found.kept:
            raise InputError.of(found.left_out[0].why)
        return found

    def _owners(self, scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
        """The objects whose instances are to become meshes."""
        from ...scene.mesh.instance_parts import shows_instances
        from ...scene.objects import is_rendered

        if not self.join or self.what != "ALL":
            return []
        every = scene.collection.all_objects
        return [item for item in every if shows_instances(item) and is_rendered(item, layer)]

    def _planned(self, scene: bpy.types.Scene, names: Sequence[str], *, guess: bool = False) -> _Planned:
        """What is to be baked of these objects, without what is finished unless that is baked again.

        Raises InputError, also where settings of their own send bakes to several folders.
        """
        from ...core.errors import InputError
        from ...job.bake_plan import plan_bakes

        requests, atlases = self._requests(scene, names)
        exports = any(request.exports for request in requests)
        ways = {(request.folder.absolute(), request.preview) for request in requests}
        if len(ways) > 1:
            raise InputError(
                "objects with settings of their own go to another folder, or have other previews: prepare a "
                "farm of them by themselves"
            )
        ((out, preview),) = ways
        course: dict[str, Any] = {"overwrite": True, "overwrite_any": True, "resume": False}
        requests = [replace(each, **course, exports=(), former=()) for each in requests]
        plans, left, there = [], 0, 0
        for plan in (plan_bakes(scene, request, guess=guess) for request in requests):
            places = {bake: plan.request.place(bake) for bake in plan.wanted}
            wanted = tuple(bake for bake, place in places.items() if self.again or not place.is_finished())
            left += len(places) - len(wanted)
            there += sum(places[bake].files.sidecar.exists() for bake in wanted)
            if wanted:
                plans.append(replace(plan, wanted=wanted))
        return _Planned(tuple(plans), atlases, out, preview, left, there, exports)

    def _requests(
        self, scene: bpy.types.Scene, names: Sequence[str]
    ) -> tuple[list[BakeRequest], tuple[SceneAtlas, ...]]:
        """The requests that bake these objects, and the scene's atlases among them. Raises InputError."""
        from ..settings.baked_groups import baked_groups
        from ..settings.request import request_of

        if self.what == "ALL":
            return requests_and_atlases(scene, names, again=True)
        groups = baked_groups(scene, names)
        return [request_of(group.values | {"resume": False}, group.names) for group in groups], ()

    def _foreseen(self, context: bpy.types.Context | None) -> tuple[tuple[str, str], ...]:
        """What the dialog says of the farm, a line each, with its icon."""
        from ...core.errors import RadTexError
        from ...farm.farm_folder import check_no_farm, told_earlier
        from ...farm.prepare_tasks import check_farmed
        from ...job.left_out import left_out_lines
        from ..jobs import estimates

        scene, layer = shown(context)
        self._there = False
        try:
            found = self._found(scene, layer, PATIENCE)
            planned = self._planned(scene, found.kept, guess=True)
            if not planned.bakes:
                return ((remark(_BAKED), "CHECKMARK"),)
            check_farmed(planned.bakes)
            check_no_farm(planned.folder)
            known = estimates.seconds_known(scene, planned.bakes)
        except RadTexError as error:
            return ((remark(error), "ERROR"),)
        lines = [(iface_("Writes the folder {}").format(planned.folder), "FILE_FOLDER")]
        if earlier := told_earlier(planned.folder):
            self._there = True
            lines.append((earlier, "ERROR"))
        if owners := self._owners(scene, layer):
            lines.append((told_owners(owners), "OUTLINER_OB_GROUP_INSTANCE"))
        lines += [(remark(atlas.told), "TEXTURE") for atlas in planned.atlases[:_MOST]]
        if more := len(planned.atlases[_MOST:]):
            lines.append((iface_("and {} more").format(more), "BLANK1"))
        if known is not None:
            told = iface_("1 bake, by this machine alone {}")
            if (count := len(planned.bakes)) > 1:
                told = iface_("{} bakes, by this machine alone {}").replace("{}", str(count), 1)
            lines.append((told.format(expected_range(known.range)), "TIME"))
        lines += _notes(planned)
        return (*lines, *((remark(line), "INFO") for line in left_out_lines(found.left_out)[:_MOST]))


def _notes(planned: _Planned) -> list[tuple[str, str]]:
    """What else to know of a farm, a line each, with its icon."""
    lines = []
    if planned.left:
        lines.append((iface_("Finished bakes that stay: {}").format(planned.left), "INFO"))
    if planned.there:
        told = iface_("Bakes that are there: {}. Assemble asks before it replaces them")
        lines.append((told.format(planned.there), "INFO"))
    if planned.exports:
        lines.append((iface_("Exports are not made by a farm: export once it is assembled"), "INFO"))
    return lines


class RADTEX_OT_assemble_farm(MayWait, bpy.types.Operator):
    """Put together what a farm's machines have made: its bakes are then found as any others"""

    bl_idname = "radtex.assemble_farm"
    bl_label = "Assemble a Farm"
    bl_options = {"REGISTER"}

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        directory: str
        into: str
        overwrite: bool
        overwrite_any: bool
        filter_folder: bool
        _asked: tuple[str, ...]  # what the dialog says
        _browsed: bool  # whether the folder was chosen in the file browser
    else:
        _asked, _browsed = (), False
        directory: StringProperty(
            name="Folder",
            description="The farm's folder, which ends in .radtex-farm. Left empty, a file browser opens",
            subtype="DIR_PATH",
            options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
        )
        into: StringProperty(
            name="Into",
            description="Where the bakes go. Left empty, where the farm's folder lies",
            subtype="DIR_PATH",
            options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
        )
        overwrite: BoolProperty(
            name="Overwrite",
            description="Replace the bakes that are there, but for better ones and those of other .blend "
            "files. The panel asks first",
            default=False,
            options={"SKIP_SAVE", "HIDDEN"},
        )
        overwrite_any: BoolProperty(
            name="Overwrite Any",
            description="As Overwrite, and replace better bakes, too, and those of other .blend files",
            default=False,
            options={"SKIP_SAVE", "HIDDEN"},
        )
        filter_folder: BoolProperty(
            name="Folders",
            description="Show folders in the file browser",
            default=True,
            options={"SKIP_SAVE", "HIDDEN"},
        )

    @classmethod
    def description(cls, _: bpy.types.Context | None, properties: Any) -> str:
        """The tooltip, and of a farm that is known how many of its tasks are done now."""
        from ...core.errors import RadTexError
        from ...farm.farm_folder import read_farm_folder

        told = cls.__doc__ or ""
        if not properties.directory:
            return told
        try:
            farm = read_farm_folder(Path(bpy.path.abspath(properties.directory)))
        except RadTexError as error:
            return f"{told}.\n{remark(error)}"
        if not farm.tasks:
            return told
        return iface_("{}.\n{} of {} tasks are done now").format(told, farm.done, farm.tasks)

    def invoke(
        self, context: bpy.types.Context | None, event: bpy.types.Event | None
    ) -> set[OperatorReturnItems]:
        """Ask for the folder, unless it is given, and before a bake is replaced; else assemble."""
        assert context is not None  # Blender always gives one
        assert context.window_manager is not None  # a click implies a window
        if not self.directory:
            self._browsed, self.directory = True, _start(context)
            context.window_manager.fileselect_add(self)
            return {"RUNNING_MODAL"}
        if not self.ask_for():
            return self.execute(context)
        return context.window_manager.invoke_props_dialog(
            self,
            width=WIDTH,
            title=iface_("Replace What Is There?"),
            confirm_text=iface_("Replace"),
            cancel_default=True,
        )

    def ask_for(self) -> bool:
        """Find what the dialog has to ask, and let OK mean yes; returns whether there is anything."""
        from ...core.errors import RadTexError

        try:
            farm, out = self._farm()
            self._asked = tuple(remark(line, out) for line in farm.replaced(out))
        except RadTexError:
            return False  # `execute` says what is wrong
        self.overwrite = self.overwrite or bool(self._asked)
        self.overwrite_any = self.overwrite_any or bool(self._asked)
        return bool(self._asked)

    def draw(self, context: bpy.types.Context | None) -> None:
        """Draw what the dialog asks, or in the file browser where the bakes go."""
        layout: Any = self.layout
        if not self._asked:
            layout.prop(self, "into")
            return
        column = layout.column(align=True)
        for line in self._asked[:_MOST]:
            draw_wrapped(column, line, "ERROR", WIDTH - _ICON)
        if more := len(self._asked[_MOST:]):
            column.label(text=iface_("and {} more").format(more), translate=False)

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import InputError, RadTexError

        if self._browsed and self.ask_for():  # the file browser asks nothing
            operators: Any = bpy.ops.radtex  # type: ignore[attr-defined]  # ours, not Blender's
            operators.assemble_farm("INVOKE_DEFAULT", directory=self.directory, into=self.into)
            return {"FINISHED"}
        try:
            farm, out = self._farm()
            if farm_jobs.is_busy(farm.folder):
                raise InputError(f"{farm.folder} is being prepared or assembled: wait for that, or cancel it")
            overwrite = self.overwrite or self.overwrite_any
            order = farm_jobs.assembly(farm, out, overwrite=overwrite, overwrite_any=self.overwrite_any)
            if not self.at_once:
                jobs.add([order])
                return {"FINISHED"}
            done = farm_jobs.run_here(order)
            for message in done.warnings:
                self.report({"WARNING"}, remark(message))
            self.report({"INFO"}, iface_("Assembled {} in {}").format(done.message.problem, out))
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def _farm(self) -> tuple[FarmFolder, Path]:
        """The farm, and where its bakes go. Raises as `read_farm_folder` does."""
        from ...core.errors import InputError
        from ...farm.farm_folder import read_farm_folder

        if not self.directory:
            raise InputError("which farm is assembled? name its folder, which ends in .radtex-farm")
        farm = read_farm_folder(Path(bpy.path.abspath(self.directory)).absolute())
        return farm, Path(bpy.path.abspath(self.into)) if self.into else farm.folder.parent


class RADTEX_OT_copy_farm_command(bpy.types.Operator):
    """Copy what to type on each machine, with its own paths: it does tasks until none is left"""

    bl_idname = "radtex.copy_farm_command"
    bl_label = "Copy Command"
    bl_options = {"INTERNAL"}

    if TYPE_CHECKING:  # type of the property that Blender creates from the annotation below
        directory: str
    else:
        directory: StringProperty(
            name="Folder",
            description="The farm's folder, which ends in .radtex-farm",
            subtype="DIR_PATH",
            options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
        )

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import RadTexError
        from ...farm.tasks import read_tasks
        from ...worker.handover import this_program
        from ...worker.order import farm_command

        assert context is not None  # Blender always gives one
        assert context.window_manager is not None  # as above
        try:
            farm = read_tasks(Path(bpy.path.abspath(self.directory)).absolute())
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        context.window_manager.clipboard = farm_command(this_program(), farm.folder)
        self.report(
            {"INFO"}, iface_("The command is in the clipboard: type it on each machine, with its paths")
        )
        return {"FINISHED"}


def _start(context: bpy.types.Context) -> str:
    """Where the file browser begins: in the folder of the scene's bakes, if that is there; else anywhere."""
    from ...core.errors import RadTexError
    from .bake_lookup import bake_location

    try:
        folder = bake_location(shown(context)[0], "")
    except RadTexError:
        return ""
    return f"{folder}/" if folder.is_dir() else ""


CLASSES = (RADTEX_OT_prepare_farm, RADTEX_OT_assemble_farm, RADTEX_OT_copy_farm_command)
