# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Open the checkpoint of a bake to resume it, and make sure that no bake loses files or another bake."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import bpy

from ..bake.checkpoint import Checkpoint, remove_left
from ..bake.key import DIGEST, check_free, is_announced, is_unfinished, replaced_by
from ..bake.spec import BakeSpec
from ..bake.spec_facts import key_facts
from ..core.errors import FormatError, InputError
from ..core.messages import Setting, do, leave_out
from ..formats.disk.atomic import check_absent
from ..formats.disk.file_digest import digest
from ..formats.sidecar import part_in
from ..formats.sidecar_file import read_facts
from ..textures.export_spec import Target
from ..version import VERSION
from .existing_bakes import is_finished, misses_preview, missing_exports, samples_of
from .output_files import OutputFiles
from .replaced_bake import Overwrite, check_replaces_no_better, check_same_subject


def open_checkpoint(
    name: str,
    spec: BakeSpec,
    files: OutputFiles,
    resume: bool,
    overwrite: bool | Overwrite = False,
    exports: Collection[Target] = (),
) -> Checkpoint:
    """Open the checkpoint of a bake of the object `name`; it lasts until the `exports` are made, too.

    At its first piece it checks again that it replaces no files that it may not. Raises InputError if the
    bake to `resume` differs.
    """
    overwrite = Overwrite.of(overwrite)
    goes_on = resume and (is_unfinished(files.unfinished) or files.sidecar.exists())
    earlier: str | None = None

    def check() -> None:
        if not goes_on:
            _check_meanwhile(name, spec, files, overwrite, earlier)

    replaces = [*files.own, *(files.export(target) for target in exports)]
    checkpoint = Checkpoint(files.unfinished, resume, replaces, check, overwrite.blend.name)
    versions = {"RadTex's version": VERSION, "Blender's version": bpy.app.version_string}
    checkpoint.set_facts({"object": name, **versions, **key_facts(spec)})
    folds = (spec.accumulate or spec.refresh) and checkpoint.made is None  # else it may be replaced already
    if folds and files.atlas.is_file():
        earlier = digest(files.atlas)
        checkpoint.set_facts({"the atlas that is there": DIGEST + earlier})
    return checkpoint


def check_files(
    name: str,
    spec: BakeSpec,
    files: OutputFiles,
    overwrite: bool | Overwrite,
    resume: bool,
    exports: Collection[Target] = (),
) -> None:
    """Make sure that a bake replaces no files that it may not, and no unfinished bake.

    Raises InputError, which says what to do; also if the bake to `resume` differs, or is finished with its
    preview and its `exports`.
    """
    overwrite = Overwrite.of(overwrite)
    check_folder(files.unfinished)
    check_same_subject(name, spec, files)
    earlier = spec.accumulate or spec.refresh
    if earlier and not files.sidecar.exists():
        done = "accumulate onto" if spec.accumulate else "refresh"
        raise InputError(f"{files.sidecar} is not there to {done}: bake it first, without that")
    if not is_unfinished(files.unfinished):
        if resume:
            remove_left(files.unfinished)  # of a bake that was killed while it cleaned up
        if resume and not overwrite and files.sidecar.exists():
            lacks = misses_preview(files) or missing_exports(files, exports)
            if lacks and not earlier and is_finished(name, spec, files.sidecar.parent):
                return
            raise _nothing_unfinished(spec, name, files)
        _check_replaced(name, spec, files, overwrite)
        return
    check_free(files.unfinished)
    if not resume and not overwrite and not is_announced(files.unfinished):
        raise _unfinished(files)
    if resume:
        open_checkpoint(name, spec, files, resume)
    else:
        _check_replaced(name, spec, files, overwrite)
    may = replaced_by(files.unfinished) if resume else frozenset()
    check_absent([path for path in files.own if path.name not in may], bool(overwrite or earlier))
    check_absent([path for path in files.own if path.name in may], overwrite=True)


def _check_replaced(name: str, spec: BakeSpec, files: OutputFiles, overwrite: Overwrite) -> None:
    """Make sure that a bake that does not go on with another replaces nothing that it may not."""
    earlier = spec.accumulate or spec.refresh
    check_absent(files.own, bool(overwrite or earlier))
    check_replaces_no_better(spec, files, overwrite)
    _check_common(name, spec, files, overwrite)


def _check_meanwhile(
    name: str, spec: BakeSpec, files: OutputFiles, overwrite: Overwrite, earlier: str | None
) -> None:
    """Check again, now with the lock held, as other processes may have written files since `check_files`.

    `earlier` is the digest that the atlas to accumulate onto or to refresh had. Raises InputError.
    """
    announced = is_announced(files.unfinished)
    if is_unfinished(files.unfinished) and not (overwrite or announced):
        raise _unfinished(files)
    if earlier is not None and digest(files.atlas) != earlier:
        raise InputError(f"{files.atlas} has changed since this bake began: start it again")
    check_same_subject(name, spec, files)
    check_absent(files.own, bool(overwrite) or earlier is not None)
    check_replaces_no_better(spec, files, overwrite)
    _check_common(name, spec, files, overwrite)


def _unfinished(files: OutputFiles) -> InputError:
    return InputError(
        f"{files.unfinished} holds an unfinished bake",
        do("go on with it", Setting.RESUME),
        do("begin anew", Setting.OVERWRITE),
    )


def _nothing_unfinished(spec: BakeSpec, name: str, files: OutputFiles) -> InputError:
    found = f"{files.sidecar} is already there, and nothing of object '{name}' is unfinished"
    if spec.refresh:
        return InputError(found, leave_out(Setting.RESUME, to="to refresh it"))
    if spec.accumulate and (samples := samples_of(files)) is not None:
        return InputError(
            f"{found}; it has {samples} samples a cell", leave_out(Setting.RESUME, to="for more")
        )
    return InputError(found, do("bake it anew", Setting.OVERWRITE))


def check_folder(unfinished: Path) -> None:
    """Raises InputError if it is a file, or a link: pieces would be written and deleted behind it."""
    if unfinished.is_symlink() or (unfinished.exists() and not unfinished.is_dir()):
        raise InputError(
            f"{unfinished} is a file, or a link, where a folder must go: move it, or choose another folder"
        )


def _check_common(name: str, spec: BakeSpec, files: OutputFiles, overwrite: Overwrite) -> None:
    """Make sure that an existing preview that parts share is one of this object's parts.

    Raises InputError if no sidecar of such a part lies beside it.
    """
    shown = files.preview
    if shown is None or files.preview_is_own or overwrite or not shown.exists():
        return
    if not any(_is_sibling(path, name, spec) for path in shown.parent.glob(f"*.{spec.kind}.json")):
        raise InputError(
            f"{shown} is already there, and shows no {spec.kind} of '{name}'",
            do("overwrite it", Setting.OVERWRITE),
            do("choose another folder", Setting.OUT),
        )


def _is_sibling(sidecar: Path, name: str, spec: BakeSpec) -> bool:
    """Whether the sidecar is of a part that shares its preview with a bake of `spec`."""
    try:
        facts = read_facts(sidecar)
        part = part_in(facts)
    except FormatError:
        return False
    found = facts.values
    same = (found.get("object"), found.get("frame"), found.get("lights", []))
    return part is not None and part.by == spec.split and same == (name, spec.frame, list(spec.lights))
