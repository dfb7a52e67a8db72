# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A row's bake and its new views: Cycles's pictures of the open scene, and what the atlas shows there."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import radians
from pathlib import Path
from time import perf_counter
from typing import Any, cast

import bpy
import numpy as np
from mathutils import Vector

from radtex_addon.bake.progress import finished
from radtex_addon.formats.containers.exr import read_render
from radtex_addon.job import bake_object
from radtex_addon.prepare.prepared import prepare
from radtex_addon.report.finished_bake import read_bake
from radtex_addon.report.gbuffer import Array, BakedSurface, CameraRays, GBuffer
from radtex_addon.scene.nodes import open_world
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec

from .row import Row, Use

SUBJECT = "Subject"
PIXELS = 256
SUBSAMPLES = 2  # of ours, along a pixel's side
SAMPLES = 48  # of a reference's pixel, before it is denoised
FRAMES = 18  # of a film
FILM_PIXELS, FILM_SAMPLES = 224, 12
_SENSOR = 36.0  # millimetres

Place = tuple[float, float, float]


@dataclass(frozen=True)
class Camera:
    """Where a view is taken from, and what it looks at; `lens` in millimetres."""

    place: Place
    target: Place = (0.0, 0.0, 0.0)
    lens: float = 60.0

    def swung(self, degrees: float, frames: int = FRAMES) -> Iterator[Camera]:
        """This camera as it swings about the vertical through its target, to both sides and back."""
        x, y, z = np.subtract(self.place, self.target).tolist()
        for angle in np.radians(degrees) * np.sin(2 * np.pi * np.arange(frames) / frames):
            across, along = x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)
            around = np.add(self.target, (across, along, z)).tolist()
            yield replace(self, place=tuple(around))

    @property
    def turn(self) -> Any:
        """The rotation, a quaternion."""
        return cast(Any, Vector(self.place) - Vector(self.target)).to_track_quat("Z", "Y")

    def rays(self, subsamples: int = SUBSAMPLES, pixels: int = PIXELS) -> CameraRays:
        """Through the middles of a picture's subsamples."""
        half = _SENSOR / 2 / self.lens
        return CameraRays.of_camera(self.place, np.array(self.turn.to_matrix()), half, pixels, subsamples)


def empty_scene(sky: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Any:
    """An empty scene in a world of one colour, no light of which is cut away."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene: Any = bpy.context.scene
    scene.world, build = open_world("Sky")
    background = build.node("ShaderNodeBackground", (*sky, 1.0))
    build.node("ShaderNodeOutputWorld", background.outputs[0])
    scene.render.engine = "CYCLES"
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0
    return scene


def studio(turn: float = 0.0, strength: float = 1.0, name: str = "studio.exr") -> None:
    """Light the scene by one of the HDRIs that Blender ships, turned by degrees about the vertical."""
    scene: Any = bpy.context.scene
    folder = cast(Any, bpy.utils).system_resource("DATAFILES", path="studiolights/world")
    scene.world, build = open_world("Studio")
    around = build.node("ShaderNodeTexCoord").outputs["Generated"]
    turned = build.node("ShaderNodeMapping", around)
    cast(Any, turned.inputs["Rotation"]).default_value = (0, 0, radians(turn))
    image = bpy.data.images.load(str(Path(folder, name)))
    light = build.node("ShaderNodeTexEnvironment", turned.outputs[0], image=image)
    background = build.node("ShaderNodeBackground", light.outputs[0], strength)
    build.node("ShaderNodeOutputWorld", background.outputs[0])


def principled(name: str, colour: tuple[float, float, float], **inputs: object) -> bpy.types.Material:
    """A material of one Principled shader; inputs by name, blanks as underscores."""
    made: Any = bpy.data.materials.new(name)
    if made.node_tree is None:  # Blender 4.5; later there always is one
        made.use_nodes = True
    shader = next(node for node in made.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    return cast(bpy.types.Material, made)


def tiles(scale: float, roughness: float) -> bpy.types.Material:
    """Slate and cream, `scale` squares along a unit of the object's space."""
    made: Any = principled("Tiles", (0.8, 0.8, 0.8), Roughness=roughness)
    tree = made.node_tree
    checker = tree.nodes.new("ShaderNodeTexChecker")
    checker.inputs["Scale"].default_value = scale
    checker.inputs["Color1"].default_value = (0.75, 0.7, 0.6, 1)
    checker.inputs["Color2"].default_value = (0.12, 0.13, 0.15, 1)
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Object"], checker.inputs["Vector"])
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    tree.links.new(checker.outputs["Color"], shader.inputs["Base Color"])
    return cast(bpy.types.Material, made)


def added(shape: str, name: str, material: bpy.types.Material | None, **options: Any) -> Any:
    """A mesh primitive, smooth where it is round."""
    getattr(bpy.ops.mesh, f"primitive_{shape}_add")(**options)
    item: Any = bpy.context.object
    item.name = name
    if material is not None:
        item.data.materials.append(material)
    if shape not in ("cube", "plane", "circle"):
        bpy.ops.object.shade_smooth()
    return item


def lamp(place: Place, watts: float, size: float, towards: Place = (0.0, 0.0, 0.0)) -> None:
    """A square area lamp that shines at `towards`."""
    data: Any = bpy.data.lights.new("Lamp", "AREA")
    data.energy, data.size = watts, size
    item: Any = bpy.data.objects.new("Lamp", data)
    item.location = place
    item.rotation_mode = "QUATERNION"
    item.rotation_quaternion = cast(Any, Vector(place) - Vector(towards)).to_track_quat("Z", "Y")
    cast(Any, bpy.context.scene).collection.objects.link(item)


def rendered(
    camera: Camera, samples: int = SAMPLES, denoised: bool = True, size: tuple[int, int] = (PIXELS, PIXELS)
) -> Array:
    """What Cycles sees of the open scene, linear (H, W, 4) from the top row on, of a `size` (W, H)."""
    scene: Any = bpy.context.scene
    data: Any = bpy.data.cameras.new("Camera")
    data.lens, data.clip_start = camera.lens, 0.01
    item: Any = bpy.data.objects.new("Camera", data)
    item.location, item.rotation_mode, item.rotation_quaternion = camera.place, "QUATERNION", camera.turn
    scene.collection.objects.link(item)
    scene.camera, scene.render.engine = item, "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = size
    cycles = scene.cycles
    cycles.samples, cycles.use_adaptive_sampling = samples, False
    cycles.use_denoising = denoised
    if denoised:
        cycles.denoiser = "OPENIMAGEDENOISE"
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    picture = render_open_scene()
    bpy.data.objects.remove(item)
    return picture


def render_open_scene() -> Array:
    """What the open scene's camera sees by its settings, linear (H, W, 4) from the top row on."""
    scene: Any = bpy.context.scene
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_depth, image.color_mode = "OPEN_EXR", "32", "RGBA"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder, "view.exr"))
        bpy.ops.render.render(write_still=True)
        (pixels,) = read_render(Path(folder, "view.exr")).values()
    picture: Array = pixels[::-1].astype(np.float64)
    return picture


