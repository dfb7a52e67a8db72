# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light whose value is known, or that a plain Cycles camera knows, through the captures that ship; sheets."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest
from mathutils import Vector

from radtex_addon.bake.plan import CapturePlan, Tile, plan_capture
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import InputError
from radtex_addon.core.hemisphere import cell_centres, mirror_direction, square_to_direction
from radtex_addon.core.texel_map import TexelMap
from radtex_addon.cycles.panoramic import PanoramicCapture
from radtex_addon.cycles.portal import PortalCapture
from radtex_addon.formats.containers.exr import read_render
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import Kind
from tests.blender import stage
from tests.blender.same_light import same_light

RUNS = 8


@contextmanager
def scratch() -> Iterator[bpy.types.Scene]:
    scene = cast(bpy.types.Scene, bpy.context.scene)
    with scratch_scene(scene, scene.view_layers[0].name) as copy:
        yield copy


def measure(
    capture: type, plan: CapturePlan, kind: Kind, samples: int, folder: Path, runs: int = RUNS
) -> Floats:
    """Cells of all texels, several times with different seeds: (runs, K, n, n, 4)."""
    found = []
    for seed in range(runs):
        with scratch() as scene:
            taken = capture(scene, plan, kind, samples, 1 + seed * 1000, folder)
            found.append(taken.render(Tile(0, plan.rows)))
    return np.stack(found).astype(np.float64)


def random_texels(count: int, seed: int = 4) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(seed)
    n = rng.normal(size=(count, 3))
    return rng.uniform(-0.9, 0.9, (count, 3)), n / np.linalg.norm(n, axis=1, keepdims=True)


def test_a_furnace_bakes_to_its_albedo_on_a_quad(tmp_path: Path) -> None:
    stage.world()
    bpy.ops.mesh.primitive_plane_add(size=2)
    bpy.context.object.data.materials.append(
        stage.material("d", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1))
    )
    position = np.random.default_rng(1).uniform(-0.9, 0.9, (16, 3)) * [1, 1, 0]
    plan = stage.plan_of(position, np.tile([0.0, 0, 1], (16, 1)), 8)
    cells = measure(PortalCapture, plan, Kind.RADIANCE, 512, tmp_path, runs=1)[0, ..., :3]
    print(f"\nfurnace, quad: mean {cells.mean():.5f}, cells {cells.min():.4f} to {cells.max():.4f}")
    assert abs(cells.mean() - 0.8) < 2e-4
    np.testing.assert_allclose(cells, 0.8, atol=0.02)


def furnace_sphere(segments: int = 256) -> Floats:
    """A smooth sphere in a white world; returns points on its facets."""
    stage.world()
    bpy.ops.mesh.primitive_uv_sphere_add(segments=segments, ring_count=segments // 2)
    bpy.ops.object.shade_smooth()
    sphere = bpy.context.object
    sphere.data.materials.append(stage.material("d", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1)))
    polygons = sphere.data.polygons
    pick = np.random.default_rng(2).choice(len(polygons), 24, replace=False)
    return np.array([polygons[int(k)].center for k in pick])


@pytest.mark.one_blender
def test_a_furnace_bakes_to_its_albedo_on_a_fine_sphere(tmp_path: Path) -> None:
    position = furnace_sphere()
    normal = position / np.linalg.norm(position, axis=1, keepdims=True)
    plan = stage.plan_of(position, normal, 8)
    cells = measure(PortalCapture, plan, Kind.RADIANCE, 512, tmp_path, runs=1)[0, ..., :3]
    print(f"\nfurnace, sphere: mean {cells.mean():.5f}, cells {cells.min():.4f} to {cells.max():.4f}")
    assert abs(cells.mean() - 0.8) < 2e-3
    np.testing.assert_allclose(cells, 0.8, atol=0.02)


