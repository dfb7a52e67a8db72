# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shadows in one bit a cell, hard and soft, against Cycles: python -m tests.bench.gallery.shadow [--all]

Light is analytic, the sun's or the area lamp's on white, times the share of the lamp that bits let through.
Up to 8 x 8 cells bits are blended wide and sharpened; with more, whole cells answer, as the shaders have it.
With `--all` both ways and every filter are tried, and 32 x 32 cells.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import radians
from pathlib import Path
from typing import Any, Literal, cast

import bpy
import numpy as np
from mathutils import Vector

from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.frame import to_frame
from radtex_addon.core.hemisphere import square_to_direction
from radtex_addon.core.sampler import Filter
from radtex_addon.core.shadow import unpack_bits
from radtex_addon.formats.containers.exr import read_render
from radtex_addon.formats.shadow_files import Words, read_shadow_of
from radtex_addon.job import bake_object
from radtex_addon.prepare.prepared import prepare
from radtex_addon.report.gbuffer import BakedSurface, CameraRays, GBuffer
from radtex_addon.report.metrics import Picture
from radtex_addon.scene.nodes import open_world
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, Kind
from tests.blender import stage
from tests.blender.casting import all_meshes, blocked, plan_of_bake
from tests.reference.shadows import (
    area_weights,
    cell_visibility,
    soft_visibility,
    square_points,
    sun_directions,
    sun_weight,
    visibility,
)

from .looking import FILM_PIXELS, FRAMES, Place
from .row import Row, Use

SUBJECT = "Subject"
TEXELS = 128
PIXELS = 256
SAMPLES = 192  # of the reference's pixels, which nothing denoises
_FILM_SAMPLES = 64
LIGHTS = 64  # points of a light that a lookup takes
SUBSAMPLES = 2  # of ours, along a pixel's side
MOST_BLENDED = 8  # cells on a side
WHITE = 0.8
_HALF = 18 / 50  # of the cameras: a sensor of 36 mm behind a lens of 50
_CAMERAS = {"left": (-4.2, -5.0, 4.2), "high": (1.5, -4.4, 6.6)}


@dataclass(frozen=True)
class Lamp:
    """A lamp of the scene: a sun from the direction `towards`, or a square of side `size` at `towards`."""

    name: str
    kind: Literal["SUN", "AREA"]
    towards: tuple[float, float, float]
    size: float  # of a sun the angle in radians
    strength: float


LAMPS = (
    Lamp("sun of 40 degrees", "SUN", (0.35, -0.3, 0.89), radians(40), 3.0),
    Lamp("area lamp", "AREA", (1.2, -1.0, 3.2), 2.4, 100.0),
)


def scene() -> None:
    """A head on a floor, which are one mesh and the subject, and things that float above them."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_monkey_add(location=(-0.5, 0, 0.75), rotation=(-0.5, 0, 0.4))
    head: Any = bpy.context.object
    subdivision = head.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels = subdivision.render_levels = 2
    bpy.ops.object.shade_smooth()
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    bpy.ops.mesh.primitive_plane_add(size=5)
    head.select_set(True)
    subject: Any = bpy.context.object
    bpy.ops.object.join()
    subject.name = SUBJECT
    subject.data.materials.clear()
    colour = (WHITE, WHITE, WHITE, 1)
    subject.data.materials.append(stage.material("White", "ShaderNodeBsdfDiffuse", Color=colour))
    bpy.ops.mesh.primitive_torus_add(location=(1.3, 0.6, 0.9), rotation=(0.5, 0.3, 0), major_radius=0.6)
    bpy.ops.mesh.primitive_cube_add(size=0.5, location=(0.9, -1.3, 0.6), rotation=(0.3, 0.5, 0.2))
    for item in cast(Any, bpy.context.scene).objects:
        item.visible_camera = item.name == SUBJECT
    cast(Any, bpy.context.scene).world, _ = open_world("Dark")


@dataclass(frozen=True, eq=False)
class Baked:
    """Shadows of the subject, and its surface."""

    words: Words
    layout: AtlasLayout
    surface: BakedSurface


def bake(spec: BakeSpec, folder: Path) -> Baked:
    """Bake the open scene's subject."""
    made = bake_object(cast(Any, bpy.context.scene), SUBJECT, spec, folder)
    words, facts = read_shadow_of(made.files.sidecar)
    kept: list[bpy.types.ID] = []
    with scratch_scene(cast(Any, bpy.context.scene), None, kept) as scratch:
        prepared = finished(prepare(scratch, [find_object(scratch, SUBJECT)], spec, kept))
        surface = BakedSurface(prepared.mesh, prepared.matrix_world, prepared.uv_layer)
    bpy.data.batch_remove(kept)
    return Baked(words, AtlasLayout(facts.width, facts.height, facts.bucket), surface)


