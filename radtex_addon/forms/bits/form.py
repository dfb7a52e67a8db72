# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The form of kind `shadow`: like an image of buckets, but its pixels are words of bits.

A cell has one bit, which says whether its direction is blocked. Exports have them as textures of integers.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...bake.progress import Progress
from ...core.arrays import Floats
from ...core.atlas import AtlasLayout
from ...core.errors import InputError
from ...core.messages import Setting, leave_out
from ...core.shadow import pack_bits, word_count
from ...core.surface import SurfaceMesh
from ...core.texel_map import covered_texels
from ...formats.codecs.bc7 import Blocks
from ...formats.containers.ktx2 import write_ktx2
from ...formats.containers.texture import PixelFormat, Texture
from ...formats.disk.atomic import replacing
from ...formats.image_files import Shapes
from ...formats.json_reader import Facts
from ...formats.shadow_files import Words, read_shadow_of, visible_buckets, write_shadow
from ...formats.sidecar import read_sidecar
from ...formats.sidecar_file import SidecarFile
from ...preview.lit_material import preview_shadow_material
from ...preview.osl import no_script
from ...settings.cost import Cost, cost_of_images
from ...settings.forms import BITS, FormTraits
from ...settings.kinds import KINDS, Kind
from ...settings.spec import BakeSpec
from ...textures.entry import Arranged, Container, TextureEntry
from ...textures.export_spec import Arrangement, ExportSpec, ExportStep, TextureFormat
from ...textures.flat_lightmap import check_stored, mean_of_buckets
from ..bake_job import BakeJob
from ..buckets.form import Buckets
from ..form import Form, PreviewOf
from ..occlusion_bake import capture_occlusion
from ..outcome import Outcome

_WORD = 4  # bytes
_CELL = 12  # bytes per cell in an export, which unpacks the bits


def check_shadow_texture(sidecar: SidecarFile, spec: ExportSpec) -> None:
    """As `Form.check_textures`."""
    if spec.format is not TextureFormat.AUTO:
        raise InputError(f"{sidecar} holds bits, not light", leave_out(Setting.FORMAT))
    if spec.arrangement is not Arrangement.MATRIX or (spec.levels or 1) > 1:
        raise InputError(
            f"{sidecar} holds bits, which are not blended", leave_out(Setting.ARRANGEMENT, Setting.LEVELS)
        )
    facts = read_sidecar(sidecar)
    if max(facts.width, facts.height) > spec.most_pixels:
        size = f"{facts.width} x {facts.height} pixels"
        raise InputError(f"{sidecar} would be a texture of {size}: raise the limit of {spec.most_pixels}")


def write_shadow_texture(sidecar: SidecarFile, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    """Write the bits of the bake `sidecar` into `folder` as KTX2; returns the entry of its one texture.

    One pixel per texel, the bottom row first: R32UI for one word, RG32UI for two, and for more an array of
    RG32UI, whose layer k has the words 2 k and 2 k + 1. Raises InputError for options that bits do not
    support, FormatError for files that cannot be read, BakeError where the system refuses.
    """
    check_shadow_texture(sidecar, spec)
    words, facts = read_shadow_of(sidecar)
    texture = shadow_texture(words)
    path = folder / sidecar.path.with_suffix(".ktx2").name
    write_ktx2(path, texture, spec.zstd, premultiplied=False)
    texels = (facts.width, facts.height)
    entry = TextureEntry(
        file=path.name,
        container=Container.KTX2,
        format=texture.format,
        zstd=spec.zstd,
        arrangement=Arranged.WORDS,
        size=texels,
        layers=texture.layers,
        texels=texels,
        stored=texels,
        levels=1,
        pages=(1, 1),
        page_texels=texels,
    )
    return {facts.kind: entry}


def shadow_texture(words: Words) -> Texture:
    """Words (H, W, w), row 0 at the bottom, as a texture."""
    height, width, count = words.shape
    if count == 1:
        return Texture(PixelFormat.R32UI, width, height, (_pixels(words[None]),))
    pairs = np.pad(words, ((0, 0), (0, 0), (0, count % 2))).reshape(height, width, -1, 2)
    layers = pairs.transpose(2, 0, 1, 3)
    return Texture(PixelFormat.RG32UI, width, height, (_pixels(layers),), is_array=count > 2)


def _pixels(words: Words) -> Blocks:
    return np.ascontiguousarray(words, dtype="<u4").view(np.uint8)


def bake_bits(job: BakeJob) -> Generator[Progress, None, Outcome]:
    """As `Form.bake`."""
    captured, spec = (yield from capture_occlusion(job)), job.spec
    layout, facts = captured.plan.layout, job.prepared.facts(spec)
    rows = [pack_bits(band.buckets[..., 0] < 0.5) for band in captured.bands.downwards()]
    with replacing(job.place) as beside:  # left last: the sidecar is renamed after the image
        beside.write_text(facts.to_json(), encoding="utf-8", newline="\n")
        write_shadow(job.place.with_suffix(".exr"), np.concatenate(rows[::-1]), facts, spec.compression)
    return Outcome(
        images=(job.sidecar.with_suffix(".exr"),),
        layout=AtlasLayout(layout.width, layout.height, spec.bucket),
        covered_texels=len(captured.plan.texel),
        paths=len(captured.plan.texel) * captured.rays,
        clamped=0,
    )


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

    def flat(self, sidecar: SidecarFile, surface: SurfaceMesh) -> Generator[ExportStep, None, Floats]:
        yield from ()
        pixels, facts = visible_buckets(sidecar)
        light = mean_of_buckets(pixels, AtlasLayout(facts.width, facts.height, facts.bucket))
        check_stored(sidecar.path, covered_texels(surface, facts.width, facts.height), light)
        return light

    def check_textures(self, sidecar: SidecarFile, spec: ExportSpec) -> None:
        check_shadow_texture(sidecar, spec)

    def write_textures(
        self, sidecar: SidecarFile, spec: ExportSpec, folder: Path, images: bool = False
    ) -> dict[str, TextureEntry]:
        return write_shadow_texture(sidecar, spec, folder)

    def includes(self, bake: Mapping[str, Any]) -> tuple[str, ...]:
        return ("radtex", "radtex_shadow")

    def usage(self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry]) -> list[str]:
        (width, height), n = bake["texels"], bake["bucket"]
        layered = ["#define RADTEX_SHADOW_LAYERS"] if textures[bake["kind"]].layers > 1 else []
        return [*layered, f"radtex_shadow(bits, ({width}, {height}), uv), then radtex_visible(…, {n}, I)"]


FORM: Form = Bits()
