# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake as it is: buckets of cells, looked up quadrilinearly."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.bake.progress import Stage as JobStage
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.job import bake_object
from radtex_addon.report.gbuffer import Array, GBuffer
from radtex_addon.settings.spec import BakeSpec

from ..method import Baked
from ..scenes import Stage

_HALF = 2  # bytes of a channel


@dataclass(frozen=True, eq=False)
class BucketBake:
    """A bake in layout buckets: its image and layout, and all of `Baked` but how it is looked up."""

    image: Floats
    layout: AtlasLayout
    unseen: Baked

    def looked_up(self, filtered: Filter) -> Baked:
        """The bake by one of the reference sampler's filters."""

        def radiance(buffer: GBuffer) -> Array:
            uv, incidence = buffer.uv[buffer.hit], buffer.incidence[buffer.hit]
            return buffer.spread(sample(self.image, self.layout, uv, incidence, filtered)[:, :3])

        return replace(self.unseen, radiance=radiance)


def bake_buckets(stage: Stage, spec: BakeSpec, folder: Path) -> BucketBake:
    """Bake by `bake_object`, as a user does."""
    scene = cast(bpy.types.Scene, bpy.context.scene)
    name = stage.subject.name
    result = bake_object(scene, name, spec, folder, preview=Filter.QUADRILINEAR, overwrite=True)
    image, sidecar = read_atlas(result.files.atlas)
    assert result.files.preview is not None
    unseen = Baked(
        paths=result.paths,
        seconds=sum(value for part, value in result.seconds.items() if part is not JobStage.PREVIEW),
        bytes=image.size * _HALF,
        radiance=lambda buffer: np.zeros((len(buffer.hit), 3)),
        mesh=mesh_of_preview(result.files.preview, name),
        matrix_world=np.array(stage.subject.matrix_world),
        uv_layer=sidecar.uv_map,
    )
    return BucketBake(
        image.astype(np.float32), AtlasLayout(sidecar.width, sidecar.height, sidecar.bucket), unseen
    )


class Plain:
    """`bake_object` with its reference sampler."""

    name = "plain"

    def __init__(self, spec: BakeSpec) -> None:
        self.spec = spec

    def bake(self, stage: Stage, folder: Path) -> Baked:
        return bake_buckets(stage, self.spec, folder).looked_up(Filter.QUADRILINEAR)


def mesh_of_preview(path: Path, name: str) -> bpy.types.Mesh:
    """The baked copy's mesh out of a saved preview, brought into the open file."""
    with cast(Any, bpy.data.libraries).load(str(path)) as (_, wanted):
        wanted.objects = [name]
    return cast(bpy.types.Mesh, wanted.objects[0].data)


def make(texels: int, samples: int) -> Plain:
    """The plain method with buckets of 8 x 8 cells."""
    return Plain(BakeSpec(texels=texels, bucket=8, samples=samples))
