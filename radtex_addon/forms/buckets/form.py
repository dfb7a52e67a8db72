# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The plain form, with the interface of all forms."""

from __future__ import annotations

from collections.abc import Collection, Generator, Mapping
from pathlib import Path
from typing import Any

import bpy

from ...bake.layers import OF_LAYER, WHOLE, Layer
from ...bake.progress import Progress
from ...core.arrays import Floats
from ...core.atlas import AtlasLayout
from ...core.fragments import Fragments
from ...core.sampler import Filter, sample
from ...core.surface import SurfaceMesh
from ...formats.bucket_files import BASE
from ...formats.containers.exr import loss_of, read_buckets, stored_compression
from ...formats.image_files import Shapes
from ...formats.json_reader import Facts
from ...formats.sidecar import Sidecar, read_sidecar
from ...formats.sidecar_file import AnySidecar, SidecarFile
from ...preview.material import preview_material
from ...preview.node_group import check_previewable
from ...preview.osl import add_osl_node
from ...scene.image_materials import ImageMaterial
from ...settings.cost import Cost, cost_of_images
from ...settings.forms import BUCKETS, FormTraits
from ...settings.kinds import KINDS, Kind, Light
from ...settings.spec import BakeSpec
from ...textures.entry import Arranged, TextureEntry
from ...textures.export_spec import ExportSpec, ExportStep, Target
from ..bake_job import BakeJob
from ..form import Form, Opened, PreviewOf
from ..hlsl_lookup import HlslLookup
from ..outcome import Outcome
from .bake import bake_buckets, bucket_images
from .hlsl import buckets_lookup
from .textures import check_buckets, flat_buckets, light_channels, write_buckets

_TEXEL = 80  # bytes per texel in an export, for the flat lightmap and the check that it is of this mesh


