# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that export a finished bake to a folder for an engine or a browser, and stop doing it again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty

from ...settings.menu_items import TARGETS
from ...settings.targets import DEFAULT_TARGET, Target
from ...textures.kept_exports import KeptExport
from ..panel.labels import iface_, remark
from ..panel.panel_state import mark_stale
from ..settings.kept_exports import forget, is_kept, keep, rows_of
from ..settings.preferences import preferred, remember_export
from .bake_lookup import in_object_mode
from .bake_operator import shown
from .export_dialog import WIDTH, Plan, applicable, dialog_title, draw_dialog, planned
from .export_sources import Place, export_sources, place_for, submit, submit_scene
from .operator_mixins import MayWait, OfBake
from .undo import push_step

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bpy.stub_internal.rna_enums import OperatorReturnItems

    from ...export.exporting import ExportSource
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

MESHES = (
    ("auto", "Automatic", "Compressed for the web, plain for programs that may not know the extension"),
    (
        "meshopt",
        "Compressed",
        "By EXT_meshopt_compression, often a third of the bytes; three.js and Babylon.js read it",
    ),
    ("plain", "Plain", "Numbers alone, which more programs read"),
)

_MIRRORS = " and ".join(each.traits.called or each.traits.title for each in Target if each.traits.mirror)


