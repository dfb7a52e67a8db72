# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the plain layout: capture every texel's bucket, cell by cell, and write the atlas and its layers."""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np

from ...bake.hidden_cells import HiddenCells
from ...bake.layers import WHOLE, Layer, captured, split_layers
from ...bake.piece_store import NO_STORE, PieceStore
from ...bake.plan import CapturePlan, plan_capture
from ...bake.progress import Progress, Stage, relayed
from ...bake.session import BYTES_PER_PIXEL, Capture, capture_bands
from ...bake.thumbnail import Thumbnail
from ...core.arrays import Floats
from ...core.atlas import AtlasLayout
from ...core.errors import InputError
from ...core.messages import Setting, do
from ...core.texel_map import TexelMap
from ...cycles.denoiser import image_denoiser
from ...cycles.layer_passes import PassesCapture
from ...cycles.panoramic import PanoramicCapture
from ...cycles.portal import PortalCapture
from ...formats.bucket_files import write_bands
from ...formats.disk.memory import readable_size
from ...formats.image_files import layer_path
from ...formats.sidecar import Content, Sidecar, check_readable
from ...prepare.prepared import Prepared
from ...scene.checks.finite_light import black_bake
from ...scene.checks.see_through import has_volumes
from ...scene.lights.light import is_dark
from ...scene.proxy_content import show_content_only
from ...scene.scratch import find_view_layer
from ...settings.spec import BakeSpec, CaptureMethod
from ..bake_job import BakeJob
from ..outcome import Outcome
from .previous_atlas import read_earlier, with_counts
from .recapture import Recapture, accumulated, chosen_texels, refreshed

log = logging.getLogger(__name__)


def bake_buckets(job: BakeJob) -> Generator[Progress, None, Outcome]:
    """As `Form.bake`; every finished tile is stored."""
    spec, prepared = job.spec, job.prepared
    scratch, folder, store = job.scratch, job.folder, job.store
    facts = prepared.facts(spec)
    earlier = read_earlier(job.sidecar, facts) if spec.incremental else None
    texels = prepared.texels()
    if earlier is not None and earlier.denoised:
        log.warning(
            "%s is denoised, and what is added to it is not: bake without denoising what is to be added to",
            job.sidecar.with_suffix(".exr").name,
        )
    plan, hidden, facts = yield from plan_buckets(scratch, spec, prepared, texels, folder, store)
    if earlier is None:
        capture = capture_of(scratch, plan, spec, folder)
        uncut = has_volumes(scratch)
        if uncut:
            _check_sheet(spec)
        steps = join_buckets(
            plan, capture, hidden, spec, job.sidecar, facts, folder, store, job.thumbnail, uncut,
            not is_dark(scratch, find_view_layer(scratch, None)),
        )  # fmt: skip
        return (yield from steps)
    chosen = chosen_texels(plan, texels, prepared.chosen, spec.where)
    again = Recapture(scratch, spec, spec.kind, texels, plan, hidden, earlier, chosen, folder)
    if spec.accumulate:
        expected = again.counts + np.where(chosen, spec.samples, 0)
        check_readable(with_counts(facts, plan.placed(expected, gutter=True)))
    work = refreshed if spec.refresh else accumulated
    image, paths, counts = yield from work(again, store, job.thumbnail)
    whole = [_images(image, plan.layout, spec.layers)]
    facts = replace(with_counts(facts, counts), denoised=earlier.denoised)
    return (yield from _write(plan, lambda: iter(whole), spec, job.sidecar, facts, paths, store))


def join_buckets(
    plan: CapturePlan,
    capture: Capture,
    hidden: HiddenCells | None,
    spec: BakeSpec,
    sidecar: Path,
    facts: Sidecar,
    folder: Path,
    store: PieceStore = NO_STORE,
    thumbnail: Thumbnail | None = None,
    uncut: bool = True,
    expects_light: bool = True,
) -> Generator[Progress, None, Outcome]:
    """Capture all tiles of the plan, and write the atlas with its layers, band by band.

    `folder` is for temporary files. The bake is written to the store's places for them (`PieceStore.place`).
    """
    memory, channels = spec.tile_mb, spec.channels
    layers = captured(spec.layers)
    with image_denoiser(folder) if spec.denoise else nullcontext() as denoiser:
        bands = yield from capture_bands(
            plan, capture, memory, hidden, store, thumbnail, channels, uncut, denoiser, layers
        )
    facts = replace(facts, denoised=denoiser is not None)
    paths = len(plan.texel) * spec.bucket**2 * spec.samples
    lit = False

    def images() -> Iterator[dict[str, Floats]]:
        nonlocal lit
        for band in bands.downwards():
            lit = lit or bool((band.buckets[..., :3] > 0).any())
            layout = AtlasLayout(plan.layout.width, len(band.buckets), plan.layout.bucket)
            yield _images(layout.from_buckets(band.buckets), layout, spec.layers)

    outcome = yield from _write(plan, images, spec, sidecar, facts, paths, store)
    if expects_light and not lit and spec.kind.traits.needs_light:
        log.warning(black_bake(sidecar.name.partition(".")[0]))
    return outcome


