# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kinds `shadow` and `ao`: which directions are blocked, as bits or in the mean."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np

from ..bake.checkpoint import KEEPS_NOTHING, Keeper
from ..bake.plan import CapturePlan, plan_capture
from ..bake.progress import Progress, Stage
from ..bake.rays import PROBE_CELLS
from ..bake.session import fill_atlas
from ..bake.spec import BakeSpec, Kind
from ..bake.thumbnail import Thumbnail
from ..core.arrays import Floats
from ..core.atlas import AtlasLayout
from ..core.occlusion import occlusion
from ..core.shadow import pack_bits
from ..cycles.occlusion import OcclusionCapture
from ..formats.atomic import replacing
from ..formats.bucket_files import write_buckets
from ..formats.shadow_files import write_shadow
from ..formats.sidecar import Sidecar
from .files import OutputFiles
from .made import Made
from .prepare import Prepared

_ROWS = 64  # of texels, worked on at once


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
    plan = yield from plan_occlusion(prepared, spec.bucket, folder, keeper)
    capture = OcclusionCapture(scratch, plan, spec.kind, spec.samples, spec.seed, folder, spec.ao_distance)
    seen = yield from fill_atlas(plan, capture, spec.memory_mb, None, keeper, thumbnail, spec.channels)
    yield Progress(Stage.WRITE, 0, 1)
    layout = plan.layout
    facts = prepared.facts(spec)
    rays = spec.bucket**2 * capture.rays
    if spec.kind is Kind.SHADOW:
        written = _write_shadow(files, seen, layout, facts, spec)
    else:
        of_texel = replace(facts, bucket=1, samples=rays, ao_distance=spec.ao_distance)
        written = _write_ambient(files, seen, layout, of_texel, spec)
    return Made(
        files,
        AtlasLayout(layout.width, layout.height, written.bucket),
        len(plan.texel),
        len(plan.texel) * rays,
        0,
    )


def plan_occlusion(
    prepared: Prepared, bucket: int, folder: Path, keeper: Keeper = KEEPS_NOTHING
) -> Generator[Progress, None, CapturePlan]:
    """Where rays start, but for texels that nobody sees, where a part of the mesh is stuck into another.

    These would blend their dark into their neighbours; now what fills gutters fills them.
    """
    texels = prepared.texels()
    probe = plan_capture(texels, PROBE_CELLS)
    hidden = yield from prepared.hidden(probe, folder, keeper)
    return plan_capture(texels, bucket, without=probe.texel[hidden.all(axis=(1, 2))])


def _write_shadow(
    files: OutputFiles, seen: Floats, layout: AtlasLayout, facts: Sidecar, spec: BakeSpec
) -> Sidecar:
    """Write bits and their sidecar, both or neither; returns what the sidecar says."""
    words = np.concatenate([pack_bits(row[..., 0] < 0.5) for row in _by_rows(seen, layout)])
    with replacing(files.sidecar) as beside:  # left last: it takes its place once the bits are in theirs
        beside.write_text(facts.to_json(), encoding="utf-8", newline="\n")
        write_shadow(files.atlas, words, facts, spec.compression)
    return facts


def _write_ambient(
    files: OutputFiles, seen: Floats, layout: AtlasLayout, facts: Sidecar, spec: BakeSpec
) -> Sidecar:
    """Write one value a texel, which is a bucket of one cell with all the rays; returns the sidecar."""
    pixels = np.empty((layout.height, layout.width, 4), dtype=np.float32)
    first = 0
    for row in _by_rows(seen, layout):
        bent, ambient = occlusion(row[..., 0])
        pixels[first : first + len(row), :, :3] = bent
        pixels[first : first + len(row), :, 3] = ambient
        first += len(row)
    return write_buckets(files.sidecar, pixels, {}, facts, spec.half, spec.compression)


def _by_rows(seen: Floats, layout: AtlasLayout) -> Generator[Floats, None, None]:
    """The buckets (r, W, n, n, 1), some rows of texels at a time."""
    buckets = layout.to_buckets(seen)
    for first in range(0, layout.height, _ROWS):
        yield buckets[first : first + _ROWS]
