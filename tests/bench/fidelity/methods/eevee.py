# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""No bake at all: Eevee renders the scene as it is, with its own defaults for ray tracing.

That is rasterising with reflections traced in the screen's depth, and a probe of the world beyond it. The
camera is found out from the rays that are asked for; a pixel takes as many samples as it has rays, and four
at least, for a game adds up as many over its last frames. 16, of a picture of 4 x 4 rays a pixel, is what the
viewport takes. Ray-traced refraction, which a material has to ask for, is on where it transmits light.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
from mathutils import Matrix

from radtex_addon.bake.progress import finished
from radtex_addon.core.errors import BakeError
from radtex_addon.formats.containers.exr import read_render
from radtex_addon.prepare.prepared import prepare
from radtex_addon.report.gbuffer import Array, GBuffer
from radtex_addon.report.metrics import Picture
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec

from ..method import Baked
from ..scenes import Stage
from ..seen_from import Camera, camera_of

_ENGINES = ("BLENDER_EEVEE", "BLENDER_EEVEE_NEXT")  # since Blender 5.0, and in 4.5
_LEAST = 4  # samples of a pixel


class Eevee:
    """Prepares the mesh, as the others do, so that the pictures are compared where theirs are."""

    name = "eevee"

    def __init__(self, spec: BakeSpec) -> None:
        self.spec = spec

    def bake(self, stage: Stage, folder: Path) -> Baked:  # noqa: ARG002  # nothing to write
        scene = cast(bpy.types.Scene, bpy.context.scene)
        kept: list[bpy.types.ID] = []
        with scratch_scene(scene, None, kept) as scratch:
            item = find_object(scratch, stage.subject.name)
            prepared = finished(prepare(scratch, [item], self.spec, kept))
        subject = stage.subject

        def radiance(buffer: GBuffer) -> Array:
            """Of each ray what its pixel shows; the open file must still hold the stage."""
            rays = len(buffer.hit) // buffer.pixels**2
            with _refracting(subject):
                picture = _rendered(camera_of(buffer), buffer.pixels, max(rays, _LEAST))
            return np.repeat(picture.reshape(-1, 3), rays, axis=0)

        return Baked(
            paths=0,
            seconds=0.0,
            bytes=0,
            radiance=radiance,
            mesh=prepared.mesh,
            matrix_world=np.array(subject.matrix_world),
            uv_layer=prepared.uv_layer,
        )


@contextmanager
def _refracting(subject: bpy.types.Object) -> Iterator[None]:
    """Switch ray-traced refraction on in the object's materials that transmit light."""
    changed: list[Any] = []
    for slot in subject.material_slots:
        material: Any = slot.material
        shaders = [node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED"]
        weights = [shader.inputs["Transmission Weight"] for shader in shaders]
        if not material.use_raytrace_refraction and any(w.is_linked or w.default_value > 0 for w in weights):
            material.use_raytrace_refraction = True
            changed.append(material)
    try:
        yield
    finally:
        for material in changed:
            material.use_raytrace_refraction = False


def _rendered(seen_from: Camera, pixels: int, samples: int) -> Picture:
    """The open scene's picture (pixels, pixels, 3), linear, rows from the top, by a copy of the scene."""
    copy = cast(bpy.types.Scene, cast(bpy.types.Scene, bpy.context.scene).copy())
    data = bpy.data.cameras.new("Eevee")
    camera = bpy.data.objects.new("Eevee", data)
    try:
        data.sensor_width, data.lens = 36, 18 / seen_from.half
        place = np.eye(4)
        place[:3, :3], place[:3, 3] = seen_from.turn, seen_from.place
        camera.matrix_world = Matrix(place.tolist())
        copy.collection.objects.link(camera)
        copy.camera = camera
        set_up(copy, pixels, samples)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "view.exr")
            copy.render.filepath = str(path)
            bpy.ops.render.render(write_still=True, scene=copy.name)
            (found,) = read_render(path).values()
    finally:
        bpy.data.scenes.remove(copy)
        bpy.data.objects.remove(camera)
        bpy.data.cameras.remove(data)
    picture: Picture = found[::-1, :, :3].astype(np.float64)
    return picture


def set_up(scene: bpy.types.Scene, pixels: int, samples: int) -> None:
    """Have the scene rendered by Eevee with ray tracing, to an EXR file. Raises BakeError without it."""
    render = cast(Any, scene.render)
    known = render.bl_rna.properties["engine"].enum_items.keys()
    found = [engine for engine in _ENGINES if engine in known]
    if not found:
        raise BakeError("this Blender has no Eevee that traces rays")
    render.engine = found[-1]
    render.resolution_x = render.resolution_y = pixels
    render.resolution_percentage = 100
    render.filter_size = 1.0  # about as sharp as the references
    eevee = cast(Any, scene).eevee
    eevee.use_raytracing, eevee.taa_render_samples = True, samples
    image = render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_depth = "OPEN_EXR", "32"


def make(texels: int, samples: int) -> Eevee:
    """Eevee; the texels are those of the mesh's unwrapping, which no picture shows."""
    return Eevee(BakeSpec(texels=texels, samples=samples))
