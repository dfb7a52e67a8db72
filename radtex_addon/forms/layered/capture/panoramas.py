# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the surroundings from the object's middle, layer by layer: the world, a plane, other things."""

from __future__ import annotations

import logging
import math
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ....bake.rays import NEAR_SAMPLES, NEAR_WIDTH, WORLD_WIDTH, panorama_paths
from ....core.arrays import Floats
from ....cycles.building_blocks import render_layers
from ....cycles.denoiser import can_denoise
from ....formats.disk.path_checks import render_path
from ..cells import PICTURE_SIZE
from ..lookup.environment import Impostor, Layer, Pictures, Plane

log = logging.getLogger(__name__)

EYE = 2.0  # times the middle's height above a plane: whence it is seen, or its far parts are a few pixels
_FLAT = 1e-3  # thickness of a flat thing, in its length
_SOLID = 0.99  # alpha of a pixel that its layer covers
_SHAPES = frozenset({"MESH", "CURVE", "FONT", "SURFACE", "META"})


@dataclass(frozen=True, eq=False)
class Near:
    """Things that lie in one layer, by name; if it is a plane, its normal and height in world space."""

    names: frozenset[str]
    plane: tuple[Floats, float] | None


def near_things(scene: bpy.types.Scene, subjects: Collection[str]) -> list[Near]:
    """The largest flat thing, and all others, from far to near; what is not there is left out.

    The objects called `subjects`, which are baked, are none of them.
    """
    flat: list[tuple[float, str, Floats, float]] = []
    others: list[str] = []
    graph = bpy.context.evaluated_depsgraph_get()
    for item in scene.objects:
        if item.type not in _SHAPES or item.name in subjects or item.hide_render:
            continue
        place = _vertices(item, graph)
        if not len(place):
            continue
        _, extent, axes = np.linalg.svd(place - place.mean(axis=0), full_matrices=False)
        if len(extent) == 3 and extent[2] < _FLAT * extent[0]:
            flat.append(
                (float(extent[0] * extent[1]), item.name, axes[2], float(place.mean(axis=0) @ axes[2]))
            )
        else:
            others.append(item.name)
    flat.sort(key=lambda found: -found[0])
    others += [name for _, name, _, _ in flat[1:]]
    found = [Near(frozenset({name}), (normal, height)) for _, name, normal, height in flat[:1]]
    return found + ([Near(frozenset(others), None)] if others else [])


def _vertices(item: bpy.types.Object, graph: bpy.types.Depsgraph) -> Floats:
    shown: Any = item.evaluated_get(graph)
    mesh = shown.to_mesh()
    place = np.empty(3 * len(mesh.vertices))
    mesh.vertices.foreach_get("co", place)
    matrix = np.array(shown.matrix_world)
    moved: Floats = place.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
    shown.to_mesh_clear()
    return moved


@dataclass(frozen=True, eq=False)
class Panoramas:
    """The world's picture, the layers before it, and how many paths both cost."""

    world: Pictures
    layers: tuple[Layer, ...]
    paths: int


def look_around(
    scene: bpy.types.Scene,
    subjects: Collection[str],
    middle: Floats,
    folder: Path,
    seed: int,
    share: float = 1.0,
) -> Panoramas:
    """Render the panoramas, in copies of `scene`, without the objects called `subjects`, which are baked.

    Their width and that of the resulting pictures is a `share` of the usual.

    Raises BakeError where Cycles fails.
    """
    world_width, near_width, size = (int(share * side) for side in (WORLD_WIDTH, NEAR_WIDTH, PICTURE_SIZE))
    camera = _Camera(scene, middle, folder, seed)
    near = near_things(scene, subjects)
    direction = panorama_directions(world_width)
    with _hidden(scene, "hide_render", _others(scene, frozenset())):
        seen = camera.render(world_width, 1)
    world = Pictures.of(direction, seen["Combined"][..., :3], size)
    direction = panorama_directions(near_width)
    layers = []
    for things in near:
        plane = None if things.plane is None else _seen_from_above(*things.plane, middle)
        eye = np.zeros(3) if plane is None else plane.eye
        camera.move(middle + eye)
        with _hidden(scene, "visible_camera", _others(scene, things.names)):
            seen = camera.render(near_width, NEAR_SAMPLES, denoise=True)
            where = camera.render(near_width, 1, position=True)
        solid = (where["Combined"][..., 3] > _SOLID).ravel()
        if not solid.any():
            continue
        shape: Plane | Impostor
        if plane is not None:
            shape = plane
            pictures = Pictures.of(*_with_mirror_image(plane, direction, seen["Combined"]), size)
        else:
            position = where["Position"].reshape(-1, where["Position"].shape[-1])[:, :3]
            distance = np.linalg.norm(position - middle, axis=1)
            shape = Impostor.of(direction.reshape(-1, 3)[solid], distance[solid])
            pictures = Pictures.of(direction, seen["Combined"], size)
        layers.append(Layer(pictures, shape))
    paths = panorama_paths(len(near), world_width, near_width)
    return Panoramas(world, tuple(layers), paths)


