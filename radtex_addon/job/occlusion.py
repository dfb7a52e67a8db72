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
from .files import OutputFiles, facts_of
from .made import Made
from .prepare import Prepared

_ROWS = 64  # of texels, worked on at once


def bake_occlusion(
    scratch: bpy.types.Scene,
    original: bpy.types.Object,
    spec: BakeSpec,
    files: OutputFiles,
    prepared: Prepared,
    folder: Path,
    keeper: Keeper = KEEPS_NOTHING,
    thumbnail: Thumbnail | None = None,
) -> Generator[Progress, None, Made]:
    """Bake the scratch scene's object; `folder` takes temporary files, the `keeper` every finished tile."""
    plan = plan_capture(prepared.texels(), spec.bucket)
    capture = OcclusionCapture(scratch, plan, spec.kind, spec.samples, spec.seed, folder)
    seen = yield from fill_atlas(plan, capture, spec.memory_mb, None, keeper, thumbnail, spec.channels)
    yield Progress(Stage.WRITE, 0, 1)
    layout = plan.layout
    facts = facts_of(
        original.name, spec, layout.width, layout.height, prepared.uv_layer, source=prepared.source_facts
    )
    write = _write_shadow if spec.kind is Kind.SHADOW else _write_ambient
    written = write(files, seen, layout, facts, spec)
    return Made(
        files,
        AtlasLayout(layout.width, layout.height, written.bucket),
        len(plan.texel),
        _paths(plan, spec),
        0,
    )


def _paths(plan: CapturePlan, spec: BakeSpec) -> int:
    return len(plan.texel) * spec.bucket**2 * spec.samples


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
    of_texel = replace(facts, bucket=1, samples=spec.samples * spec.bucket**2)
    return write_buckets(files.sidecar, pixels, {}, of_texel, spec.half, spec.compression)


def _by_rows(seen: Floats, layout: AtlasLayout) -> Generator[Floats, None, None]:
    """The buckets (r, W, n, n, 1), some rows of texels at a time."""
    buckets = layout.to_buckets(seen)
    for first in range(0, layout.height, _ROWS):
        yield buckets[first : first + _ROWS]
