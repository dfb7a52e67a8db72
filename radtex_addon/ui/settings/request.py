# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake request made from the settings: validated, and independent of Blender's properties."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import bpy

from ...bake.frame_numbers import parse_frames
from ...core.errors import InputError
from ...core.sampler import Filter
from ...job.bake_request import BakeRequest
from ...scene.lights.lamps import EACH
from ...store.ownership import blend_folder_name, former_folder, open_blend
from ...textures.export_spec import Target
from .output_settings import DEFAULT_FOLDER
from .preferences import preferred
from .surfaces import shared_name
from .values import open_layout_of, spec_of, values_of, values_with

__all__ = [
    "former_places",
    "has_folder",
    "output_folder",
    "request_of",
    "spec_of",
    "values_of",
    "values_with",
]


def request_of(values: Mapping[str, Any], names: Sequence[str]) -> BakeRequest:
    """The request to bake the objects `names` by `values` (by setting name).

    Raises InputError for invalid settings.
    """
    spec = spec_of(values)
    targets = tuple(target for target in Target if target.value in values["export_targets"])
    if targets and not values["preview"]:
        raise InputError("an export is made from the preview: switch Preview on, or the export off")
    return BakeRequest(
        objects=tuple(names),
        spec=spec,
        folder=output_folder(values["directory"], preferred().output),
        former=former_places(values["directory"]),
        shared=shared_name(values, spec) if len(names) > 1 else None,
        preview=Filter.QUADRILINEAR if values["preview"] else None,
        overwrite=values["overwrite"],
        resume=values["resume"],
        exports=targets,
        frames=parse_frames(values["frames"]) if values["variants"] == "frames" else (),
        lights=((EACH,),) if values["variants"] == "lamps" else (),
        open_layout=open_layout_of(values),
    )


def output_folder(directory: str, instead: Path | None) -> Path:
    """The absolute path of `directory`; `instead` if that is empty, or relative to an unsaved file.

    `{blend_name}` in it becomes the name of the file's own folder of bakes. Raises InputError if neither can
    be used.
    """
    if directory.strip() and (bpy.data.filepath or not directory.startswith("//")):
        own = blend_folder_name(open_blend()) if bpy.data.filepath else "untitled"
        return Path(bpy.path.abspath(directory.replace("{blend_name}", own)))
    if instead is not None:
        return instead
    if not directory.strip():
        raise InputError("no output folder is chosen: choose one")
    raise InputError("this file was never saved: save it, or choose a folder for its bakes")


def former_places(directory: str) -> tuple[Path, ...]:
    """Where earlier versions left bakes, if `directory` is the default: there they are still found."""
    if directory != DEFAULT_FOLDER or not bpy.data.filepath:
        return ()
    return (former_folder(open_blend()),)


def has_folder(values: Mapping[str, Any]) -> bool:
    """Whether `values` or the preferences name a usable output folder."""
    try:
        output_folder(values["directory"], preferred().output)
    except InputError:
        return False
    return True
