# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kinds `shadow` and `ao`: which directions are blocked, as bits or in the mean."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np

from ..bake.bands import Bands
from ..bake.keeper import KEEPS_NOTHING, Keeper
from ..bake.progress import Progress, Stage
from ..bake.session import capture_bands
from ..bake.spec import BakeSpec, Kind
from ..bake.thumbnail import Thumbnail
from ..core.atlas import AtlasLayout
from ..core.occlusion import occlusion
from ..core.shadow import pack_bits
from ..cycles.occlusion import OcclusionCapture
from ..formats.atomic import replacing
from ..formats.bucket_files import write_buckets
from ..formats.shadow_files import write_shadow
from ..formats.sidecar import Sidecar
from .bake_output import Made
from .files import OutputFiles
from .prepare import Prepared


def bake_occlusion(
    scratch: bpy.types.Scene,
    spec: BakeSpec,
    files: OutputFiles,
    prepared: Prepared,
    folder: Path,
    keeper: Keeper = KEEPS_NOTHING,
    thumbnail: Thumbnail | None = None,
) -> Generator[Progress, None, Made]:
    """Bake what is prepared; `folder` takes temporary files, the `keeper` every finished tile."""
    plan = yield from prepared.plan_of_seen(spec.bucket, folder, keeper)
    capture = OcclusionCapture(scratch, plan, spec.kind, spec.samples, spec.seed, folder, spec.ao_distance)
    bands = yield from capture_bands(plan, capture, spec.tile_mb, None, keeper, thumbnail, spec.channels)
    yield Progress(Stage.WRITE, 0, 1)
    layout = plan.layout
    facts = prepared.facts(spec)
    rays = spec.bucket**2 * capture.rays
    place = keeper.place(files.sidecar)
    if spec.kind is Kind.SHADOW:
        written = _write_shadow(place, bands, facts, spec)
    else:
        of_texel = replace(facts, bucket=1, samples=rays, ao_distance=spec.ao_distance)
        written = _write_ambient(place, bands, layout, of_texel, spec)
    return Made(
        files,
        AtlasLayout(layout.width, layout.height, written.bucket),
        len(plan.texel),
        len(plan.texel) * rays,
        0,
    )


def _write_shadow(path: Path, bands: Bands, facts: Sidecar, spec: BakeSpec) -> Sidecar:
    """Write the sidecar to `path` and the bits beside it, both or neither; returns what the sidecar says."""
    rows = [pack_bits(band.buckets[..., 0] < 0.5) for band in bands.downwards()]
    words = np.concatenate(rows[::-1])
    with replacing(path) as beside:  # left last: it takes its place once the bits are in theirs
        beside.write_text(facts.to_json(), encoding="utf-8", newline="\n")
        write_shadow(path.with_suffix(".exr"), words, facts, spec.compression)
    return facts


def _write_ambient(path: Path, bands: Bands, layout: AtlasLayout, facts: Sidecar, spec: BakeSpec) -> Sidecar:
    """Write one value a texel, which is a bucket of one cell with all the rays; returns the sidecar."""
    pixels = np.empty((layout.height, layout.width, 4), dtype=np.float32)
    for band in bands.downwards():
        bent, ambient = occlusion(band.buckets[..., 0])
        pixels[band.first : band.end, :, :3] = bent
        pixels[band.first : band.end, :, 3] = ambient
    return write_buckets(path, pixels, {}, facts, spec.half, spec.compression)
