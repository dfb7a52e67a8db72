# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Render settings for captures: no filter, denoiser, adaptive sampling, crop or colour grading.

They are set on the scratch scene only. The settings of light paths (bounces, clamps, caustics, light tree,
the film's transparency) stay the user's.
"""

from __future__ import annotations

import logging
from typing import Any, cast

import bpy

from ..scene.lights.lamps import GROUP

log = logging.getLogger(__name__)


def apply_capture_settings(scene: bpy.types.Scene, samples: int, seed: int, first: int = 0) -> None:
    """Make `scene` render raw, unfiltered, scene-linear Rec.709 at exactly `samples` per pixel.

    The samples start at number `first` of Cycles's sequence. With the pattern TABULATED_SOBOL, 4 samples and
    the next 4 equal the first 8 (but beyond 256 the sequence changes whenever the total doubles); other
    patterns have a different sequence for each total.
    """
    _measure_evenly(cast(Any, scene).cycles, samples, seed, first)
    _output(scene.render)
    if any(GROUP in layer.lightgroups for layer in scene.view_layers):
        keep_passes(scene, ())  # light groups are written to multi-layer files only
    render = scene.render
    cast(Any, render).engine = "CYCLES"  # the stubs lack add-ons' engines
    render.use_motion_blur = False
    render.use_compositing = render.use_sequencer = render.use_freestyle = False
    render.use_multiview = render.use_stamp = False
    render.use_persistent_data = True
    render.use_border = render.use_crop_to_border = False
    render.resolution_percentage = 100
    render.pixel_aspect_x = render.pixel_aspect_y = 1
    scene.view_settings.view_transform = "Raw"


def _measure_evenly(cycles: Any, samples: int, seed: int, first: int) -> None:
    cycles.samples = first + samples
    cycles.use_sample_subset = first > 0
    cycles.sample_offset, cycles.sample_subset_length = first, samples
    cycles.seed = seed
    cycles.use_animated_seed = False
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.use_guiding = False  # behind portals it darkens texels, and its result depends on the tiles
    cycles.time_limit = 0
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0  # or neighbouring cells bleed into each other
    cycles.film_exposure = 1.0
    cycles.use_auto_tile = False
    cycles.texture_limit_render = "OFF"  # Simplify would shrink the images with the rays' starts
    if hasattr(cycles, "texture_resolution_render"):  # Blender 5
        cycles.texture_resolution_render = 100
    cycles.use_camera_cull = cycles.use_distance_cull = False  # the capture's camera is not the user's


def _output(render: bpy.types.RenderSettings) -> None:
    image = render.image_settings
    if hasattr(image, "media_type"):  # Blender 5; must be set before the format
        image.media_type = "IMAGE"
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGBA", "32"
    image.exr_codec = "NONE"
    image.color_management = "OVERRIDE"
    image.linear_colorspace_settings.name = "Linear Rec.709"
    render.use_file_extension = render.use_overwrite = True
    render.use_placeholder = False


def look_at_centres(scene: bpy.types.Scene) -> None:
    """Send every ray through its pixel's centre."""
    cycles = cast(Any, scene).cycles
    cycles.pixel_filter_type, cycles.filter_width = "GAUSSIAN", 0.01


def keep_passes(scene: bpy.types.Scene, passes: tuple[str, ...]) -> None:
    """Write passes, named as attributes of a view layer or of its `cycles`, beside the combined picture."""
    layer = next(layer for layer in scene.view_layers if layer.use)
    for name in passes:
        owner, _, attribute = name.rpartition(".")
        setattr(getattr(layer, owner) if owner else layer, attribute, True)
    image = scene.render.image_settings
    if hasattr(image, "media_type"):  # Blender 5
        image.media_type = "MULTI_LAYER_IMAGE"
    image.file_format, image.color_depth = "OPEN_EXR_MULTILAYER", "32"
    image.exr_codec = "NONE"


def denoise(scene: bpy.types.Scene) -> None:
    """Denoise the picture with OpenImageDenoise, if this Blender has it; else log a warning."""
    cycles = cast(Any, scene).cycles
    try:
        cycles.denoiser = "OPENIMAGEDENOISE"
    except TypeError:  # not among the enum's choices
        log.warning("this Blender has no OpenImageDenoise: pictures stay noisy, take more samples")
        return
    cycles.use_denoising = True


def first_hit_only(scene: bpy.types.Scene) -> None:
    """End paths at their first hit, for passes that do not depend on light."""
    cycles = cast(Any, scene).cycles
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 0


def allow_more_bounces(scene: bpy.types.Scene, transparent: int, glossy: int) -> None:
    """Add the bounces that the capture itself uses: portals are transparent bounces, mirrors glossy ones."""
    cycles = cast(Any, scene).cycles
    cycles.transparent_max_bounces += transparent
    cycles.glossy_bounces += glossy
    cycles.max_bounces += glossy
