# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Going on with a bake that did not come to its end."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import fields
from pathlib import Path

import bpy

from ..bake.checkpoint import Checkpoint, remove_left
from ..bake.key import DIGEST, check_free, is_announced, is_unfinished, replaced_by
from ..bake.spec import BakeSpec
from ..core.errors import FormatError, InputError
from ..formats.condensed_files import digest
from ..formats.disk.atomic import check_absent
from ..formats.sidecar import part_in, read_facts
from ..textures.spec import Target
from ..version import VERSION
from .files import OutputFiles
from .finished import is_finished, misses_preview, missing_exports, samples_of

# Of a specification: tiles may be of any height; device and frame are compared as they were found.
_MAY_DIFFER = ("memory_mb", "device", "frame")
# What the scene's own digests call by the same word.
_CALLED = {"objects": "objects that share the atlas", "lights": "lamps that are lit"}


def open_checkpoint(
    name: str,
    spec: BakeSpec,
    files: OutputFiles,
    resume: bool,
    overwrite: bool = False,
    exports: Collection[Target] = (),
) -> Checkpoint:
    """Where the pieces of a bake of the object `name` are kept, until its `exports` are made, too.

    It looks once more, at its first piece, whether it would replace what may not be. Raises InputError where
    it is to `resume` one that differs.
    """
    goes_on = resume and (is_unfinished(files.unfinished) or files.sidecar.exists())
    earlier: str | None = None

    def check() -> None:
        if not goes_on:
            _check_meanwhile(name, spec, files, overwrite, earlier)

    replaces = [*files.own, *(files.export(target) for target in exports)]
    checkpoint = Checkpoint(files.unfinished, resume, replaces, check)
    chosen = {
        _CALLED.get(field.name, field.name.replace("_", " ")): str(getattr(spec, field.name))
        for field in fields(spec)
        if field.name not in _MAY_DIFFER
    }
    versions = {"RadTex's version": VERSION, "Blender's version": bpy.app.version_string}
    checkpoint.set_facts({"object": name, **versions, **chosen})
    folds = (spec.accumulate or spec.refresh) and checkpoint.made is None  # else it is there already
    if folds and files.atlas.is_file():
        earlier = digest(files.atlas)
        checkpoint.set_facts({"the atlas that is there": DIGEST + earlier})
    return checkpoint


def check_files(
    name: str,
    spec: BakeSpec,
    files: OutputFiles,
    overwrite: bool,
    resume: bool,
    exports: Collection[Target] = (),
) -> None:
    """Make sure that a bake destroys nothing that it may not, an unfinished bake among it.

    Raises InputError, which says what to do, also where it is to `resume` one that differs, or one that is
    finished, with its preview and its `exports`.
    """
    _check_folder(files.unfinished)
    earlier = spec.accumulate or spec.refresh
    if earlier and not files.sidecar.exists():
        done = "accumulate onto" if spec.accumulate else "refresh"
        raise InputError(f"{files.sidecar} is not there to {done}: bake it first, without that")
    if not is_unfinished(files.unfinished):
        if resume:
            remove_left(files.unfinished)  # the bake was killed at its very end
        if resume and not overwrite and files.sidecar.exists():
            lacks = misses_preview(files) or missing_exports(files, exports)
            if lacks and not earlier and is_finished(name, spec, files.sidecar.parent):
                return
            raise InputError(_nothing_unfinished(name, spec, files))
        check_absent(files.own, overwrite or earlier)
        _check_common(name, spec, files, overwrite)
        return
    check_free(files.unfinished)
    if not resume and not overwrite and not is_announced(files.unfinished):
        raise _unfinished(files)
    if resume:
        open_checkpoint(name, spec, files, resume)
    else:
        _check_common(name, spec, files, overwrite)
    may = replaced_by(files.unfinished) if resume else frozenset()
    check_absent([path for path in files.own if path.name not in may], overwrite or earlier)
    check_absent([path for path in files.own if path.name in may], overwrite=True)


def _check_meanwhile(
    name: str, spec: BakeSpec, files: OutputFiles, overwrite: bool, earlier: str | None
) -> None:
    """Make sure, where nobody else can write any more, that nobody has since `check_files` looked.

    `earlier` is the digest of the atlas that there was to go on from. Raises InputError.
    """
    announced = is_announced(files.unfinished)
    if is_unfinished(files.unfinished) and not (overwrite or announced):
        raise _unfinished(files)
    if earlier is not None and digest(files.atlas) != earlier:
        raise InputError(f"{files.atlas} has changed since this bake began: start it again")
    check_absent(files.own, overwrite or earlier is not None)
    _check_common(name, spec, files, overwrite)


def _unfinished(files: OutputFiles) -> InputError:
    return InputError(
        f"{files.unfinished} holds an unfinished bake: go on with it (--resume), or begin anew (--overwrite)"
    )


def _nothing_unfinished(name: str, spec: BakeSpec, files: OutputFiles) -> str:
    found = f"{files.sidecar} is already there, and nothing of object '{name}' is unfinished: "
    if spec.refresh:
        return found + "leave --resume out to refresh it"
    if spec.accumulate and (samples := samples_of(files)) is not None:
        return found + f"it has {samples} samples a cell; if more are wanted, leave --resume out"
    return found + "leave --resume out, and bake it anew (--overwrite)"


def _check_folder(unfinished: Path) -> None:
    """Raises InputError for a link, behind which pieces would be removed and written."""
    if unfinished.is_symlink() or (unfinished.exists() and not unfinished.is_dir()):
        raise InputError(
            f"{unfinished} is a file, or a link, where a folder must go: move it, or choose another folder"
        )


def _check_common(name: str, spec: BakeSpec, files: OutputFiles, overwrite: bool) -> None:
    """Leave a preview that parts have in common to them, unless such parts as this one made it.

    Raises InputError where none of them lies beside it.
    """
    shown = files.preview
    if shown is None or files.preview_is_own or overwrite or not shown.exists():
        return
    if not any(_is_sibling(path, name, spec) for path in shown.parent.glob(f"*.{spec.kind}.json")):
        raise InputError(
            f"{shown} is already there, and shows no {spec.kind} of '{name}': "
            "overwrite it (--overwrite), or choose another folder"
        )


def _is_sibling(sidecar: Path, name: str, spec: BakeSpec) -> bool:
    """Whether it is of a part that has its preview in common with what `spec` asks for."""
    try:
        facts = read_facts(sidecar)
        part = part_in(facts)
    except FormatError:
        return False
    found = facts.values
    same = (found.get("object"), found.get("frame"), found.get("lights", []))
    return part is not None and part.by == spec.split and same == (name, spec.frame, list(spec.lights))
