# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The condensed form, behind the interface of all forms."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from pathlib import Path
from typing import Any

from ...bake.forms import CONDENSED, FormTraits
from ...bake.progress import Progress
from ...bake.spec import BakeSpec
from ...core.shared import Axis
from ...formats.condensed_sizes import texture_bytes
from ...formats.json_reader import Facts
from ...formats.packing import layer_names
from ...formats.shared_files import read_shared_sidecar, texture_path
from ...textures.entry import TextureEntry
from ...textures.spec import ExportSpec
from ..bake_job import BakeJob
from ..form import Form, Opened
from ..outcome import Outcome
from ..shared.form import Shared, opened_shared
from .bake import bake_condensed
from .condense import check_budget
from .textures import copy_textures

_COPIES = 3  # of the buckets of all texels, in an export


class Condensed(Shared):
    """Several compressed textures: see `forms.form.Form`."""

    traits: FormTraits = CONDENSED
    lobes_are_buckets = False

    def images(self, spec: BakeSpec, sidecar: Path) -> tuple[Path, ...]:
        return tuple(texture_path(sidecar, layer) for layer in layer_names(Axis, condensed=True))

    def bake(self, job: BakeJob) -> Generator[Progress, None, Outcome]:
        return bake_condensed(job)

    def check_size(self, spec: BakeSpec, width: int, height: int) -> None:
        check_budget(spec, width, height)

    def holds(self, facts: Facts) -> bool:
        return "condensed" in facts.inner("shared").values

    def open(self, sidecar: Path) -> Opened:
        facts = read_shared_sidecar(sidecar)
        images = tuple(texture_path(sidecar, layer) for layer in facts.bake.layers)
        return opened_shared(sidecar, images, texture_bytes(facts.shapes))

    def export_bytes(self, sidecar: Path) -> int:
        return super().export_bytes(sidecar) + _COPIES * self.expanded_bytes(sidecar)

    def write_textures(self, sidecar: Path, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
        return copy_textures(sidecar, spec, folder)

    def includes(self, bake: Mapping[str, Any]) -> tuple[str, ...]:
        return ("radtex", "radtex_shared", "radtex_condensed")


FORM: Form = Condensed()
