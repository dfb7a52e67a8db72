# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that bring a finished bake into the artist's own scene: as an asset, or as a real copy."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy.props import EnumProperty, StringProperty

from ..panel.labels import remark
from ..settings.chosen_objects import selected_meshes
from .bake_lookup import bake_called, bake_of_copy, has_meshes, originals, sidecars_of
from .bake_operator import shown
from .operator_mixins import OfBake
from .undo import push_step

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems

    from ...preview.bake_group import ScriptNode

SHADERS = (
    (
        "NODES",
        "Nodes: Eevee and Cycles",
        "Native shader nodes, which every engine and device of Blender runs",
    ),
    (
        "OSL",
        "Script Node (OSL): Cycles Only",
        "One node with an Open Shading Language shader, for Cycles on the CPU",
    ),
)


class _Shows(OfBake):
    """Mixin with the choice of the shader, and the bakes it is for; not registered itself."""

    if TYPE_CHECKING:  # type of the property that Blender creates from the annotation below
        shader: str
    else:
        shader: EnumProperty(
            name="Shader",
            description="What the bake is looked up with",
            items=SHADERS,
            default="NODES",
            options={"SKIP_SAVE"},
        )

    def found(
        self, operator: bpy.types.Operator, scene: bpy.types.Scene, layer: bpy.types.ViewLayer
    ) -> dict[Path, list[bpy.types.Object]]:
        """The chosen objects by the sidecar of their bake; those without one are reported as warnings.

        Raises RadTexError if none has a bake, or the scene cannot run the chosen shader.
        """
        from ...preview.osl import check_scene

        if self.shader == "OSL":
            check_scene(scene)
        items = originals(layer, self.object, scene, self.bake)
        sidecars, errors = sidecars_of(scene, items, bake_called(layer, self.object, scene, self.bake))
        for error in errors:
            operator.report({"WARNING"}, remark(error))
        found: dict[Path, list[bpy.types.Object]] = {}
        for item, sidecar in sidecars.items():
            found.setdefault(sidecar, []).append(item)
        return found

    def script(self, sidecar: Path) -> ScriptNode | None:
        """What adds the Script node of a bake, if that is chosen. Raises FormatError."""
        return script_of(sidecar) if self.shader == "OSL" else None

    def switch_osl_on(self, operator: bpy.types.Operator, scene: bpy.types.Scene) -> None:
        """Set the scene up for Script nodes if they are chosen, and say so."""
        from ...preview.osl import switch_osl_on

        if self.shader != "OSL":
            return
        if switch_osl_on(scene):
            operator.report({"INFO"}, "Open Shading Language is on now, in the scene's render properties")
        engine: str = scene.render.engine
        if engine != "CYCLES":
            operator.report({"WARNING"}, "Script nodes are shown by Cycles alone: choose it as render engine")


class RADTEX_OT_make_asset(_Shows, bpy.types.Operator):
    """Make a node group and a material of the bake, as assets: for the object's baked copy, in any file"""

    bl_idname = "radtex.make_asset"
    bl_label = "Make Asset"
    bl_options = {"REGISTER"}  # pushes its own undo step: see undo.py

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import RadTexError
        from ...preview.apply_copy import make_assets

        scene, layer = shown(context)
        names: list[str] = []
        try:
            for sidecar, items in self.found(self, scene, layer).items():
                made = make_assets(sidecar, [item.name for item in items], scene, self.script(sidecar))
                names += [material.name for material in made]
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            if not names:
                return {"CANCELLED"}
        self.switch_osl_on(self, scene)
        self.report({"INFO"}, f"Node group and material in the asset browser: {', '.join(names)}")
        push_step(self.bl_label)
        return {"FINISHED"}