def lit(baked: Baked, seen: GBuffer, lamp: Lamp, kind: Filter | None, lights: int = LIGHTS) -> Floats:
    """The light (hits, 3) that the subject sends back where rays met it; of whole cells with a `kind`."""
    hit = seen.hit
    position, normal = seen.position[hit], seen.normal[hit]
    frame = seen.tangent[hit], seen.bitangent[hit], normal
    if lamp.kind == "SUN":
        towards = np.array(lamp.towards) / np.linalg.norm(lamp.towards)
        ways = np.broadcast_to(sun_directions(towards, lamp.size, lights), (len(position), lights, 3))
        weight = np.maximum(np.einsum("ksx,kx->ks", ways, normal), 0)
        arriving = weight.mean(axis=1) * lamp.strength * sun_weight(lamp.size)
    else:
        axis, corner_u, corner_v = _area_frame(lamp)
        points = np.array([x * corner_u + y * corner_v for x, y in square_points(lights)]) + lamp.towards
        ways, weight = area_weights(position, normal, points, axis)
        arriving = weight.mean(axis=1) * lamp.strength / np.pi
    local = np.stack([to_frame(ways[:, s], *frame) for s in range(lights)], axis=1)
    looked_up = baked.words, baked.layout, seen.uv[hit], local, weight
    share = soft_visibility(*looked_up) if kind is None else cell_visibility(*looked_up, kind)
    return np.repeat((WHITE / np.pi * arriving * share)[:, None], 3, axis=1)


def _area_frame(lamp: Lamp) -> tuple[Floats, Floats, Floats]:
    """Where an area lamp shines, and the halves of its sides."""
    turn = np.array(_turn_down(lamp.towards).to_matrix())
    return -turn[:, 2], turn[:, 0] * lamp.size / 2, turn[:, 1] * lamp.size / 2


def _turn_down(place: tuple[float, float, float]) -> Any:
    return cast(Any, Vector(place)).to_track_quat("Z", "Y")


def views(surface: BakedSurface, lamp: Lamp) -> Iterator[tuple[str, GBuffer, Picture]]:
    """Each camera's name, what it sees, and Cycles's picture."""
    item = _add_lamp(lamp)
    try:
        for name, place in _CAMERAS.items():
            yield name, *_view(surface, place, PIXELS, SAMPLES)
    finally:
        bpy.data.objects.remove(item)


def _view(surface: BakedSurface, place: Place, pixels: int, samples: int) -> tuple[GBuffer, Picture]:
    """What a camera at a place, which looks at the origin, sees of the subject, and of the scene."""
    turn = cast(Any, Vector(place)).to_track_quat("Z", "Y")
    rays = CameraRays.of_camera(place, np.array(turn.to_matrix()), _HALF, pixels, SUBSAMPLES)
    seen = surface.gbuffer(rays, np.full(len(rays.away), np.inf))
    return seen, _render(place, turn, pixels, samples)


def _add_lamp(lamp: Lamp) -> bpy.types.Object:
    data: Any = bpy.data.lights.new(lamp.name, lamp.kind)
    data.energy = lamp.strength
    if lamp.kind == "SUN":
        data.angle = lamp.size
    else:
        data.size = lamp.size
    item: Any = bpy.data.objects.new(lamp.name, data)
    item.location = lamp.towards
    item.rotation_mode, item.rotation_quaternion = "QUATERNION", _turn_down(lamp.towards)
    cast(Any, bpy.context.scene).collection.objects.link(item)
    return cast(bpy.types.Object, item)


def _render(place: Place, turn: Any, pixels: int, samples: int) -> Picture:
    """Direct light alone, from the top row on."""
    made: Any = bpy.context.scene
    data = bpy.data.cameras.new("Camera")
    camera: Any = bpy.data.objects.new("Camera", data)
    camera.location, camera.rotation_mode, camera.rotation_quaternion = place, "QUATERNION", turn
    made.collection.objects.link(camera)
    made.camera, made.render.engine = camera, "CYCLES"
    made.render.resolution_x = made.render.resolution_y = pixels
    made.cycles.samples, made.cycles.max_bounces, made.cycles.use_denoising = samples, 0, False
    made.cycles.use_adaptive_sampling = False
    made.cycles.pixel_filter_type, made.cycles.filter_width = "BOX", 1.0
    image = made.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_depth = "OPEN_EXR", "32"
    with tempfile.TemporaryDirectory() as folder:
        made.render.filepath = str(Path(folder, "view.exr"))
        bpy.ops.render.render(write_still=True)
        (seen,) = read_render(Path(folder, "view.exr")).values()
    bpy.data.objects.remove(camera)
    picture: Picture = seen[::-1, :, :3].astype(np.float64)
    return picture


def rows(buckets: Sequence[int] = (8, 16), stills: bool = True) -> Iterator[Row]:
    """The gallery's rows: each lamp from new views."""
    scene()
    bakes = [_baked(bucket) for bucket in (buckets if stills else buckets[-1:])]
    for lamp in LAMPS if stills else ():
        yield from _rows_of(bakes, lamp, lambda n: None if n <= MOST_BLENDED else Filter.QUADRILINEAR)
    yield from _film(bakes[-1])


