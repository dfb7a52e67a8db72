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
from bpy.props import StringProperty

from ...core.errors import InputError
from ...settings.options import SHOWN
from ...settings.presets import STOCK, STOCK_FOLDER, SUBDIR, preset_values, stock_values
from ..operators.undo import push_step
from ..panel.labels import remark
from .bake_settings import NAMES
from .chosen_objects import chosen_names
from .object_settings import edited_settings

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems

# Settings stored in a preset: quality, but no object, UV layer or folder.
PRESET_NAMES = tuple(name for name, option in SHOWN.items() if option.preset)


class RADTEX_PT_presets(PresetPanel, bpy.types.Panel):
    """Presets of your own, beside those in the panel"""

    bl_label = "RadTex Presets"
    bl_space_type = "VIEW_3D"
    bl_region_type = "HEADER"
    preset_subdir = SUBDIR
    preset_operator = "radtex.preset_apply"
    preset_add_operator = "radtex.preset_add"

    def path_menu(self, searchpaths: Sequence[str], operator: str, **choices: Any) -> None:
        """Blender's menu, without RadTex's presets."""
        others = [path for path in searchpaths if not Path(path).is_relative_to(STOCK_FOLDER)]
        if not others:  # Blender shows '* Missing Paths *' for an empty list
            choices["filter_path"] = lambda _: False
        cast(Any, PresetPanel).path_menu(self, others or searchpaths, operator, **choices)


class RADTEX_OT_preset_add(AddPresetBase, bpy.types.Operator):  # type: ignore[misc]  # as Blender's stubs type the base
    """Keep these settings as a preset of your own, or remove one"""

    bl_idname = "radtex.preset_add"
    bl_label = "Add RadTex Preset"
    preset_menu = "RADTEX_PT_presets"
    preset_subdir = SUBDIR

    def add(self, context: bpy.types.Context, filepath: str) -> None:
        """Write the settings that the panel shows, those of an object or the scene's; called by Blender."""
        scene, layer = cast(bpy.types.Scene, context.scene), cast(bpy.types.ViewLayer, context.view_layer)
        settings = edited_settings(scene, context.active_object, chosen_names(scene, layer))
        lines = [f"radtex.{name} = {getattr(settings, name)!r}\n" for name in PRESET_NAMES]
        head = "import bpy\nradtex = bpy.context.scene.radtex\n\n"
        Path(filepath).write_text(head + "".join(lines), encoding="utf-8")


class RADTEX_OT_preset_apply(bpy.types.Operator):
    """Set what a preset says: texels, cells, samples and layout"""

    bl_idname = "radtex.preset_apply"
    bl_label = "Apply RadTex Preset"
    bl_options = {"REGISTER", "INTERNAL"}  # pushes its own undo step: see undo.py

    if TYPE_CHECKING:
        name: str
        filepath: str
    else:
        name: StringProperty(
            name="Name", description="A preset's name, RadTex's or your own", options={"SKIP_SAVE"}
        )
        filepath: StringProperty(
            name="File",
            description="The preset's file, instead of its name",
            subtype="FILE_PATH",
            options={"SKIP_SAVE"},
        )

    @classmethod
    def description(cls, _: bpy.types.Context | None, properties: Any) -> str:
        """The tooltip of a RadTex preset."""
        return next((told for name, _, told in STOCK if name == properties.name), "")

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        assert context is not None  # Blender always gives one
        assert context.scene is not None  # as above
        assert context.view_layer is not None  # as above
        names = chosen_names(context.scene, context.view_layer)
        settings = edited_settings(context.scene, context.active_object, names)
        try:
            left_out = apply_preset(self.filepath or self.name, settings)
        except (InputError, OSError, SyntaxError, ValueError) as error:
            self.report({"ERROR"}, remark(error if isinstance(error, InputError) else str(error)))
            return {"CANCELLED"}
        for told in left_out:
            self.report({"WARNING"}, remark(told))
        push_step(self.bl_label)
        return {"FINISHED"}


def apply_preset(name: str, settings: Any = None) -> tuple[str, ...]:
    """Apply a preset to `settings`, those of the current scene if None; returns what of it was left out.

    `name` is a preset's name or its file. Raises InputError if there is none.
    """
    chosen: Any = bpy.context.scene.radtex if settings is None else settings  # type: ignore[union-attr]  # ours
    values = preset_values(_found(name))
    left_out = []
    for setting, value in values.items():
        if not _set(chosen, setting, value):
            left_out.append(f"preset '{name}': this version of RadTex has no setting {setting} = {value!r}")
    return tuple(left_out)


def _set(settings: Any, name: str, value: Any) -> bool:
    """Set one setting; returns False if there is none of that name, or it has no such choice."""
    if name not in NAMES:
        return False
    try:
        setattr(settings, name, value)
    except TypeError:
        return False
    return True


def is_applied(name: str, settings: Any) -> bool:
    """Whether all settings are as RadTex's preset `name` sets them."""
    values = stock_values(name)
    return all(getattr(settings, setting) == value for setting, value in values.items())


def _found(name: str) -> Path:
    if name.endswith(".py") and Path(name).is_file():
        return Path(name)
    utils: Any = bpy.utils  # the 4.5 stubs type preset_find as returning None
    found = utils.preset_find(name, SUBDIR) or utils.preset_find(name, SUBDIR, display_name=True)
    if found is None:
        raise InputError(f"there is no preset '{name}': choose one from the panel's preset menu")
    return Path(found)


def register() -> None:
    """Add RadTex's presets to Blender's search path."""
    bpy.utils.register_preset_path(str(STOCK_FOLDER))


def unregister() -> None:
    """Remove them from the search path."""
    bpy.utils.unregister_preset_path(str(STOCK_FOLDER))
