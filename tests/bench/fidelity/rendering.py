# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One path-traced picture of a stage."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.formats.containers.exr import read_render
from radtex_addon.report.metrics import Picture

from .scenes.stage import PIXELS, Stage

_VERSION = 2  # raise it with every change of how pictures are rendered that shows


@dataclass(frozen=True)
class Rendering:
    """How a picture is rendered; `alone`: camera rays stop at whatever is not the subject."""

    samples: int
    seed: int
    alone: bool
    pixels: int = PIXELS
    version: int = _VERSION


@dataclass(frozen=True)
class Behind:
    """How a picture is rendered of what lies behind the subject, which only the camera does not see."""

    samples: int
    seed: int
    pixels: int = PIXELS
    version: int = 1  # raise it with every change of how these are rendered that shows


def render(stage: Stage, camera: bpy.types.Object, rendering: Rendering | Behind) -> Picture:
    """A denoised picture (H, W, 4), premultiplied, by a copy of the scene, so that it keeps its settings."""
    copy = cast(bpy.types.Scene, cast(bpy.types.Scene, bpy.context.scene).copy())
    try:
        copy.camera = camera
        cycles = cast(Any, copy).cycles
        cycles.samples, cycles.seed, cycles.use_adaptive_sampling = rendering.samples, rendering.seed, False
        cycles.use_denoising, cycles.denoiser = True, "OPENIMAGEDENOISE"
        cycles.pixel_filter_type = "BOX"
        cycles.filter_width = 1.0
        alone = isinstance(rendering, Rendering) and rendering.alone
        copy.render.film_transparent = alone
        copy.render.resolution_x = copy.render.resolution_y = rendering.pixels
        image = copy.render.image_settings
        if hasattr(image, "media_type"):
            image.media_type = "IMAGE"
        image.file_format, image.color_depth, image.color_mode = "OPEN_EXR", "32", "RGBA"
        hides = nullcontext() if isinstance(rendering, Rendering) else _unseen(stage.subject)
        with tempfile.TemporaryDirectory() as folder, _holdouts(stage, alone), hides:
            path = Path(folder, "view.exr")
            copy.render.filepath = str(path)
            bpy.ops.render.render(write_still=True, scene=copy.name)
            (pixels,) = read_render(path).values()
    finally:
        bpy.data.scenes.remove(copy)
    flipped: Picture = pixels[::-1].astype(np.float64)
    return flipped


@contextmanager
def _holdouts(stage: Stage, wanted: bool) -> Iterator[None]:
    """Make everything but the subject a holdout: nothing that camera rays meet, all that others do."""
    scene = cast(bpy.types.Scene, bpy.context.scene)
    others = [item for item in scene.objects if item.type == "MESH" and item != stage.subject]
    for item in others:
        item.is_holdout = wanted
    try:
        yield
    finally:
        for item in others:
            item.is_holdout = False


@contextmanager
def _unseen(subject: bpy.types.Object) -> Iterator[None]:
    """Hide the subject from camera rays; its shadow and its reflections stay."""
    before = subject.visible_camera
    subject.visible_camera = False
    try:
        yield
    finally:
        subject.visible_camera = before
