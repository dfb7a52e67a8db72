# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Views of an asset: the scene's cameras, close-ups, and pictures of them by Blender's engines."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field
from math import atan, degrees, radians, tan
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.core.errors import InputError
from radtex_addon.formats.containers.exr import read_render
from radtex_addon.report.gbuffer import Array, CameraRays
from radtex_addon.report.metrics import Picture
from tests.real.exhibit import Camera

from ..fidelity.methods.eevee import set_up

PIXELS = 256  # of a picture's side
SAMPLES = 256  # of a path-traced pixel, denoised
SUBSAMPLES = 3  # along a pixel's side
EEVEE_SAMPLES = 64
_NEAREST = 1e-3  # what is nearer to a camera, in the scene's units, is cut off
_APART = 0.5  # metres between probes of a volume, in a room
_IN_WALLS = 0.13  # metres behind their surface, where a volume's outermost probes see little sky
_TILTED = 1e-4  # of a matrix's values


@dataclass(frozen=True, eq=False)
class View:
    """A path-traced picture by a camera, and pictures by other ways under their names.

    All are square, of the camera's pixels, (P, P, 3), linear, rows from the top. `subsamples` along a pixel's
    side are looked up.
    """

    camera: Camera
    reference: Picture
    others: dict[str, Picture] = field(default_factory=dict)
    subsamples: int = SUBSAMPLES

    @property
    def name(self) -> str:
        """The camera's."""
        return self.camera.name

    @property
    def rays(self) -> CameraRays:
        """Of its pixels."""
        return rays_of(self.camera, self.subsamples)


def rays_of(camera: Camera, subsamples: int) -> CameraRays:
    """A camera's rays, `subsamples` along each side of a pixel."""
    matrix = np.array(camera.matrix)
    half = tan(radians(camera.fovy) / 2)
    return CameraRays.of_camera(matrix[:3, 3], matrix[:3, :3], half, camera.pixels, subsamples)


def scene_cameras(pixels: int = PIXELS) -> list[Camera]:
    """The open scene's cameras whose name begins with "view", in order of names, for so many pixels a side.

    Raises InputError for one whose head is tilted, which not every program could follow, and without any.
    """
    scene: Any = bpy.context.scene
    items = [item for item in scene.objects if item.type == "CAMERA" and item.name.startswith("view")]
    if not items:
        raise InputError("the scene has no camera whose name begins with 'view': add view0, view1 and so on")
    return [_camera(item, pixels) for item in sorted(items, key=lambda item: str(item.name))]


def _camera(item: Any, pixels: int) -> Camera:
    matrix = np.array(item.matrix_world, dtype=np.float64)
    half = item.data.sensor_width / 2 / item.data.lens
    found = _towards(item.name, matrix[:3, 3], -matrix[:3, 2], half, pixels)
    if np.abs(np.array(found.matrix) - matrix).max() > _TILTED:
        raise InputError(f"camera {item.name} is tilted or scaled: level its head, and apply its scale")
    return found


def _towards(name: str, place: Array, away: Array, half: float, pixels: int) -> Camera:
    """A camera at `place` that looks along `away`; `half`: the tangent of half its angle of view."""
    x, y, z = place.tolist()
    to_x, to_y, to_z = (place + away).tolist()
    return Camera(name, (x, y, z), (to_x, to_y, to_z), degrees(2 * atan(half)), pixels)


def nearer(camera: Camera, name: str, away: Array, distance: float, width: float) -> Camera:
    """A camera like another that looks along its ray `away` (3,), where what lies there fills the picture.

    That is, `width` of what lies at `distance` from the other camera along the ray.
    """
    half = tan(radians(camera.fovy) / 2)
    place = np.array(camera.place) + away * max(distance - width / 2 / half, 0)
    return _towards(name, place, away, half, camera.pixels)