def _seen_from_above(normal: Floats, height: float, middle: Floats) -> Plane:
    """The plane normal . p = height, in world space, seen from farther off than the object's middle is."""
    below = float(normal @ middle) - height
    if below < 0:
        normal, below = -normal, -below
    eye = (normal * (EYE - 1) * below).astype(np.float32)
    return Plane(normal.astype(np.float32), -below, eye)


def _with_mirror_image(plane: Plane, direction: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Directions (P, 3) below the plane's horizon and values (P, C) there, and both mirrored above it."""
    direction, values = direction.reshape(-1, 3), values.reshape(direction.size // 3, -1)
    sine = direction @ plane.normal
    below = sine < 0
    mirrored = direction - 2 * sine[:, None] * plane.normal
    return np.concatenate([direction[below], mirrored[below]]), np.concatenate([values[below]] * 2)


def _others(scene: bpy.types.Scene, names: frozenset[str]) -> list[bpy.types.Object]:
    return [item for item in scene.objects if item.type in _SHAPES and item.name not in names]


@contextmanager
def _hidden(scene: bpy.types.Scene, attribute: str, items: Sequence[bpy.types.Object]) -> Iterator[None]:
    """Hide objects from all rays, or from the camera's; world alone if from all."""
    before = [getattr(item, attribute) for item in items]
    scene.render.film_transparent = attribute == "visible_camera"
    try:
        for item in items:
            setattr(item, attribute, attribute == "hide_render")
        yield
    finally:
        for item, value in zip(items, before, strict=True):
            setattr(item, attribute, value)


class _Camera:
    """A camera that sees all around, from the middle."""

    def __init__(self, scene: bpy.types.Scene, middle: Floats, folder: Path, seed: int) -> None:
        self._scene, self._folder, self._seed = scene, folder, seed
        data = bpy.data.cameras.new("RadTex panorama")
        cast(Any, data).type = "PANO"
        cast(Any, data).panorama_type = "EQUIRECTANGULAR"
        data.clip_start = 1e-3
        camera = bpy.data.objects.new("RadTex panorama", data)
        camera.location, camera.rotation_euler = middle.tolist(), (math.pi / 2, 0, 0)
        scene.collection.objects.link(camera)
        scene.camera = camera

    def move(self, place: Floats) -> None:
        """Let the next renders be from another place, (3,) in world space."""
        cast(Any, self._scene.camera).location = place.tolist()

    def render(
        self, width: int, samples: int, denoise: bool = False, position: bool = False
    ) -> dict[str, Floats]:
        """The picture's passes by their names, (H, W, C), rows from the bottom; light in Rec.709."""
        scene = self._scene
        render, cycles = scene.render, cast(Any, scene).cycles
        cast(Any, render).engine = "CYCLES"
        cycles.samples, cycles.seed, cycles.use_adaptive_sampling = samples, self._seed, False
        cycles.pixel_filter_type, cycles.use_denoising = "BOX", denoise and can_denoise(scene)
        if denoise and not cycles.use_denoising:
            log.warning("this Blender has no OpenImageDenoise: what the object mirrors stays noisy")
        render.resolution_x, render.resolution_y, render.resolution_percentage = width, width // 2, 100
        image = render.image_settings
        if hasattr(image, "media_type"):
            image.media_type = "MULTI_LAYER_IMAGE"
        image.file_format, image.color_depth = "OPEN_EXR_MULTILAYER", "32"
        scene.view_layers[0].use_pass_position = position
        path = self._folder / "panorama.exr"
        render.filepath = render_path(path)
        passes = render_layers(scene, path)
        path.unlink()
        light = passes.whole
        if passes.to_rec709 is not None:  # colours beyond Rec.709 are below 0
            light = np.concatenate([np.maximum(light[..., :3], 0), light[..., 3:]], axis=-1)
        return passes.raw | {"Combined": light}


def panorama_directions(width: int) -> Floats:
    """World directions of an equirectangular panorama's pixels, (width / 2, width, 3), rows from the bottom.

    Its middle looks along +Y, and +X lies to the right of that.
    """
    turn = ((np.arange(width) + 0.5) / width - 0.5) * 2 * np.pi
    rise = ((np.arange(width // 2) + 0.5) / (width // 2) - 0.5) * np.pi
    turn, rise = np.meshgrid(turn, rise)
    parts = (np.sin(turn) * np.cos(rise), np.cos(turn) * np.cos(rise), np.sin(rise))
    return np.stack(parts, axis=-1).astype(np.float32)
