# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator that exports a finished bake to a folder for an engine or a browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty

from ..jobs import jobs
from ..panel.labels import remark
from ..settings.menu_items import TARGETS
from .bake_lookup import originals, place_of, sharing
from .bake_operator import shown
from .operator_mixins import AsksFirst, MayWait, OfBake

if TYPE_CHECKING:
    from collections.abc import Iterable

    from bpy.stub_internal.rna_enums import OperatorReturnItems

    from ...textures.export_spec import ExportSpec

FORMATS = (
    ("auto", "Automatic", "What the target reads best"),
    ("exr", "OpenEXR", "Exact, and large: for tools, not for players"),
    ("ktx2-rgba16f", "KTX2, RGBA16F", "Half floats: exact, eight bytes a pixel"),
    ("ktx2-rgb9e5", "KTX2, RGB9E5", "Four bytes a pixel, no alpha: hardly to be told from half floats"),
    ("ktx2-bc6h", "KTX2, BC6H", "One byte a pixel, no alpha: fine gradients may step"),
    ("dds-bc6h", "DDS, BC6H", "One byte a pixel, no alpha: fine gradients may step"),
    ("dds-rgba16f", "DDS, RGBA16F", "Half floats: exact, eight bytes a pixel"),
)

ARRANGEMENTS = (
    ("matrix", "Matrix", "Each texel's bucket lies in one place, as in the atlas"),
    ("slices", "Slices", "An array with a layer for each cell, which a GPU blends between texels by itself"),
)


class Place(NamedTuple):
    """An object's name, the sidecar of its bake, and the folder to make."""

    name: str
    sidecar: Path
    out: Path


class RADTEX_OT_export(AsksFirst, MayWait, OfBake, bpy.types.Operator):
    """Make a folder of the bake that an engine or a browser takes: mesh, textures, shaders"""

    bl_idname = "radtex.export"
    bl_label = "Export Bake"
    bl_options = {"REGISTER"}

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        target: str
        format: str
        zstd: bool
        arrangement: str
        levels: int
        limit: int
        mirror: bool
        directory: str
        overwrite: bool
    else:
        target: EnumProperty(name="Target", description="Who takes the folder", items=TARGETS, default="gltf")
        format: EnumProperty(
            name="Format", description="How the textures are stored", items=FORMATS, default="auto"
        )
        zstd: BoolProperty(
            name="Zstandard",
            description="Pack KTX2 files: smaller on disk, the same picture",
            default=True,
        )
        arrangement: EnumProperty(
            name="Arrangement",
            description="How a plain bake's buckets lie in its texture",
            items=ARRANGEMENTS,
            default="matrix",
        )
        levels: IntProperty(
            name="Mip Levels",
            description="Smaller copies of the textures, which keep far objects from shimmering. 0 is as "
            "many as fit",
            default=0,
            min=0,
            max=15,
        )
        limit: IntProperty(
            name="Limit",
            description="Most pixels along a texture's side: larger ones are split or refused. 0 is what the "
            "target's devices take",
            default=0,
            min=0,
            soft_max=16384,
        )
        mirror: BoolProperty(
            name="Mirror Ball",
            description="For the web and Godot: a chrome ball that moves and mirrors the bake",
            default=False,
        )
        directory: StringProperty(
            name="Folder",
            description="The folder to make. Left empty, one beside the bake. Not for several objects",
            subtype="DIR_PATH",
            options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
        )
        overwrite: BoolProperty(
            name="Overwrite",
            description="Replace an earlier export there; files of others in that folder stay",
            default=False,
            options={"SKIP_SAVE"},
        )

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import InputError, RadTexError

        scene, layer = shown(context)
        try:
            spec = self._spec()
            names = [item.name for item in originals(layer, self.object, scene, self.bake)]
            if sharing(layer, self.object, scene, self.bake):
                names = [self.object]
            places = [place for name in names for place in self._places(scene, name, spec)]
            places = list({place.sidecar: place for place in places}.values())  # objects may share an atlas
            if self.directory and len(places) > 1:
                raise InputError("several bakes do not fit in one folder: leave the folder out")
            if self.at_once:
                self._export(places, spec)
            else:
                submit(places, spec, overwrite=self.overwrite)
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def _spec(self) -> ExportSpec:
        from ...textures.export_spec import Arrangement, ExportSpec, Target, TextureFormat

        return ExportSpec(
            target=Target(self.target),
            format=TextureFormat(self.format),
            zstd=self.zstd,
            arrangement=Arrangement(self.arrangement),
            levels=self.levels or None,
            limit=self.limit or None,
            mirror=self.mirror,
        )

    def _places(self, scene: bpy.types.Scene, called: str, spec: ExportSpec) -> list[Place]:
        """The sidecars of the bakes named `called`, one for each part or variant, and their export folders.

        Raises RadTexError if an export would fail immediately.
        """
        from ...bake.spec import Kind
        from ...export.exporting import ExportSource, check_export
        from ...formats.sidecar import file_name
        from ...job.variants import variants_in
        from ...report.finished_bake import find_bakes, object_of

        place, kind = place_of(scene, self.bake), scene.radtex.kind  # type: ignore[attr-defined]  # ours
        chosen_kind = place / file_name(called, kind, "json")
        variants = variants_in(place, called, kind) if place.is_dir() else ()
        place = chosen_kind if chosen_kind.is_file() else place
        chosen = Path(bpy.path.abspath(self.directory)) if self.directory else None
        places = []
        name = called if place.is_dir() else None
        for sidecar in variants or find_bakes(place, name, "exported", tuple(Kind)):
            bake = ExportSource.of(sidecar)
            out = chosen or bake.folder(spec.target)
            check_export(bake, spec, out, overwrite=self.overwrite)
            places.append(Place(object_of(bake.sidecar), bake.sidecar.path, out))
        return places

    def _export(self, places: list[Place], spec: ExportSpec) -> None:
        """Export in this process and report each object. Raises RadTexError."""
        from ...bake.progress import finished
        from ...export.exporting import export_steps
        from ..panel.labels import size

        for place in places:
            made = finished(export_steps(place.sidecar, spec, place.out, overwrite=self.overwrite))
            self.report({"INFO"}, f"Exported {made.name} to {made.folder}: {size(made.bytes)}")


def submit(places: Iterable[Place], spec: ExportSpec, *, overwrite: bool) -> None:
    """Queue the exports as background jobs. Raises BakeError if no work folder can be created."""
    from ...worker.handover import work_folder
    from ...worker.orders import order_export
    from ..settings.preferences import preferred

    folder = work_folder(preferred().cache)
    jobs.add(
        order_export(folder, place.sidecar, place.name, spec, place.out, overwrite=overwrite)
        for place in places
    )