def directional_world() -> Callable[[Floats], Floats]:
    """A world that is a polynomial of direction, and the same function in numpy."""
    made = stage.world()
    cast(Any, made).cycles.sampling_method = "NONE"  # nothing is lit by it, and a map of its light takes long
    tree = made.node_tree
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    square = tree.nodes.new("ShaderNodeVectorMath")
    square.operation = "MULTIPLY"
    lift = tree.nodes.new("ShaderNodeVectorMath")
    lift.operation = "MULTIPLY_ADD"
    lift.inputs[1].default_value, lift.inputs[2].default_value = (0.3, 0.3, 0.3), (0.5, 0.5, 0.5)
    total = tree.nodes.new("ShaderNodeVectorMath")
    tree.links.new(coordinates.outputs["Generated"], square.inputs[0])
    tree.links.new(coordinates.outputs["Generated"], square.inputs[1])
    tree.links.new(coordinates.outputs["Generated"], lift.inputs[0])
    tree.links.new(lift.outputs[0], total.inputs[0])
    tree.links.new(square.outputs[0], total.inputs[1])
    background = next(n for n in tree.nodes if n.type == "BACKGROUND")
    tree.links.new(total.outputs[0], background.inputs["Color"])
    return lambda direction: 0.5 + 0.3 * direction + direction**2


@pytest.mark.one_blender
@pytest.mark.parametrize(("kind", "sign"), [(Kind.INCIDENT, 1), (Kind.REFLECTION, -1)])
def test_a_world_of_known_light_bakes_to_its_cell_means(tmp_path: Path, kind: Kind, sign: int) -> None:
    light = directional_world()
    position, normal = random_texels(3)
    plan = stage.plan_of(position, normal, 4, tangent=np.roll(normal, 1, axis=1), sign=sign)
    fine = 64
    local = square_to_direction(cell_centres(4 * fine))
    if kind is Kind.REFLECTION:
        local = mirror_direction(local)
    frame = np.stack([plan.tangent[0], plan.bitangent[0], plan.normal[0]], axis=1).astype(float)
    value = light(np.einsum("qpa,kab->kqpb", local, frame))
    expected = value.reshape(3, 4, fine, 4, fine, 3).mean(axis=(2, 4))
    for capture, samples, bound in ((PortalCapture, 4096, 1e-3), (PanoramicCapture, 16384, 2e-3)):
        cells = measure(capture, plan, kind, samples, tmp_path, runs=1)[0]
        error = np.abs(cells[..., :3] - expected).max()
        print(f"\n{capture.__name__}, {kind}: largest error of a cell mean {error:.5f}")
        assert error < bound
        np.testing.assert_allclose(cells[..., 3], 1, atol=1e-6)


def mirror_floor() -> CapturePlan:
    bpy.ops.mesh.primitive_plane_add(size=2)
    bpy.context.object.data.materials.append(
        stage.material("mirror", "ShaderNodeBsdfAnisotropic", Color=(1, 1, 1, 1), Roughness=0.0)
    )
    position = np.random.default_rng(3).uniform(-0.9, 0.9, (16, 3)) * [1, 1, 0]
    return stage.plan_of(position, np.tile([0.0, 0, 1], (16, 1)), 8, tangent=np.tile([0.6, 0.8, 0], (16, 1)))


@pytest.mark.one_blender
def test_a_perfect_mirrors_radiance_is_its_reflection(tmp_path: Path) -> None:
    stage.hdri(stage.world())
    stage.lamps()
    stage.clamps_off()
    plan = mirror_floor()
    seen, arriving = (
        measure(PortalCapture, plan, kind, 64, tmp_path) for kind in (Kind.RADIANCE, Kind.REFLECTION)
    )
    assert arriving[..., :3].max() > 10, "the lamps are not in the picture"
    colours = [a[..., :3].reshape(RUNS, -1) for a in (seen, arriving)]
    same_light("mirror: radiance, reflection", colours[0], colours[1])


@pytest.mark.one_blender
def test_portal_and_panoramic_agree(tmp_path: Path) -> None:
    stage.hdri(stage.world())
    stage.lamps()
    stage.clamps_off()
    bpy.ops.mesh.primitive_ico_sphere_add(radius=0.4, location=(0.2, 1.6, 0.8))
    position, normal = random_texels(24)
    plan = stage.plan_of(position, normal, 4, tangent=np.roll(normal, 1, axis=1), sign=-1)
    runs = 4
    portal, panoramic = (
        measure(capture, plan, Kind.INCIDENT, 1024, tmp_path, runs)[..., :3].mean(axis=-1)
        for capture in (PortalCapture, PanoramicCapture)
    )
    # At 1024 spp a cell is 36 disc pixels wide: one that straddles cells mixes them by half a pixel.
    exact = contrast(portal.mean(axis=0)).ravel() * 0.5 / 36 + 2e-4
    same_light("portal, panoramic", portal.reshape(runs, -1), panoramic.reshape(runs, -1), exact=exact)


