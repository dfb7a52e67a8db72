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
from ..cycles.layers import LayeredCapture
from ..cycles.panoramic import PanoramicCapture
from ..cycles.portal import PortalCapture
from ..formats.bucket_files import write_buckets
from ..formats.sidecar import Content
from ..scene.enclosed import show_content_only
from .accumulate import accumulated
from .again import Again, chosen_texels
from .earlier import read_earlier, with_counts
from .files import OutputFiles
from .made import Made
from .prepare import Prepared
from .refresh import refreshed


def bake_buckets(
    scratch: bpy.types.Scene,
    spec: BakeSpec,
    files: OutputFiles,
    prepared: Prepared,
    folder: Path,
    keeper: Keeper = KEEPS_NOTHING,
    thumbnail: Thumbnail | None = None,
) -> Generator[Progress, None, Made]:
    """Bake what is prepared; `folder` takes temporary files, the `keeper` every finished tile."""
    facts = prepared.facts(spec)
    earlier = read_earlier(files, facts) if spec.accumulate or spec.refresh else None
    texels = prepared.texels()
    plan, hidden = yield from _plan(prepared, texels, spec, folder, keeper)
    if spec.kind is Kind.PROXY:
        named = show_content_only(scratch, prepared.original, spec.content)
        facts = replace(facts, content=Content(spec.content or "", named))
    count = len(plan.texel)
    paths = count * spec.bucket**2 * spec.samples
    if earlier is not None:
        chosen = chosen_texels(plan, texels, prepared.chosen, spec.where)
        again = Again(scratch, spec, _rays(spec), texels, plan, hidden, earlier, chosen, folder)
        work = refreshed if spec.refresh else accumulated
        image, paths, counts = yield from work(again, keeper, thumbnail)
        facts = with_counts(facts, counts)
    else:
        capture = _capture(scratch, plan, spec, folder)
        image = yield from fill_atlas(plan, capture, spec.memory_mb, hidden, keeper, thumbnail, spec.channels)
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
    hidden = yield from prepared.hidden(plan, folder, keeper)
    buried = hidden.all(axis=(1, 2))
    return plan_capture(texels, spec.bucket, without=plan.texel[buried]), hidden[~buried]


def _rays(spec: BakeSpec) -> Kind:
    """A proxy's rays are radiance's, in a scene without it."""
    return Kind.RADIANCE if spec.kind is Kind.PROXY else spec.kind


def _capture(scratch: bpy.types.Scene, plan: CapturePlan, spec: BakeSpec, folder: Path) -> Capture:
    kind = _rays(spec)
    if spec.layers:
        return LayeredCapture(scratch, plan, kind, spec.layers, spec.samples, spec.seed, folder)
    if spec.capture is CaptureMethod.PANORAMIC:
        return PanoramicCapture(scratch, plan, kind, spec.samples, spec.seed, folder)
    return PortalCapture(scratch, plan, kind, spec.samples, spec.seed, folder)
