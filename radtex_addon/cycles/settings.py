# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Render settings under which Cycles measures: everything that would blur, reuse, crop or grade is off.

They are written on the scratch scene only. What decides how light travels (bounces, clamps, caustics, light
tree, the film's transparency) stays the user's.
"""

from __future__ import annotations

import logging
from typing import Any, cast

import bpy

from ..scene.lamps import GROUP

log = logging.getLogger(__name__)


def apply_capture_settings(scene: bpy.types.Scene, samples: int, seed: int, first: int = 0) -> None:
    """Make `scene` render raw, unfiltered, scene-linear Rec.709 at exactly `samples` per pixel.

    They are those from the number `first` on. Of the pattern TABULATED_SOBOL 4 and the next 4 are the first 8
    (beyond 256 the sequence is another whenever their number doubles); others have one for each number.
    """
    _measure_evenly(cast(Any, scene).cycles, samples, seed, first)
    _output(scene.render)
    if any(GROUP in layer.lightgroups for layer in scene.view_layers):
        keep_passes(scene, ())  # the lamps' own
    render = scene.render
    cast(Any, render).engine = "CYCLES"  # the stubs know no add-on's engine
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
    cycles.use_guiding = False  # what it learns behind portals darkens texels, and depends on the tiles
    cycles.time_limit = 0
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0  # or neighbouring cells bleed into each other
    cycles.film_exposure = 1.0
    cycles.use_auto_tile = False
    cycles.texture_limit_render = "OFF"  # Simplify's: it would shrink the images that say where rays start
    if hasattr(cycles, "texture_resolution_render"):  # Blender 5
        cycles.texture_resolution_render = 100
    cycles.use_camera_cull = cycles.use_distance_cull = False  # they ask a camera that is none of the scene's


def _output(render: bpy.types.RenderSettings) -> None:
    image = render.image_settings
    if hasattr(image, "media_type"):  # Blender 5: to be set before the format
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
    """Let OpenImageDenoise clean the picture, where this Blender was built with it."""
    cycles = cast(Any, scene).cycles
    try:
        cycles.denoiser = "OPENIMAGEDENOISE"
    except TypeError:  # of a choice that is not among those there are
        log.warning("this Blender has no OpenImageDenoise: pictures stay noisy, take more samples")
        return
    cycles.use_denoising = True


def first_hit_only(scene: bpy.types.Scene) -> None:
    """Let paths end where they first meet something: for passes that know nothing of light."""
    cycles = cast(Any, scene).cycles
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 0


def allow_more_bounces(scene: bpy.types.Scene, transparent: int, glossy: int) -> None:
    """Pay for what the apparatus spends of a path: portals are transparent bounces, mirrors glossy ones."""
    cycles = cast(Any, scene).cycles
    cycles.transparent_max_bounces += transparent
    cycles.glossy_bounces += glossy
    cycles.max_bounces += glossy
