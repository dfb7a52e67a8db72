# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoise pictures by OpenImageDenoise, through the compositor of a scene of its own."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ..core.arrays import Floats
from ..formats.disk.path_checks import render_path
from ..scene.scratch import remove_scene
from .building_blocks import float_image, render_layers
from .capture_settings import apply_capture_settings

log = logging.getLogger(__name__)

_INPUTS = ("Image", "Albedo", "Normal")
_LEAST = 4  # pixels along a side: Blender makes smaller renders that large


class ImageDenoiser:
    """As `bake.denoising.Denoiser`; renders with the compositor of `scene`, which it has for itself."""

    def __init__(self, scene: bpy.types.Scene, folder: Path) -> None:
        """`folder` is for temporary files."""
        self._scene, self._file = scene, folder / "denoised.exr"
        apply_capture_settings(scene, 1, 0)
        scene.render.filepath = render_path(self._file)
        if hasattr(bpy.data, "colorspace"):  # Blender 5: else colours would be converted on their way out
            space = cast(Any, bpy.data).colorspace.working_space
            scene.render.image_settings.linear_colorspace_settings.name = space
        scene.render.use_compositing = True
        for name in ("compositor_device", "compositor_denoise_device"):
            if hasattr(scene.render, name):
                setattr(scene.render, name, "CPU")  # GPUs differ from each other
        if hasattr(scene.render, "compositor_precision"):
            cast(Any, scene.render).compositor_precision = "FULL"
        self._nodes = _node_tree(scene)

    def __call__(self, light: Floats, albedo: Floats, normal: Floats) -> Floats:
        """Denoise: see `bake.denoising.Denoiser`. Raises BakeError where Blender fails."""
        render: Any = self._scene.render
        height, width = light.shape[:2]
        render.resolution_x, render.resolution_y = max(width, _LEAST), max(height, _LEAST)
        more = ((0, max(_LEAST - height, 0)), (0, max(_LEAST - width, 0)), (0, 0))
        images = [
            float_image(f"RadTex {name}", np.pad(field, more, mode="edge"))
            for name, field in zip(_INPUTS, (light, albedo, normal), strict=True)
        ]
        try:
            for node, image in zip(self._nodes, images, strict=True):
                node.image = image
            picture = render_layers(self._scene, self._file).raw_whole
            return np.ascontiguousarray(
                picture[:height, :width, :3]
            )  # as it was given, whatever the working space is
        finally:
            for node in self._nodes:
                node.image = None
            bpy.data.batch_remove(images)


@contextmanager
def image_denoiser(folder: Path) -> Iterator[ImageDenoiser | None]:
    """A denoiser in an empty scene, which goes away afterwards; None where Blender has none."""
    before = {image.session_uid for image in bpy.data.images}
    scene = bpy.data.scenes.new("RadTex denoiser")
    if not can_denoise(scene):
        remove_scene(scene)
        log.warning("this Blender has no OpenImageDenoise: the bake stays noisy")
        yield None
        return
    camera = bpy.data.objects.new("RadTex camera", bpy.data.cameras.new("RadTex camera"))
    tree: bpy.types.NodeTree | None = None
    try:
        scene.collection.objects.link(camera)
        scene.camera = camera
        denoiser = ImageDenoiser(scene, folder)
        tree = cast(Any, scene).compositing_node_group if _is_group(scene) else None
        yield denoiser
    finally:
        data = camera.data
        remove_scene(scene)
        viewers = [
            image
            for image in bpy.data.images
            if image.type == "COMPOSITING" and image.session_uid not in before  # Blender 4.5 makes one
        ]
        made: list[bpy.types.ID | None] = [camera, data, tree, *viewers]
        bpy.data.batch_remove([each for each in made if each is not None])


def can_denoise(scene: bpy.types.Scene) -> bool:
    """Whether this Blender was built with OpenImageDenoise; if so, `scene` is set to it.

    Packages of Linux distributions may lack it.
    """
    try:
        cast(Any, scene).cycles.denoiser = "OPENIMAGEDENOISE"
    except TypeError:  # not among the enum's choices
        return False
    return True


def _is_group(scene: bpy.types.Scene) -> bool:
    """Whether compositing is a node group's, as in Blender 5."""
    return hasattr(scene, "compositing_node_group")


def _node_tree(scene: bpy.types.Scene) -> list[Any]:
    """Build the compositing nodes; returns the image nodes in the order of `_INPUTS`."""
    made: Any = scene
    if _is_group(scene):
        tree: Any = bpy.data.node_groups.new("RadTex denoiser", "CompositorNodeTree")
        made.compositing_node_group = tree
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        out = tree.nodes.new("NodeGroupOutput")
    else:
        made.use_nodes = True
        tree = made.node_tree
        tree.nodes.clear()
        out = tree.nodes.new("CompositorNodeComposite")
    denoise = tree.nodes.new("CompositorNodeDenoise")
    if hasattr(denoise, "prefilter"):  # Blender 4.5
        denoise.prefilter, denoise.quality, denoise.use_hdr = "NONE", "BALANCED", True
    else:
        for name, value in (("Prefilter", "None"), ("Quality", "Balanced"), ("HDR", True)):
            denoise.inputs[name].default_value = value
    images = []
    for name in _INPUTS:
        node = tree.nodes.new("CompositorNodeImage")
        tree.links.new(node.outputs["Image"], denoise.inputs[name])
        images.append(node)
    tree.links.new(denoise.outputs[0], out.inputs[0])
    return images
