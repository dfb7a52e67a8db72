# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the surroundings from the object's middle, layer by layer: the world, a plane, other things."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any, Protocol, cast

import bpy
import numpy as np
from mathutils import Euler, Matrix, Vector

from ....bake.piece_store import PieceStore
from ....core.arrays import Floats, Ints
from ....core.errors import BakeError
from ....core.sampler import bilinear
from ....cycles.building_blocks import render_layers
from ....cycles.denoiser import can_denoise
from ....cycles.passes import finite_light
from ....formats.disk.path_checks import render_path
from ....scene.lights.casters import as_glossy_rays_see
from ....scene.lights.light import dark_to_cameras, materials_in_reflections, world_in_reflections
from ....scene.lights.linking import lights
from ....scene.mesh.mesh_checks import FARTHEST
from ....scene.mesh.render_contents import Shape, Shown, read_render
from ....scene.objects import is_rendered
from ....scene.regroup import regroup
from ....scene.scratch import find_view_layer, scene_copied
from ....scene.surfaces import MADE_TO_MESHES
from ....settings.rays import NEAR_SAMPLES, NEAR_WIDTH, ROOM_SAMPLES, WORLD_WIDTH
from ..cells import PICTURE_SIZE
from ..lookup.environment import Impostor, Pictures, Plane, SurroundingLayer
from ..lookup.ray_ends import SAME
from .room import Room

log = logging.getLogger(__name__)

_LEAST_EYE = 0.25  # times the object's radius: the least height that is doubled so
_CLIP = 1e-3  # of the object's radius, and at most in scene units: nearer things are not seen
EYE = 2.0  # times the middle's height above a plane: whence it is seen, or its far parts are a few pixels
_FLAT = 1e-3  # thickness of a flat thing, in its length
_SOLID = 0.99  # alpha of a pixel that its layer covers
_BORDER = 64  # pixels that are rendered around things: OpenImageDenoise dims or brightens narrow pictures
_DARK = 2.0**-16  # OpenImageDenoise makes an eighth of that of black; half floats hold it roughly
_ALL = slice(None)
_FINE = 0.03  # radians: a lobe this wide still needs pictures of the usual size
_COARSEST = 0.25  # share of the usual size
_UP = np.array([0.0, 0.0, 1.0])
_KEPT = 4  # views of rooms, of 11 MB each
NO_SURFACE = MADE_TO_MESHES | {"LIGHT", "LIGHT_PROBE", "CAMERA", "SPEAKER", "EMPTY", "ARMATURE", "LATTICE"}


@dataclass(frozen=True, eq=False)
class _Seen:
    """What a room's eye sees in each pixel: `light` (H, W, 4) and the `place` (H, W, 3), in world space."""

    light: Floats
    place: Floats


class Views(Protocol):
    """What rooms' eyes have seen in a run of bakes, by what that depends on."""

    def find(self, key: str) -> _Seen | None: ...

    def keep(self, key: str, seen: _Seen) -> None: ...


class _LatestViews:
    """The latest views, in memory."""

    def __init__(self) -> None:
        self._kept: dict[str, _Seen] = {}

    def find(self, key: str) -> _Seen | None:
        seen = self._kept.pop(key, None)
        if seen is not None:
            self._kept[key] = seen  # the last to be left out
        return seen

    def keep(self, key: str, seen: _Seen) -> None:
        while len(self._kept) >= _KEPT:
            del self._kept[next(iter(self._kept))]
        self._kept[key] = seen


@dataclass(frozen=True, eq=False)
class StoredViews:
    """All views, as pieces of a store; `make` says whether this process is to make one that is not there."""

    store: PieceStore
    make: Callable[[str], bool]

    def find(self, key: str) -> _Seen | None:
        while (piece := self.store.found(key)) is None:
            if self.make(key):
                return None
        return _Seen(piece["light"], piece["place"])

    def keep(self, key: str, seen: _Seen) -> None:
        self.store.keep(key, {"light": seen.light, "place": seen.place})


_RUNS: list[Views] = []  # of runs of bakes


@dataclass(frozen=True, eq=False)
class Near:
    """Objects of the scene that lie in one layer with their instances.

    In a plane, with its normal and height, or on the planes of a room.
    """

    objects: frozenset[bpy.types.Object]
    plane: tuple[Floats, float] | None = None
    room: Room | None = None


