# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene with what a user's file has, so that a trace left in it is found."""

from __future__ import annotations

from typing import Any

import bpy

from tests.blender import stage

context: Any = bpy.context  # to the stubs, every pointer may be None


def lived_in_scene() -> Any:
    """A file with what a user's file has: animation, a parent, markers, a second scene, uncommon settings."""
    scene = context.scene
    bpy.ops.mesh.primitive_monkey_add(location=(1, 2, 3), rotation=(0.3, 0.2, 0.1))
    head = context.object
    head.scale = (1, -2, 0.5)
    head.modifiers.new("Subdivision", "SUBSURF").render_levels = 1
    head.data.materials.append(stage.material("gold", "ShaderNodeBsdfDiffuse", Color=(1, 0.7, 0.3, 1)))
    head.keyframe_insert("location", frame=1)
    bpy.ops.object.empty_add()
    head.parent = context.object
    stage.world()
    stage.lamps()
    bpy.ops.object.camera_add(location=(0, -5, 0))
    scene.camera = context.object
    scene.timeline_markers.new("cut", frame=1).camera = scene.camera
    scene.render.engine = "CYCLES"
    scene.render.use_border, scene.render.border_max_x, scene.render.resolution_percentage = True, 0.5, 37
    scene.render.use_compositing = True
    scene.cycles.samples, scene.cycles.seed = 7, 9
    scene.cycles.keyframe_insert("samples", frame=1)
    scene.frame_set(1, subframe=0.25)
    second = scene.view_layers.new("second")
    second.samples = 3
    other = bpy.data.scenes.new("elsewhere")
    other.collection.objects.link(head)
    context.view_layer.objects.active = head
    return head
