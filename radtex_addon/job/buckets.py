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
from ..core.arrays import Bools, Floats
from ..core.texel_map import TexelMap
from ..cycles.layers import LayeredCapture
from ..cycles.panoramic import PanoramicCapture
from ..cycles.portal import PortalCapture
from ..formats.bucket_files import write_buckets
from ..formats.sidecar import Content, Sidecar
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
    plan, hidden, facts = yield from plan_buckets(scratch, spec, prepared, texels, folder, keeper)
    if earlier is None:
        capture = capture_of(scratch, plan, spec, folder)
        return (yield from join_buckets(plan, capture, hidden, spec, files, facts, keeper, thumbnail))
    chosen = chosen_texels(plan, texels, prepared.chosen, spec.where)
    again = Again(scratch, spec, _rays(spec), texels, plan, hidden, earlier, chosen, folder)
    work = refreshed if spec.refresh else accumulated
    image, paths, counts = yield from work(again, keeper, thumbnail)
    return (yield from _write(plan, image, spec, files, with_counts(facts, counts), paths))


def join_buckets(
    plan: CapturePlan,
    capture: Capture,
    hidden: Bools | None,
    spec: BakeSpec,
    files: OutputFiles,
    facts: Sidecar,
    keeper: Keeper = KEEPS_NOTHING,
    thumbnail: Thumbnail | None = None,
) -> Generator[Progress, None, Made]:
    """Ask the capture for all tiles of the plan, and write the atlas with its layers."""
    image = yield from fill_atlas(plan, capture, spec.memory_mb, hidden, keeper, thumbnail, spec.channels)
    paths = len(plan.texel) * spec.bucket**2 * spec.samples
    return (yield from _write(plan, image, spec, files, facts, paths))


def _write(
    plan: CapturePlan, image: Floats, spec: BakeSpec, files: OutputFiles, facts: Sidecar, paths: int
) -> Generator[Progress, None, Made]:
    yield Progress(Stage.WRITE, 0, 1)
    layers = split_layers(image, plan.layout, spec.layers)
    written = write_buckets(files.sidecar, image[..., :WHOLE], layers, facts, spec.half, spec.compression)
    return Made(files, plan.layout, len(plan.texel), paths, written.clamped)


def plan_buckets(
    scratch: bpy.types.Scene,
    spec: BakeSpec,
    prepared: Prepared,
    texels: TexelMap,
    folder: Path,
    keeper: Keeper = KEEPS_NOTHING,
) -> Generator[Progress, None, tuple[CapturePlan, Bools | None, Sidecar]]:
    """What to capture in a scene that then shows nothing else, which cells nobody sees, and what that is."""
    facts = prepared.facts(spec)
    plan, hidden = yield from _plan(prepared, texels, spec, folder, keeper)
    if spec.kind is Kind.PROXY:
        named = show_content_only(scratch, prepared.original, spec.content)
        facts = replace(facts, content=Content(spec.content or "", named))
    return plan, hidden, facts


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


def capture_of(
    scratch: bpy.types.Scene, plan: CapturePlan, spec: BakeSpec, folder: Path, whole: bool = False
) -> Capture:
    """Set a scratch scene up to capture a plan; `whole` is the portal's."""
    kind = _rays(spec)
    if spec.layers:
        return LayeredCapture(scratch, plan, kind, spec.layers, spec.samples, spec.seed, folder, whole)
    if spec.capture is CaptureMethod.PANORAMIC:
        return PanoramicCapture(scratch, plan, kind, spec.samples, spec.seed, folder)
    return PortalCapture(scratch, plan, kind, spec.samples, spec.seed, folder, whole=whole)