def near_things(
    scene: bpy.types.Scene, subjects: Collection[bpy.types.Object], room: Room | None = None
) -> list[Near]:
    """The largest flat thing that a scratch scene renders, and all others, from far to near.

    Of a `room` the things on its planes, and its furniture. What is not there is left out, and so are the
    `subjects`, which are baked; but a room's planes have those that belong to them, and so has its furniture
    where it is seen from an eye of the room. What lies nowhere is left out with a warning. Raises BakeError
    where Blender does not render.
    """
    hidden = frozenset(subjects) if room is None else frozenset(subjects) - room.shown
    there = read_render(scene, lambda shown: _owners(shown, hidden))
    finite = {owner: found for owner, found in there.items() if found.is_somewhere}
    for owner in there.keys() - finite.keys():
        log.warning(
            "object '%s' has vertices nowhere, or too far away: nothing mirrors it",
            owner.name,
        )
    if room is not None:
        shell = frozenset(owner for owner in finite if owner not in room.furniture)
        inside = frozenset(owner for owner in finite if owner in room.furniture)
        return [Near(shell, room=room)] + ([Near(inside)] if inside else [])
    flat = {owner: found for owner, found in finite.items() if found.is_flat}
    largest = max(flat, key=lambda owner: (flat[owner].size, owner.name), default=None)
    others = frozenset(owner for owner in finite if owner is not largest)
    found = [] if largest is None else [Near(frozenset({largest}), flat[largest].plane)]
    return found + ([Near(others)] if others else [])


def _owners(shown: Iterator[Shown], subjects: frozenset[bpy.types.Object]) -> dict[bpy.types.Object, _Spread]:
    """How the vertices lie in space of all that each object of the scene shows to glossy rays."""
    spreads: dict[bpy.types.Object, _Spread] = {}
    of_shape: dict[Shape, _Spread] = {}
    for one in shown:
        if one.evaluated.type in NO_SURFACE or one.owner in subjects or "glossy" not in one.seen_by:
            continue
        shape = one.shape
        if shape is None:  # hair, a volume: its box is all that is known of it
            spread = _Spread.of(one.bounds)
        else:
            if shape not in of_shape:
                of_shape[shape] = _Spread.of(shape.position[np.unique(shape.triangles)])
            spread = of_shape[shape].moved(one.matrix)
        before = spreads.get(one.owner)
        spreads[one.owner] = spread if before is None else before.joined(spread)
    return spreads


@dataclass(frozen=True, eq=False)
class _Spread:
    """How many points there are, their `mean` (3,), and their `covariance` (3, 3)."""

    count: int
    mean: Floats
    covariance: Floats

    @classmethod
    def of(cls, points: Floats) -> _Spread:
        with np.errstate(all="ignore"):  # what is not finite is asked about afterwards
            mean = points.mean(axis=0, dtype=np.float64)
            apart = points - mean
            return cls(len(points), mean, apart.T @ apart / len(points))

    def moved(self, matrix: Floats) -> _Spread:
        """The points under a matrix (4, 4)."""
        with np.errstate(all="ignore"):
            turn = matrix[:3, :3]
            return _Spread(self.count, turn @ self.mean + matrix[:3, 3], turn @ self.covariance @ turn.T)

    def joined(self, other: _Spread) -> _Spread:
        """Both sets of points together."""
        with np.errstate(all="ignore"):
            count = self.count + other.count
            mean = (self.count * self.mean + other.count * other.mean) / count
            parts = [
                part.count * (part.covariance + np.outer(part.mean - mean, part.mean - mean))
                for part in (self, other)
            ]
            return _Spread(count, mean, (parts[0] + parts[1]) / count)

    @property
    def is_somewhere(self) -> bool:
        reach = np.abs(self.mean) + np.sqrt(np.abs(np.diag(self.covariance)))
        return bool((reach < FARTHEST).all())

    @property
    def size(self) -> float:
        """The product of the standard deviations along its two longest axes."""
        return float(np.prod(self._deviations[1:]))

    @property
    def is_flat(self) -> bool:
        """Whether the points lie in a plane, and not along a line."""
        thin, wide, long = self._deviations
        return bool(thin < _FLAT * long < wide)

    @property
    def plane(self) -> tuple[Floats, float]:
        """Its unit normal (3,), and its height along that."""
        normal: Floats = np.linalg.eigh(self.covariance)[1][:, 0]
        return normal, float(self.mean @ normal)

    @property
    def _deviations(self) -> Floats:
        """Along its axes, from the shortest."""
        deviations: Floats = np.sqrt(np.maximum(np.linalg.eigvalsh(self.covariance), 0))
        return deviations


