# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene whose every pixel is one lookup: planes seen from straight above, their inputs in images."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import OpenEXR

from radtex_addon.core.arrays import Floats
from radtex_addon.scene.nodes import NodeBuilder, Socket
from tests.lookups import SIDE, Lookups

EEVEE = "BLENDER_EEVEE" if bpy.app.version >= (5, 0) else "BLENDER_EEVEE_NEXT"
ENGINES = {"Cycles": "CYCLES", "Eevee": EEVEE}

Inputs = tuple[Socket, ...]  # UV, normal, tangent, sign, viewer
Shader = Callable[[NodeBuilder, Inputs], tuple[Socket, ...]]  # to colour and alpha


class LookupStage:
    """Places lookups side by side; one render answers them all."""

    def __init__(self, scene: bpy.types.Scene, engine: str) -> None:
        self.scene = scene
        self.columns: list[bpy.types.Object] = []
        set_up_render(scene, engine)

    def add(self, lookups: Lookups, shader: Shader) -> None:
        """A plane that shows the shader's colours below and its alphas above."""
        column = len(self.columns)
        mesh = bpy.data.meshes.new(f"lookups {column}")
        corners = [(x, y, 0.0) for x, y in ((0, 0), (1, 0), (1, 2), (0, 2))]
        mesh.from_pydata([(x + column, y, z) for x, y, z in corners], [], [(0, 1, 2, 3)])
        mesh.uv_layers.new(name="places").uv.foreach_set("vector", np.ravel([c[:2] for c in corners]))
        material = bpy.data.materials.new(f"lookups {column}")
        if material.node_tree is None:
            material.use_nodes = True
        tree = cast(bpy.types.NodeTree, material.node_tree)
        tree.nodes.clear()
        build = NodeBuilder(tree)
        place = build.uv_map("places")
        color, alpha = shader(build, _inputs(build, lookups, build.vector("FRACTION", place)))
        above = build.math("GREATER_THAN", build.separate(place)[1], 1.0)
        grey = build.combine(alpha, alpha, alpha)
        emission = build.node("ShaderNodeEmission", build.mix(above, color, grey))
        build.node("ShaderNodeOutputMaterial", emission.outputs[0])
        mesh.materials.append(material)
        plane = bpy.data.objects.new(mesh.name, mesh)
        cast(Any, self.scene).collection.objects.link(plane)
        self.columns.append(plane)

    def render(self, path: Path) -> list[Floats]:
        """The answers of each plane: (K, 4) float32."""
        width = len(self.columns)
        add_camera_above(self.scene, (width / 2, 1.0), (width, 2), SIDE)
        image = render_exr(self.scene, path)[..., :3]
        planes = [image[:, i * SIDE : (i + 1) * SIDE] for i in range(width)]
        return [
            np.concatenate([plane[:SIDE].reshape(-1, 3), plane[SIDE:, :, :1].reshape(-1, 1)], axis=1)
            for plane in planes
        ]


def set_up_render(scene: bpy.types.Scene, engine: str) -> None:
    """One sample at each pixel's centre, values as they are."""
    settings = cast(Any, scene)
    settings.render.engine = engine
    settings.render.filter_size = 0.01
    settings.render.dither_intensity = 0
    settings.render.film_transparent = True
    settings.view_settings.view_transform = "Raw"
    settings.cycles.samples, settings.cycles.pixel_filter_type, settings.cycles.filter_width = 1, "BOX", 0.01
    settings.cycles.use_adaptive_sampling = settings.cycles.use_denoising = False
    settings.eevee.taa_render_samples = 1
    if hasattr(settings.render.image_settings, "media_type"):
        settings.render.image_settings.media_type = "IMAGE"
    settings.render.image_settings.file_format = "OPEN_EXR"
    settings.render.image_settings.color_depth = "32"
    settings.render.image_settings.color_mode = "RGBA"


def add_camera_above(
    scene: bpy.types.Scene, centre: tuple[float, float], size: tuple[int, int], pixels_per_unit: int
) -> bpy.types.Object:
    """An orthographic camera that looks down on `size` units around `centre`."""
    data = bpy.data.cameras.new("above")
    data.type, data.ortho_scale = "ORTHO", max(size)
    camera = bpy.data.objects.new("above", data)
    camera.location = (*centre, 5.0)
    cast(Any, scene).collection.objects.link(camera)
    scene.camera = camera
    render = cast(Any, scene.render)
    render.resolution_x, render.resolution_y = (side * pixels_per_unit for side in size)
    return camera


def render_exr(scene: bpy.types.Scene, path: Path) -> Floats:
    """Render the scene to `path`: (height, width, 4) float32, row 0 at the bottom."""
    cast(Any, scene.render).filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    with OpenEXR.File(str(path)) as file:
        pixels = next(iter(file.channels().values())).pixels
    return np.array(pixels[::-1], dtype=np.float32)


def write_exr(path: Path, image: Floats) -> Path:
    """Write (height, width, 4), row 0 at the bottom, in its own precision."""
    path.parent.mkdir(exist_ok=True)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGBA": np.ascontiguousarray(image[::-1])}) as file:
        file.write(str(path))
    return path


def _inputs(build: NodeBuilder, lookups: Lookups, place: Socket) -> Inputs:
    """Sockets that hold this pixel's lookup."""
    names = ("uv", "normal", "tangent", "viewer")
    uv, normal, tangent, viewer = (build.image(data_image(n, getattr(lookups, n)), place)[0] for n in names)
    sign = build.separate(build.image(data_image("sign", lookups.sign[:, None]), place)[0])[0]
    return uv, normal, tangent, sign, viewer


def data_image(name: str, values: Floats) -> bpy.types.Image:
    """An image that holds (SIDE * SIDE, up to 3) numbers exactly."""
    image = bpy.data.images.new(name, SIDE, SIDE, alpha=True, float_buffer=True, is_data=True)
    image.use_half_precision = False
    image.alpha_mode = "CHANNEL_PACKED"
    pixels = np.ones((SIDE * SIDE, 4), np.float32)
    pixels[:, : values.shape[1]] = values
    cast(Any, image.pixels).foreach_set(pixels.ravel())
    image.update()
    return image
