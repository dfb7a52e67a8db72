# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The form of kind `transfer`: one image of buckets that hold the whole sphere, of one view or several."""

from __future__ import annotations

from collections.abc import Collection, Generator, Mapping
from pathlib import Path
from typing import Any

import bpy

from ...bake.forms import SPHERE, FormTraits
from ...bake.progress import Progress
from ...bake.spec import BakeSpec
from ...bake.transfer_views import views_along
from ...core.arrays import Floats
from ...core.atlas import AtlasLayout
from ...core.sampler import with_views
from ...core.surface import SurfaceMesh
from ...formats.image_files import Shapes
from ...formats.json_reader import Facts
from ...formats.sidecar import Sidecar
from ...formats.sidecar_file import SidecarFile
from ...formats.transfer_files import TransferSidecar, read_transfer_sidecar
from ...preview.lit_material import preview_transfer_material
from ...preview.node_group import check_previewable
from ...preview.osl import add_transfer_osl_node
from ...textures.entry import TextureEntry
from ...textures.export_spec import ExportSpec, Step, Target
from ..bake_job import BakeJob
from ..buckets.form import Buckets, defines, has_samples_and_cells
from ..form import Form, PreviewOf
from ..hlsl_lookup import HlslLookup
from ..outcome import Outcome
from .bake import bake_transfer
from .hlsl import sphere_lookup
from .textures import check_sphere, flat_sphere, write_sphere

_PIXEL = 48  # bytes per pixel in an export, which reads the whole image


class Sphere(Buckets):
    """Buckets of all directions to the light, in one image: see `forms.form.Form`."""

    traits: FormTraits = SPHERE

    def bake(self, job: BakeJob) -> Generator[Progress, None, Outcome]:
        return bake_transfer(job)

    def check_previewable(self, spec: BakeSpec) -> None:
        layout = AtlasLayout(spec.texels, spec.texels, spec.bucket)
        check_previewable(with_views(layout, views_along(spec.view)))

    def material(self, of: PreviewOf) -> bpy.types.Material:
        facts, atlas = read_transfer_sidecar(of.sidecar), of.sidecar.with_suffix(".exr")
        return preview_transfer_material(
            of.title, atlas, facts.layout, of.uv_layer, of.scene, of.spec.half, facts.views
        )

    def script_node(self, tree: bpy.types.NodeTree, sidecar: SidecarFile) -> bpy.types.Node:
        facts, atlas = read_transfer_sidecar(sidecar), sidecar.path.with_suffix(".exr").absolute()
        return add_transfer_osl_node(tree, atlas, facts.layout, facts.views)

    def holds(self, facts: Facts) -> bool:
        return True

    def is_of(self, facts: Facts, spec: BakeSpec) -> bool:
        return has_samples_and_cells(facts, spec)

    def read_sidecar(self, sidecar: SidecarFile) -> Sidecar:
        return read_transfer_sidecar(sidecar).bake

    def shapes(self, sidecar: SidecarFile, texels: int = 1, cells: int = 1) -> Shapes:
        stored = read_transfer_sidecar(sidecar).stored
        factor = texels * cells
        return {"": (stored.pixel_width * factor, stored.pixel_height * factor, 4)}

    def export_bytes(self, sidecar: SidecarFile) -> int:
        stored = read_transfer_sidecar(sidecar).stored
        return _PIXEL * stored.pixel_width * stored.pixel_height

    def textures_of(self, facts: Facts, present: Collection[str]) -> tuple[str, ...]:
        return (TransferSidecar.from_facts(facts).bake.kind,)

    def flat(self, sidecar: SidecarFile, surface: SurfaceMesh) -> Generator[Step, None, Floats]:
        yield from ()
        return flat_sphere(sidecar, surface)

    def check_textures(self, sidecar: SidecarFile, spec: ExportSpec) -> None:
        check_sphere(sidecar, spec)

    def write_textures(self, sidecar: SidecarFile, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
        return write_sphere(sidecar, spec, folder)

    def includes(self, bake: Mapping[str, Any]) -> tuple[str, ...]:
        return ("radtex", "radtex_transfer")

    def usage(self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry]) -> list[str]:
        size, n, views = "({}, {})".format(*bake["texels"]), bake["bucket"], bake["transfer"].get("views", 1)
        lookup = f"radtex_transfer(atlas, {size}, {n}, uv, L)"
        if views > 1:
            lookup = f"radtex_transfer_around(atlas, {size}, {views}, {n}, uv, I, L)"
        return [*defines(textures[bake["kind"]]), f"{lookup}, L being the light's direction"]

    def hlsl(
        self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry], target: Target
    ) -> HlslLookup:
        return sphere_lookup(bake, textures, target)


FORM: Form = Sphere()
