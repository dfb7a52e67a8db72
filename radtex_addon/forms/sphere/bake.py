# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kind `transfer`: capture the object under suns all around, and fit each texel's bucket to that light."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace

import numpy as np

from ...bake.denoising import Denoiser, denoise_pictures, squares
from ...bake.plan import CapturePlan
from ...bake.progress import Progress, Stage
from ...bake.spec import View
from ...bake.transfer_buckets import fit_buckets, view_shift, views_along
from ...core.arrays import Floats
from ...core.atlas import AtlasLayout
from ...cycles.denoiser import image_denoiser
from ...cycles.transfer_capture import MOST, Lit, capture_under_suns
from ...formats.transfer_files import TransferSidecar, write_transfer
from ...scene.camera_place import find_camera_place
from ...scene.scratch import scene_copied
from ..bake_job import BakeJob
from ..outcome import Outcome


def bake_transfer(job: BakeJob) -> Generator[Progress, None, Outcome]:
    """As `Form.bake`; every finished render is stored."""
    spec, prepared = job.spec, job.prepared
    eye = find_camera_place(job.scratch) if spec.view is View.CAMERA else None
    views = views_along(spec.view)
    plan = yield from prepared.plan_of_seen(views, job.folder, job.store)
    suns, shift = spec.bucket**2, view_shift(plan, eye)
    with scene_copied(job.scratch) as scene:
        lit = yield from capture_under_suns(
            scene, plan, shift, suns, spec.samples, spec.seed, job.folder, job.store, job.thumbnail
        )
    facts = prepared.facts(spec)
    if spec.denoise:
        with image_denoiser(job.folder) as denoiser:
            if denoiser is not None:
                lit = yield from _denoised(plan, lit, denoiser)
                facts = replace(facts, denoised=True)
    atlas = yield from _atlas(plan, lit, spec.bucket)
    yield Progress(Stage.WRITE, 0, 1)
    layout = AtlasLayout(plan.layout.width, plan.layout.height, spec.bucket)
    place = None if eye is None else (*eye.place, 0.0 if eye.far else 1.0)
    described = TransferSidecar(facts, suns, spec.view, place, views)
    written = write_transfer(job.place, atlas, described, spec.half, spec.compression)
    count = len(plan.texel)
    paths = count * views**2 * suns * spec.samples
    return Outcome((job.sidecar.with_suffix(".exr"),), layout, count, paths, written.bake.clamped)


def _denoised(plan: CapturePlan, lit: Lit, denoiser: Denoiser) -> Generator[Progress, None, Lit]:
    """Denoise the light of each view: for each sun, the picture over texels."""
    light = np.empty_like(lit.light)
    count, views, done = len(plan.texel), light.shape[2], 0
    for square in squares(plan, len(light)):
        own = square.texels[square.own]
        for view in range(views):
            yield Progress(Stage.DENOISE, done // views, count)
            values = lit.light[:, square.texels, view].transpose(1, 0, 2)
            found = denoise_pictures(values, square.picture, denoiser)[square.own]
            light[:, own, view] = np.minimum(found, MOST).transpose(1, 0, 2)
            done += len(own)
    yield Progress(Stage.DENOISE, count, count)
    return Lit(light, lit.alpha)


def _atlas(plan: CapturePlan, lit: Lit, n: int) -> Generator[Progress, None, Floats]:
    """The image (H*k*n, W*k*n, 4) float32 of k x k views, gutter filled."""
    layout, k = plan.layout, plan.layout.bucket
    atlas = np.empty((layout.height, k, n, layout.width, k, n, 4), dtype=np.float32)
    for view in range(k * k):
        light = yield from fit_buckets(plan, lit.light[:, :, view], n)
        alpha = np.repeat(lit.alpha[:, view, None, None].astype(np.float32), n * n, axis=1)
        rgba = np.concatenate([light, alpha], axis=2).reshape(-1, n, n, 4)
        atlas[:, view // k, :, :, view % k] = plan.placed(rgba, gutter=True).transpose(0, 2, 1, 3, 4)
    return atlas.reshape(layout.height * k * n, layout.width * k * n, 4)
