# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Building blocks of captures: planes and boxes that only some rays see, a camera, renders, float images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ..core.abandonable import abandonable
from ..core.arrays import Floats
from ..core.errors import BakeError, FormatError
from ..core.messages import Setting, do
from ..formats.containers.exr import read_render
from ..formats.render_space import render_matrix
from ..scene.lights.lamps import GROUP
from ..scene.mesh.render_contents import RAYS, top_of_render
from ..scene.nodes import NodeBuilder, open_material
from ..scene.scratch import render_scene
from .passes import Passes


@dataclass(frozen=True)
class Extent:
    """A plane's size in scene units; planes are centred on x = y = 0, where float32 is most precise."""

    width: float
    height: float

    @classmethod
    def of_pixels(cls, width: int, height: int) -> Extent:
        """The extent with an image's aspect ratio whose longer side is 2."""
        longest = max(width, height)
        return cls(2 * width / longest, 2 * height / longest)


def above_everything(scene: bpy.types.Scene) -> float:
    """A height far above all objects and instances, where their rays are beyond the reach of portals."""
    return 10.0 + 1.5 * top_of_render(scene)


def plane(
    scene: bpy.types.Scene,
    name: str,
    extent: Extent,
    height: float,
    material: bpy.types.Material,
    visible: str,
) -> None:
    """Add a rectangle at `height` that only rays of the kind `visible` see."""
    x, y = extent.width / 2, extent.height / 2
    corners = [(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)]
    item = _mesh_object(scene, name, corners, [(0, 1, 2, 3)], material, {visible})
    item.location.z = height


def box(
    scene: bpy.types.Scene, name: str, half: float, material: bpy.types.Material, visible: set[str]
) -> bpy.types.Object:
    """Add a cube of half side `half` around its origin that only the `visible` kinds of rays see."""
    corners = [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return _mesh_object(scene, name, corners, faces, material, visible)


def _mesh_object(
    scene: bpy.types.Scene,
    name: str,
    corners: list[tuple[float, float, float]],
    faces: Sequence[tuple[int, ...]],
    material: bpy.types.Material,
    visible: set[str],
) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], faces)
    mesh.materials.append(material)
    item = bpy.data.objects.new(name, mesh)
    for ray in RAYS:
        setattr(item, f"visible_{ray}", ray in visible)
    scene.collection.objects.link(item)
    return item


def camera_above(scene: bpy.types.Scene, extent: Extent, height: float, gap: float) -> bpy.types.Object:
    """Add an orthographic camera at `height` that looks straight down on an extent at a distance of `gap`."""
    data = bpy.data.cameras.new("RadTex camera")
    data.type, data.ortho_scale = "ORTHO", max(extent.width, extent.height)
    data.clip_start, data.clip_end = gap / 100, 10 * gap
    camera = bpy.data.objects.new("RadTex camera", data)
    camera.location.z = height
    scene.collection.objects.link(camera)
    return camera


def render_image(scene: bpy.types.Scene, file: Path) -> Floats:
    """Render `scene` to its output path `file`, and read that: (H, W, 4) float32, row 0 at the bottom.

    Colours are in Rec.709. Raises BakeError where Cycles fails.
    """
    return render_layers(scene, file).whole


def render_layers(scene: bpy.types.Scene, file: Path) -> Passes:
    """Like `render_image`, but returns every pass that is kept, each (H, W, C).

    Where only some lamps are lit (`scene.lights.lamps`), the combined pass has the light of their light
    group, and the alpha of the whole render.
    """
    file.unlink(missing_ok=True)
    try:
        with abandonable():
            render_scene(scene, write=True)
    except RuntimeError as error:
        reason = " ".join(str(error).removeprefix("Error:").split())
        raise BakeError(f"Cycles cannot render: {reason}") from error
    if not file.exists():
        raise BakeError(
            "Cycles returned no picture, as where memory runs out",
            do("bake fewer texels"),
            do("bake on the CPU", Setting.DEVICE, value="cpu"),
            do("read Blender's own messages", Setting.VERBOSE),
        )
    try:
        return read_layers(file)
    except FormatError as error:
        raise BakeError(
            f"Cycles's picture in {file.parent} is not whole, as where a disk is full: make room there, or "
            "name another folder for temporary files by TMPDIR"
        ) from error


def read_layers(file: Path) -> Passes:
    """Read the passes of a picture that `render_layers` wrote. Raises FormatError for any other file."""
    passes = {name.rpartition(".")[2]: image for name, image in read_render(file).items()}
    light = passes.pop(f"Combined_{GROUP}", None)
    if light is not None:
        passes["Combined"] = np.concatenate([light[..., :3], passes["Combined"][..., 3:]], axis=-1)
    ordered = sorted(passes.items(), key=lambda named: named[0] not in ("", "Combined"))
    return Passes(dict(ordered), render_matrix(file))


def mirror_material() -> bpy.types.Material:
    """A perfect mirror."""
    material, build = open_material("RadTex mirror")
    build.node("ShaderNodeOutputMaterial", mirror(build))
    return material


def mirror(build: NodeBuilder) -> bpy.types.NodeSocket:
    """The shader of a perfect mirror."""
    node = build.node("ShaderNodeBsdfAnisotropic")
    build.feed(node.inputs["Color"], (1.0, 1.0, 1.0, 1.0))
    build.feed(node.inputs["Roughness"], 0.0)
    return node.outputs[0]


def float_image(name: str, field: Floats) -> bpy.types.Image:
    """Store vectors (rows, columns, 3) unchanged in a float image, row 0 at the bottom."""
    rows, columns = field.shape[:2]
    image = bpy.data.images.new(name, columns, rows, alpha=True, float_buffer=True, is_data=True)
    image.alpha_mode = "CHANNEL_PACKED"
    pixels = np.ones((rows, columns, 4), dtype=np.float32)
    pixels[..., :3] = field
    cast(Any, image.pixels).foreach_set(pixels.ravel())  # the stubs allow lists only
    image.update()
    return image
