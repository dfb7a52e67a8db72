# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Delete a finished bake: its files, its preview and the exports beside it, and nothing else."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from ..bake.key import is_unfinished
from ..core.errors import BakeError, FormatError, InputError
from ..core.messages import Setting, do
from ..export.earlier_export import earlier_manifest
from ..export.exporting import ExportSource
from ..export.folder import remove_export
from ..textures.export_spec import Target
from .existing_bakes import images_of


@dataclass(frozen=True)
class BakeFiles:
    """What there is of a bake: `sidecar`, images and preview, and the folders of its `exports` beside it."""

    sidecar: Path
    files: tuple[Path, ...]
    exports: tuple[Path, ...]

    @property
    def all(self) -> tuple[Path, ...]:
        """All of them, the sidecar first."""
        return (self.sidecar, *self.files, *self.exports)


def files_of_bakes(bakes: Iterable[ExportSource]) -> list[BakeFiles]:
    """What there is of each bake. A preview that is also that of a bake which stays is left out.

    Raises InputError for a bake that is not finished.
    """
    sources = {source.sidecar.path: source for source in bakes}
    found = []
    for sidecar, source in sources.items():
        if is_unfinished(sidecar.with_suffix(".radtex-unfinished")):
            raise InputError(
                f"the bake of '{source.bake.object_name}' is not finished",
                do("go on with it", Setting.RESUME),
                do("bake it anew", Setting.OVERWRITE),
            )
        files = sorted(path for path in images_of(sidecar) if path.is_file())
        others = _others_with_preview(source) - sources.keys()
        if source.preview.is_file() and not others:
            files.append(source.preview)
        exports = [folder for target in Target if _is_of(source, folder := source.folder(target))]
        found.append(BakeFiles(sidecar, tuple(files), tuple(exports)))
    return found


def delete_bake(files: BakeFiles) -> list[Path]:
    """Delete a bake. The sidecar goes first: what is left after an interruption is no bake any more.

    Files in the exports' folders that no export wrote stay, and those that were changed after the export,
    which are returned. Raises BakeError where the system refuses.
    """
    try:
        for path in (files.sidecar, *files.files):
            path.unlink(missing_ok=True)
        return [path for folder in files.exports for path in remove_export(folder)]
    except OSError as error:
        raise BakeError(
            f"{error.filename} cannot be deleted ({error.strerror}): close what uses it, and try again"
        ) from error


def _others_with_preview(source: ExportSource) -> set[Path]:
    """The sidecars of other bakes beside a bake whose preview is the same file: parts, and other kinds.

    A file of such a name that cannot be read counts: it may be of a newer RadTex.
    """
    found = set()
    for path in source.sidecar.path.parent.glob("*.json"):
        try:
            is_other = path != source.sidecar.path and ExportSource.of(path).preview == source.preview
        except FormatError:
            is_other = path.name.startswith(source.preview.name.removesuffix("preview.blend"))
        if is_other:
            found.add(path)
    return found


def _is_of(source: ExportSource, folder: Path) -> bool:
    """Whether a folder is an export of a bake by this name and of this kind."""
    manifest = earlier_manifest(source, folder)
    return manifest is not None and manifest.bake.get("kind") == source.bake.kind
