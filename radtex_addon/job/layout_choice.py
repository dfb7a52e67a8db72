# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The layout of a bake for which none was named: shared within a budget, or buckets where that does not go.

What was asked for, the object and the files that are there decide; the machine does not.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import bpy

from ..bake.forms import FormTraits
from ..bake.key import is_unfinished, read_key
from ..bake.kinds import Layout, form_in
from ..bake.memory_limits import check_memory
from ..bake.spec import BakeSpec, shared_bytes
from ..core.errors import FormatError, InputError, MemoryLimitError
from ..formats.disk.memory import readable_size
from ..formats.sidecar import read_facts
from ..forms import form_in as form_of_facts
from ..forms.condensed.condense import check_bytes
from ..scene.checks.see_through import why_see_through
from .files import OutputFiles
from .variants import Bake

DEFAULT_BUDGET = 2_000_000  # bytes: the preset Preview's, too
_MOST_MEMORY = 8 << 30  # bytes that the shared layout may take where no layout was named, on every machine
SHARED_CELLS = BakeSpec(texels=1, layout=Layout.SHARED, budget=DEFAULT_BUDGET).bucket

_REMEDY = re.compile(r": [^:]*\blayout buckets$")  # of a refusal, which was already followed


@dataclass(frozen=True)
class OpenLayout:
    """That no layout was named, nor a budget or target; `cells` are those named for a bucket's side."""

    cells: int | None = None


@dataclass(frozen=True)
class Choice:
    """A bake whose layout is settled.

    `reason` says why it is in layout buckets although none was named; empty where it is not so, or where
    it goes on with a bake that is there.
    """

    spec: BakeSpec
    reason: str = ""

    def told(self, name: str) -> str:
        """The line that tells of it; empty without a reason."""
        return f"'{name}' is baked in layout buckets, not shared: {self.reason}" if self.reason else ""


def choose_layout(
    scene: bpy.types.Scene,
    bake: Bake,
    wish: OpenLayout | None,
    folder: Path | None,
    *,
    resume: bool = False,
    overwrite: bool = False,
    others: Sequence[Bake] = (),
) -> Choice:
    """Settle the layout of a bake into `folder`, whose specification has layout buckets until then.

    Without a `wish` it was named, and stays. To `resume`, to accumulate and to refresh go on in the layout of
    what is there, of this bake or else of the `others` that are baked with it, unless there is no folder yet.
    Where some of them are of single lamps, all are alike, for they add up. An object that is not there has no
    say. Raises InputError for a shared atlas that is to be accumulated or
    refreshed, and as `BakeSpec` does.
    """
    name, spec = bake
    if wish is None:
        return Choice(spec)
    again = spec.accumulate or spec.refresh
    if folder is not None and spec.kind.traits.looks_at_surface and (resume or again):
        begun = _begun([bake, *(one for one in others if one[0] == name)], folder, overwrite and not again)
        if begun is not None:
            return Choice(_as_begun(bake, begun, wish, folder))
    lit = next((one for _, one in others if one.lights), spec)
    reason = _why_not_shared(lit, wish.cells) or _why_not_objects(scene, name, spec)
    if reason:
        return Choice(spec, reason)
    shared = _in_shared(spec, wish.cells, DEFAULT_BUDGET)
    try:
        check_memory(shared)
    except MemoryLimitError as error:
        raise InputError(f"{error}, or choose layout buckets (--layout buckets)") from error
    return Choice(shared)


def choose_layouts(
    scene: bpy.types.Scene,
    asked: Sequence[Bake],
    wish: OpenLayout | None,
    folder: Path | None,
    *,
    resume: bool,
    overwrite: bool,
) -> dict[Bake, Choice]:
    """The bakes of one run with their layouts settled, each with its choice. Raises as `choose_layout`."""
    choices = (
        choose_layout(scene, bake, wish, folder, resume=resume, overwrite=overwrite, others=asked)
        for bake in asked
    )
    return {(name, choice.spec): choice for (name, _), choice in zip(asked, choices, strict=True)}


def _in_shared(
    spec: BakeSpec, cells: int | None, budget: int | None, target: float | None = None
) -> BakeSpec:
    bucket = cast(int, cells)  # None is for the specification to settle
    return replace(spec, layout=Layout.SHARED, bucket=bucket, budget=budget, target=target)


def _why_not_shared(spec: BakeSpec, cells: int | None) -> str:
    """What of the options the shared layout refuses, or its budget for a square atlas."""
    try:
        _in_shared(spec, cells, DEFAULT_BUDGET)
    except InputError as error:
        return _REMEDY.sub("", str(error))
    try:
        check_bytes(DEFAULT_BUDGET, cells or SHARED_CELLS, spec.texels, spec.texels)
    except InputError as error:
        return str(error)
    if (needed := shared_bytes(spec.texels, cells or SHARED_CELLS, spec.samples)) > _MOST_MEMORY:
        return f"{spec.texels} texels at {spec.samples} samples would need {readable_size(needed)} of memory"
    return ""


def _why_not_objects(scene: bpy.types.Scene, name: str, spec: BakeSpec) -> str:
    wanted = [scene.objects[each] for each in spec.objects or (name,) if each in scene.objects]
    return next(filter(None, (why_see_through(scene, item) for item in wanted if item.type == "MESH")), "")


@dataclass(frozen=True)
class _Begun:
    """How a bake that is there is stored, and what belongs to it."""

    form: FormTraits
    bucket: int
    budget: int | None
    target: float | None


def _begun(bakes: Sequence[Bake], folder: Path, anew: bool) -> _Begun | None:
    """Of the first of these that is there, unfinished or, unless it is baked `anew`, finished."""
    for name, spec in bakes:
        files = OutputFiles.of(name, spec, folder, preview=False)
        if is_unfinished(files.unfinished):
            found = _from_key(read_key(files.unfinished).facts)
        else:
            found = None if anew or not files.sidecar.is_file() else _from_sidecar(files.sidecar)
        if found is not None:
            return found
    return None


def _from_key(facts: Mapping[str, str]) -> _Begun | None:
    """What an unfinished bake's key says; None for one that others than we wrote."""
    budget, target = (facts.get(name, "None") for name in ("budget", "target"))
    try:
        limits = (None if budget == "None" else int(budget), None if target == "None" else float(target))
        return _Begun(form_in(Layout(facts["layout"]), limits != (None, None)), int(facts["bucket"]), *limits)
    except (KeyError, ValueError):
        return None


def _from_sidecar(path: Path) -> _Begun | None:
    """What a finished bake's sidecar says: not for which budget or target it was condensed."""
    try:
        facts = read_facts(path)
        form = form_of_facts(facts).traits
    except FormatError:
        return None
    bucket: Any = facts.values.get("bucket")
    if not isinstance(bucket, int):
        return None
    return _Begun(form, bucket, DEFAULT_BUDGET if form.limited else None, None)


def _as_begun(bake: Bake, begun: _Begun, wish: OpenLayout, folder: Path) -> BakeSpec:
    name, spec = bake
    cells = wish.cells or begun.bucket
    if begun.form.accumulates:
        return replace(spec, bucket=cells)
    if spec.accumulate or spec.refresh:
        done = "accumulated" if spec.accumulate else "refreshed"
        sidecar = OutputFiles.of(name, spec, folder, preview=False).sidecar
        raise InputError(
            f"{sidecar} is in the shared layout, which cannot be {done}: "
            "bake it anew in layout buckets (--layout buckets --overwrite)"
        )
    return _in_shared(spec, cells, begun.budget, begun.target)
