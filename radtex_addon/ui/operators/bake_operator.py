# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake operator, for the panel's button and for scripts."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING, Any, cast

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ...scene.surfaces import may_have_faces
from ..panel.fitting import draw_wrapped
from ..panel.labels import iface_, remark, size
from ..settings.bake_settings import NAMES, BakeSettings
from ..settings.chosen_objects import chosen_names, nothing_chosen, told_names
from ..settings.update_callbacks import without_updates
from .export_dialog import WIDTH
from .undo import push_step

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bpy.stub_internal.rna_enums import OperatorReturnItems

    from ...job.bake_plan import BakePlan
    from ...job.bake_request import BakeRequest

_ONLY = (
    ("all", "All", "Every one of them"),
    (
        "changed",
        "Changed",
        "Those that have no finished bake, or whose mesh, place, materials or settings have changed since",
    ),
    (
        "affected",
        "Changed, or Near a Change",
        "As Changed, and those whose surroundings have changed: other objects, lamps, the world",
    ),
)
_MOST, _ICON = 8, 40  # questions that are asked word by word, and pixels beside each
_PATIENCE = 1.0  # seconds that the check before queuing may take; each bake checks its object again


@without_updates
class RADTEX_OT_bake(BakeSettings, bpy.types.Operator):
    """Bake the selected objects' light in every direction into texture atlases, path traced by Cycles"""

    bl_idname = "radtex.bake"
    bl_label = "Bake Radiance Texture"
    bl_options = {"REGISTER"}

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        object: str
        objects: str
        wait: bool
        show_object: bool
        only: str
        expected: str
        overwrite_any: bool
        _asked: tuple[str, ...]  # what the dialog says
    else:
        _asked = ()
        object: StringProperty(
            name="Object",
            description="Name of the object to bake. Left empty, what the panel has chosen is baked",
            options={"SKIP_SAVE"},
        )
        objects: StringProperty(
            name="Objects",
            description="Names of the objects to bake, a line each, where that is more than one",
            options={"SKIP_SAVE", "HIDDEN"},
        )
        wait: BoolProperty(
            name="Wait",
            description="Bake here and now, so that a script finds the files afterwards. Without a window "
            "that is always so",
            default=False,
            options={"SKIP_SAVE"},
        )
        show_object: BoolProperty(
            name="Show the Object",
            description="Where an earlier bake is shown in the object's place, show the object again first. "
            "Otherwise such an object is not baked",
            default=False,
            options={"SKIP_SAVE"},
        )

        only: EnumProperty(
            name="Only",
            description="Which of the chosen objects to bake; with other than All their bakes are replaced",
            items=_ONLY,
            default="all",
            options={"SKIP_SAVE"},
        )

        expected: StringProperty(
            name="Expected",
            description="Names that the panel showed when its button was drawn, a line each: if others are "
            "chosen by now, nothing is baked. Left empty, that is not checked",
            options={"SKIP_SAVE", "HIDDEN"},
        )

        overwrite_any: BoolProperty(
            name="Overwrite Any",
            description="As Overwrite, and replace better bakes, too, and those of other .blend files. The "
            "panel asks first",
            default=False,
            options={"SKIP_SAVE"},
        )

    @classmethod
    def description(cls, _: bpy.types.Context | None, properties: Any) -> str:
        """The tooltip of what the button does."""
        if properties.only != "all":
            told = next(told for name, _, told in _ONLY if name == properties.only)
            return f"Bake again only what has changed. {told}"
        if properties.resume:
            return "Go on with bakes that were cancelled or failed; finished ones stay"
        return cls.__doc__ or ""

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        return can_bake(cls, context)

    def invoke(
        self, context: bpy.types.Context | None, event: bpy.types.Event | None
    ) -> set[OperatorReturnItems]:
        """Ask before a better bake, or one of another file, is replaced; else bake."""
        if not self.ask_for(context):
            return self.execute(context)
        assert context is not None  # Blender always gives one
        assert context.window_manager is not None  # a click implies a window
        return context.window_manager.invoke_props_dialog(
            self,
            width=WIDTH,
            title=iface_("Replace What Is There?"),
            confirm_text=iface_("Replace"),
            cancel_default=True,
        )

    def ask_for(self, context: bpy.types.Context | None) -> bool:
        """Find what the dialog has to ask, and let OK mean yes; returns whether there is anything."""
        from ...core.errors import RadTexError

        scene, layer = shown(context)
        try:
            names = self._names(scene, layer, bpy.app.background or self.wait)
            self._asked = questions(self._plans(scene, names, guess=self.only == "all"))
        except RadTexError:
            return False  # `execute` says what is wrong
        self.overwrite_any = self.overwrite_any or bool(self._asked)
        return bool(self._asked)

    def draw(self, context: bpy.types.Context | None) -> None:
        layout: Any = self.layout
        column = layout.column(align=True)
        for line in self._asked[:_MOST]:
            draw_wrapped(column, line, "ERROR", WIDTH - _ICON)
        if more := len(self._asked[_MOST:]):
            column.label(text=iface_("and {} more").format(more), translate=False)

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        # Imported here so that OpenEXR is loaded with the first bake, not when Blender starts.
        from ...core.errors import RadTexError
        from ...job.bake_plan import check_apart
        from ..jobs import jobs

        scene, layer = shown(context)
        at_once = bpy.app.background or self.wait
        try:
            names = self._names(scene, layer, at_once)
            if self.show_object and self.only == "all":
                show_objects(scene, names)
            if not self._are_named:
                names = self._bakeable(scene, names, at_once)
            plans = self._plans(scene, names)
            if self.show_object and self.only != "all":
                replaced = [bake for plan in plans for bake in plan.replaced]
                show_objects(scene, [one for name, spec in replaced for one in spec.objects or (name,)])
            check_apart(plans)
            for plan in plans:
                self._tell(plan)
                check_plan(scene, plan)
            if not any(plan.wanted for plan in plans):
                self.report({"INFO"}, "Nothing has changed: no bake is left to do")
            elif at_once:
                bake_here(self, scene, plans, names)
            else:
                jobs.submit(scene, plans, names)
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def _names(self, scene: bpy.types.Scene, layer: bpy.types.ViewLayer, at_once: bool) -> tuple[str, ...]:
        """The objects to bake. Raises InputError if they are not those that are `expected`."""
        from ...core.errors import InputError

        named = (self.object,) if self.object else tuple(self.objects.splitlines())
        names = named or chosen_names(scene, layer)
        if self.expected and self.expected != told_names(names):
            raise InputError("other objects are chosen by now: look at the panel, and press again")
        return names if named or at_once else _free(scene, names)

    @property
    def _are_named(self) -> bool:
        return bool(self.object or self.objects)

    def _bakeable(self, scene: bpy.types.Scene, names: tuple[str, ...], at_once: bool) -> tuple[str, ...]:
        """Those that can be baked; reports why the others are left out. Raises InputError if none can."""
        from ...core.errors import InputError
        from ...job.left_out import left_out_lines
        from ..panel.request_checks import sort_out

        found = sort_out(
            scene,
            names,
            self._values,
            shows_objects=self.show_object,
            patience=inf if at_once else _PATIENCE,
            evaluate=at_once,
        )
        if names and not found.kept:
            raise InputError.of(found.left_out[0].why)
        for line in left_out_lines(found.left_out):
            self.report({"INFO"}, remark(line))
        return found.kept

    def _values(self, settings: BakeSettings) -> dict[str, Any]:
        """The values of settings, overridden by the operator's own."""
        from ..settings.request import values_with

        given = [name for name in NAMES if self.properties.is_property_set(name)]
        return values_with(settings, self, given)

    def _tell(self, plan: BakePlan) -> None:
        """Report what a plan leaves out or chooses."""
        for told in (*plan.change_lines, plan.skipped, *plan.layout_lines):
            if told:
                self.report({"INFO"}, remark(told))

    def _plans(self, scene: bpy.types.Scene, names: Sequence[str], *, guess: bool = False) -> list[BakePlan]:
        """A plan for each group of objects that are baked by one request. Raises InputError.

        With `guess` no object is evaluated: see `plan_bakes`.
        """
        from ...core.errors import InputError
        from ...job.bake_plan import plan_bakes
        from ..panel.request_checks import all_finished, check_left
        from ..settings.baked_groups import baked_groups
        from ..settings.request import request_of

        if not names:
            raise InputError(nothing_chosen(scene))
        groups = baked_groups(scene, names, self._values)
        requests = [request_of(group.values, group.names) for group in groups]
        if self.only != "all":
            requests = [_of_changed(request, surroundings=self.only == "affected") for request in requests]
        if self.overwrite_any:
            requests = [
                replace(each, overwrite=not each.only_changed, overwrite_any=True) for each in requests
            ]
        plans = [plan_bakes(scene, request, guess=guess) for request in requests]
        _check_begun(plans)
        if len(plans) > 1:  # resuming a group that is done would be refused
            plans = [plan for plan in plans if not (plan.request.resume and plan.is_done)]
            if not plans:
                raise all_finished("objects")
        check_left([plan for plan in plans if not plan.request.only_changed])
        return [plan for plan in plans if plan.wanted or len(plans) == 1]


