# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""RadTex's presets, and the user's in Blender's preset menu.

A preset is a Python script that sets the scene's settings, like Blender's own presets.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from ...core.errors import InputError
from ..operators.undo import push_step
from ..panel.labels import remark

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems

SUBDIR = "radtex"
_FOLDER = Path(__file__).with_name("stock")  # contains presets/radtex/*.py, as Blender expects

# File name, label and tooltip: first by increasing cost, then by material.
STOCK = (
    ("draft", "Draft", "A first look in seconds: coarse, and noisy"),
    ("preview", "Preview", "Good enough to judge the light"),
    ("final", "Final", "Fine texels and little noise, for what ships"),
    ("mirror_like", "Mirror-like", "Polished, coated and glassy things: sharp reflections"),
    (
        "diffuse_like",
        "Diffuse-like",
        "Matt things: light that hardly changes with the view, in little space",
    ),
)

# Settings stored in a preset: quality, but no object, UV layer or folder.
PRESET_NAMES = (
    "kind",
    "atlas_layout",
    "atlas_size",
    "texels",
    "density",
    "bucket",
    "samples",
    "padding",
    "full_floats",
    "compression",
)


class RADTEX_PT_presets(PresetPanel, bpy.types.Panel):
    """Settings for a purpose, and your own"""

    bl_label = "RadTex Presets"
    bl_space_type = "VIEW_3D"
    bl_region_type = "HEADER"
    preset_subdir = SUBDIR
    preset_operator = "script.execute_preset"
    preset_add_operator = "radtex.preset_add"

    def draw(self, context: bpy.types.Context | None) -> None:
        """Draw RadTex's presets in the order of `STOCK`, and the user's below them."""
        layout: Any = self.layout
        layout.emboss = "PULLDOWN_MENU"
        for name, label, _ in STOCK:
            layout.operator("radtex.preset_apply", text=label).name = name
        layout.separator()
        super().draw(context)

    def path_menu(self, searchpaths: Sequence[str], operator: str, **choices: Any) -> None:
        """Blender's menu, without RadTex's presets."""
        others = [path for path in searchpaths if not Path(path).is_relative_to(_FOLDER)]
        if not others:  # Blender shows '* Missing Paths *' for an empty list
            choices["filter_path"] = lambda _: False
        cast(Any, PresetPanel).path_menu(self, others or searchpaths, operator, **choices)


class RADTEX_OT_preset_add(AddPresetBase, bpy.types.Operator):  # type: ignore[misc]  # as Blender's stubs type the base
    """Keep these settings as a preset of your own, or remove one"""

    bl_idname = "radtex.preset_add"
    bl_label = "Add RadTex Preset"
    preset_menu = "RADTEX_PT_presets"
    preset_subdir = SUBDIR
    preset_defines = ["radtex = bpy.context.scene.radtex"]
    preset_values = [f"radtex.{name}" for name in PRESET_NAMES]


class RADTEX_OT_preset_apply(bpy.types.Operator):
    """Set what a preset says: texels, cells, samples and layout"""

    bl_idname = "radtex.preset_apply"
    bl_label = "Apply RadTex Preset"
    bl_options = {"REGISTER", "INTERNAL"}  # pushes its own undo step: see undo.py

    if TYPE_CHECKING:
        name: str
    else:
        name: bpy.props.StringProperty(name="Name", description="A preset's name, RadTex's or your own")

    @classmethod
    def description(cls, _: bpy.types.Context | None, properties: Any) -> str:
        """The tooltip of a RadTex preset."""
        return next((told for name, _, told in STOCK if name == properties.name), "")

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        try:
            apply_preset(self.name)
        except InputError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        push_step(self.bl_label)
        return {"FINISHED"}


def apply_preset(name: str) -> None:
    """Apply a preset to the current scene. Raises InputError if no preset has that name."""
    utils: Any = bpy.utils  # the 4.5 stubs type preset_find as returning None
    found = utils.preset_find(name, SUBDIR) or utils.preset_find(name, SUBDIR, display_name=True)
    if found is None:
        raise InputError(f"there is no preset '{name}': choose one from the panel's preset menu")
    bpy.utils.execfile(found)


def register() -> None:
    """Add RadTex's presets to Blender's search path."""
    bpy.utils.register_preset_path(str(_FOLDER))


def unregister() -> None:
    """Remove them from the search path."""
    bpy.utils.unregister_preset_path(str(_FOLDER))
