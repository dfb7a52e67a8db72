# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Names, files, frames and render settings that say nothing of light leave every bit as it was."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from tests.bench.metamorphic.trial import Outcome, Relation, Trial, nearly, same_bits, same_light


def renamed(trial: Trial) -> Outcome:
    """Nothing here looks at a name."""
    first = trial.bake()
    for blocks in (bpy.data.objects, bpy.data.materials, bpy.data.lights, bpy.data.meshes, bpy.data.worlds):
        for number, block in enumerate(list(blocks)):
            block.name = f"Ü {number}.Combined/{block.name[::-1]}"
    trial.body.name = "{new} #### <UDIM>"
    trial.body.data.uv_layers["UVMap"].name = "Other.Layer"
    trial.scene.view_layers[0].name = "View.Combined"
    trial.scene.name = "Scene.R"
    return same_bits(first, trial.bake(trial.body.name, uv_layer="Other.Layer"))


def in_collections(trial: Trial) -> Outcome:
    """Collections order the Outliner, not the light."""
    first = trial.bake()
    inner, outer = bpy.data.collections.new("Inner"), bpy.data.collections.new("Outer")
    trial.scene.collection.children.link(outer)
    outer.children.link(inner)
    for item in list(trial.scene.collection.objects):
        inner.objects.link(item)
        if trial.rng.uniform() < 0.7:
            trial.scene.collection.objects.unlink(item)
    return nearly(first, trial.bake(), 1e-2)


def foreign_settings(trial: Trial) -> Outcome:
    """Settings of pictures, and of how Cycles looks for light, are none of the light itself."""
    first = trial.bake()
    scene, layer = trial.scene, trial.scene.view_layers[0]
    render, cycles = scene.render, scene.cycles
    scene.view_settings.exposure, scene.view_settings.gamma = 3, 2
    scene.view_settings.use_curve_mapping = True
    render.dither_intensity, render.resolution_percentage = 2, 50
    render.use_border, render.border_max_x, render.pixel_aspect_x = True, 0.3, 2
    render.use_single_layer = render.use_stamp = render.use_motion_blur = True
    render.image_settings.file_format = "JPEG"
    cycles.film_exposure, cycles.pixel_filter_type = 3, "GAUSSIAN"
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_guiding = True
    cycles.time_limit, cycles.use_animated_seed = 0.01, True
    layer.use_pass_cryptomatte_object = layer.use_pass_z = layer.use_pass_diffuse_direct = True
    layer.aovs.add().name = "Combined"
    layer.lightgroups.add(name="group")
    layer.samples = 1
    scene.view_layers.new("Other").use = True
    return same_bits(first, trial.bake(view_layer=layer.name))


def drawn_over(trial: Trial) -> Outcome:
    """Grease pencil has no light: Blender draws it over pictures."""
    first = trial.bake()
    bpy.ops.object.grease_pencil_add(type="STROKE", location=(0, 0, 1))
    return same_bits(first, trial.bake())


def other_scene(trial: Trial) -> Outcome:
    """A scene is the same, whichever is open, and so is an object that two scenes show."""
    for frame in (1, 9):
        trial.body.location.x = frame / 10
        trial.body.keyframe_insert("location", frame=frame)
    trial.scene.frame_set(9)
    scene = trial.scene
    first = trial.bake()
    bpy.context.window.scene = bpy.data.scenes.new("Open")
    bpy.context.scene.collection.objects.link(trial.body)
    return same_bits(first, trial.bake(scene=scene))


def frames(trial: Trial) -> Outcome:
    """To bake a frame is to go there and bake."""
    for frame in (1, 20):
        for item in (trial.body, *bpy.data.lights):
            name = "location" if item is trial.body else "energy"
            value = getattr(item, name)
            setattr(
                item, name, [each + frame / 30 for each in value] if name == "location" else value * frame
            )
            item.keyframe_insert(name, frame=frame)
    chosen = int(trial.rng.integers(2, 20))
    trial.scene.frame_set(1)
    first = trial.bake(frame=chosen)
    trial.scene.frame_set(chosen)
    return same_bits(first, trial.bake())


def linked(trial: Trial) -> Outcome:
    """A library's scene is what it was in its own file."""
    first = trial.bake()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "library.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
        bpy.ops.wm.read_factory_settings(use_empty=True)
        load: Any = bpy.data.libraries.load  # to the stubs it returns nothing
        with load(str(path), link=True) as (there, here):
            here.objects, here.worlds = list(there.objects), list(there.worlds)
        scene: Any = bpy.context.scene
        for item in here.objects:
            scene.collection.objects.link(item)
        scene.world = here.worlds[0]
        scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0
        second = trial.bake(scene=scene)
    return nearly(first, second, 1e-2)


def precision(trial: Trial) -> Outcome:
    """Half floats are rounded floats, however they are packed."""
    whole = trial.bake().astype(np.float16).astype(np.float32)
    kind = ("zip", "piz")[int(trial.rng.integers(2))]
    return same_bits(whole, trial.bake(half=True, compression=kind))


def sheets(trial: Trial) -> Outcome:
    """Sheets have other seeds, and the same light; memory changes no bit of it."""
    noisy = trial.noisy()
    return same_light(noisy, trial.bake(seed=3, sheet=int(trial.rng.integers(16, 48))))


def memory(trial: Trial) -> Outcome:
    """How much memory there is decides how a sheet is cut, and no bit; path guiding on, as users may."""
    trial.scene.cycles.use_guiding = True
    return same_bits(trial.bake(), trial.bake(memory_mb=64))


def more_samples(trial: Trial) -> Outcome:
    """More samples of the same light have the same mean, but for what tone mapping makes of less noise."""
    return same_light(trial.noisy(samples=64), trial.bake(seed=3, samples=256), rounding=3e-2)


def another_seed(trial: Trial) -> Outcome:
    """Seeds differ in noise alone: what is found here is what the measure itself takes for a difference."""
    return same_light(trial.noisy(), trial.bake(seed=3))


RELATIONS: dict[str, Relation] = {
    "another seed": another_seed,
    "more samples": more_samples,
    "everything renamed": renamed,
    "in collections": in_collections,
    "settings of pictures": foreign_settings,
    "grease pencil": drawn_over,
    "another scene is open": other_scene,
    "a frame": frames,
    "linked from a library": linked,
    "half floats": precision,
    "other sheets": sheets,
    "less memory": memory,
}
