# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Going on with a bake that did not come to its end."""

from __future__ import annotations

from dataclasses import fields

import bpy

from ..bake.checkpoint import DIGEST, Checkpoint, is_unfinished, replaced_by
from ..bake.spec import BakeSpec
from ..core.errors import InputError
from ..formats.atomic import check_absent
from ..formats.condensed_files import digest
from ..version import VERSION
from .files import OutputFiles

# Of a specification: tiles may be of any height; device and frame are compared as they were found.
_MAY_DIFFER = ("memory_mb", "device", "frame")


def open_checkpoint(name: str, spec: BakeSpec, files: OutputFiles, resume: bool) -> Checkpoint:
    """Where the pieces of a bake of the object `name` are kept.

    Raises InputError where it is to `resume` one that differs.
    """
    checkpoint = Checkpoint(files.unfinished, resume, files.all)
    chosen = {
        field.name.replace("_", " "): str(getattr(spec, field.name))
        for field in fields(spec)
        if field.name not in _MAY_DIFFER
    }
    versions = {"RadTex's version": VERSION, "Blender's version": bpy.app.version_string}
    checkpoint.expect({"object": name, **versions, **chosen})
    if (spec.accumulate or spec.refresh) and files.atlas.is_file():
        checkpoint.expect({"the atlas that is there": DIGEST + digest(files.atlas)})
    return checkpoint


def check_files(name: str, spec: BakeSpec, files: OutputFiles, overwrite: bool, resume: bool) -> None:
    """Make sure that a bake destroys nothing that it may not, an unfinished bake among it.

    Raises InputError, which says what to do, also where it is to `resume` one that differs.
    """
    earlier = spec.accumulate or spec.refresh
    if earlier and not files.sidecar.exists():
        done = "accumulate onto" if spec.accumulate else "refresh"
        raise InputError(f"{files.sidecar} is not there to {done}: bake it first, without that")
    if not is_unfinished(files.unfinished):
        if resume and not overwrite and files.sidecar.exists():
            raise InputError(
                f"{files.sidecar} is already there, and nothing of object '{name}' is unfinished: "
                "leave --resume out, and bake it anew (--overwrite)"
            )
        check_absent(files.all, overwrite or earlier)
        return
    if not resume and not overwrite:
        raise InputError(
            f"{files.unfinished} holds an unfinished bake: go on with it (--resume), "
            "or begin anew (--overwrite)"
        )
    if resume:
        open_checkpoint(name, spec, files, resume)
    may = replaced_by(files.unfinished) if resume else frozenset()
    check_absent([path for path in files.all if path.name not in may], overwrite or earlier)
    check_absent([path for path in files.all if path.name in may], overwrite=True)