def contrast(cells: Floats) -> Floats:
    """Range of values among each cell's neighbours in its bucket: (K, n, n) both."""
    n = cells.shape[1]
    around = np.pad(cells, ((0, 0), (1, 1), (1, 1)), mode="edge")
    shifted = np.stack([around[:, y : y + n, x : x + n] for y in range(3) for x in range(3)])
    return shifted.max(axis=0) - shifted.min(axis=0)


@pytest.mark.one_blender
def test_the_panoramic_capture_cannot_look_at_its_own_surface(tmp_path: Path) -> None:
    plan = stage.plan_of(np.zeros((1, 3)), np.array([[0.0, 0, 1]]), 4)
    with scratch() as scene, pytest.raises(InputError, match="bake radiance by portal"):
        PanoramicCapture(scene, plan, Kind.RADIANCE, 1, 0, tmp_path)


def crowded_scene() -> None:
    """Diffuse, metal and glass, an object unseen by the camera, a lamp, and a wall that knows camera rays."""
    shaders = [
        stage.material("diffuse", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.2, 0.2, 1)),
        stage.material("metal", "ShaderNodeBsdfAnisotropic", Color=(0.9, 0.7, 0.3, 1), Roughness=0.3),
        stage.material("glass", "ShaderNodeBsdfGlass", Roughness=0.2, IOR=1.4),
        stage.material("unseen", "ShaderNodeBsdfDiffuse", Color=(0.2, 0.8, 0.2, 1)),
    ]
    for index, shader in enumerate(shaders):
        bpy.ops.mesh.primitive_uv_sphere_add(location=(index * 1.2 - 1.8, 0, 0), radius=0.6)
        bpy.ops.object.shade_smooth()
        bpy.context.object.data.materials.append(shader)
    bpy.context.object.visible_camera = False
    bpy.ops.mesh.primitive_plane_add(size=3, location=(0, 1.5, 0), rotation=(np.pi / 2, 0, 0))
    wall = stage.material("wall", "ShaderNodeEmission")
    path = wall.node_tree.nodes.new("ShaderNodeLightPath")
    emission = next(n for n in wall.node_tree.nodes if n.type == "EMISSION")
    wall.node_tree.links.new(path.outputs["Is Camera Ray"], emission.inputs["Color"])
    bpy.context.object.data.materials.append(wall)
    bpy.ops.object.light_add(type="AREA", location=(0, -1, 2.5))
    bpy.context.object.data.energy = 40


def point_camera(pixels: int) -> bpy.types.Object:
    """A perspective camera somewhere, that samples its pixels at their centres."""
    place = Vector(np.random.default_rng(11).uniform((-1.5, -4.5, 0.3), (1.5, -3.5, 1.2)).tolist())
    data = bpy.data.cameras.new("plain")
    camera = bpy.data.objects.new("plain", data)
    camera.location = place
    camera.rotation_euler = (-place).to_track_quat("-Z", "Y").to_euler()
    data.lens, data.clip_start = 40, 1e-3
    scene = bpy.context.scene
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = pixels
    bpy.context.view_layer.update()
    return camera