def bake_here(
    operator: bpy.types.Operator, scene: bpy.types.Scene, plans: Sequence[BakePlan], names: Sequence[str]
) -> None:
    """Bake in this process, in the order of the objects `names`; the operator reports each bake.

    Then the exports are made that the scene keeps of these bakes. Raises RadTexError.
    """
    from ...bake.progress import finished
    from ...forms.layered.capture.panoramas import pictures_shared
    from ...job.bake_plan import in_order, steps_of_bakes
    from ...job.variants import title_of
    from ..jobs.repeated_exports import RepeatedExports

    repeats = RepeatedExports.of(scene, plans)
    steps_of = {id(plan): steps_of_bakes(scene, plan) for plan in plans}
    with pictures_shared():
        for plan, _ in in_order(plans, names):
            name, spec, steps = next(steps_of[id(plan)])
            finished(steps)
            operator.report({"INFO"}, f"Baked {title_of(name, spec)}")
            if repeats is not None:
                repeats.note(name, (plan.request.place((name, spec)).files.sidecar,))
    for made in repeats.export_here() if repeats is not None else ():
        operator.report({"INFO"}, f"Exported {made.name} to {made.folder}: {size(made.bytes)}")


def questions(plans: Sequence[BakePlan]) -> tuple[str, ...]:
    """What to ask before these bakes are made: each names a bake that is there, and the new one."""
    asked = []
    for plan in plans:
        for name, spec in plan.replaced:
            course = plan.course_of((name, spec))
            if not course.resume and (course.overwrite or spec.incremental):
                found = plan.request.place((name, spec)).reasons_to_ask(course.overwrite)
                asked += [remark(reason, plan.request.folder) for reason in found]
    return tuple(asked)


