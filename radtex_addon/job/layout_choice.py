# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Choose the layout of a bake for which none was named: layered, else buckets.

The specification, the object and existing files decide; the machine does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import bpy

from ..core.errors import InputError, MemoryLimitError
from ..core.messages import Setting, do
from ..formats.disk.memory import readable_size
from ..forms.layered.files.sidecar import MOST_MATERIALS
from ..scene.checks.see_through import why_no_surface
from ..scene.surfaces import may_have_faces
from ..settings.cost import check_memory
from ..settings.forms import NOT_REFRESHED, FormTraits
from ..settings.kinds import Layout
from ..settings.spec import BakeSpec
from ..store.bake_folder import BakeFolder, FolderState
from .variants import Bake

_MOST_MEMORY = 8 << 30  # bytes: if the layered layout needs more, buckets is chosen, on every machine


@dataclass(frozen=True)
class OpenLayout:
    """The user named no layout; `cells` along a bucket's side, if the user named them."""

    cells: int | None = None


@dataclass(frozen=True)
class Choice:
    """A specification with its final layout.

    `reason` says why layout buckets was chosen automatically; it is empty if that is not so, or if the
    layout is that of an existing bake.
    """

    spec: BakeSpec
    reason: str = ""

    def told(self, name: str) -> str:
        """A line with the reason, for the user; empty without a reason."""
        return f"'{name}' is baked in layout buckets, not layered: {self.reason}" if self.reason else ""


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
    """Choose the layout of a bake into `folder` (None if unknown yet); `bake` has layout buckets until then.

    Without a `wish` the layout was named, and stays. To `resume`, accumulate or refresh, the layout is that
    of the existing bake, or of the first existing one of the `others` in this run with the same name. Objects
    that do not exist are ignored. Raises InputError if a layered bake is to be refreshed,
    if the layered layout does not fit into memory, and as `BakeSpec` does.
    """
    name, spec = bake
    if wish is None:
        return Choice(spec)
    again = spec.incremental
    if folder is not None and spec.kind.traits.looks_at_surface and (resume or again):
        begun = _begun([bake, *(one for one in others if one[0] == name)], folder, overwrite and not again)
        if begun is not None:
            return Choice(_as_begun(bake, *begun, wish, folder))
    reason = _why_not_layered(spec, wish.cells) or _why_not_objects(scene, name, spec)
    if reason:
        return Choice(spec, reason)
    layered = _in_layout(Layout.LAYERED, spec, wish.cells)
    try:
        check_memory(layered)
    except MemoryLimitError as error:
        buckets = do("choose layout buckets", Setting.LAYOUT, value="buckets")
        raise InputError(error.message.problem, *error.message.remedies, buckets) from error
    return Choice(layered)


def choose_layouts(
    scene: bpy.types.Scene,
    asked: Sequence[Bake],
    wish: OpenLayout | None,
    folder: Path | None,
    *,
    resume: bool,
    overwrite: bool,
) -> dict[Bake, Choice]:
    """All bakes of one run with their final layouts, each with its choice. Raises as `choose_layout`."""
    choices = (
        choose_layout(scene, bake, wish, folder, resume=resume, overwrite=overwrite, others=asked)
        for bake in asked
    )
    return {(name, choice.spec): choice for (name, _), choice in zip(asked, choices, strict=True)}


def _in_layout(layout: Layout, spec: BakeSpec, cells: int | None) -> BakeSpec:
    bucket = cast(int, cells)  # None: the specification takes the default
    return replace(spec, layout=layout, bucket=bucket)


def _why_not_layered(spec: BakeSpec, cells: int | None) -> str:
    """Why a bake cannot be in the layered layout: its options, or the memory; empty if it can."""
    try:
        layered = _in_layout(Layout.LAYERED, spec, cells)
    except InputError as error:
        return error.message.problem  # without the remedy, layout buckets, which is chosen anyway
    if (needed := layered.atlas_bytes) > _MOST_MEMORY:
        return f"{spec.texels} texels at {spec.samples} samples would need {readable_size(needed)} of memory"
    return ""


def _why_not_objects(scene: bpy.types.Scene, name: str, spec: BakeSpec) -> str:
    names = spec.objects or (name,) if spec.source is None else (spec.source,)
    wanted = [scene.objects[each] for each in names if each in scene.objects]
    if spec.split is None and (count := _materials_of(wanted)) > MOST_MATERIALS:
        return f"it has {count} materials, and layered holds {MOST_MATERIALS} in one atlas"
    return next(filter(None, (why_no_surface(scene, item) for item in wanted if may_have_faces(item))), "")


def _materials_of(items: Sequence[bpy.types.Object]) -> int:
    """How many materials the objects' atlas has at most, as far as their slots tell."""
    if len(items) == 1:  # whose slots are counted, unused ones before used ones included
        return len(items[0].material_slots)
    return len({slot.material for item in items for slot in item.material_slots})


def _begun(bakes: Sequence[Bake], folder: Path, anew: bool) -> tuple[FormTraits, int] | None:
    """How the first of these bakes that exists is stored; if `anew`, only unfinished ones count."""
    for bake in bakes:
        there = BakeFolder(*bake, folder)
        if not anew or there.state is FolderState.UNFINISHED:
            found = there.stored_as()
            if found is not None:
                return found
    return None


def _as_begun(bake: Bake, form: FormTraits, bucket: int, wish: OpenLayout, folder: Path) -> BakeSpec:
    name, spec = bake
    cells = wish.cells or bucket
    if form.layout == spec.layout:
        return replace(spec, bucket=cells)
    if spec.refresh and not form.refreshes:
        raise InputError(
            f"{BakeFolder(name, spec, folder).files.sidecar} is in {form.title}, which cannot be refreshed, "
            f"{NOT_REFRESHED}",
            do("bake it again only if it has changed", Setting.CHANGED, without=(Setting.REFRESH,)),
            do("bake it anew in layout buckets", Setting.LAYOUT, Setting.OVERWRITE, value="buckets"),
        )
    return _in_layout(Layout(form.layout), spec, cells)
