# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The curves of all materials as one small image, and their lookup by N.V."""

from __future__ import annotations

import bpy
import numpy as np

from ....core.arrays import Floats
from ....preview.taps import pixel_centre
from ....scene.nodes import NodeBuilder, Socket, close_group, open_group
from ..files.sidecar import LayeredSidecar
from ..lookup.lobes import STEPS

ROWS = 4  # of each material: the falloff, both lobes' weights, and the bend with both widths' logarithms


def curves_of(facts: LayeredSidecar) -> Floats:
    """The image (ROWS M, STEPS, 3) of M materials, row 0 at the bottom."""
    rows = []
    for falloff, material in zip(facts.falloff, facts.materials, strict=True):
        numbers = np.stack([material.bend, *np.log(material.variance)], axis=1)
        rows += [falloff, *material.weight, numbers]
    return np.stack(rows).astype(np.float32)


def curve_group(image: bpy.types.Image, materials: int) -> bpy.types.ShaderNodeTree:
    """Look up a Row of the material's curves at a Cosine, linear between steps: Color."""
    size = (STEPS, ROWS * materials)
    build, (cosine, row, material) = open_group("RadTex Curve", Cosine="Float", Row="Float", Material="Float")
    place = build.math("MULTIPLY_ADD", cosine, float(STEPS), -0.5)
    place = build.math("MINIMUM", build.math("MAXIMUM", place, 0.0), STEPS - 1.0)
    low = build.math("MINIMUM", build.math("FLOOR", place), STEPS - 2.0)
    number = build.math("MAXIMUM", build.math("ROUND", material), 0.0)
    number = build.math("MINIMUM", number, materials - 1.0)
    line = build.math("MULTIPLY_ADD", number, float(ROWS), row)
    first, second = (
        build.image(image, pixel_centre(build, build.combine(step, line), size))[0]
        for step in (low, build.math("ADD", low, 1.0))
    )
    return close_group(build, Color=build.mix(build.math("SUBTRACT", place, low), first, second))


def curves_at(
    build: NodeBuilder, group: bpy.types.ShaderNodeTree, cosine: Socket, material: Socket
) -> tuple[Socket, Socket, Socket, Socket, tuple[Socket, Socket]]:
    """The falloff, both lobes' weights, the bend, and both widths²."""
    falloff, first, second, numbers = (
        build.group(group, cosine, float(row), material)[0] for row in range(ROWS)
    )
    bend, *logarithms = build.separate(numbers)
    narrow, wide = (build.math("EXPONENT", one) for one in logarithms)
    return falloff, first, second, bend, (narrow, wide)
