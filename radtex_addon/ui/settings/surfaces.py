# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that assign surfaces to atlases (shared or split), and the bakes that result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ...bake.kinds import Kind
from .menu_items import SPLITS
from .update_callbacks import NOTICED

if TYPE_CHECKING:
    from ...bake.spec import BakeSpec

NAMES = ("together", "atlas_name", "split", "part")  # property names of the mixin below


class SurfaceSettings:
    """Mixin with the properties of atlases; not registered itself."""

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        together: bool
        atlas_name: str
        split: str
        part: str
    else:
        together: BoolProperty(
            name="One Atlas",
            description="Bake all chosen objects into one texture, so that a game draws them at once",
            default=False,
            **NOTICED,
        )
        atlas_name: StringProperty(
            name="Name",
            description="Name of the shared texture, and of its files",
            default="Atlas",
            **NOTICED,
        )
        split: EnumProperty(
            name="Split By",
            description="One texture for the whole object, or one for each material or UDIM tile",
            items=SPLITS,
            default="none",
            **NOTICED,
        )
        part: StringProperty(
            name="Only",
            description="The one material, or the tile's number, to bake. Left empty, all are baked",
            **NOTICED,
        )


def draw_surfaces(column: Any, settings: Any, several: bool) -> None:
    """Draw the settings that apply; a shared atlas needs `several` objects."""
    if several and Kind(settings.kind).traits.shared_atlas:
        column.prop(settings, "together")
        if settings.together:
            column.prop(settings, "atlas_name")
    column.prop(settings, "split")
    if settings.split == "material":
        column.prop_search(settings, "part", bpy.data, "materials")
    elif settings.split != "none":
        column.prop(settings, "part")


def shared_name(values: Mapping[str, Any], spec: BakeSpec) -> str | None:
    """Name of the atlas that all objects share; None if each object has its own."""
    fits = spec.kind.traits.shared_atlas
    name: str = values["atlas_name"]
    return name if values["together"] and fits else None