class RADTEX_OT_export(MayWait, OfBake, bpy.types.Operator):
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
        mesh: str
        mirror: bool
        as_scene: bool
        scene_name: str
        directory: str
        into: str
        overwrite: bool
        again: bool
        advanced: bool

        _asked_of: tuple[str, str | None] | None  # the target and the scene's name that `again` was set for
        _sources: tuple[ExportSource, ...]  # the bakes that the dialog is about; empty without a dialog
        _plan: tuple[object, Plan] | None  # settings of the dialog, and the plan for them
    else:
        target: EnumProperty(
            name="Target", description="Who takes the folder", items=TARGETS, default=DEFAULT_TARGET.value
        )
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
        mesh: EnumProperty(
            name="Mesh",
            description="How the .glb stores vertices and triangles",
            items=MESHES,
            default="auto",
        )
        mirror: BoolProperty(
            name="Mirror Ball",
            description=f"For {_MIRRORS}: a chrome ball that moves and mirrors the bake",
            default=False,
        )
        as_scene: BoolProperty(
            name="As One Scene",
            description="Of several objects: one folder with one glTF, which has a node for each object, "
            "instead of a folder for each. TREE_LOD0, TREE_LOD1 and so on become levels of detail",
            default=False,
        )
        scene_name: StringProperty(
            name="Scene Name",
            description="What the folder and its files are called. Left empty, as this scene in Blender",
            options={"SKIP_SAVE"},
        )
        directory: StringProperty(
            name="Folder",
            description="The folder to make, of a single bake or a scene. Left empty, one in Into",
            subtype="DIR_PATH",
            options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
        )
        into: StringProperty(
            name="Into",
            description="Where a folder is made for each bake. Left empty, beside the bake",
            subtype="DIR_PATH",
            options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
        )
        overwrite: BoolProperty(
            name="Overwrite",
            description="Replace an earlier export there; files of others in that folder stay",
            default=False,
            options={"SKIP_SAVE"},
        )
        again: BoolProperty(
            name="After Each Bake",
            description="Make this export again whenever its bakes are made again: by the same settings, in "
            "the same folder. The scene keeps that, and the panel lists it below Output",
            default=False,
            options={"SKIP_SAVE"},
        )
        advanced: BoolProperty(
            name="Advanced",
            description="Show how the textures are stored",
            default=False,
            options={"HIDDEN"},
        )

        _asked_of = None
        _sources = ()
        _plan = None

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        """Whether Blender is in Object Mode; nothing needs to be selected, since `object` may be given."""
        return in_object_mode(cls, context)

    def invoke(
        self, context: bpy.types.Context | None, event: bpy.types.Event | None
    ) -> set[OperatorReturnItems]:
        """Open the dialog, unless there is no bake to export."""
        from ...core.errors import RadTexError

        assert context is not None  # Blender always gives one
        assert context.window_manager is not None  # a click implies a window
        try:
            self.check_files()
            self.ask_for(context)
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        return context.window_manager.invoke_props_dialog(
            self, width=WIDTH, title=dialog_title(self._sources), confirm_text=iface_("Export")
        )

    def ask_for(self, context: bpy.types.Context) -> None:
        """Find the bakes that the dialog is about, and set what it starts with: the last target and folder.

        Overwrite is on, and shown where it matters. Raises RadTexError if there are no bakes.
        """
        last = preferred()
        self._sources = tuple(export_sources(*shown(context), self.object, self.bake))
        if not self.properties.is_property_set("overwrite"):
            self.overwrite = True
        if not self.properties.is_property_set("target"):
            self.target = last.export_target
        if not self.properties.is_property_set("into") and _is_there(last.export_into):
            self.into = last.export_into
        assert context.scene is not None  # as in every window
        self.scene_name = self.scene_name or context.scene.name
        if self.properties.is_property_set("again"):
            self._asked_of = self.target, self._scene_name()
        self.check(context)

    def check(self, context: bpy.types.Context | None) -> bool:
        """After each change in the dialog: leave a format that the target does not read.

        For another target, or another scene to export, *After Each Bake* starts as it was left for that one.
        """
        if self.format not in Target(self.target).traits.formats:
            self.format = "auto"
        asked = self.target, self._scene_name()
        if self._asked_of != asked:
            sidecars = [source.sidecar.path for source in self._sources]
            self.again = is_kept(shown(context)[0], sidecars, Target(self.target), asked[1])
            self._asked_of = asked
        return True

    def draw(self, context: bpy.types.Context | None) -> None:
        layout: Any = self.layout
        if self._sources:
            draw_dialog(layout, self, self._planned())

    def _planned(self) -> Plan:
        """What OK would do; worked out anew after a change only."""
        from ...core.errors import RadTexError

        stored = ("target", "format", "zstd", "arrangement", "levels", "limit", "mesh", "mirror")
        names = (*stored, "directory", "into", "as_scene", "scene_name")
        key = tuple(getattr(self, name) for name in names)
        if self._plan is None or self._plan[0] != key:
            scene = self._scene_name()
            try:
                plan = planned(self._sources, self._spec(), self._outs(self._sources), scene is not None)
            except RadTexError as error:
                plan = Plan(self._sources, self._outs(self._sources), errors=(error.message,))
            self._plan = key, plan
        return self._plan[1]

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import RadTexError

        scene, layer = shown(context)
        try:
            self.check_files()
            spec = self._spec()
            sources = export_sources(scene, layer, self.object, self.bake)
            name = self._scene_name()
            if name is None:
                self._export_each(sources, spec)
            else:
                self._export_scene(sources, spec, name)
            if self._sources:
                remember_export(self.target, self.into)
            if self._sources or self.properties.is_property_set("again"):
                self._keep(scene, sources, spec)
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def _spec(self) -> ExportSpec:
        """The specification; settings that the dialog does not show are left out of one that it asked for."""
        from ...textures.export_spec import Arrangement, ExportSpec, MeshPacking, Target, TextureFormat

        names = {"format", "zstd", "arrangement", "levels", "limit", "mesh", "mirror"}
        scene = self._scene_name() is not None
        used = applicable(self._sources, self.target, self.format, scene) if self._sources else names
        return ExportSpec(
            target=Target(self.target),
            format=TextureFormat(self.format if "format" in used else "auto"),
            zstd=self.zstd or "zstd" not in used,
            arrangement=Arrangement(self.arrangement if "arrangement" in used else "matrix"),
            levels=(self.levels or None) if "levels" in used else None,
            limit=self.limit or None,
            mirror=self.mirror and "mirror" in used,
            mesh=MeshPacking(self.mesh if "mesh" in used else "auto"),
        )

    def _scene_name(self) -> str | None:
        """The name of the scene that all bakes are exported as; None if each has a folder of its own."""
        if not self.as_scene or len(self._sources) == 1:  # the dialog does not show the choice for one bake
            return None
        assert bpy.context.scene is not None
        return self.scene_name.strip() or bpy.context.scene.name

    def _outs(self, sources: Sequence[ExportSource]) -> tuple[Path, ...]:
        """The folder of each bake's export, or of the scene: the one that was named, else one in `into`."""
        from ...export.exporting_scene import scene_folder
        from ...textures.export_spec import Target

        target, scene = Target(self.target), self._scene_name()
        if self.directory:
            return (Path(bpy.path.abspath(self.directory)),) * (len(sources) if scene is None else 1)
        if scene is None:
            found = [source.folder(target) for source in sources]
        else:
            found = [scene_folder(sources, scene, target)]
        into = Path(bpy.path.abspath(self.into)) if self.into else None
        return tuple(out if into is None else into / out.name for out in found)

    def _keep(self, scene: bpy.types.Scene, sources: Sequence[ExportSource], spec: ExportSpec) -> None:
        """Let the scene keep these exports, to be made again after each bake, or forget them.

        A step to undo, if that changes anything.
        """
        outs, name = self._outs(sources), self._scene_name()
        if name is None:
            exports = [
                KeptExport(source.name, (source.sidecar.path,), out, spec)
                for source, out in zip(sources, outs, strict=True)
            ]
        else:
            sidecars = tuple(source.sidecar.path for source in sources)
            exports = [KeptExport(name, sidecars, outs[0], spec, name)]
        typed = self.directory or self.into
        changed = self.again
        for export in exports:
            if self.again:
                keep(scene, export, relative=not typed or typed.startswith("//"))
            else:
                changed |= forget(scene, export)
        if changed:
            mark_stale()
            push_step("Export After Each Bake")

    def _places(self, sources: list[ExportSource], spec: ExportSpec) -> list[Place]:
        """Where each bake goes. Raises RadTexError if an export would fail immediately."""
        from ...export.exporting import check_export, check_folders_differ

        outs = self._outs(sources)
        check_folders_differ(outs)
        for source, out in zip(sources, outs, strict=True):
            check_export(source, spec, out, overwrite=self.overwrite)
        return [place_for(source, out) for source, out in zip(sources, outs, strict=True)]

    def _export_scene(self, sources: list[ExportSource], spec: ExportSpec, name: str) -> None:
        """Export the bakes as one scene, here and now or as a job. Raises RadTexError."""
        from ...bake.progress import finished
        from ...export.exporting_scene import check_scene, export_scene_steps
        from ..panel.labels import size

        (out,) = self._outs(sources)
        check_scene(sources, spec, out, overwrite=self.overwrite)
        sidecars = [source.sidecar.path for source in sources]
        if not self.at_once:
            submit_scene(sidecars, spec, name, out, overwrite=self.overwrite)
            return
        made = finished(export_scene_steps(sidecars, spec, name, out, overwrite=self.overwrite))
        self.report({"INFO"}, f"Exported {made.name} to {made.folder}: {size(made.bytes)}")

    def _export_each(self, sources: list[ExportSource], spec: ExportSpec) -> None:
        """Export each bake to a folder of its own, here and now or as a job. Raises RadTexError."""
        from ...bake.progress import finished
        from ...export.exporting import export_steps
        from ..panel.labels import size

        places = self._places(sources, spec)
        if not self.at_once:
            submit(places, spec, overwrite=self.overwrite)
            return
        for place in places:
            made = finished(export_steps(place.sidecar, spec, place.out, overwrite=self.overwrite))
            self.report({"INFO"}, f"Exported {made.name} to {made.folder}: {size(made.bytes)}")


class RADTEX_OT_forget_export(bpy.types.Operator):
    """Do not make this export again after each bake. What was exported stays"""

    bl_idname = "radtex.forget_export"
    bl_label = "Forget Export"
    bl_options = {"REGISTER"}  # pushes its own undo step: see undo.py

    if TYPE_CHECKING:  # type of the property that Blender creates from the annotation below
        row: int
    else:
        row: IntProperty(name="Row", description="Its row on the list, from 0", min=0, options={"SKIP_SAVE"})

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        rows = rows_of(shown(context)[0])
        if self.row >= len(rows):
            self.report({"ERROR"}, "That export is not on the list any more")
            return {"CANCELLED"}
        rows.remove(self.row)
        mark_stale()
        push_step(self.bl_label)
        return {"FINISHED"}


def _is_there(folder: str) -> bool:
    """Whether a folder of an earlier file can be used in this one: `//` needs a file that was saved."""
    is_usable = bool(bpy.data.filepath) or not folder.startswith("//")
    return bool(folder) and is_usable and Path(bpy.path.abspath(folder)).is_dir()
