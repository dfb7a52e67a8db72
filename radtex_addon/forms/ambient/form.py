# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The form of kind `ao`: an image of buckets of one cell, with a direction and an openness.

They say how much of the sky each texel sees, and in which direction most of it lies.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from math import ceil, isqrt, sqrt
from pathlib import Path

import bpy
import numpy as np

from ...bake.layers import WHOLE
from ...bake.plan import MAX_IMAGE_SIDE
from ...bake.progress import Progress
from ...core.arrays import Floats
from ...core.atlas import AtlasLayout
from ...core.hemisphere import occlusion
from ...core.surface import SurfaceMesh
from ...formats.bucket_files import write_buckets
from ...formats.json_reader import Facts
from ...formats.sidecar import Sidecar
from ...formats.sidecar_file import SidecarFile
from ...preview.lit_material import preview_ambient_material
from ...preview.node_group import check_previewable
from ...preview.osl import no_script
from ...settings.cost import Cost, cost_of_images
from ...settings.forms import AMBIENT, FormTraits
from ...settings.kinds import KINDS, Kind
from ...settings.spec import BakeSpec
from ...textures.export_spec import ExportStep
from ..bake_job import BakeJob
from ..buckets.form import Buckets, layout_in
from ..buckets.textures import flat_buckets
from ..form import Form, PreviewOf
from ..occlusion_bake import OcclusionCaptured, capture_occlusion
from ..outcome import Outcome

_OPENNESS = slice(3, None)  # the channel


def bake_ambient(job: BakeJob) -> Generator[Progress, None, Outcome]:
    """As `Form.bake`."""
    captured, spec = (yield from capture_occlusion(job)), job.spec
    facts = replace(job.prepared.facts(spec), bucket=1, samples=captured.rays, ao_distance=spec.ao_distance)
    _write(job.place, captured, facts, spec)
    layout = captured.plan.layout
    return Outcome(
        images=(job.sidecar.with_suffix(".exr"),),
        layout=AtlasLayout(layout.width, layout.height, 1),
        covered_texels=len(captured.plan.texel),
        paths=len(captured.plan.texel) * captured.rays,
        clamped=0,
    )


def _write(path: Path, captured: OcclusionCaptured, facts: Sidecar, spec: BakeSpec) -> None:
    """Write one value per texel: a bucket of one cell, the mean over all rays."""
    layout = captured.plan.layout
    pixels = np.empty((layout.height, layout.width, 4), dtype=np.float32)
    for band in captured.bands.downwards():
        bent, ambient = occlusion(band.buckets[..., 0])
        pixels[band.first : band.end, :, :3] = bent
        pixels[band.first : band.end, :, 3] = ambient
    write_buckets(path, pixels, {}, facts, spec.half, spec.compression)


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

    def flat(self, sidecar: SidecarFile, surface: SurfaceMesh) -> Generator[ExportStep, None, Floats]:
        yield from ()
        return flat_buckets(sidecar, surface, _OPENNESS)


FORM: Form = Ambient()