@dataclass(frozen=True, eq=False)
class Panoramas:
    """The world's picture, the layers before it, and how many paths both cost."""

    world: Pictures
    layers: tuple[SurroundingLayer, ...]
    paths: int


@contextmanager
def pictures_shared(views: Views | None = None) -> Iterator[None]:
    """Within the context, bakes of one scene render a room's picture once: between them nothing is edited.

    They are kept in memory, or in other `views`.
    """
    _RUNS.append(_LatestViews() if views is None else views)
    try:
        yield
    finally:
        _RUNS.pop()


def share_for(width: float) -> float:
    """How wide pictures need to be for lobes of a width² or more, as a share of the usual: a power of 2."""
    finer = math.log2(max(math.sqrt(min(width, 1.0)) / _FINE, 1.0))
    return max(2.0 ** -math.floor(finer), _COARSEST)


def look_around(
    scene: bpy.types.Scene,
    subjects: Collection[bpy.types.Object],
    middle: Floats,
    radius: float,
    folder: Path,
    seed: int,
    share: float = 1.0,
    room: Room | None = None,
    known_as: str = "",
) -> Panoramas:
    """Render the panoramas of a scratch scene, which is spent, without its `subjects`, which are baked.

    The subjects lie in a sphere of `radius` about `middle` (3,), and may stand in a `room`: see
    `near_things`. Panoramas show what glossy rays see. Their width and that of the resulting pictures is a
    `share` of the usual.

    Only what a layer can show is rendered of its panorama: of a plane what lies below its horizon, of other
    things a rectangle around them. Bakes of a run that are `known_as` of one scene, by a digest of all that
    it renders, share a room's picture; "": of none, see `pictures_shared`. Raises BakeError where Cycles
    fails.
    """
    world_width, near_width, size = (int(share * side) for side in (WORLD_WIDTH, NEAR_WIDTH, PICTURE_SIZE))
    near = near_things(scene, subjects, room)
    with scene_copied(scene) as bare:
        regroup(bare, {})
        bare.world = world_in_reflections(bare.world)
        distant = _Camera(bare, middle, radius, folder, seed)
        seen = distant.render(world_width, 1)
    world = Pictures.of(panorama_directions(world_width), seen["Combined"][..., :3], size)
    layers, paths = [], distant.paths
    with materials_in_reflections(), _unlinked_dark(scene, subjects) as linked:
        look = _Look(scene, middle, radius, folder, seed, near_width, size, "" if linked else known_as)
        for things in near:
            found, traced = look.at(things, room)
            paths += traced
            if found is not None:
                layers.append(found)
    return Panoramas(world, tuple(layers), paths)


