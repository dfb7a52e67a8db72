# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings for a bake's output files: folder, contents, and what to do with existing files."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ...scene.mesh.named_regions import places_on
from .menu_items import COMPRESSIONS, LAYERS, TARGETS
from .update_callbacks import NOTICED, notice

DEFAULT_FOLDER = "//radtex/{blend_name}/"

# Property names of the mixin below, in the panel's order.
NAMES = (
    "layers",
    "directory",
    "full_floats",
    "compression",
    "preview",
    "overwrite",
    "accumulate",
    "refresh",
    "where",
    "resume",
    "export_targets",
)


def places(_: OutputSettings, around: bpy.types.Context, typed: str) -> Iterator[tuple[str, str]]:
    """Search function: the active object's named regions that match `typed`, each with its type."""
    item = around.object
    if item is not None and item.type == "MESH":
        for name, kind in places_on(item).items():
            if typed.lower() in name.lower():
                yield name, kind.capitalize()


class OutputSettings:
    """Mixin with the output properties; not registered itself."""

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        layers: set[str]
        directory: str
        full_floats: bool
        compression: str
        preview: bool
        overwrite: bool
        accumulate: bool
        refresh: bool
        where: str
        resume: bool
        export_targets: set[str]
    else:
        layers: EnumProperty(
            name="Layers",
            description="Also save parts of the light, such as reflections, as textures of their own, to "
            "mix or to regrade later",
            items=LAYERS,
            update=notice,
            options={"ENUM_FLAG", "SKIP_SAVE"},
            default=set(),
        )
        directory: StringProperty(
            name="Output Folder",
            description="Where the atlas and all that belongs to it are written; // is the .blend "
            "file's folder, {blend_name} its name, so that no two files share a folder",
            default=DEFAULT_FOLDER,
            subtype="DIR_PATH",
            update=notice,
            options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
        )
        full_floats: BoolProperty(
            name="32-bit Floats",
            description="Keep light beyond 65504 and steps that 16 bits are too few for. Hardly ever seen, "
            "and twice as large",
            default=False,
            **NOTICED,
        )
        compression: EnumProperty(
            name="Compression",
            description="How the images are packed on disk",
            items=COMPRESSIONS,
            default="zip",
            **NOTICED,
        )
        preview: BoolProperty(
            name="Preview",
            description="Also write a .blend in which the baked copy stands in the object's place. Showing "
            "the bake here and exporting it need that",
            default=True,
            **NOTICED,
        )
        overwrite: BoolProperty(
            name="Overwrite",
            description="Replace the files of an earlier bake of the same object",
            default=False,
            **NOTICED,
        )
        accumulate: BoolProperty(
            name="Accumulate",
            description="Add samples to the bake that is there: the same picture with less grain",
            default=False,
            **NOTICED,
        )
        refresh: BoolProperty(
            name="Refresh",
            description="Bake again only the places whose light has changed since the atlas was baked, as "
            "after a lamp was moved",
            default=False,
            **NOTICED,
        )
        where: StringProperty(
            name="Only Where",
            description="Accumulate or refresh only the faces of this vertex group, boolean face attribute "
            "or material. Left empty, everywhere",
            search=places,
            **NOTICED,
        )
        resume: BoolProperty(
            name="Resume",
            description="Go on with a bake that was cancelled or that failed, from what is kept of it: the "
            "picture is the same as if it had never stopped",
            default=False,
            **NOTICED,
        )
        export_targets: EnumProperty(
            name="Export",
            description="Folders to make of the bake once it is done: for browsers, engines and viewers",
            items=TARGETS,
            update=notice,
            options={"ENUM_FLAG", "SKIP_SAVE"},
            default=set(),
        )