@dataclass(frozen=True, eq=False)
class Baked:
    """A bake in its folder: its `sidecar`, its surface, and what it took, in words."""

    sidecar: Path
    surface: BakedSurface
    words: str

    def seen(self, camera: Camera, pixels: int = PIXELS) -> GBuffer:
        """The surface as a camera sees it, with nothing before it."""
        rays = camera.rays(pixels=pixels)
        return self.surface.gbuffer(rays, np.full(len(rays.away), np.inf))


def baked(spec: BakeSpec, folder: Path, name: str = SUBJECT) -> Baked:
    """Bake an object of the open scene."""
    scene: Any = bpy.context.scene
    began = perf_counter()
    result = bake_object(scene, name, spec, folder)
    seconds = perf_counter() - began
    size = sum(path.stat().st_size for path in folder.glob("*.exr"))
    kept: list[bpy.types.ID] = []
    with scratch_scene(scene, None, kept) as scratch:
        item = find_object(scratch, name)
        prepared = finished(prepare(scratch, [item], spec, kept, backs=spec.form.backs))
        surface = BakedSurface(prepared.mesh, prepared.matrix_world, prepared.uv_layer)
    bpy.data.batch_remove(kept)
    shape = f"{spec.texels} texels, {spec.bucket} cells, {spec.samples} spp, {spec.layout}"
    shape += ", denoised" if spec.denoise else ""
    words = f"{shape}; {result.paths / 1e6:.1f} M paths, {seconds:.0f} s, {size / 1e6:.1f} MB of EXR"
    return Baked(result.files.sidecar, surface, words)


def filmed(camera: Camera) -> Array:
    """What Cycles sees of the open scene, as `rendered`, for a frame of a film."""
    return rendered(camera, FILM_SAMPLES, size=(FILM_PIXELS, FILM_PIXELS))


def opaque_rows(
    title: str,
    spec: BakeSpec,
    cameras: Mapping[str, Camera],
    build: Callable[[], object],
    beside: BakeSpec | None = None,
    swing: float = 0.0,
    stills: bool = True,
) -> Iterator[Row]:
    """The rows of a subject that hides what is behind it, and that nothing else hides from the cameras.

    With another bake `beside`, in layout buckets, the table has its figures too. With a `swing`, in degrees,
    the first camera makes a film, alone without `stills`.
    """
    build()
    with tempfile.TemporaryDirectory() as folder:
        bake = baked(spec, Path(folder, "first"))
        look = read_bake(bake.sidecar).radiance
        other = None if beside is None or not stills else baked(beside, Path(folder, "other"))
        for name, camera in cameras.items() if stills else ():
            seen, truth = bake.seen(camera), rendered(camera)[..., :3]
            yield Row(f"{title}, {name}", truth, seen.resolve(look(seen)), seen.eroded, bake.words)
            if other is not None:
                seen = other.seen(camera)
                ours = seen.resolve(read_bake(other.sidecar).radiance(seen))
                yield Row(f"{title}, {name}, buckets", truth, ours, seen.eroded, other.words, use=Use.TABLE)
        for camera in next(iter(cameras.values())).swung(swing) if swing else ():
            seen = bake.seen(camera, FILM_PIXELS)
            ours = seen.resolve(look(seen))
            yield Row(f"{title}, film", filmed(camera)[..., :3], ours, seen.eroded, use=Use.FILM)


def resolved(values: Array, seen: GBuffer) -> Array:
    """The mean of values (N, C) over each pixel's rays, zero where those miss: (pixels, pixels, C)."""
    side = seen.pixels
    shown: Array = values.reshape(side, side, -1, values.shape[1]).mean(axis=2)
    return np.where(seen.hit.reshape(side, side, -1).any(axis=2)[..., None], shown, 0.0)
