# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reset the render settings of a scene copy to Blender's defaults, except those that a bake keeps.

So no setting of the user's affects a bake unless it is named here. Captures then set what they need
(`cycles.capture_settings`).
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from typing import Any, cast

import bpy

log = logging.getLogger(__name__)

# Settings of what renders show: simplification limits subdivisions and hair, remapping changes the time.
KEPT_OF_RENDER = frozenset(
    (
        "engine",
        "film_transparent",
        "fps",
        "fps_base",
        "frame_map_new",
        "frame_map_old",
        "hair_subdiv",
        "hair_type",
        "simplify_child_particles",
        "simplify_child_particles_render",
        "simplify_subdivision",
        "simplify_subdivision_render",
        "simplify_volumes",
        "threads",
        "threads_mode",
        "use_simplify",
        "use_simplify_normals",
    )
)
# Settings of how light travels.
LIGHT_PATHS = frozenset(
    (
        "ao_bounces",
        "ao_bounces_render",
        "blur_glossy",
        "caustics_reflective",
        "caustics_refractive",
        "diffuse_bounces",
        "direct_light_sampling_type",
        "fast_gi_method",
        "film_transparent_glass",
        "film_transparent_roughness",
        "glossy_bounces",
        "light_sampling_threshold",
        "max_bounces",
        "min_light_bounces",
        "min_transparent_bounces",
        "sample_clamp_direct",
        "sample_clamp_indirect",
        "sampling_pattern",
        "transmission_bounces",
        "transparent_max_bounces",
        "use_fast_gi",
        "use_light_tree",
        "volume_biased",
        "volume_bounces",
        "volume_max_steps",
        "volume_step_rate",
    )
)
# Also settings of subdivision, shaders and the device.
KEPT_OF_CYCLES = LIGHT_PATHS | frozenset(
    (
        "device",
        "dicing_rate",
        "feature_set",
        "max_subdivisions",
        "offscreen_dicing_scale",
        "shading_system",
    )
)
_OF_NO_RENDER = ("debug_", "preview_")  # prefixes of settings for debugging and the viewport
# Settings of which kinds of objects a view layer renders, and its name and use.
KEPT_OF_LAYER = frozenset(("name", "use", "use_ao", "use_sky", "use_solid", "use_strand", "use_volumes"))
_GROUPS = {  # settings to keep in each group, by the group's path from the scene
    "render": KEPT_OF_RENDER,
    "render.image_settings": frozenset[str](),
    "render.image_settings.display_settings": frozenset[str](),
    "render.image_settings.view_settings": frozenset[str](),
    "cycles": KEPT_OF_CYCLES,
    "view_settings": frozenset[str](),
    "display_settings": frozenset[str](),
}
_DERIVED = frozenset(("white_balance_whitepoint", "filepath"))  # follow from other settings, or are empty


def reset_render_settings(scene: bpy.types.Scene, graded: bool = False) -> None:
    """Reset a scene's render settings to a new scene's, except what renders show and how light travels.

    Its view layers keep which kinds of objects they render, and have no additional passes. With `graded` the
    scene's view transform and display stay.
    """
    fresh = cast(bpy.types.Scene, bpy.data.scenes.new("RadTex fresh"))
    try:
        for path, kept in _GROUPS.items():
            if not (graded and path in {"view_settings", "display_settings"}):
                _copy(fresh.path_resolve(path), scene.path_resolve(path), kept)
        for layer in scene.view_layers:
            _reset_layer(fresh.view_layers[0], layer)
    finally:
        bpy.data.scenes.remove(fresh)
    _switch_off(scene.render)


def _switch_off(render: Any) -> None:
    """Switch off settings that are on in a new scene, but that single renders do not need."""
    render.use_compositing = render.use_sequencer = render.use_freestyle = False
    if hasattr(render, "use_texture_cache"):  # Blender 5.2: mip levels by the width of camera rays
        render.use_texture_cache = False


def take_overrides(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> None:
    """Use a view layer's world override as the scene's world, and remove its material override."""
    anything = cast(Any, layer)
    if anything.world_override is not None:
        scene.world, anything.world_override = anything.world_override, None
    if layer.material_override is not None:
        log.warning(
            "view layer '%s' overrides all materials with '%s': the bake shows the objects' own",
            layer.name,
            layer.material_override.name,
        )
        layer.material_override = None


def _reset_layer(fresh: Any, layer: Any) -> None:
    _copy(fresh, layer, KEPT_OF_LAYER)
    _copy(fresh.cycles, layer.cycles, frozenset())
    for group in list(layer.lightgroups):
        layer.lightgroups.remove(group)
    for output in list(layer.aovs):
        layer.aovs.remove(output)


def _copy(fresh: Any, settings: Any, kept: frozenset[str]) -> None:
    """Copy all settings of `fresh` that can be written, except the `kept` ones."""
    for name in settings_of(settings):
        if name in kept or name in _DERIVED or name.startswith(_OF_NO_RENDER):
            continue
        wanted = getattr(fresh, name)
        if _plain(getattr(settings, name)) != _plain(wanted):
            setattr(settings, name, wanted)


def settings_of(group: Any) -> Iterator[str]:
    """Names of a group's writable settings that are neither pointers nor collections, in Blender's order."""
    for prop in group.bl_rna.properties:
        if not prop.is_readonly and prop.type not in {"POINTER", "COLLECTION"}:
            yield prop.identifier


def _plain(value: Any) -> Any:
    return list(value) if hasattr(value, "__len__") and not isinstance(value, str) else value