def plain_picture(samples: int, seed: int, folder: Path) -> Floats:
    """What F12 gives, (pixels, pixels, 4), row 0 at the bottom."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.samples, cycles.seed = samples, seed
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.pixel_filter_type, cycles.filter_width = "GAUSSIAN", 0.01
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_depth, image.color_mode = "OPEN_EXR", "32", "RGBA"
    scene.view_settings.view_transform = "Raw"
    scene.render.filepath = str(folder / "plain.exr")
    bpy.ops.render.render(write_still=True)
    return next(iter(read_render(folder / "plain.exr").values())).astype(np.float64)


def camera_rays(camera: bpy.types.Object, pixels: int, shift: tuple[float, float] = (0, 0)) -> Floats:
    """Unit directions through the pixels' centres, `shift` pixels away: (pixels, pixels, 3), row 0 below."""
    corners = [camera.matrix_world @ v for v in camera.data.view_frame(scene=bpy.context.scene)]
    _, bottom_right, bottom_left, top_left = (np.array(corner) for corner in corners)
    x, y = np.meshgrid(*((np.arange(pixels) + 0.5 + by) / pixels for by in shift))
    target = (
        bottom_left + x[..., None] * (bottom_right - bottom_left) + y[..., None] * (top_left - bottom_left)
    )
    ray = target - np.array(camera.matrix_world.translation)
    unit: Floats = ray / np.linalg.norm(ray, axis=-1, keepdims=True)
    return unit


def camera_plan(camera: bpy.types.Object, pixels: int) -> CapturePlan:
    """A texel for every pixel of the camera: without T and Bt every cell looks along N, the camera's ray."""
    ray = camera_rays(camera, pixels)
    # The capture starts a little before P: here that is where the camera's own rays start, to a micrometre.
    position = (np.array(camera.matrix_world.translation) + 1e-3 * ray).astype(np.float32)
    normal = (-ray).astype(np.float32)
    none = np.zeros_like(normal)
    layout = AtlasLayout(pixels, pixels, 2)
    return CapturePlan(layout, np.arange(pixels**2), position, none, none, normal, normal)


def on_one_facet(camera: bpy.types.Object, pixels: int) -> Bools:
    """Pixels whose centre is well inside a facet: (pixels * pixels). At edges float32 decides what is hit."""
    scene, graph = bpy.context.scene, bpy.context.evaluated_depsgraph_get()

    def facets(shift: tuple[float, float]) -> list[tuple[object, int]]:
        rays = camera_rays(camera, pixels, shift).reshape(-1, 3)
        hits = (scene.ray_cast(graph, camera.matrix_world.translation, Vector(ray.tolist())) for ray in rays)
        return [(hit[4] and hit[4].name, hit[3]) for hit in hits]

    centre = facets((0, 0))
    around = [facets(shift) for shift in ((0.02, 0.02), (-0.02, 0.02), (0.02, -0.02), (-0.02, -0.02))]
    return np.array([all(other[k] == centre[k] for other in around) for k in range(len(centre))])


@pytest.mark.parametrize(
    "case",
    [
        "plain",
        pytest.param("transparent film", marks=pytest.mark.one_blender),
        pytest.param("world volume", marks=pytest.mark.one_blender),
    ],
)
def test_the_portal_is_a_plain_camera(tmp_path: Path, case: str) -> None:
    pixels = 24
    made = stage.world((0.3, 0.4, 0.6))
    if case == "world volume":
        scatter = made.node_tree.nodes.new("ShaderNodeVolumeScatter")
        scatter.inputs["Density"].default_value = 0.05
        output = next(n for n in made.node_tree.nodes if n.type == "OUTPUT_WORLD")
        made.node_tree.links.new(scatter.outputs[0], output.inputs["Volume"])
    crowded_scene()
    stage.clamps_off()
    bpy.context.scene.render.film_transparent = case == "transparent film"
    camera = point_camera(pixels)
    samples = 32
    plain = np.stack([plain_picture(4 * samples, 50 + seed, tmp_path) for seed in range(RUNS)])
    cells = measure(PortalCapture, camera_plan(camera, pixels), Kind.RADIANCE, samples, tmp_path)
    portal = cells.mean(axis=(2, 3)).reshape(plain.shape)
    inside = on_one_facet(camera, pixels)
    assert inside.mean() > 0.9
    colours = [a[..., :3].mean(axis=-1).reshape(RUNS, -1)[:, inside] for a in (plain, portal)]
    alphas = [a[..., 3].reshape(RUNS, -1)[:, inside] for a in (plain, portal)]
    same_light(f"camera, portal, {case}: colour", colours[0], colours[1])
    same_light(f"camera, portal, {case}: alpha", alphas[0], alphas[1])
    if case == "transparent film":
        assert portal[..., 3].min() < 0.01
        assert portal[..., 3].max() > 0.99


