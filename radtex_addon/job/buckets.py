# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The plain layout: every texel's bucket is captured, cell by cell, and written; layers lie beside."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

import bpy

from ..bake.capture import Capture
from ..bake.checkpoint import KEEPS_NOTHING, Keeper
from ..bake.layers import WHOLE, split_layers
from ..bake.plan import CapturePlan, plan_capture
from ..bake.progress import Progress, Stage
from ..bake.session import fill_atlas
from ..bake.spec import BakeSpec, CaptureMethod, Kind
from ..bake.thumbnail import Thumbnail
from ..core.arrays import Bools
from ..core.texel_map import TexelMap
from ..cycles.hidden import find_hidden
from ..cycles.layers import LayeredCapture
from ..cycles.panoramic import PanoramicCapture
from ..cycles.portal import PortalCapture
from ..formats.bucket_files import write_buckets
from ..scene.enclosed import show_content_only
from .accumulate import read_earlier
from .files import OutputFiles, facts_of
from .made import Made
from .prepare import Prepared
from .refresh import Refresh


def bake_buckets(
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
    facts = facts_of(
        original.name,
        spec,
        prepared.width,
        prepared.height,
        prepared.uv_layer,
        prepared.digest,
        source=prepared.source_facts,
    )
    earlier = read_earlier(files, facts) if spec.accumulate or spec.refresh else None
    texels = prepared.texels()
    plan, hidden = yield from _plan(prepared, texels, spec, folder, keeper)
    if spec.kind is Kind.PROXY:
        show_content_only(scratch, original, spec.content)
    count = len(plan.texel)
    paths = count * spec.bucket**2 * spec.samples
    if earlier is not None and spec.refresh:
        work = Refresh(scratch, spec, _rays(spec), texels, plan, hidden, earlier, folder)
        image, paths = yield from work.steps(keeper, thumbnail)
        facts = replace(facts, samples=earlier.samples)
    else:
        capture = _capture(scratch, plan, spec, folder, earlier.samples if earlier else 0)
        image = yield from fill_atlas(plan, capture, spec.memory_mb, hidden, keeper, thumbnail, spec.channels)
        if earlier is not None:
            image, facts = earlier.with_more(image, facts)
    yield Progress(Stage.WRITE, 0, 1)
    layers = split_layers(image, plan.layout, spec.layers)
    written = write_buckets(files.sidecar, image[..., :WHOLE], layers, facts, spec.half, spec.compression)
    return Made(files, plan.layout, count, paths, written.clamped)


def _plan(
    prepared: Prepared, texels: TexelMap, spec: BakeSpec, folder: Path, keeper: Keeper
) -> Generator[Progress, None, tuple[CapturePlan, Bools | None]]:
    """What to capture, and which cells of it nobody sees; texels that nobody sees at all cost no path."""
    plan = plan_capture(texels, spec.bucket)
    if spec.kind is not Kind.RADIANCE:
        return plan, None
    hidden = yield from find_hidden(*prepared.seen, plan, folder, keeper)
    buried = hidden.all(axis=(1, 2))
    return plan_capture(texels, spec.bucket, without=plan.texel[buried]), hidden[~buried]


def _rays(spec: BakeSpec) -> Kind:
    """A proxy's rays are radiance's, in a scene without it."""
    return Kind.RADIANCE if spec.kind is Kind.PROXY else spec.kind


def _capture(
    scratch: bpy.types.Scene, plan: CapturePlan, spec: BakeSpec, folder: Path, first: int
) -> Capture:
    kind = _rays(spec)
    if spec.layers:
        return LayeredCapture(scratch, plan, kind, spec.layers, spec.samples, spec.seed, folder)
    if spec.capture is CaptureMethod.PANORAMIC:
        return PanoramicCapture(scratch, plan, kind, spec.samples, spec.seed, folder)
    return PortalCapture(scratch, plan, kind, spec.samples, spec.seed, folder, first=first)
