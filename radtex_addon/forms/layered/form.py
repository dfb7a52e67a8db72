# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The form of the layered layout, with the interface of all forms."""

from __future__ import annotations

from collections.abc import Collection, Generator, Mapping
from pathlib import Path
from typing import Any

import bpy

from ...bake.progress import Progress
from ...core.arrays import Floats
from ...core.fragments import Fragments
from ...core.surface import SurfaceMesh
from ...formats.containers.exr import stored_compression
from ...formats.image_files import Shapes, layer_path
from ...formats.json_reader import Facts
from ...formats.sidecar import Sidecar
from ...formats.sidecar_file import SidecarFile, opened
from ...scene.image_materials import ImageMaterial
from ...settings.cost import Cost, cost_of_images
from ...settings.forms import LAYERED, FormTraits
from ...settings.rays import coarser, finer
from ...settings.spec import BakeSpec
from ...textures.entry import TextureEntry
from ...textures.export_spec import ExportSpec, ExportStep, Target
from ..bake_job import BakeJob
from ..buckets.form import has_samples_and_cells
from ..form import Form, Opened, PreviewOf
from ..hlsl_lookup import HlslLookup
from ..outcome import Outcome
from .bake import bake_layered
from .cells import CELLS, EXIT_CELLS, FIELD_SAMPLES, PICTURE_SIZE, THROUGH_CELLS
from .cells import DISTANCES as DISTANCE_CELLS
from .files.arrangement import (
    ALPHA,
    CHANNELS,
    COLOUR,
    DISTANCES,
    EXIT_DIRECTION,
    EXIT_PLACE,
    FIELD,
    IRRADIANCE,
    NORMAL,
    OF_IMAGES,
    OWN,
    PICTURES,
    REST,
    TANGENT,
    THROUGH_COLOUR,
    THROUGH_REST,
    TINT,
    WIDTH,
    packed_size,
    padded_size,
)
from .files.layered_files import read_layered, read_layered_sidecar
from .hlsl import layered_lookup
from .lookup.atlas import alpha_at, sample_layered
from .lookup.blurred_levels import level_count
from .lookup.distance_field import image_size
from .preview.material import (
    check_layered_previewable,
    preview_layered_material,
    preview_materials_of_images,
)
from .preview.osl import add_layered_osl_node
from .shader_values import exported_facts
from .textures import check_layered_textures, flat_layered, own_texels, write_layered_textures

_VALUE = 12  # bytes per value in an export, which reads whole images