@dataclass(frozen=True, eq=False)
class _Look:
    """How panoramas of near things are rendered: see `look_around`; pictures are of `width` and `size`."""

    scene: bpy.types.Scene
    middle: Floats
    radius: float
    folder: Path
    seed: int
    width: int
    size: int
    known_as: str

    def at(self, things: Near, room: Room | None) -> tuple[SurroundingLayer | None, int]:
        """The layer of near things, None if nothing is seen of them, and how many paths that took."""
        if things.room is not None:
            return self._of_room(things, things.room)
        with self._camera(things, self.radius) as camera:
            if things.plane is not None:
                plane = _seen_from_above(*things.plane, self.middle, self.radius)
                camera.place(self.middle + plane.eye, plane.normal)
                return _plane_layer(camera, self.width, plane, self.size), camera.paths
            eye = None if room is None else room.furniture_eye
            found = _impostor(camera, self.width, self.middle, eye, self.size)
            if found is None:
                return None, camera.paths
            pictures, shape = found
            if room is not None:
                boxes, shell = room.boxes_of(things.objects, self.middle), room.shell(self.middle)
                shape = replace(shape, boxes=boxes, shell=shell)
            return SurroundingLayer(pictures, shape), camera.paths

    def _of_room(self, things: Near, room: Room) -> tuple[SurroundingLayer | None, int]:
        """The layer of what lies on a room's planes.

        Its picture is seen from the room's eye, and is that of an earlier bake of the scene if there is one.
        What shines there, such as a mirror or a polished floor, looks as it does from the objects' middle.
        """
        seen, paths = self._known(things, room)
        if seen is None:
            return None, paths
        light = seen.light
        if not room.shown:
            with self._camera(things, self.radius) as camera:
                light = _as_from(self.middle, _view(camera, self.width, self.middle), seen)
            paths += camera.paths
        pictures = Pictures.of(panorama_directions(self.width), light, self.size)
        return SurroundingLayer(pictures, room.shell(self.middle)), paths

    def _known(self, things: Near, room: Room) -> tuple[_Seen | None, int]:
        """What a room's eye sees, None if nothing, and how many paths that took."""
        names = sorted(item.name_full for item in things.objects)
        told = repr((self.known_as, *names, room.eye.tobytes(), self.seed, self.width))
        key = f"view-{sha256(told.encode()).hexdigest()}"
        views: Views = _RUNS[-1] if _RUNS and self.known_as else _LatestViews()
        seen = views.find(key)
        if seen is not None:
            return seen, 0
        with self._camera(things, room.size) as camera:
            seen = _view(camera, self.width, room.eye)
        if not seen.light[..., 3].any():
            return None, camera.paths
        views.keep(key, seen)
        return seen, camera.paths

    @contextmanager
    def _camera(self, things: Near, radius: float) -> Iterator[_Camera]:
        """A camera that sees near things alone, lit by all others, as glossy rays do."""
        with scene_copied(self.scene) as copy, as_glossy_rays_see(copy):
            _show_alone(copy, things.objects)
            copy.render.film_transparent = True
            yield _Camera(copy, self.middle, radius, self.folder, self.seed)


