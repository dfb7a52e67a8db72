# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator that deletes finished bakes from the disk, after a dialog that lists the files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from ..jobs import jobs
from ..panel.fitting import draw_wrapped
from ..panel.labels import iface_, remark, size
from ..panel.panel_state import mark_stale
from .bake_lookup import originals
from .bake_operator import shown
from .export_dialog import WIDTH, shortened
from .export_sources import export_sources
from .operator_mixins import OfBake
from .undo import push_step

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Sequence

    from bpy.stub_internal.rna_enums import OperatorReturnItems

    from ...export.exporting import ExportSource
    from ...store.output_files import BakeFiles

_MOST = 12  # files that are listed by name
_MARGINS = 40.0  # of the dialog, in pixels at UI scale 1


class RADTEX_OT_delete_bake(OfBake, bpy.types.Operator):
    """Delete the bake's files, preview and exports beside it. The object stays, and what you changed"""

    bl_idname = "radtex.delete_bake"
    bl_label = "Delete Bake"
    bl_options = {"REGISTER"}  # pushes its own undo step: see undo.py

    if TYPE_CHECKING:
        _found: tuple[BakeFiles, ...]  # what the dialog lists
    else:
        _found = ()

    def invoke(
        self, context: bpy.types.Context | None, event: bpy.types.Event | None
    ) -> set[OperatorReturnItems]:
        """List the files, and ask."""
        from ...core.errors import RadTexError

        assert context is not None  # Blender always gives one
        assert context.window_manager is not None  # a click implies a window
        try:
            self.check_files()
            self._found = tuple(self._files(*shown(context)))
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        count = len(self._found)
        title = iface_("Delete This Bake?") if count == 1 else iface_("Delete {} Bakes?").format(count)
        return context.window_manager.invoke_props_dialog(
            self, width=WIDTH, title=title, confirm_text=iface_("Delete"), cancel_default=True
        )

    def draw(self, context: bpy.types.Context | None) -> None:
        column: Any = self.layout.column(align=True)  # type: ignore[union-attr]  # Blender sets it for drawing
        for line in told_files(self._found):
            draw_wrapped(column, line, "NONE", WIDTH - _MARGINS)
        column.separator()
        column.label(text="Exports in other folders stay. This cannot be undone", icon="ERROR")

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import InputError, RadTexError
        from ...store.output_files import delete_bake

        scene, layer = shown(context)
        try:
            self.check_files()
            found = self._files(scene, layer)
            if self._found and tuple(found) != self._found:
                raise InputError("the files have changed since they were listed: press Delete Bake again")
            _hide(scene, {path.resolve() for one in found for path in one.all})
            changed = [path for one in found for path in delete_bake(one)]
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        finally:
            mark_stale()
        _forget({one.sidecar for one in found})
        count = sum(len(one.all) for one in found)
        self.report({"INFO"}, f"Deleted {count} files and folders of {len(found)} bakes")
        if changed:
            some = ", ".join(map(shortened, changed[:_MOST]))
            told = f"{len(changed)} files stay: they were changed after the export: {some}"
            self.report({"WARNING"}, told)
        return {"FINISHED"}

    def _files(self, scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> list[BakeFiles]:
        """What there is of the bakes of all objects that have one.

        Raises RadTexError if none has, and for bakes that are being made or exported, or are not finished.
        """
        from ...core.errors import InputError, RadTexError
        from ...store.output_files import files_of_bakes

        sources: list[ExportSource] = []
        errors: list[RadTexError] = []
        names = [self.object] if self.object else [item.name for item in originals(layer, "", scene)]
        for name in names:
            try:
                sources += self._sources(scene, layer, name)
            except RadTexError as error:
                errors.append(error)
        if errors and not sources:
            raise errors[0]
        for source in sources:
            if _is_in_use(source.sidecar.path, source.bake.object_name):
                name = source.bake.object_name
                raise InputError(f"'{name}' is being baked or exported: wait for it, or cancel it")
        return files_of_bakes(sources)

    def _sources(
        self, scene: bpy.types.Scene, layer: bpy.types.ViewLayer, name: str
    ) -> Sequence[ExportSource]:
        """The bakes of an object; the one that `bake` names needs no object any more. Raises RadTexError."""
        from ...export.exporting import ExportSource

        bake = Path(bpy.path.abspath(self.bake)) if self.bake else None
        if bake is not None and bake.is_file():
            return [ExportSource.of(bake)]
        return export_sources(scene, layer, name, self.bake)


def told_files(found: Iterable[BakeFiles]) -> list[str]:
    """Lines on what is deleted: names, the folders that they are in, and the size of the files."""
    paths = [path for one in found for path in one.all]
    lines = [path.name for path in paths[:_MOST]]
    if more := len(paths) - len(lines):
        lines.append(iface_("and {} more").format(more))
    folders = ", ".join(sorted({shortened(path.parent) for path in paths}))
    return [*lines, iface_("{} in {}").format(size(sum(map(_bytes, paths))), folders)]


def _bytes(path: Path) -> int:
    """Bytes of a file, or of the files in a folder."""
    inside = path.rglob("*") if path.is_dir() else (path,)
    return sum(each.stat().st_size for each in inside if each.is_file())


def _hide(scene: bpy.types.Scene, files: Collection[Path]) -> None:
    """Show the objects again in whose place previews show one of these files: a step to undo."""
    from ...preview.save import images_of
    from ...preview.swap import copy_of, is_on, switch_off

    hidden = []
    for item in scene.objects:
        copy = copy_of(item) if is_on(item) else None
        if copy is None or copy == item:
            continue
        trees = [slot.material.node_tree for slot in copy.material_slots if slot.material is not None]
        images = {image for tree in trees for image in images_of(tree)}
        if any(Path(bpy.path.abspath(image.filepath)).resolve() in files for image in images):
            hidden.append(item)
    for item in hidden:
        switch_off(item)
    if hidden:
        push_step("Show the Object")


def _is_in_use(sidecar: Path, name: str) -> bool:
    """Whether a job that has not ended makes or exports the bake with this sidecar."""
    from ...worker.order import Work

    for job in (each for each in jobs.snapshot() if not each.ended):
        is_baked = job.work is Work.BAKE and job.object == name
        if is_baked and job.out.absolute() == sidecar.parent.absolute():
            return True
        if job.work is Work.EXPORT and str(sidecar.absolute()) in job.order.facts["sidecars"]:
            return True
    return False


def _forget(sidecars: set[Path]) -> None:
    """Take the jobs that made these bakes off the list: their buttons are about files that are gone."""
    for job in jobs.snapshot():
        if job.ended and not sidecars.isdisjoint(job.files):
            jobs.forget_ended(job.number)
