# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Path-traced pictures of a stage, rendered where the cache lacks them."""

from __future__ import annotations

from time import perf_counter

import bpy
import numpy as np

from radtex_addon.formats.disk.atomic import replacing
from radtex_addon.report.metrics import Picture

from .cache import picture_path
from .rendering import Behind, Rendering, render
from .scenes import Stage

SAMPLES = 1024  # of a pixel inside the subject, before it is denoised
LOTTERY_SAMPLES = 512
TUNING_SAMPLES = 256  # of the views that choices are tuned on
_BESIDE_SAMPLES = 64  # of a pixel that is not wholly inside the subject
_BESIDE_SEED = 44
_BEHIND_SAMPLES, _BEHIND_SEED = 256, 55  # of what is seen through the subject
_OPAQUE = 0.999


def picture(stage: Stage, camera: bpy.types.Object, samples: int, seed: int) -> Picture:
    """What a camera sees of the stage, (PIXELS, PIXELS, 3), linear, denoised, rows from the top.

    Pixels that the subject does not cover wholly are no part of what is measured; unless one sees through the
    subject, they are rendered with few samples, and paths from the camera end there for the many.
    """
    if stage.see_through:
        return _kept(stage, camera, Rendering(samples, seed, alone=False))[..., :3]
    alone = _alone(stage, camera, samples, seed)
    beside = _kept(stage, camera, Rendering(_BESIDE_SAMPLES, _BESIDE_SEED, alone=False))
    composed: Picture = np.where(alone[..., 3:] > _OPAQUE, alone[..., :3], beside[..., :3])
    return composed


def picture_inside(stage: Stage, camera: bpy.types.Object, samples: int, seed: int) -> Picture:
    """The same where the subject covers pixels wholly; unless one sees through it, less where it does not."""
    if stage.see_through:
        return picture(stage, camera, samples, seed)
    return _alone(stage, camera, samples, seed)[..., :3]


def picture_behind(stage: Stage, camera: bpy.types.Object, samples: int = _BEHIND_SAMPLES) -> Picture:
    """What a camera sees of the stage without the subject, whose shadows stay; as `picture` gives it."""
    return _kept(stage, camera, Behind(samples, _BEHIND_SEED))[..., :3]


def _alone(stage: Stage, camera: bpy.types.Object, samples: int, seed: int) -> Picture:
    """The subject alone before nothing, (PIXELS, PIXELS, 4), premultiplied."""
    return _kept(stage, camera, Rendering(samples, seed, alone=True))


def _kept(stage: Stage, camera: bpy.types.Object, rendering: Rendering | Behind) -> Picture:
    """A picture (H, W, 4) out of the cache, into which it is rendered if it lacks it."""
    path = picture_path(stage.name, camera.name, rendering)
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        started = perf_counter()
        rendered = render(stage, camera, rendering)
        with replacing(path) as beside, beside.open("wb") as file:
            np.save(file, rendered.astype(np.float32))
        what = f"{stage.name}, {camera.name}: {rendering.samples} samples, seed {rendering.seed}"
        print(f"{what}, rendered in {perf_counter() - started:.0f} s", flush=True)
    kept: Picture = np.load(path).astype(np.float64)
    return kept