@dataclass(frozen=True)
class Pictures:
    """Pictures of a saved scene, which is open, kept in `folder`: none is rendered twice.

    A path-traced pixel takes `samples`.
    """

    scene: Path
    folder: Path
    samples: int = SAMPLES

    def traced(self, camera: Camera) -> Picture:
        """By Cycles."""
        return self._kept(camera, "cycles", self._set_up_cycles)

    def by_eevee(self, camera: Camera, objects: list[str]) -> Picture:
        """By Eevee, as an artist sets it up for the asset, which is of these objects.

        Reflections are traced in the picture's full resolution, and a sphere probe in the asset's middle sees
        what is not of it; no light is clamped. Eevee takes no sun out of the world: a studio's lamp becomes
        one with hard shadows, and too bright. A baked volume of probes is left out: it made the helmet of
        docs/results.md worse.
        """

        def set_up_probe(scene: Any, pixels: int) -> None:
            _set_up_eevee(scene, pixels)
            _add_probe(scene, objects)

        return self._kept(camera, "eevee with a probe, unclamped", set_up_probe)

    def by_eevee_inside(self, camera: Camera, room: tuple[Array, Array]) -> Picture:
        """By Eevee, as an artist sets it up for a room, whose lowest and highest corners are those.

        As `by_eevee`, but the sphere probe stands in the room's middle and sees the room, and a baked volume
        of probes, one each _APART metres, gives the light that has bounced, and keeps the sky's outside: it
        takes minutes, once, also without a display, and without it a room is more than twice as bright.
        """
        inside = Pictures(self._with_probes(*room), self.folder, self.samples)
        picture = inside._kept(camera, "eevee in a room, unclamped", _set_up_eevee)
        bpy.ops.wm.open_mainfile(filepath=str(self.scene))
        return picture

    def _with_probes(self, low: Array, high: Array) -> Path:
        """The scene's file with a sphere probe and a baked volume in it, made once."""
        facts = json.dumps([low.tolist(), high.tolist(), _APART, _IN_WALLS, bpy.app.version_string])
        digest = hashlib.sha256(self.scene.read_bytes() + facts.encode()).hexdigest()[:12]
        file = self.folder / f"probes-{digest}.blend"
        if not file.exists():
            bpy.ops.wm.open_mainfile(filepath=str(self.scene))
            scene: Any = bpy.context.scene
            _set_up_eevee(scene, PIXELS)
            _add_sphere(scene, low, high)
            _add_volume(scene, low - _IN_WALLS, high + _IN_WALLS)
            cast(Any, bpy.ops.object).lightprobe_cache_bake(subset="ALL")
            beside = file.with_suffix(".baking.blend")
            bpy.ops.wm.save_as_mainfile(filepath=str(beside))
            beside.rename(file)
            bpy.ops.wm.open_mainfile(filepath=str(self.scene))
        return file

    def panorama(self, place: Array, hidden: list[str], height: int, samples: int) -> Picture:
        """What lies around a place (3,), by Cycles, without the `hidden` objects: (height, 2 height, 3).

        An equirectangular picture as three.js has it: its middle looks along +x, its upper row up (+z).
        Lamps are not in it, but the light that they give is.
        """

        def set_up_panorama(scene: Any, pixels: int) -> None:
            self._set_up_cycles(scene, pixels)
            camera = scene.camera
            scene.cycles.samples = samples
            scene.render.resolution_x, scene.render.resolution_y = 2 * height, height
            camera.data.type = "PANO"
            holder = camera.data if hasattr(camera.data, "panorama_type") else camera.data.cycles
            holder.panorama_type = "EQUIRECTANGULAR"
            for item in scene.objects:
                item.hide_render = item.hide_render or item.name in hidden
                item.visible_camera = item.visible_camera and item.type != "LIGHT"

        x, y, z = place.tolist()
        camera = Camera("probe", (x, y, z), (x + 1, y, z), 90.0, height)
        return self._kept(camera, f"around {sorted(hidden)} {samples}", set_up_panorama)

    def _set_up_cycles(self, scene: Any, pixels: int) -> None:
        scene.render.engine = "CYCLES"
        scene.render.resolution_x = scene.render.resolution_y = pixels
        scene.render.resolution_percentage = 100
        scene.render.image_settings.file_format = "OPEN_EXR"
        scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.seed = self.samples, True, 7

    def _kept(self, camera: Camera, way: str, set_up_scene: Any) -> Picture:
        facts = json.dumps([asdict(camera), way, self.samples, EEVEE_SAMPLES, bpy.app.version_string])
        digest = hashlib.sha256(self.scene.read_bytes() + facts.encode()).hexdigest()[:12]
        file = self.folder / f"{camera.name}-{way.split(maxsplit=1)[0]}-{digest}.exr"
        if not file.exists():
            bpy.ops.wm.open_mainfile(filepath=str(self.scene))
            scene: Any = bpy.context.scene
            scene.camera = _placed(scene, camera)
            set_up_scene(scene, camera.pixels)
            beside = file.with_name("rendering.exr")
            scene.render.filepath = str(beside)
            bpy.ops.render.render(write_still=True)
            beside.rename(file)
            bpy.ops.wm.open_mainfile(filepath=str(self.scene))
        (found,) = read_render(file).values()
        picture: Picture = found[::-1, :, :3].astype(np.float64)
        return picture


