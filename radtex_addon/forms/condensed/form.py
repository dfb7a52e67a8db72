# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The condensed form, with the interface of all forms."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...bake.cost import Cost, cost_of_images
from ...bake.forms import CONDENSED, FormTraits
from ...bake.progress import Progress
from ...bake.rays import FINER
from ...bake.spec import BakeSpec
from ...core.shared import Axis, level_count
from ...formats.condensed_sizes import CondensedSizes, clusters_within, condensed_bytes, texture_bytes
from ...formats.json_reader import Facts
from ...formats.packing import layer_names
from ...formats.shared_files import read_shared_sidecar, texture_path
from ...formats.sidecar_file import SidecarFile
from ...textures.entry import TextureEntry
from ...textures.export_spec import ExportSpec
from ..bake_job import BakeJob
from ..form import Form, Opened
from ..outcome import Outcome
from ..shared.form import Shared, opened_shared
from .bake import bake_condensed
from .condense import check_budget
from .textures import copy_textures

_COPIES = 3  # copies of all texels' buckets in memory during an export
_LARGEST_BUDGET = 2**40


class Condensed(Shared):
    """Several compressed textures: see `forms.form.Form`."""

    traits: FormTraits = CONDENSED
    lobes_are_buckets = False

    def images(self, spec: BakeSpec, sidecar: Path) -> tuple[Path, ...]:
        return tuple(texture_path(sidecar, layer) for layer in layer_names(Axis, condensed=True))

    def bake(self, job: BakeJob) -> Generator[Progress, None, Outcome]:
        return bake_condensed(job)

    def cost(self, spec: BakeSpec) -> Cost:
        """With as many clusters as the budget allows; for a target as there are texels."""
        largest = CondensedSizes(
            width=spec.texels,
            height=spec.texels,
            bucket=spec.bucket,
            colour=(FINER * spec.texels, FINER * spec.texels),
            surroundings=spec.rays.size,
            levels=level_count(spec.rays.size),
            clusters=dict.fromkeys(Axis, 1),
        )
        count = clusters_within(spec.budget or _LARGEST_BUDGET, largest)
        sizes = replace(largest, clusters=dict.fromkeys(Axis, count))
        stored = min(condensed_bytes(sizes), spec.budget or _LARGEST_BUDGET)
        return replace(cost_of_images(spec, sizes.shapes(sizes.columns)), disk=stored, gpu=stored)

    def check_size(self, spec: BakeSpec, width: int, height: int) -> None:
        check_budget(spec, width, height)

    def holds(self, facts: Facts) -> bool:
        return "condensed" in facts.inner("shared").values

    def open(self, sidecar: SidecarFile) -> Opened:
        facts = read_shared_sidecar(sidecar)
        images = tuple(texture_path(sidecar.path, layer) for layer in facts.bake.layers)
        return opened_shared(sidecar, images, texture_bytes(facts.shapes))

    def export_bytes(self, sidecar: SidecarFile) -> int:
        return super().export_bytes(sidecar) + _COPIES * self.expanded_bytes(sidecar)

    def write_textures(self, sidecar: SidecarFile, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
        return copy_textures(sidecar, spec, folder)

    def includes(self, bake: Mapping[str, Any]) -> tuple[str, ...]:
        return ("radtex", "radtex_shared", "radtex_condensed")


FORM: Form = Condensed()