def _plane_layer(camera: _Camera, width: int, plane: Plane, size: int) -> SurroundingLayer | None:
    """The picture of a plane below the camera; None if nothing is seen of it."""
    below = slice(0, width // 4)
    light = camera.render(width, NEAR_SAMPLES, below, denoise=True)["Combined"]
    if not light[..., 3].any():
        return None
    direction = camera.directions(width)[below]
    return SurroundingLayer(Pictures.of(*_with_mirror_image(plane, direction, light), size), plane)


def _view(camera: _Camera, width: int, eye: Floats) -> _Seen:
    """What is seen of a room's planes, and beyond them, from an eye."""
    camera.place(eye)
    passes = camera.render(width, ROOM_SAMPLES, denoise=True, position=True)
    return _Seen(passes["Combined"], passes["Position"][..., :3])


def _as_from(middle: Floats, own: _Seen, seen: _Seen) -> Floats:
    """The light (H, W, 4) of all places that are `seen`, as it looks from the `middle` (3,), whence `own` is.

    Where a place is not seen from there, it stays.
    """
    light = seen.light.copy()
    solid = seen.light[..., 3] > _SOLID
    away = seen.place[solid] - middle
    distance = np.linalg.norm(away, axis=1)
    place = panorama_place(away / np.maximum(distance, 1e-9)[:, None])
    there = bilinear(np.concatenate([own.light, own.place], axis=2), place)
    same = np.linalg.norm(there[:, 4:] - seen.place[solid], axis=1) < SAME * distance
    same &= there[:, 3] > _SOLID
    light[solid] = np.where(same[:, None], there[:, :4], light[solid])
    return light


def _impostor(
    camera: _Camera, width: int, middle: Floats, eye: Floats | None, size: int
) -> tuple[Pictures, Impostor] | None:
    """The picture of all that is seen, and how far away it is; None if nothing is.

    It is seen from the middle, or from an `eye` (3,) in a room.
    """
    place = middle if eye is None else eye.astype(np.float32)
    camera.place(place)
    where = camera.render(width, 1, position=True)
    direction, alpha = camera.directions(width), where["Combined"][..., 3]
    distance = np.linalg.norm(where["Position"][..., :3] - place, axis=-1)
    solid = (alpha > _SOLID) & np.isfinite(distance) & (distance > 0)
    if not solid.any():
        return None
    rows, columns = (
        _around(np.flatnonzero(some), len(some)) for some in (alpha.any(axis=1), alpha.any(axis=0))
    )
    light = np.zeros((*alpha.shape, 4), dtype=np.float32)
    samples = NEAR_SAMPLES if eye is None else ROOM_SAMPLES
    seen = camera.render(width, samples, rows, columns, denoise=True)
    light[rows, columns] = seen["Combined"]
    shape = Impostor.of(direction[solid], distance[solid], place - middle)
    return Pictures.of(direction, light, size), shape


def _around(some: Ints, count: int) -> slice:
    """A range of `count` pixels that holds `some` (N,) of them, and a border for what their edges hide."""
    return slice(max(0, int(some[0]) - _BORDER), min(count, int(some[-1]) + 1 + _BORDER))


@contextmanager
def _unlinked_dark(scene: bpy.types.Scene, subjects: Collection[bpy.types.Object]) -> Iterator[bool]:
    """Hide from cameras the emission of objects that by light linking do not light all subjects.

    Cycles does not show it to them, in mirrors either. Yields whether any is hidden. The slots have their own
    materials again at the end.
    """

    def unlinked(shown: Iterator[Shown]) -> set[bpy.types.Object]:
        return {
            one.original
            for one in shown
            if one.evaluated.type != "LIGHT"
            and not all(lights(one.original, subject) for subject in subjects)
        }

    linking = any(cast(Any, item).light_linking.receiver_collection for item in bpy.data.objects)
    items = read_render(scene, unlinked) if linking else set()
    slots: list[Any] = [slot for item in items for slot in item.material_slots if slot.material is not None]
    before = [slot.material for slot in slots]
    try:
        for slot, material in zip(slots, before, strict=True):
            slot.material = dark_to_cameras(material)
        yield bool(slots)
    finally:
        for slot, material in zip(slots, before, strict=True):
            slot.material = material


def _show_alone(scene: bpy.types.Scene, objects: Collection[bpy.types.Object]) -> None:
    """Let the camera of a scratch scene see some objects alone, with all the light that others send."""
    layer, every = find_view_layer(scene, None), list(scene.objects)
    rendered = {item for item in every if is_rendered(item, layer)}
    seen = frozenset(objects)
    groups = regroup(
        scene,
        {
            "RadTex rest": rendered - seen,
            "RadTex hidden": set(every) - rendered - seen,
            "RadTex near": seen,
        },
    )
    groups["RadTex rest"].indirect_only = True
    groups["RadTex hidden"].collection.hide_render = True


def _seen_from_above(normal: Floats, height: float, middle: Floats, radius: float) -> Plane:
    """The plane normal . p = height, in world space, seen from farther off than the object's middle is.

    An object of that `radius` may stand in it, so that its middle lies in the plane or nearly.
    """
    below = float(normal @ middle) - height
    if below < 0:
        normal, below = -normal, -below
    eye = (normal * (EYE * max(below, _LEAST_EYE * radius) - below)).astype(np.float32)
    return Plane(normal.astype(np.float32), -below, eye)


def _with_mirror_image(plane: Plane, direction: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Directions (P, 3) below the plane's horizon and values (P, C) there, and both mirrored above it."""
    direction, values = direction.reshape(-1, 3), values.reshape(direction.size // 3, -1)
    sine = direction @ plane.normal
    below = sine < 0
    mirrored = direction - 2 * sine[:, None] * plane.normal
    return np.concatenate([direction[below], mirrored[below]]), np.concatenate([values[below]] * 2)


class _Camera:
    """A camera that sees all around, from the middle."""

    def __init__(
        self, scene: bpy.types.Scene, middle: Floats, radius: float, folder: Path, seed: int
    ) -> None:
        self._scene, self._folder = scene, folder
        self.paths = 0  # that were traced
        data = bpy.data.cameras.new("RadTex panorama")
        cast(Any, data).type = "PANO"
        cast(Any, data).panorama_type = "EQUIRECTANGULAR"
        data.clip_start = _CLIP * min(1.0, radius)
        self._turn = Matrix.Identity(3)
        scene.camera = bpy.data.objects.new("RadTex panorama", data)
        scene.collection.objects.link(scene.camera)
        self.place(middle)
        _settle(scene, seed)

    def place(self, place: Floats, up: Floats = _UP) -> None:
        """Let the next renders be from another place, (3,) in world space; their top rows look along `up`."""
        self._turn = Vector(_UP.tolist()).rotation_difference(Vector(up.tolist())).to_matrix()
        camera = cast(Any, self._scene.camera)
        camera.location = place.tolist()
        camera.rotation_euler = (self._turn @ Euler((math.pi / 2, 0, 0)).to_matrix()).to_euler()

    def directions(self, width: int) -> Floats:
        """World directions of a picture's pixels, (width / 2, width, 3), rows from the bottom."""
        return panorama_directions(width) @ np.array(self._turn, dtype=np.float32).T

    def render(
        self,
        width: int,
        samples: int,
        rows: slice = _ALL,
        columns: slice = _ALL,
        denoise: bool = False,
        position: bool = False,
    ) -> dict[str, Floats]:
        """Passes of some pixels by their names, (H, W, C), rows from the bottom; light in Rec.709."""
        scene = self._scene
        render, cycles = scene.render, cast(Any, scene).cycles
        cycles.samples, cycles.use_denoising = samples, denoise and can_denoise(scene)
        if denoise and not cycles.use_denoising:
            log.warning("this Blender has no OpenImageDenoise: what the object mirrors stays noisy")
        render.resolution_x, render.resolution_y = width, width // 2
        low, high, _ = rows.indices(width // 2)
        render.border_min_y, render.border_max_y = _border(low, high, width // 2)
        left, right, _ = columns.indices(width)
        render.border_min_x, render.border_max_x = _border(left, right, width)
        find_view_layer(scene, None).use_pass_position = position
        path = self._folder / "panorama.exr"
        render.filepath = render_path(path)
        passes = render_layers(scene, path)
        path.unlink()
        light = finite_light(passes.whole)
        if light.shape[:2] != (high - low, right - left):
            raise BakeError(
                f"Cycles returned a picture of {light.shape[:2]}, expected {(high - low, right - left)}"
            )
        if cycles.use_denoising:
            light = np.where(np.abs(light) > _DARK, light, light.dtype.type(0))
        self.paths += samples * (high - low) * (right - left)
        if passes.to_rec709 is not None:  # colours beyond Rec.709 are below 0
            light = np.concatenate([np.maximum(light[..., :3], 0), light[..., 3:]], axis=-1)
        return passes.raw | {"Combined": light}


def _settle(scene: bpy.types.Scene, seed: int) -> None:
    """Settings that all panoramas of a scene share."""
    render, cycles = scene.render, cast(Any, scene).cycles
    cast(Any, render).engine = "CYCLES"
    cycles.seed, cycles.use_adaptive_sampling, cycles.pixel_filter_type = seed, False, "BOX"
    # Prefilters cost more time than twice the samples, which do more:
    cycles.denoising_prefilter, cycles.denoising_quality = "FAST", "HIGH"
    cycles.denoising_input_passes = "RGB_ALBEDO_NORMAL"
    render.resolution_percentage = 100
    render.use_border = render.use_crop_to_border = True
    image = render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "MULTI_LAYER_IMAGE"
    image.file_format, image.color_depth, image.exr_codec = "OPEN_EXR_MULTILAYER", "32", "NONE"


def _border(first: int, end: int, count: int) -> tuple[float, float]:
    """Pixels `first` … `end` - 1 of `count` as a border's sides; a quarter of a pixel keeps rounding safe."""
    return (first + 0.25) / count if first else 0.0, min(1.0, (end + 0.25) / count)


def panorama_place(direction: Floats) -> Floats:
    """Where a panorama shows unit directions (N, 3): (N, 2), 0 to 1, from its lower left corner."""
    x, y, z = direction.T
    turn, rise = np.arctan2(x, y) / (2 * np.pi) + 0.5, np.arcsin(np.clip(z, -1, 1)) / np.pi + 0.5
    return np.stack([turn, rise], axis=1)


def panorama_directions(width: int) -> Floats:
    """World directions of an equirectangular panorama's pixels, (width / 2, width, 3), rows from the bottom.

    Its middle looks along +Y, and +X lies to the right of that.
    """
    turn = ((np.arange(width) + 0.5) / width - 0.5) * 2 * np.pi
    rise = ((np.arange(width // 2) + 0.5) / (width // 2) - 0.5) * np.pi
    turn, rise = np.meshgrid(turn, rise)
    parts = (np.sin(turn) * np.cos(rise), np.cos(turn) * np.cos(rise), np.sin(rise))
    return np.stack(parts, axis=-1).astype(np.float32)
