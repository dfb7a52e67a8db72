# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The form of kind `shadow`: like an image of buckets, but its pixels are words of bits."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy

from ...bake.cost import Cost, cost_of_images
from ...bake.forms import BITS, FormTraits
from ...bake.kinds import KINDS, Kind
from ...bake.progress import Progress
from ...bake.spec import BakeSpec
from ...core.arrays import Floats
from ...core.atlas import AtlasLayout
from ...core.shadow import word_count
from ...core.surface import SurfaceMesh
from ...core.texel_map import covered_texels
from ...formats.image_files import Shapes
from ...formats.json_reader import Facts
from ...formats.shadow_files import visible_buckets
from ...formats.sidecar import read_sidecar
from ...formats.sidecar_file import SidecarFile
from ...preview.lit_material import preview_shadow_material
from ...preview.osl import no_script
from ...textures.entry import TextureEntry
from ...textures.export_spec import ExportSpec, Step
from ...textures.flat_lightmap import check_means, mean_of_buckets
from ..bake_job import BakeJob
from ..buckets.form import Buckets
from ..form import Form, PreviewOf
from ..outcome import Outcome
from .bake import bake_bits
from .textures import check_shadow_texture, write_shadow_texture

_WORD = 4  # bytes
_CELL = 12  # bytes per cell in an export, which unpacks the bits


class Bits(Buckets):
    """Bits in the words of one image: see `forms.form.Form`."""

    traits: FormTraits = BITS

    def bake(self, job: BakeJob) -> Generator[Progress, None, Outcome]:
        return bake_bits(job)

    def cost(self, spec: BakeSpec) -> Cost:
        """A texel takes words of 32 bits, on a GPU pairs of them if one is not enough."""
        words, texels = word_count(spec.bucket), spec.texels**2
        stored = cost_of_images(spec, {"words": (spec.texels, spec.texels, words)})
        return replace(
            stored, disk=_WORD * words * texels, gpu=_WORD * (words + words % 2 * (words > 1)) * texels
        )

    def shapes(self, sidecar: SidecarFile, texels: int = 1, cells: int = 1) -> Shapes:
        facts = read_sidecar(sidecar)
        return {"": (facts.width * texels, facts.height * texels, word_count(facts.bucket * cells))}

    def material(self, of: PreviewOf) -> bpy.types.Material:
        return preview_shadow_material(of.title, of.sidecar, of.uv_layer, of.scene, of.filter)

    def script_node(self, tree: bpy.types.NodeTree, sidecar: SidecarFile) -> bpy.types.Node:
        raise no_script(sidecar)

    def holds(self, facts: Facts) -> bool:
        kind = facts.text("kind")
        return kind in tuple(Kind) and KINDS[Kind(kind)].form == self.traits

    def export_bytes(self, sidecar: SidecarFile) -> int:
        facts = read_sidecar(sidecar)
        return _CELL * facts.width * facts.height * facts.bucket**2

    def flat(self, sidecar: SidecarFile, surface: SurfaceMesh) -> Generator[Step, None, Floats]:
        yield from ()
        pixels, facts = visible_buckets(sidecar)
        light = mean_of_buckets(pixels, AtlasLayout(facts.width, facts.height, facts.bucket))
        check_means(sidecar.path, covered_texels(surface, facts.width, facts.height), light)
        return light

    def check_textures(self, sidecar: SidecarFile, spec: ExportSpec) -> None:
        check_shadow_texture(sidecar, spec)

    def write_textures(self, sidecar: SidecarFile, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
        return write_shadow_texture(sidecar, spec, folder)

    def includes(self, bake: Mapping[str, Any]) -> tuple[str, ...]:
        return ("radtex", "radtex_shadow")

    def usage(self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry]) -> list[str]:
        (width, height), n = bake["texels"], bake["bucket"]
        layered = ["#define RADTEX_SHADOW_LAYERS"] if textures[bake["kind"]].layers > 1 else []
        return [*layered, f"radtex_shadow(bits, ({width}, {height}), uv), then radtex_visible(…, {n}, I)"]


FORM: Form = Bits()
