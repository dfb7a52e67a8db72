# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator that shows a finished bake in the user's browser, exporting it for the web first where needed."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy.props import StringProperty

from ..jobs import browser, jobs
from ..panel.labels import remark
from .bake_lookup import in_object_mode
from .bake_operator import shown
from .export_sources import export_sources, place_for, submit
from .operator_mixins import MayWait, OfBake

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bpy.stub_internal.rna_enums import OperatorReturnItems

    from ...export.exporting import ExportSource
    from ...textures.export_spec import ExportSpec
    from ...worker.job import Job

_log = logging.getLogger(__name__)

_MOST_PAGES = 8  # that one click opens


class RADTEX_OT_show_in_browser(MayWait, OfBake, bpy.types.Operator):
    """Show the bake as a web page, to turn and to inspect. Exported first, if it is new or was baked again"""

    bl_idname = "radtex.show_in_browser"
    bl_label = "Show in Browser"
    bl_options = {"REGISTER"}

    if TYPE_CHECKING:  # type of the property that Blender creates from the annotation below
        directory: str
    else:
        directory: StringProperty(
            name="Folder",
            description="A folder that was exported for the web, to be shown as it is. Left empty, the "
            "object's bake is shown",
            subtype="DIR_PATH",
            options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
        )

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        """Whether Blender is in Object Mode; nothing needs to be selected, since `object` may be given."""
        return in_object_mode(cls, context)

    @classmethod
    def unregister(cls) -> None:
        """Called by Blender when RadTex is disabled."""
        browser.end_server()

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import RadTexError

        try:
            self.check_files()
            if self.directory:
                self._open(_checked_page(Path(bpy.path.abspath(self.directory))))
            else:
                self._show(export_sources(*shown(context), self.object, self.bake))
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def _show(self, sources: Sequence[ExportSource]) -> None:
        """Open the pages of the bakes, once those that are missing or outdated are exported."""
        from ...core.errors import InputError
        from ...export.exporting import current_manifest
        from ...textures.export_spec import Target

        if len(sources) > _MOST_PAGES:
            raise InputError(f"{len(sources)} pages would open: select {_MOST_PAGES} objects at most")
        pages = [(source, source.folder(Target.WEB)) for source in sources]
        if busy := [out.name for _, out in pages if _is_being_exported(out)]:
            raise InputError(f"{busy[0]} is being exported: wait until that is done, then press again")
        for source, out in pages:
            if current_manifest(source, out) is not None:
                self._open(out)
            else:
                self._export(source, out)

    def _export(self, source: ExportSource, out: Path) -> None:
        """Export a bake and open it, here and now or when the job is done. Raises RadTexError."""
        from ...bake.progress import finished
        from ...export.exporting import check_export, export_steps

        spec = _spec_like_before(source, out)
        check_export(source, spec, out, overwrite=True)
        if self.at_once:
            self._open(finished(export_steps(source.sidecar, spec, out, overwrite=True)).folder)
            return
        submit([place_for(source, out)], spec, overwrite=True, completion=jobs.Completion(open_exported))
        self.report({"INFO"}, f"{out.name} is exported first, and opens when that is done")

    def _open(self, folder: Path) -> None:
        address, has_browser = browser.open_page(folder)
        if has_browser:
            self.report({"INFO"}, f"{folder.name} is shown at {address} while Blender runs")
        else:
            self.report({"WARNING"}, f"No browser was found: open {address} in one, while Blender runs")


def open_exported(job: Job) -> None:
    """Open what a job has exported."""
    from ...core.errors import RadTexError

    for folder in job.files:
        try:
            address, has_browser = browser.open_page(folder)
        except RadTexError as error:
            _log.warning("%s", error)
            continue
        if not has_browser:
            _log.warning("no browser was found: open %s in one, while Blender runs", address)


def _spec_like_before(source: ExportSource, out: Path) -> ExportSpec:
    """How to export for the web: with the layers and the mirror ball of an export that is replaced."""
    from ...export.exporting import earlier_manifest
    from ...settings.choices import parse_layer
    from ...textures.export_spec import ExportSpec, Target

    earlier = earlier_manifest(source, out)
    if earlier is None:
        return ExportSpec(Target.WEB)
    layers = source.bake.layers if source.form.traits.layers else ()
    kept = tuple(parse_layer(layer) for layer in layers if layer in earlier.textures)
    return ExportSpec(Target.WEB, layers=kept, mirror=earlier.mirror is not None)


def _is_being_exported(out: Path) -> bool:
    """Whether a job that has not ended writes this folder."""
    from ...worker.order import Work

    exports = [job.order.facts for job in jobs.snapshot() if not job.ended and job.work is Work.EXPORT]
    return any(str(out.absolute()) in facts["folders"] for facts in exports)


def _checked_page(folder: Path) -> Path:
    """The folder. Raises InputError if it is no export for the web."""
    from ...core.errors import InputError
    from ...export.folder import is_export

    if not (is_export(folder) and (folder / "index.html").is_file()):
        raise InputError(f"{folder} holds no web page: export the bake for Web first")
    return folder