@pytest.mark.parametrize(("bucket", "count"), [(2, 1), (2, 5), (3, 7), (3, 2)])
def test_a_handful_of_texels_renders_too(tmp_path: Path, bucket: int, count: int) -> None:
    """Blender renders nothing smaller than 4 pixels a side, and a tile may be lower still."""
    stage.world((0.5, 0.5, 0.5))
    up = np.tile(np.array([0, 0, 1], np.float32), (1, count, 1))
    none = np.zeros_like(up)
    sign, triangle, inside = np.ones((1, count), np.float32), np.zeros((1, count), np.int32), up[..., 2] > 0
    surface = TexelMap(none, up, none, sign, up, triangle, inside)
    plan = plan_capture(surface, bucket)
    for capture in (PortalCapture, PanoramicCapture):
        with scratch() as scene:
            taken = capture(scene, plan, Kind.INCIDENT, 4, 1, tmp_path)
            cells = np.concatenate([taken.render(Tile(row, 1)) for row in range(plan.rows)])
        assert cells.shape == (count, bucket, bucket, 4)
        if capture is PortalCapture:
            np.testing.assert_allclose(cells[..., :3], 0.5, atol=1e-3)


SIDE = 12  # buckets along the packed image


@pytest.fixture
def plan() -> CapturePlan:
    """Points on a glossy ball over a floor, five sheets of three rows."""
    stage.world()
    bpy.ops.mesh.primitive_uv_sphere_add()
    glossy = stage.material("glossy", "ShaderNodeBsdfAnisotropic", Roughness=0.3)
    bpy.context.object.data.materials.append(glossy)
    bpy.ops.mesh.primitive_plane_add(size=9, location=(0, 0, -1))
    normal = np.random.default_rng(3).normal(size=(SIDE * SIDE - 5, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    row = stage.plan_of(normal, normal, 4)

    def folded(field: Floats) -> Floats:
        padded = field.reshape(-1, 3)[np.minimum(np.arange(SIDE * SIDE), len(normal) - 1)]
        return padded.reshape(SIDE, SIDE, 3)

    fields: Any = {name: folded(getattr(row, name)) for name in _FIELDS}
    return replace(row, sheet=24, **fields)


_FIELDS = ("position", "tangent", "bitangent", "normal", "facet")


@pytest.mark.parametrize("kind", [Kind.RADIANCE, Kind.INCIDENT])
def test_a_sheet_has_the_same_bits_whichever_came_before(
    plan: CapturePlan, kind: Kind, tmp_path: Path
) -> None:
    assert (plan.sheet_rows, plan.sheets) == (3, 4)
    scene = cast(bpy.types.Scene, bpy.context.scene)
    layer = scene.view_layers[0].name
    with scratch_scene(scene, layer) as scratch:
        capture = PortalCapture(scratch, plan, kind, 2, 5, tmp_path)
        whole = capture.render(Tile(0, plan.rows))
        upwards = [capture.render(Tile(row, 1)) for row in reversed(range(plan.rows))]
    assert np.array_equal(np.concatenate(upwards[::-1]), whole)
    with scratch_scene(scene, layer) as scratch:
        alone = PortalCapture(scratch, plan, kind, 2, 5, tmp_path).render(Tile(6, 3))
    assert np.array_equal(alone, whole[6 * SIDE : 9 * SIDE])


@pytest.mark.one_blender
def test_sheets_have_noise_of_their_own(plan: CapturePlan, tmp_path: Path) -> None:
    """Two sheets of the same point differ; with one seed for all they would repeat it."""
    still = {name: np.broadcast_to(getattr(plan, name)[:1, :1], (SIDE, SIDE, 3)) for name in _FIELDS}
    alike: Any = {name: np.ascontiguousarray(field) for name, field in still.items()}
    same = replace(plan, **alike)
    scene = cast(bpy.types.Scene, bpy.context.scene)
    with scratch_scene(scene, scene.view_layers[0].name) as scratch:
        capture = PortalCapture(scratch, same, Kind.RADIANCE, 2, 5, tmp_path)
        first, second = (capture.render(Tile(row, 3)) for row in (0, 3))
    assert not np.array_equal(first, second)
    np.testing.assert_allclose(first.mean(), second.mean(), rtol=0.05)