class Buckets:
    """Buckets in one image: see `forms.form.Form`."""

    traits: FormTraits = BUCKETS

    def images(self, spec: BakeSpec, sidecar: Path) -> tuple[Path, ...]:
        return bucket_images(spec.layers, sidecar)

    def bake(self, job: BakeJob) -> Generator[Progress, None, Outcome]:
        return bake_buckets(job)

    def cost(self, spec: BakeSpec) -> Cost:
        side = spec.pixels_a_side
        layers: Shapes = {
            layer: (*((spec.texels,) * 2 if layer is Layer.BASE else (side,) * 2), OF_LAYER)
            for layer in spec.layers
        }
        return cost_of_images(spec, {"atlas": (side, side, WHOLE)} | layers)

    def check_size(self, spec: BakeSpec, width: int, height: int) -> None:
        """Accept any size that a specification can have."""

    def check_previewable(self, spec: BakeSpec) -> None:
        check_previewable(AtlasLayout(spec.texels, spec.texels, spec.bucket))

    def material(self, of: PreviewOf) -> bpy.types.Material:
        layout, atlas = layout_in(of.sidecar), of.sidecar.with_suffix(".exr")
        return preview_material(of.title, atlas, layout, of.uv_layer, of.filter, of.spec.half, of.hull)

    def materials(self, of: PreviewOf, images: Mapping[int, ImageMaterial]) -> dict[int, bpy.types.Material]:
        return {}

    def script_node(self, tree: bpy.types.NodeTree, sidecar: SidecarFile) -> bpy.types.Node:
        atlas = sidecar.path.with_suffix(".exr").absolute()
        return add_osl_node(tree, atlas, layout_in(sidecar), Filter.QUADRILINEAR)

    def holds(self, facts: Facts) -> bool:
        kind = facts.text("kind")  # a bake of an unknown kind is read as plain buckets
        return kind not in tuple(Kind) or KINDS[Kind(kind)].form in (None, self.traits)

    def is_of(self, facts: Facts, spec: BakeSpec) -> bool:
        layers = facts.values.get("layers") == list(spec.layers)
        return layers and has_samples_and_cells(facts, spec)

    def read_sidecar(self, sidecar: SidecarFile) -> Sidecar:
        return read_sidecar(sidecar)

    def open(self, sidecar: SidecarFile) -> Opened:
        pixels, facts = read_buckets(sidecar)
        image, layout = sidecar.path.with_suffix(".exr"), AtlasLayout(facts.width, facts.height, facts.bucket)
        compression = stored_compression(image)

        def lookup(at: Fragments) -> Floats:
            return sample(pixels, layout, at.uv, at.incidence, Filter.QUADRILINEAR)[:, :3]

        return Opened(
            sidecar=facts,
            images=(image,),
            lookup=lookup,
            texels=layout.some_cells(pixels[..., :3]),
            compression=compression,
            loss=loss_of(compression),
        )

    def shapes(self, sidecar: SidecarFile, texels: int = 1, cells: int = 1) -> Shapes:
        facts = read_sidecar(sidecar)
        side = facts.bucket * cells * texels
        return {"": (facts.width * side, facts.height * side, 4)}

    def export_bytes(self, sidecar: SidecarFile) -> int:
        facts = read_sidecar(sidecar)
        return _TEXEL * facts.width * facts.height

    def own_images(self, sidecar: SidecarFile) -> tuple[int, ...]:
        return ()

    def material_count(self, sidecar: SidecarFile) -> int:
        return 1

    def textures_of(self, facts: Facts, present: Collection[str]) -> tuple[str, ...]:
        kind = Sidecar.from_facts(facts).kind
        return (kind, *(layer for layer in facts.texts("layers") if layer in present))

    def flat(self, sidecar: SidecarFile, surface: SurfaceMesh) -> Generator[ExportStep, None, Floats]:
        yield from ()
        leaves = Kind(read_sidecar(sidecar).kind).traits.light is Light.LEAVING
        return flat_buckets(sidecar, surface, light_channels(sidecar) if leaves else slice(3))

    def check_textures(self, sidecar: SidecarFile, spec: ExportSpec) -> None:
        check_buckets(sidecar, spec)

    def write_textures(
        self, sidecar: SidecarFile, spec: ExportSpec, folder: Path, images: bool = False
    ) -> dict[str, TextureEntry]:
        return write_buckets(sidecar, spec, folder)

    def includes(self, bake: Mapping[str, Any]) -> tuple[str, ...]:
        return ("radtex",)

    def usage(self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry]) -> list[str]:
        entry, n = textures[bake["kind"]], bake["bucket"]
        if entry.arrangement is Arranged.SLICES:
            return [f"radtex_slices(slices, {n}, uv, I), of a texture array with {n} x {n} layers"]
        size = "({}, {})".format(*bake["texels"])
        lookups = [f"radtex_sample(atlas, {size}, {n}, uv, I, RADTEX_QUADRILINEAR)"]
        if entry.levels > 1:
            level = f"radtex_level(uv, {size}, {entry.levels})"
            lookups.append(f"radtex_sample_level(atlas, {size}, {n}, uv, I, {level})")
        if BASE in textures:
            lookups.append(
                "base: an image, looked up at uv by plain bilinear filtering; base + rest is the whole"
            )
        return [*defines(entry), *lookups]

    def shader_facts(
        self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry], images: bool = False
    ) -> dict[str, Any] | None:
        return None

    def hlsl(
        self,
        bake: Mapping[str, Any],
        textures: Mapping[str, TextureEntry],
        target: Target,
        images: bool = False,
    ) -> HlslLookup:
        return buckets_lookup(bake, textures, target)


def layout_in(sidecar: AnySidecar) -> AtlasLayout:
    """The atlas's layout, by its sidecar. Raises FormatError."""
    facts = read_sidecar(sidecar)
    return AtlasLayout(facts.width, facts.height, facts.bucket)


def has_samples_and_cells(facts: Facts, spec: BakeSpec) -> bool:
    """Whether a sidecar has the samples and cells of a specification. Raises FormatError."""
    samples, cells = facts.whole_number("samples", 1), facts.whole_number("bucket", 1)
    return (samples, cells) == (spec.samples, spec.bucket)


def defines(entry: TextureEntry) -> list[str]:
    """The #defines of a shader for a matrix of buckets."""
    if entry.layers == 1:
        return []
    columns, rows, across, up = (*entry.pages, *entry.page_texels)
    return [f"#define RADTEX_PAGES, pages = ({columns}, {rows}, {across}, {up})"]


FORM: Form = Buckets()
