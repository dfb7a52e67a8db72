# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find out whether a bake is finished, and whether its preview or exports are missing."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..bake.key import is_unfinished, replaced_by
from ..bake.options import MARKED
from ..bake.spec import BakeSpec, Layer
from ..core.errors import FormatError
from ..export.exporting import check_writer
from ..export.folder import check_out, is_whole
from ..export.target_checks import check_target
from ..formats.image_files import layer_path
from ..formats.json_reader import Facts
from ..formats.sidecar import density_in
from ..formats.sidecar_file import read_facts
from ..forms import form_for, form_in
from ..forms.layered.files.arrangement import CHANNELS as LAYERED
from ..textures.export_spec import Target
from .output_files import OutputFiles

_FORMER = (  # of the layouts that this RadTex no longer reads
    "surroundings",
    *(
        f"{lobe}_{part}"
        for lobe in ("mirror", "through")
        for part in ("weights", "ends", "ends_xy", "ends_zs", "gain", "rest")
    ),
)
_LAYERS = frozenset((*Layer, *LAYERED, *_FORMER))


def has_begun(name: str, spec: BakeSpec, out: Path) -> bool:
    """Whether the folder `out` holds an unfinished bake by the name of this one."""
    return is_unfinished(OutputFiles.of(name, spec, out, preview=False).unfinished)


def is_baked(name: str, spec: BakeSpec, out: Path) -> bool:
    """Whether the folder `out` holds a sidecar by the name of this one's."""
    return OutputFiles.of(name, spec, out, preview=False).sidecar.is_file()


def is_finished(name: str, spec: BakeSpec, out: Path) -> bool:
    """Whether the folder `out` holds a finished bake of `spec`; False if its sidecar cannot be read."""
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
    """Whether a sidecar's facts match a specification; `Form.is_of` compares the other facts."""
    part, source = (facts.inner(key).values if key in facts.values else {} for key in ("part", "source"))
    asked: dict[str, Any] = {
        "object": name,
        "frame": spec.frame,
        "lights": list(spec.lights) or None,
        "seed": spec.seed,
        "objects": list(spec.objects) or None,
        "ao_distance": spec.ao_distance,
        **{name: name in spec.marks or None for name in MARKED},
    }
    if spec.uv_layer is not None:
        asked["uv_map"] = spec.uv_layer
    same = all(facts.values.get(key) == value for key, value in asked.items())
    same = same and (part.get("by"), part.get("name")) == (spec.split, spec.part)
    return same and source.get("object") == spec.source and _has_size(facts, spec)


def _has_size(facts: Facts, spec: BakeSpec) -> bool:
    """Whether the atlas has the density that is asked for, or was baked without one and has the texels."""
    density = density_in(facts)
    if density is not None or spec.density is not None:
        if density is None or spec.density is None:
            return False
        return math.isclose(density.asked, spec.density, rel_tol=1e-6)  # the panel's is a float32
    return max(facts.size("texels")) == spec.texels


def samples_of(files: OutputFiles) -> int | None:
    """Samples per cell of the existing bake; None if its sidecar cannot be read."""
    try:
        return read_facts(files.sidecar).whole_number("samples", 1)
    except FormatError:
        return None


def images_of(sidecar: Path) -> frozenset[Path]:
    """The images that the existing bake with this sidecar may have; none if it cannot be read.

    Layers in the sidecar that RadTex does not write are ignored.
    """
    try:
        layers = set(read_facts(sidecar).texts("layers")) & _LAYERS
    except FormatError:
        return frozenset()
    named = (layer_path(sidecar, layer) for layer in layers)
    textures = (sidecar.with_name(f"{sidecar.stem}.{layer}.dds") for layer in layers)  # of former layouts
    return frozenset((sidecar.with_suffix(".exr"), *named, *textures))


def misses_preview(files: OutputFiles) -> bool:
    """Whether a preview is wanted but missing."""
    return files.preview is not None and not files.preview.is_file()


def missing_exports(files: OutputFiles, exports: Iterable[Target]) -> tuple[Target, ...]:
    """Those of the `exports` whose folder is missing or incomplete."""
    return tuple(target for target in exports if not is_whole(files.export(target)))


def check_exports(
    spec: BakeSpec, files: OutputFiles, exports: Iterable[Target], overwrite: bool, resume: bool
) -> None:
    """Check before a bake what would make its exports fail after it.

    Raises InputError for a target that does not support the bake's kind or that this installation cannot
    write, and for a folder that would be lost, unless the unfinished bake to `resume` may have written it.
    """
    begun = is_unfinished(files.unfinished)
    may = replaced_by(files.unfinished) if resume and begun else frozenset()
    was_finished = is_there(files, overwrite, resume)
    for target in exports:
        place = files.export(target)
        check_target("the bake", spec.kind, target)
        if was_finished and is_whole(place):
            continue  # it is not exported again
        check_writer(target)
        check_out(place, place.parent, overwrite or was_finished or place.name in may)


def is_there(files: OutputFiles, overwrite: bool, resume: bool) -> bool:
    """Whether resuming finds a finished bake, so that only a missing preview or exports are made."""
    return resume and not overwrite and not is_unfinished(files.unfinished) and files.sidecar.exists()