def _film(baked: Baked) -> Iterator[Row]:
    """The sun once around, by whole cells."""
    for angle in 2 * np.pi * np.arange(FRAMES) / FRAMES:
        lamp = replace(LAMPS[0], towards=(0.75 * float(np.cos(angle)), 0.75 * float(np.sin(angle)), 0.8))
        item = _add_lamp(lamp)
        seen, reference = _view(baked.surface, _CAMERAS["left"], FILM_PIXELS, _FILM_SAMPLES)
        bpy.data.objects.remove(item)
        ours = seen.resolve(seen.spread(lit(baked, seen, lamp, Filter.QUADRILINEAR)))
        yield Row("Shadow, film", reference, ours, seen.eroded, use=Use.FILM)


def _baked(bucket: int) -> Baked:
    with tempfile.TemporaryDirectory() as folder:
        return bake(BakeSpec(kind=Kind.SHADOW, texels=TEXELS, bucket=bucket), Path(folder))


def _rows_of(bakes: Sequence[Baked], lamp: Lamp, kind: Callable[[int], Filter | None]) -> Iterator[Row]:
    """Of bakes of one unwrap, each by the `kind` that suits its number of cells."""
    for camera, seen, reference in views(bakes[0].surface, lamp):
        for baked in bakes:
            n = baked.layout.bucket
            ours = seen.resolve(seen.spread(lit(baked, seen, lamp, kind(n))))
            note = f"{n} x {n} cells, {baked.words[0, 0].nbytes} bytes a texel"
            yield Row(f"Shadow, {lamp.name}, {camera}, {n} cells", reference, ours, seen.eroded, note)


def agreement(bucket: int = 8) -> tuple[float, float, float]:
    """Shares of 10,000 rays that bits are right of: at cells' centres, anywhere, and at best anywhere.

    The last is what one bit a cell can do: the answer that most of many rays through the cell agree with.
    """
    scene()
    spec = BakeSpec(kind=Kind.SHADOW, texels=TEXELS, bucket=bucket)
    with tempfile.TemporaryDirectory() as folder:
        baked = bake(spec, Path(folder))
    plan, tree = plan_of_bake(SUBJECT, spec), all_meshes()
    rng = np.random.default_rng(7)
    texel = rng.integers(0, len(plan.texel), 10_000)
    q, p = rng.integers(0, bucket, (2, 10_000))
    cells = unpack_bits(baked.words, bucket).reshape(-1, bucket, bucket)[plan.texel]
    centre = _cell_directions(np.full((10_000, 2), 0.5), q, p, bucket)
    at_centres = float(np.mean(cells[texel, q, p] == blocked(tree, plan, texel, centre)))
    return at_centres, *_anywhere(baked, plan, tree, bucket, rng)


def _cell_directions(within: Floats, q: Ints, p: Ints, bucket: int) -> Floats:
    return square_to_direction((np.stack([p, q], axis=1) + within) / bucket * 2 - 1)


def _anywhere(
    baked: Baked, plan: CapturePlan, tree: Any, bucket: int, rng: np.random.Generator
) -> tuple[float, float]:
    """Of random cells, many directions each, even in the cell."""
    count, each = 500, 32
    texel = np.repeat(rng.integers(0, len(plan.texel), count), each)
    q, p = (np.repeat(axis, each) for axis in rng.integers(0, bucket, (2, count)))
    ways = _cell_directions(rng.random((count * each, 2)), q, p, bucket)
    truth = blocked(tree, plan, texel, ways)
    place = plan.texel[texel]
    uv = (np.stack([place % baked.layout.width, place // baked.layout.width], axis=1) + 0.5) / [
        baked.layout.width,
        baked.layout.height,
    ]
    ours = visibility(baked.words, baked.layout, uv, ways, Filter.NEAREST) < 0.5
    share = truth.reshape(count, each).mean(axis=1)
    return float(np.mean(ours == truth)), float(np.mean(np.maximum(share, 1 - share)))


def main() -> None:
    """Print what was measured."""
    for bucket in (8, 16):
        centres, random, best = agreement(bucket)
        print(
            f"{bucket} x {bucket} cells, {bucket * bucket // 8} bytes a texel: {centres:.2%} at centres, "
            f"{random:.1%} anywhere, {best:.1%} at best"
        )
    for row in rows():
        print(f"{row.name}: {row.psnr:.1f} dB, FLIP {row.flip:.3f}; {row.note}", flush=True)
    if "--all" in sys.argv:
        tried = (8, 16, 32)
        bakes = [_baked(bucket) for bucket in tried]
        for way, lamp in product((None, *Filter), LAMPS):
            for row in _rows_of(bakes, lamp, dict.fromkeys(tried, way).get):
                print(f"{way or 'blended'}: {row.name}: {row.psnr:.1f} dB", flush=True)


if __name__ == "__main__":
    main()