def _of_changed(request: BakeRequest, *, surroundings: bool) -> BakeRequest:
    """The request for those bakes alone that have changed. Raises InputError where bakes are added to."""
    from ...core.errors import InputError
    from ...core.messages import Setting, leave_out

    adds = {Setting.ACCUMULATE: request.spec.accumulate, Setting.REFRESH: request.spec.refresh}
    if used := [setting for setting, is_on in adds.items() if is_on]:
        raise InputError("what has changed is baked anew, and not added to the bake", leave_out(*used))
    return replace(request, overwrite=False, resume=False, only_changed=True, surroundings=surroundings)


def _check_begun(plans: Sequence[BakePlan]) -> None:
    """Raise InputError if bakes that have changed, and would be made anew, are not finished."""
    from ...core.errors import InputError
    from ...core.messages import Setting, do
    from ...job.changed_bakes import BakeState
    from ...job.variants import title_of

    begun = [
        title_of(*bake)
        for plan in plans
        for bake, found in plan.found.items()
        if found.state is BakeState.UNFINISHED
    ]
    if begun:
        others = f" and {len(begun) - 1} more" if len(begun) > 1 else ""
        raise InputError(
            f"the bake of '{begun[0]}'{others} is not finished",
            do("go on with it", Setting.RESUME),
            do("bake it anew", Setting.OVERWRITE),
        )


def _free(scene: bpy.types.Scene, names: tuple[str, ...]) -> tuple[str, ...]:
    """Those of the names that are not being baked by a worker; all if all are, so that this is refused.

    Objects that share an atlas stay together.
    """
    from ..jobs.jobs import is_being_baked
    from ..settings.object_settings import settings_for

    settings = {name: settings_for(scene, name) for name in names}
    stay = {name for name in names if settings[name].together == "one"}
    free = (name for name in names if name in stay or not is_being_baked(name, settings[name]))
    return tuple(free) or names


def show_objects(scene: bpy.types.Scene, names: Sequence[str]) -> None:
    """Switch the previews of these objects off: a step to undo."""
    from ...preview.swap import is_on, switch_off

    previewed = [item for item in scene.objects if item.name in names and is_on(item)]
    for item in previewed:
        switch_off(item)
    if previewed:
        push_step("Show the Object")


def can_bake(operator: type[bpy.types.Operator], context: bpy.types.Context | None) -> bool:
    """Poll: whether there is a mesh to bake; sets the operator's message if not.

    The operator may name another object than those that are chosen, so any mesh in the view layer will do.
    """
    layer = context.view_layer if context is not None else None
    if layer is None or not any(map(may_have_faces, layer.objects)):
        operator.poll_message_set("Add a mesh object: its radiance texture can be baked")
        return False
    return True


def shown(context: bpy.types.Context | None) -> tuple[bpy.types.Scene, bpy.types.ViewLayer]:
    """The scene and view layer that an operator runs in."""
    assert context is not None  # Blender always gives one
    return cast(bpy.types.Scene, context.scene), cast(bpy.types.ViewLayer, context.view_layer)


def check_plan(scene: bpy.types.Scene, plan: BakePlan) -> None:
    """Check for errors before baking. Raises InputError with the first one found."""
    from ...core.errors import InputError
    from ...job.bake_plan import preflight

    if errors := preflight(scene, plan, _PATIENCE).errors:
        raise InputError.of(errors[0])
