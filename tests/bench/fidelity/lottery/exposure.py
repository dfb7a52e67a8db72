# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light set so that the subject is exposed well, by a cheap picture of it."""

from __future__ import annotations

from math import log2
from typing import Any, cast

import bpy
import numpy as np

from ..rendering import Rendering, render
from ..scenes.stage import Stage

_PROBE = Rendering(samples=8, seed=5, alone=True, pixels=40)
_TARGET = 0.2  # mean luminance over the subject, clipped at 1
_STEPS = 4  # of a strength's doubling, so that a difference in the last bits makes none here
_LEAST_SEEN = 0.07  # of the frame, by the subject
_MOST_CLIPPED = 0.25  # of the subject's pixels
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def expose(stage: Stage) -> bool:
    """Scale all light to the target's exposure; false if the subject cannot be seen well in some view."""
    seen = []
    for camera in stage.held_out:
        probe = render(stage, camera, _PROBE)
        inside = probe[..., 3] > 0.99
        if inside.mean() < _LEAST_SEEN:
            return False
        seen.append(np.maximum(probe[inside][:, :3], 0) @ _LUMINANCE)
    light = np.concatenate(seen)
    if float(np.median(light)) <= 0:
        return False
    steps = range(-20 * _STEPS, 20 * _STEPS)
    means = [float(np.minimum(light * 2 ** (step / _STEPS), 1).mean()) for step in steps]
    scale = 2 ** (steps[int(np.argmin([abs(log2(mean / _TARGET)) for mean in means]))] / _STEPS)
    _scale_light(scale)
    return all(
        np.minimum(part * scale, 1).mean() > 0.05 and (part * scale > 1).mean() < _MOST_CLIPPED
        for part in seen
    )


def _scale_light(scale: float) -> None:
    scene = cast(bpy.types.Scene, bpy.context.scene)
    background: Any = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Strength"].default_value *= scale
    for item in scene.objects:
        if item.type == "LIGHT":
            cast(Any, item.data).energy *= scale
