# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The form of kind `shadow`: an image of buckets, but for its pixels, which are words of bits."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from pathlib import Path
from typing import Any

import bpy

from ...bake.forms import BITS, FormTraits
from ...bake.kinds import KINDS, Kind
from ...bake.progress import Progress
from ...core.arrays import Floats
from ...core.atlas import AtlasLayout
from ...core.surface import SurfaceMesh
from ...core.texel_map import covered_texels
from ...formats.json_reader import Facts
from ...formats.shadow_files import visible_buckets
from ...formats.sidecar import read_sidecar
from ...preview.occlusion import preview_shadow_material
from ...textures.entry import TextureEntry
from ...textures.flat import check_means, mean_of_buckets
from ...textures.progress import Step
from ...textures.spec import ExportSpec, Target
from ..bake_job import BakeJob
from ..buckets.form import Buckets
from ..form import Form, PreviewOf
from ..outcome import Outcome
from .bake import bake_bits
from .texture import write_shadow_texture

_CELL = 12  # bytes of one in an export, which spreads the bits out


class Bits(Buckets):
    """Bits in the words of one image: see `forms.form.Form`."""

    traits: FormTraits = BITS

    def bake(self, job: BakeJob) -> Generator[Progress, None, Outcome]:
        return bake_bits(job)

    def material(self, of: PreviewOf) -> bpy.types.Material:
        return preview_shadow_material(of.title, of.sidecar, of.uv_layer, of.scene, of.filter)

    def holds(self, facts: Facts) -> bool:
        kind = facts.text("kind")
        return kind in tuple(Kind) and KINDS[Kind(kind)].form == self.traits

    def export_bytes(self, sidecar: Path) -> int:
        facts = read_sidecar(sidecar)
        return _CELL * facts.width * facts.height * facts.bucket**2

    def flat(self, sidecar: Path, surface: SurfaceMesh) -> Generator[Step, None, Floats]:
        yield from ()
        pixels, facts = visible_buckets(sidecar)
        light = mean_of_buckets(pixels, AtlasLayout(facts.width, facts.height, facts.bucket))
        check_means(sidecar, covered_texels(surface, facts.width, facts.height), light)
        return light

    def write_textures(self, sidecar: Path, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
        return write_shadow_texture(sidecar, spec, folder)

    def includes(self, bake: Mapping[str, Any]) -> tuple[str, ...]:
        return ("radtex", "radtex_shadow")

    def usage(
        self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry], target: Target
    ) -> list[str]:
        (width, height), n = bake["texels"], bake["bucket"]
        layered = ["#define RADTEX_SHADOW_LAYERS"] if textures[bake["kind"]].layers > 1 else []
        return [*layered, f"radtex_shadow(bits, ({width}, {height}), uv), then radtex_visible(…, {n}, I)"]


FORM: Form = Bits()
