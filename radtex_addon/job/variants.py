# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of one object that differ in their frame, light or part: their names, and which are finished."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil, isqrt, sqrt
from pathlib import Path
from typing import Any, TypeAlias

from ..bake.key import is_unfinished
from ..bake.plan import MAX_IMAGE_SIDE
from ..bake.spec import BakeSpec, Kind
from ..core.errors import FormatError, InputError
from ..formats.sidecar import file_name, part_in, read_facts
from .files import OutputFiles

Bake: TypeAlias = tuple[str, BakeSpec]  # of an object, or an atlas, by name

_KEYS = ("frame", "lights")  # of a sidecar that is a variant's


def variant_of(spec: BakeSpec) -> str:
    """The frame and the lamps that tell a bake from others of the same surface and kind, in words."""
    words = [] if spec.frame is None else [f"frame {spec.frame}"]
    if spec.lights:
        words.append(f"light of {', '.join(spec.lights)}")
    return ", ".join(words)


def left_to_do(bakes: Sequence[Bake], out: Path) -> tuple[Bake, ...]:
    """Those of several bakes into the folder `out` that going on makes: all that are not finished.

    Of atlases that get more samples, or are refreshed, nothing tells which were already: the unfinished ones
    alone. Raises InputError where none of these is unfinished.
    """
    again = [spec for _, spec in bakes if spec.accumulate or spec.refresh]
    if not again:
        return tuple(bake for bake in bakes if not is_finished(*bake, out))
    found = tuple(
        (name, spec)
        for name, spec in bakes
        if is_unfinished(OutputFiles.of(name, spec, out, preview=False).unfinished)
    )
    if not found:
        names = ", ".join(f"'{name}'" for name in dict.fromkeys(name for name, _ in bakes))
        raise InputError(
            f"no bake of {names} is unfinished, and nothing tells which of them were {_done(again[0])} "
            f"already: leave --resume out, and name those that lack (--part, --frames, --lights)"
        )
    return found


def passed_over(bakes: Sequence[Bake], left: Sequence[Bake]) -> str:
    """What to know where going on leaves out some that may lack samples, or light; empty if none."""
    again = [spec for _, spec in bakes if spec.accumulate or spec.refresh]
    if not again or len(left) == len(bakes):
        return ""
    return (
        f"{len(left)} of {len(bakes)} bakes go on, those that are unfinished; whether the others were "
        f"{_done(again[0])} nothing tells: they stay as they are"
    )


def _done(spec: BakeSpec) -> str:
    return "accumulated" if spec.accumulate else "refreshed"


def is_finished(name: str, spec: BakeSpec, out: Path) -> bool:
    """Whether the folder holds such a bake, whole."""
    files = OutputFiles.of(name, spec, out, preview=False)
    if not files.sidecar.is_file() or is_unfinished(files.unfinished):
        return False
    found = read_facts(files.sidecar).values
    part = found.get("part", {})
    asked = {
        "object": name,
        "frame": spec.frame,
        "lights": list(spec.lights) or None,
        "seed": spec.seed,
        "objects": list(spec.objects) or None,
        "ao_distance": spec.ao_distance,
    }
    same_part = (part.get("by"), part.get("name")) == (spec.split, spec.part)
    same = same_part and all(found.get(key) == value for key, value in asked.items())
    return same and _has_samples(found, spec)


def _has_samples(found: Mapping[str, Any], spec: BakeSpec) -> bool:
    """Whether a sidecar says that all samples were taken; that of `ao` counts the rays of its one cell."""
    samples, cells = int(found.get("samples", 0)), spec.bucket**2
    if spec.kind is not Kind.AO:
        return samples == spec.samples
    if spec.ao_distance is None:
        return samples == cells * spec.samples
    wanted, had = ceil(sqrt(spec.samples)), isqrt(samples // cells)  # a square of rays in each cell
    if samples != cells * had**2 or had > wanted:
        return False
    largest = max(found["texels"]) * spec.bucket
    return bool(had == wanted or (had + 1) * largest > MAX_IMAGE_SIDE)  # a picture had no room for more


def variants_in(folder: Path, name: str, kind: str) -> tuple[Path, ...]:
    """The sidecars of all variants of a bake, or of its parts, where no plain one is beside them."""
    found = {path: plain for path in sorted(folder.glob(f"*.{kind}.json")) if (plain := _plain(path, name))}
    if any(path.name == file_name(name, kind, "json", part=part) for path, (part, _) in found.items()):
        return ()
    return tuple(path for path, (_, is_variant) in found.items() if is_variant)


def _plain(sidecar: Path, name: str) -> tuple[str | None, bool] | None:
    """Which part a bake called `name` is of, and whether it is a variant; None for another's sidecar."""
    try:
        facts = read_facts(sidecar)
        part = part_in(facts)
    except FormatError:
        return None
    if facts.values.get("object") != name:
        return None
    return None if part is None else part.name, any(key in facts.values for key in _KEYS)