class Layered:
    """An atlas in several images, before surroundings in layers: see `forms.form.Form`."""

    traits: FormTraits = LAYERED

    def images(self, spec: BakeSpec, sidecar: Path) -> tuple[Path, ...]:
        return tuple(layer_path(sidecar, layer) for layer in CHANNELS)

    def bake(self, job: BakeJob) -> Generator[Progress, None, Outcome]:
        return bake_layered(job)

    def cost(self, spec: BakeSpec) -> Cost:
        """With every map, of an object that lets light through."""
        return cost_of_images(spec, _most_shapes(spec.texels))

    def check_size(self, spec: BakeSpec, width: int, height: int) -> None:
        """Accept any size that a specification can have."""

    def check_previewable(self, spec: BakeSpec) -> None:
        check_layered_previewable(_most_shapes(spec.texels))

    def material(self, of: PreviewOf) -> bpy.types.Material:
        return preview_layered_material(of.title, of.sidecar, of.uv_layer, of.spec.half, of.hull)

    def materials(self, of: PreviewOf, images: Mapping[int, ImageMaterial]) -> dict[int, bpy.types.Material]:
        return preview_materials_of_images(of.title, of.sidecar, of.uv_layer, images, of.spec.half, of.hull)

    def script_node(self, tree: bpy.types.NodeTree, sidecar: SidecarFile) -> bpy.types.Node:
        return add_layered_osl_node(tree, opened(sidecar.path.absolute()))

    def holds(self, facts: Facts) -> bool:
        return True

    def is_of(self, facts: Facts, spec: BakeSpec) -> bool:
        return has_samples_and_cells(facts, spec)

    def read_sidecar(self, sidecar: SidecarFile) -> Sidecar:
        return read_layered_sidecar(sidecar).bake

    def open(self, sidecar: SidecarFile) -> Opened:
        atlas, facts = read_layered(sidecar)
        texels, loss = own_texels(sidecar.path, atlas)

        def lookup(at: Fragments) -> Floats:
            return sample_layered(atlas, at.single())

        return Opened(
            sidecar=facts.bake,
            images=tuple(layer_path(sidecar.path, layer) for layer in facts.bake.layers),
            lookup=lookup,
            texels=texels,
            compression=stored_compression(layer_path(sidecar.path, IRRADIANCE)),
            loss=loss,
            alpha=None if atlas.alpha is None else lambda uv: alpha_at(atlas, uv),
        )

    def shapes(self, sidecar: SidecarFile, texels: int = 1, cells: int = 1) -> Shapes:
        return read_layered_sidecar(sidecar).larger(texels, cells).shapes

    def export_bytes(self, sidecar: SidecarFile) -> int:
        shapes = read_layered_sidecar(sidecar).shapes
        return _VALUE * sum(width * height * channels for width, height, channels in shapes.values())

    def own_images(self, sidecar: SidecarFile) -> tuple[int, ...]:
        looks = read_layered_sidecar(sidecar).looks
        return tuple(number for number, look in enumerate(looks) if look is not None)

    def material_count(self, sidecar: SidecarFile) -> int:
        return len(read_layered_sidecar(sidecar).materials)

    def textures_of(self, facts: Facts, present: Collection[str]) -> tuple[str, ...]:
        layers = facts.texts("layers")
        return tuple(layer for layer in layers if layer in present or layer not in OF_IMAGES)

    def flat(self, sidecar: SidecarFile, surface: SurfaceMesh) -> Generator[ExportStep, None, Floats]:
        return flat_layered(sidecar, surface)

    def check_textures(self, sidecar: SidecarFile, spec: ExportSpec) -> None:
        check_layered_textures(sidecar, spec)

    def write_textures(
        self, sidecar: SidecarFile, spec: ExportSpec, folder: Path, images: bool = False
    ) -> dict[str, TextureEntry]:
        return write_layered_textures(sidecar, spec, folder, OF_IMAGES if images else ())

    def includes(self, bake: Mapping[str, Any]) -> tuple[str, ...]:
        through = "through" in bake["layered"]
        return ("radtex_layered", "radtex_layered_through") if through else ("radtex_layered",)

    def usage(self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry]) -> list[str]:
        return [
            "radtex_layered(uv, position, N, V), premultiplied by radtex_alpha(uv), in the world space of",
            "the bake, in Blender's axes (z up). What to define, and all uniforms, stand in the manifest,",
            'under "shader"; those of a material are set where faces of that material are drawn.',
        ]

    def shader_facts(
        self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry], images: bool = False
    ) -> dict[str, Any] | None:
        return exported_facts(bake, textures, images)

    def hlsl(
        self,
        bake: Mapping[str, Any],
        textures: Mapping[str, TextureEntry],
        target: Target,
        images: bool = False,
    ) -> HlslLookup:
        return layered_lookup(exported_facts(bake, textures, images), textures, target)


def _most_shapes(texels: int) -> Shapes:
    """Width, height and channels of all images that a bake of a square atlas can have."""
    side = max(1, round(texels / coarser(texels)))
    fine, coarse = (round(finer(texels) * texels),) * 2, padded_size((side, side))
    sizes = dict.fromkeys((COLOUR, TINT, NORMAL, WIDTH, ALPHA), fine)
    sizes |= dict.fromkeys((IRRADIANCE, TANGENT), (texels, texels))
    sizes |= dict.fromkeys(PICTURES, packed_size(PICTURE_SIZE, level_count(PICTURE_SIZE)))
    sizes |= {DISTANCES: (DISTANCE_CELLS,) * 2, THROUGH_COLOUR: (side, side)}
    tiles = {OWN: CELLS[0].own, REST: CELLS[0].rest, THROUGH_REST: THROUGH_CELLS}
    tiles |= dict.fromkeys((EXIT_DIRECTION, EXIT_PLACE), EXIT_CELLS)
    sizes |= {name: (cells * coarse[0], cells * coarse[1]) for name, cells in tiles.items()}
    sizes[FIELD] = image_size((FIELD_SAMPLES,) * 3)
    return {name: (*sizes[name], channels) for name, channels in CHANNELS.items()}


FORM: Form = Layered()
