# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The form of the shared layout, with the interface of all forms."""

from __future__ import annotations

from collections.abc import Collection, Generator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...bake.cost import Cost, cost_of_images
from ...bake.forms import SHARED, FormTraits
from ...bake.progress import Progress
from ...bake.rays import FINER
from ...bake.spec import BakeSpec
from ...core.arrays import Floats
from ...core.fragments import Fragments
from ...core.shared import LEAST_LEVEL, Axis, level_count, sample_shared
from ...core.surface import SurfaceMesh
from ...formats.condensed_sizes import Shapes
from ...formats.containers.exr import stored_compression
from ...formats.gutter_signature import own_texels
from ...formats.image_files import layer_path
from ...formats.json_reader import Facts
from ...formats.packing import (
    COLOUR,
    IRRADIANCE,
    LOBE_CHANNELS,
    SURROUNDINGS,
    layer_names,
    lobe_layer,
    surroundings_size,
)
from ...formats.shared_files import expanded_bytes, read_shared, read_shared_sidecar
from ...formats.shared_sidecar import SharedSidecar
from ...formats.sidecar import Sidecar
from ...formats.sidecar_file import SidecarFile
from ...prepare.facts import facts_of
from ...preview.material import preview_shared_material
from ...preview.shared_group import check_shared_previewable
from ...scene.mesh.copy import UV_LAYER
from ...textures.entry import TextureEntry
from ...textures.export_progress import Step
from ...textures.export_spec import ExportSpec, Target
from ...textures.godot_shader import GodotShader
from ..bake_job import BakeJob
from ..buckets.form import has_samples_and_cells
from ..form import Form, Opened, PreviewOf
from ..outcome import Outcome
from .bake import bake_shared
from .flat import flat_shared
from .godot import shared_shader
from .textures import write_shared_textures

_VALUE = 12  # bytes per value in an export, which reads whole images


class Shared:
    """An atlas in several images: see `forms.form.Form`."""

    traits: FormTraits = SHARED
    lobes_are_buckets = True  # each texel has its own bucket, instead of sharing a cluster's

    def images(self, spec: BakeSpec, sidecar: Path) -> tuple[Path, ...]:
        return tuple(layer_path(sidecar, layer) for layer in layer_names(Axis))

    def bake(self, job: BakeJob) -> Generator[Progress, None, Outcome]:
        return bake_shared(job)

    def cost(self, spec: BakeSpec) -> Cost:
        """With both lobes."""
        texels, side, around = spec.texels, spec.pixels_a_side, spec.rays.size
        shapes: Shapes = {
            COLOUR: (FINER * texels, FINER * texels, 3),
            IRRADIANCE: (texels, texels, 3),
            SURROUNDINGS: (*surroundings_size(around, level_count(around)), 3),
        } | {
            lobe_layer(axis, part): (side, side, channels)
            for axis in Axis
            for part, channels in LOBE_CHANNELS.items()
        }
        return cost_of_images(spec, shapes)

    def check_size(self, spec: BakeSpec, width: int, height: int) -> None:
        """Accept any size that a specification can have."""

    def check_previewable(self, spec: BakeSpec) -> None:
        side = spec.texels
        largest = SharedSidecar(
            bake=facts_of("", spec, side, side, spec.uv_layer or UV_LAYER),
            colour=(FINER * side, FINER * side),
            surroundings=LEAST_LEVEL,
            levels=1,
            sharpest=1.0,
            falloff=((1.0, 1.0, 1.0),),
            lobes=tuple(Axis) if self.lobes_are_buckets else (),
        )
        check_shared_previewable(largest)

    def material(self, of: PreviewOf) -> bpy.types.Material:
        return preview_shared_material(of.title, of.sidecar, of.uv_layer, of.spec.half)

    def holds(self, facts: Facts) -> bool:
        return "condensed" not in facts.inner("shared").values

    def is_of(self, facts: Facts, spec: BakeSpec) -> bool:
        return has_samples_and_cells(facts, spec)

    def read_sidecar(self, sidecar: SidecarFile) -> Sidecar:
        return read_shared_sidecar(sidecar).bake

    def open(self, sidecar: SidecarFile) -> Opened:
        facts = read_shared_sidecar(sidecar)
        images = tuple(layer_path(sidecar.path, layer) for layer in facts.bake.layers)
        opened = opened_shared(sidecar, images)
        return replace(opened, compression=stored_compression(layer_path(sidecar.path, IRRADIANCE)))

    def shapes(self, sidecar: SidecarFile, texels: int = 1, cells: int = 1) -> Shapes:
        shared = read_shared_sidecar(sidecar)
        bake, (width, height) = shared.bake, shared.colour
        larger = replace(
            bake, width=bake.width * texels, height=bake.height * texels, bucket=bake.bucket * cells
        )
        return replace(shared, bake=larger, colour=(width * texels, height * texels)).shapes

    def expanded_bytes(self, sidecar: SidecarFile) -> int:
        return expanded_bytes(read_shared_sidecar(sidecar))

    def export_bytes(self, sidecar: SidecarFile) -> int:
        shapes = read_shared_sidecar(sidecar).shapes
        return _VALUE * sum(width * height * channels for width, height, channels in shapes.values())

    def textures_of(self, facts: Facts, present: Collection[str]) -> tuple[str, ...]:
        shared = SharedSidecar.from_facts(facts)
        return layer_names(shared.lobes, shared.condensed is not None)

    def flat(self, sidecar: SidecarFile, surface: SurfaceMesh) -> Generator[Step, None, Floats]:
        return flat_shared(sidecar, surface)

    def write_textures(self, sidecar: SidecarFile, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
        return write_shared_textures(sidecar, spec, folder)

    def includes(self, bake: Mapping[str, Any]) -> tuple[str, ...]:
        return ("radtex", "radtex_shared")

    def usage(
        self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry], target: Target
    ) -> list[str]:
        return [
            "Light is looked up in the world space of the bake, in Blender's axes (z up): docs/format.md,",
            '"The shared layout". All numbers stand in the manifest under "bake".',
        ]

    def shader_facts(
        self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry]
    ) -> dict[str, Any] | None:
        return None

    def godot_shader(
        self,
        bake: Mapping[str, Any],
        textures: Mapping[str, TextureEntry],
        baked: Floats,
        culled: bool = False,
    ) -> GodotShader:
        return shared_shader(bake, textures, baked)


def opened_shared(sidecar: SidecarFile, images: tuple[Path, ...], budget: int | None = None) -> Opened:
    """Read a bake in the shared layout, condensed or not, with these images."""
    atlas, facts = read_shared(sidecar)
    texels, loss = own_texels(sidecar.path, atlas, facts)

    def lookup(at: Fragments) -> Floats:
        return sample_shared(atlas, *(part.astype(np.float32) for part in (at.uv, at.normal, at.viewer)))

    return Opened(facts.bake, images, lookup, texels, None, loss, budget)


FORM: Form = Shared()
