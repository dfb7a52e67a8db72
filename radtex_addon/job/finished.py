# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a bake is there as it was asked for, and which of what is made from it is not."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..bake.key import is_unfinished, replaced_by
from ..bake.spec import BakeSpec, Layer
from ..core.errors import FormatError
from ..core.shared import Axis
from ..export.folder import check_out, is_whole
from ..export.kinds import check_target
from ..export.run import check_writer
from ..formats.json_reader import Facts
from ..formats.packing import layer_names
from ..formats.shared_files import layer_path, texture_path
from ..formats.sidecar import read_facts
from ..forms import form_for, form_in
from ..textures.spec import Target
from .files import OutputFiles

_LAYERS = frozenset((*Layer, *layer_names(Axis), *layer_names(Axis, condensed=True)))


def is_finished(name: str, spec: BakeSpec, out: Path) -> bool:
    """Whether the folder holds such a bake, whole; False for a sidecar that cannot be read."""
    files = OutputFiles.of(name, spec, out, preview=False)
    if not files.sidecar.is_file() or is_unfinished(files.unfinished):
        return False
    try:
        facts = read_facts(files.sidecar)
        form = form_in(facts)
        return form is form_for(spec) and _is_of(facts, name, spec) and form.is_of(facts, spec)
    except FormatError:
        return False


def _is_of(facts: Facts, name: str, spec: BakeSpec) -> bool:
    """Whether a sidecar's facts are those that a specification asks for, but for what its form asks for."""
    part, source = (facts.inner(key).values if key in facts.values else {} for key in ("part", "source"))
    asked: dict[str, Any] = {
        "object": name,
        "frame": spec.frame,
        "lights": list(spec.lights) or None,
        "seed": spec.seed,
        "objects": list(spec.objects) or None,
        "ao_distance": spec.ao_distance,
    }
    if spec.uv_layer is not None:
        asked["uv_map"] = spec.uv_layer
    same = all(facts.values.get(key) == value for key, value in asked.items())
    same = same and (part.get("by"), part.get("name")) == (spec.split, spec.part)
    return same and source.get("object") == spec.source and max(facts.size("texels")) == spec.texels


def samples_of(files: OutputFiles) -> int | None:
    """How many samples a cell the bake has that is there; None where its sidecar cannot be read."""
    try:
        return read_facts(files.sidecar).whole_number("samples", 1)
    except FormatError:
        return None


def images_of(sidecar: Path) -> frozenset[Path]:
    """The images that the bake with this sidecar may have; none where there is no such bake.

    Only layers that RadTex writes count, whatever the sidecar names.
    """
    try:
        layers = set(read_facts(sidecar).texts("layers")) & _LAYERS
    except FormatError:
        return frozenset()
    named = (path_of(sidecar, layer) for layer in layers for path_of in (layer_path, texture_path))
    return frozenset((sidecar.with_suffix(".exr"), *named))


def misses_preview(files: OutputFiles) -> bool:
    """Whether a preview is wanted that is not there."""
    return files.preview is not None and not files.preview.is_file()


def missing_exports(files: OutputFiles, exports: Iterable[Target]) -> tuple[Target, ...]:
    """For whom of those a folder is wanted that is not there, or not whole."""
    return tuple(target for target in exports if not is_whole(files.export(target)))


def check_exports(
    spec: BakeSpec, files: OutputFiles, exports: Iterable[Target], overwrite: bool, resume: bool
) -> None:
    """Find out before a bake what an export of it would fail at behind it.

    Raises InputError for a target that does not show its kind, or that this installation cannot serve, and
    for a folder that would be lost, unless an unfinished bake that it is to `resume` may have made it.
    """
    begun = is_unfinished(files.unfinished)
    may = replaced_by(files.unfinished) if resume and begun else frozenset()
    was_there = is_there(files, overwrite, resume)
    for target in exports:
        place = files.export(target)
        check_target("the bake", spec.kind, target)
        if was_there and is_whole(place):
            continue  # it stays as it is
        check_writer(target)
        check_out(place, place.parent, overwrite or was_there or place.name in may)


def is_there(files: OutputFiles, overwrite: bool, resume: bool) -> bool:
    """Whether going on is with a bake that is there whole, to make what is missing beside it."""
    return resume and not overwrite and not is_unfinished(files.unfinished) and files.sidecar.exists()
