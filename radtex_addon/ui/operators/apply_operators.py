# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that bring a finished bake into the artist's own scene: as an asset, or as a real copy."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy.props import EnumProperty

from ..panel.labels import remark
from .bake_lookup import bake_called, originals, sidecars_of
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
        from ...formats.sidecar_file import opened
        from ...forms import form_in

        if self.shader != "OSL":
            return None
        file = opened(sidecar)
        form = form_in(file.facts)
        return lambda tree: form.script_node(tree, file)

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
        self.report({"INFO"}, f"Made {names}, in the same place: move it, or hide the original")
        push_step(self.bl_label)
        return {"FINISHED"}