def _check_sheet(spec: BakeSpec) -> None:
    """Raises InputError where a sheet that cannot be cut takes more memory than is allowed."""
    needed = spec.sheet**2 * BYTES_PER_PIXEL * spec.channels // WHOLE
    if spec.memory_mb is not None and needed > spec.tile_mb << 20:
        raise InputError(
            f"pictures of a scene with volumes are not cut, and one of {spec.sheet} x {spec.sheet} pixels "
            f"needs {readable_size(needed)} of memory",
            do("allow more", Setting.MEMORY),
            do("take smaller ones", Setting.SHEET),
        )


def bucket_images(layers: Sequence[Layer], sidecar: Path) -> tuple[Path, ...]:
    """The paths of the atlas and its layers."""
    return (sidecar.with_suffix(".exr"), *(layer_path(sidecar, layer) for layer in layers))


def _images(image: Floats, layout: AtlasLayout, layers: Sequence[Layer]) -> dict[str, Floats]:
    """The images of an atlas, or of some of its rows, by layer; the atlas itself is called ""."""
    return {"": image[..., :WHOLE], **split_layers(image, layout, layers)}


def _write(
    plan: CapturePlan,
    images: Callable[[], Iterator[dict[str, Floats]]],
    spec: BakeSpec,
    sidecar: Path,
    facts: Sidecar,
    paths: int,
    store: PieceStore,
) -> Generator[Progress, None, Outcome]:
    layout = plan.layout

    def in_rows(done: int) -> Progress:
        return Progress(Stage.WRITE, done, layout.height)

    yield in_rows(0)
    place = store.place(sidecar)
    steps = write_bands(place, images, spec.layers, facts, spec.half, spec.compression)
    written = yield from relayed(steps, in_rows)
    return Outcome(bucket_images(spec.layers, sidecar), layout, len(plan.texel), paths, written.clamped)


def plan_buckets(
    scratch: bpy.types.Scene,
    spec: BakeSpec,
    prepared: Prepared,
    texels: TexelMap,
    folder: Path,
    store: PieceStore = NO_STORE,
) -> Generator[Progress, None, tuple[CapturePlan, HiddenCells | None, Sidecar]]:
    """The plan of the texels to capture, their hidden cells (None for kinds without), and the sidecar.

    For a proxy, the scene then shows only the hull's content.
    """
    facts = prepared.facts(spec)
    plan, hidden = yield from _plan(prepared, texels, spec, folder, store)
    if spec.kind.traits.content:
        named = show_content_only(scratch, prepared.original, spec.content)
        facts = replace(facts, content=Content(spec.content or "", named))
        check_readable(facts)
    return plan, hidden, facts


def _plan(
    prepared: Prepared, texels: TexelMap, spec: BakeSpec, folder: Path, store: PieceStore
) -> Generator[Progress, None, tuple[CapturePlan, HiddenCells | None]]:
    """The plan and its hidden cells (None for kinds without); texels that nobody can see are left out."""
    plan = plan_capture(texels, spec.bucket, sheet=spec.sheet)
    if not spec.kind.traits.looks_at_surface:
        return plan, None
    hidden = yield from prepared.hidden(plan, texels, folder, store)
    buried = hidden.buried
    if buried.any():
        plan = plan_capture(texels, spec.bucket, plan.texel[buried], spec.sheet)
    return plan, hidden.of_texels(~buried)


def capture_of(
    scratch: bpy.types.Scene, plan: CapturePlan, spec: BakeSpec, folder: Path, whole: bool = False
) -> Capture:
    """Set a scratch scene up to capture a plan; `whole` is as for `PortalCapture`."""
    kind = spec.kind
    if spec.layers:
        return PassesCapture(scratch, plan, kind, spec.layers, spec.samples, spec.seed, folder, whole)
    if spec.capture is CaptureMethod.PANORAMIC:
        return PanoramicCapture(scratch, plan, kind, spec.samples, spec.seed, folder)
    return PortalCapture(scratch, plan, kind, spec.samples, spec.seed, folder, whole=whole)
