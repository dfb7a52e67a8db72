# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The form of kind `ao`: an image of buckets of one cell, with a direction and an openness."""

from __future__ import annotations

from collections.abc import Generator
from math import ceil, isqrt, sqrt

import bpy

from ...bake.cost import Cost, cost_of_images
from ...bake.forms import AMBIENT, FormTraits
from ...bake.kinds import KINDS, Kind
from ...bake.layers import WHOLE
from ...bake.plan import MAX_IMAGE_SIDE
from ...bake.progress import Progress
from ...bake.spec import BakeSpec
from ...core.arrays import Floats
from ...core.atlas import AtlasLayout
from ...core.surface import SurfaceMesh
from ...formats.json_reader import Facts
from ...formats.sidecar_file import SidecarFile
from ...preview.lit_material import preview_ambient_material
from ...preview.node_group import check_previewable
from ...preview.osl import no_script
from ...textures.export_spec import Step
from ..bake_job import BakeJob
from ..buckets.flat import flat_buckets
from ..buckets.form import Buckets, layout_in
from ..form import Form, PreviewOf
from ..outcome import Outcome
from .bake import bake_ambient

_OPENNESS = slice(3, None)  # the channel


class Ambient(Buckets):
    """One value per texel: see `forms.form.Form`."""

    traits: FormTraits = AMBIENT

    def bake(self, job: BakeJob) -> Generator[Progress, None, Outcome]:
        return bake_ambient(job)

    def cost(self, spec: BakeSpec) -> Cost:
        return cost_of_images(spec, {"atlas": (spec.texels, spec.texels, WHOLE)})

    def check_previewable(self, spec: BakeSpec) -> None:
        check_previewable(AtlasLayout(spec.texels, spec.texels, 1))

    def material(self, of: PreviewOf) -> bpy.types.Material:
        layout, atlas = layout_in(of.sidecar), of.sidecar.with_suffix(".exr")
        return preview_ambient_material(of.title, atlas, layout, of.uv_layer, of.spec.half)

    def script_node(self, tree: bpy.types.NodeTree, sidecar: SidecarFile) -> bpy.types.Node:
        raise no_script(sidecar)

    def holds(self, facts: Facts) -> bool:
        kind = facts.text("kind")
        return kind in tuple(Kind) and KINDS[Kind(kind)].form == self.traits

    def is_of(self, facts: Facts, spec: BakeSpec) -> bool:
        """The sidecar's samples are rays per texel; with a distance, their number per cell is a square."""
        samples, cells = facts.whole_number("samples", 1), spec.bucket**2
        if facts.values.get("layers") != []:
            return False
        if spec.ao_distance is None:
            return samples == cells * spec.samples
        wanted, had = ceil(sqrt(spec.samples)), isqrt(samples // cells)
        if samples != cells * had**2 or had > wanted:
            return False
        largest = max(facts.size("texels")) * spec.bucket
        return had == wanted or (had + 1) * largest > MAX_IMAGE_SIDE  # the image had no room for more

    def flat(self, sidecar: SidecarFile, surface: SurfaceMesh) -> Generator[Step, None, Floats]:
        yield from ()
        return flat_buckets(sidecar, surface, _OPENNESS)


FORM: Form = Ambient()