def _placed(scene: Any, camera: Camera) -> Any:
    data: Any = bpy.data.cameras.new(camera.name)
    data.sensor_fit, data.angle, data.clip_start = "HORIZONTAL", radians(camera.fovy), _NEAREST
    item = bpy.data.objects.new(camera.name, data)
    item.matrix_world = camera.matrix
    scene.collection.objects.link(item)
    return item


def _set_up_eevee(scene: Any, pixels: int) -> None:
    set_up(scene, pixels, EEVEE_SAMPLES)
    scene.eevee.use_shadows = True
    scene.eevee.clamp_surface_direct = scene.eevee.clamp_surface_indirect = (
        0  # or a lamp's mirror image is dull
    )
    scene.eevee.ray_tracing_options.resolution_scale = "1"
    scene.eevee.fast_gi_resolution = "1"
    if scene.world is not None:
        scene.world.sun_threshold = 0


def _add_probe(scene: Any, objects: list[str]) -> None:
    """A sphere probe amid objects, which it does not see."""
    _add_sphere(scene, *bounds(objects))
    for name in objects:
        cast(Any, bpy.data.objects[name]).hide_probe_sphere = True


def _add_sphere(scene: Any, low: Array, high: Array) -> None:
    """A sphere probe in the middle of a box, which is all within its influence."""
    data: Any = bpy.data.lightprobes.new("Sphere", "SPHERE")
    data.influence_distance = float(np.linalg.norm(high - low))
    probe = bpy.data.objects.new("Sphere", data)
    probe.location = ((low + high) / 2).tolist()
    scene.collection.objects.link(probe)


def _add_volume(scene: Any, low: Array, high: Array) -> None:
    """A volume of probes, _APART at most, from one corner of a box to another; they take the sky's light too.

    The volume is larger by half a gap all around: beyond the outermost probes Eevee fades to the sky.
    """
    data: Any = bpy.data.lightprobes.new("Volume", "VOLUME")
    counts = np.ceil((high - low) / _APART) + 1
    half = (high - low) / 2 * counts / (counts - 1)
    for axis, count in zip("xyz", counts, strict=True):
        setattr(data, f"resolution_{axis}", int(count))
    data.capture_world, data.clamp_indirect = True, 0
    probe = bpy.data.objects.new("Volume", data)
    probe.location, probe.scale = ((low + high) / 2).tolist(), half.tolist()
    scene.collection.objects.link(probe)


def bounds(objects: list[str]) -> tuple[Array, Array]:
    """The lowest and highest corners of a box in world space around objects of the open file."""
    corners = [
        np.array(item.matrix_world) @ [*corner, 1]
        for item in (bpy.data.objects[name] for name in objects)
        for corner in cast(Any, item).bound_box
    ]
    points = np.array(corners)[:, :3]
    return points.min(axis=0), points.max(axis=0)


def bounds_inside(cameras: list[Camera]) -> tuple[Array, Array]:
    """The lowest and highest corners of the room that cameras stand in, in the open scene's world space.

    Those are the farthest surfaces that the cameras meet along the axes. Raises InputError where they meet
    none, as without a ceiling.
    """
    scene: Any = bpy.context.scene
    graph = bpy.context.evaluated_depsgraph_get()
    corners = []
    for sign in (-1, 1):
        axes = sign * np.eye(3)
        for axis, away in enumerate(axes):
            met = [scene.ray_cast(graph, camera.place, away.tolist()) for camera in cameras]
            places = [sign * one[1][axis] for one in met if one[0]]
            if not places:
                raise InputError(f"the cameras are in no room: nothing lies along {away.tolist()}")
            corners.append(sign * max(places))
    return np.array(corners[:3]), np.array(corners[3:])