class RADTEX_OT_apply_to_copy(_Shows, bpy.types.Operator):
    """Make a copy of the object that shows the bake, to keep, move and edit. The object stays as it is"""

    bl_idname = "radtex.apply_to_copy"
    bl_label = "Apply to a Copy"
    bl_options = {"REGISTER"}  # pushes its own undo step: see undo.py

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import RadTexError
        from ...preview.apply_copy import apply_to_copies
        from ...preview.kept_copies import COLLECTION

        scene, layer = shown(context)
        made = []
        try:
            for sidecar, items in self.found(self, scene, layer).items():
                made += apply_to_copies(items, sidecar, layer, self.script(sidecar))
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            if not made:
                return {"CANCELLED"}
        self.switch_osl_on(self, scene)
        for name in (one.original.name for one in made if one.moved):
            self.report({"WARNING"}, f"{name} has moved since the bake: it shows the light of its old place")
        names = ", ".join(f"'{one.copy.name}'" for one in made)
        self.report(
            {"INFO"}, f"Made {names} in '{COLLECTION}', in the same place: move it, or hide the original"
        )
        push_step(self.bl_label)
        return {"FINISHED"}


class _OfCopies:
    """Mixin with the choice of copies that show a bake, and a poll; not registered itself."""

    if TYPE_CHECKING:  # type of the property that Blender creates from the annotation below
        object: str
    else:
        object: StringProperty(
            name="Object",
            description="Name of a copy that shows a bake. Left empty, all selected ones are meant",
            options={"SKIP_SAVE"},
        )

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        """Whether there is a mesh, in Object Mode."""
        return has_meshes(cls, context)  # type: ignore[arg-type]  # the class that uses the mixin is an operator

    def copies(self, layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
        """The copies. Raises InputError if there are none."""
        from ...core.errors import InputError
        from ...preview.kept_copies import shown_by

        named = [item for item in layer.objects if item.name == self.object]
        if self.object and not named:
            raise InputError(
                f"no object '{self.object}' in view layer '{layer.name}': name one that is there"
            )
        found = [item for item in named or selected_meshes(layer) if shown_by(item) is not None]
        if not found:
            raise InputError(
                "no copy that shows a bake is selected: select one that Apply to a Copy has made"
            )
        return found

    def own_copies(self, layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
        """The same, to be changed. Raises InputError also if one is of another file."""
        from ...core.errors import InputError
        from ...preview.swap import is_foreign

        found = self.copies(layer)
        for copy in found:
            if is_foreign(copy):
                raise InputError(
                    f"'{copy.name}' is of a linked file: do it there, or make the copy local first"
                )
        return found


class RADTEX_OT_select_original(_OfCopies, bpy.types.Operator):
    """Select the object that the copy was made of, or its preview if that is on, and show what is hidden"""

    bl_idname = "radtex.select_original"
    bl_label = "Select Original"
    bl_options = {"REGISTER"}  # pushes its own undo step: see undo.py

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import InputError, RadTexError
        from ...preview.apply_copy import select_only
        from ...preview.kept_copies import original_of_copy, seen_of, shown_by

        scene, layer = shown(context)
        try:
            copies = self.copies(layer)
            found = {copy: original_of_copy(copy, scene) for copy in copies}
            originals = list(dict.fromkeys(seen_of(one) for one in found.values() if one is not None))
            originals = [one for one in originals if one in set(layer.objects)]
            if not originals:
                told = shown_by(copies[0])
                name = "" if told is None else told.name
                raise InputError(
                    f"the original '{name}' is not in view layer '{layer.name}': it was deleted, or its "
                    "collection is left out here"
                )
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        for one in originals:
            one.hide_viewport = False
            one.hide_set(False, view_layer=layer)
        select_only(originals, layer)
        for one in originals:
            if not one.visible_get(view_layer=layer):
                self.report(
                    {"WARNING"}, f"'{one.name}' is hidden by its collection: show that in the Outliner"
                )
        push_step(self.bl_label)
        return {"FINISHED"}


class RADTEX_OT_update_copy(_OfCopies, bpy.types.Operator):
    """Show the bake as it is now on the copy, and on others of that bake. They stay where they are"""

    bl_idname = "radtex.update_copy"
    bl_label = "Update Copy"
    bl_options = {"REGISTER"}  # pushes its own undo step: see undo.py

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import RadTexError

        scene, layer = shown(context)
        done: list[str] = []
        try:
            for (sidecar, shader), copies in self._wanted(scene, self.own_copies(layer)).items():
                done += self._update(scene, sidecar, shader, copies)
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            if not done:
                return {"CANCELLED"}
        self.report({"INFO"}, f"Updated {', '.join(done)}")
        push_step(self.bl_label)
        return {"FINISHED"}

    def _wanted(
        self, scene: bpy.types.Scene, copies: list[bpy.types.Object]
    ) -> dict[tuple[Path, str], list[bpy.types.Object]]:
        """The copies that are updated, by bake and shader: others of the same bake share its node group.

        Raises InputError for a copy whose bake is not there.
        """
        from ...core.errors import InputError
        from ...preview.kept_copies import shown_by

        chosen: dict[Path, list[bpy.types.Object]] = {}
        for copy in copies:
            sidecar, told = bake_of_copy(scene, copy), shown_by(copy)
            if sidecar is None:
                name = "" if told is None else told.name
                raise InputError(
                    f"the bake of '{name}' that '{copy.name}' shows is not there: bake '{name}' again"
                )
            chosen.setdefault(sidecar, []).append(copy)
        wanted: dict[tuple[Path, str], list[bpy.types.Object]] = {}
        for sidecar, those in chosen.items():
            alike = [one for one in bpy.data.objects if _shows(one, sidecar) and one.users_scene]
            for one in dict.fromkeys((*those, *alike)):
                told = shown_by(one)
                wanted.setdefault((sidecar, "" if told is None else told.shader), []).append(one)
        return wanted

    def _update(
        self, scene: bpy.types.Scene, sidecar: Path, shader: str, copies: list[bpy.types.Object]
    ) -> list[str]:
        """Update copies by one shader; returns their names in quotes. Raises RadTexError."""
        from ...preview.kept_copies import update_copies
        from ...preview.osl import check_scene

        if shader == "OSL":
            check_scene(scene)
        update_copies(copies, sidecar, script_of(sidecar) if shader == "OSL" else None)
        return [f"'{copy.name}'" for copy in copies]


class RADTEX_OT_delete_copy(_OfCopies, bpy.types.Operator):
    """Delete the copy with its mesh. The object that it was made of and the bake's files stay"""

    bl_idname = "radtex.delete_copy"
    bl_label = "Delete Copy"
    bl_options = {"REGISTER"}  # pushes its own undo step: see undo.py

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import RadTexError
        from ...preview.kept_copies import delete_copies

        try:
            copies = self.own_copies(shown(context)[1])
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        names = ", ".join(f"'{copy.name}'" for copy in copies)
        delete_copies(copies)
        self.report({"INFO"}, f"Deleted {names}")
        push_step(self.bl_label)
        return {"FINISHED"}


def script_of(sidecar: Path) -> ScriptNode:
    """What adds the Script node of a bake. Raises FormatError."""
    from ...formats.sidecar_file import opened
    from ...forms import form_in

    file = opened(sidecar)
    form = form_in(file.facts)
    return lambda tree: form.script_node(tree, file)


def _shows(item: bpy.types.Object, sidecar: Path) -> bool:
    """Whether this is a copy that shows the bake with this sidecar."""
    from ...preview.kept_copies import shown_by
    from ...preview.swap import is_foreign

    told = shown_by(item)
    return told is not None and told.sidecar == sidecar and not is_foreign(item)


CLASSES = (
    RADTEX_OT_apply_to_copy,
    RADTEX_OT_make_asset,
    RADTEX_OT_select_original,
    RADTEX_OT_update_copy,
    RADTEX_OT_delete_copy,
)
