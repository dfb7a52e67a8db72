# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles's own bake of diffuse light without its colour, on a RadTex bake's UV map and texels."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.prepare.prepared import Prepared


class CyclesBake:
    """Bakes an object's copy in the open scene, in which it stands in the object's place."""

    def __init__(self, item: bpy.types.Object, image: bpy.types.Image) -> None:
        self._item, self._image = item, image

    def light(self, samples: int, seed: int) -> tuple[Floats, Bools]:
        """The irradiance (H, W, 3) by so many paths a texel, and which texels have any, (H, W)."""
        scene: Any = bpy.context.scene
        scene.render.engine = "CYCLES"
        cycles = scene.cycles
        cycles.samples, cycles.seed = samples, seed
        cycles.use_adaptive_sampling = cycles.use_denoising = False
        for item in bpy.context.view_layer.objects:
            item.select_set(item == self._item)
        bpy.context.view_layer.objects.active = self._item
        bpy.ops.object.bake(type="DIFFUSE", pass_filter={"DIRECT", "INDIRECT"}, margin=0, use_clear=True)
        image: Any = self._image
        width, height = image.size
        found = np.empty(height * width * 4, dtype=np.float32)
        image.pixels.foreach_get(found)
        found = found.reshape(height, width, 4)
        return found[..., :3].copy(), found[..., 3] > 0


@contextmanager
def cycles_bake(original: bpy.types.Object, prepared: Prepared) -> Iterator[CyclesBake]:
    """A bake of an `original` of the open scene, on the mesh that is `prepared` of it."""
    scene = cast(bpy.types.Scene, bpy.context.scene)
    image = bpy.data.images.new("Light", prepared.width, prepared.height, alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    mesh = prepared.mesh.copy()
    cast(Any, mesh.uv_layers)[prepared.uv_layer].active = True
    for number, material in enumerate(mesh.materials):
        if material is not None:
            copy = material.copy()
            tree: Any = copy.node_tree
            node = tree.nodes.new("ShaderNodeTexImage")
            node.image = image
            tree.nodes.active = node
            cast(Any, mesh.materials)[number] = copy
    item = bpy.data.objects.new("Light map", mesh)
    item.matrix_world = original.matrix_world
    scene.collection.objects.link(item)
    hidden, original.hide_render = original.hide_render, True
    try:
        yield CyclesBake(item, image)
    finally:
        original.hide_render = hidden
        bpy.data.objects.remove(item)
        bpy.data.images.remove(image)
