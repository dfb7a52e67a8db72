# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kinds `shadow` and `ao`, held against rays cast without Cycles, and against walls of known height."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.core.errors import InputError
from radtex_addon.core.hemisphere import cell_centres, square_to_direction
from radtex_addon.core.shadow import unpack_bits
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.formats.shadow_files import read_shadow_of
from radtex_addon.job import BakeResult, bake_object, bake_steps
from radtex_addon.job.checks import check_request
from radtex_addon.settings.spec import BakeSpec
from tests.blender import stage
from tests.blender.casting import all_meshes, blocked, plan_of_bake
from tests.blender.fingerprint import differences, fingerprint

pytestmark = pytest.mark.usefixtures("temporary")
# Both look through the same scene.
KINDS = ["shadow", pytest.param("ao", marks=pytest.mark.one_blender)]
context: Any = bpy.context  # to the stubs, every pointer may be None

CELLS = 8


def floor(size: float = 4) -> Any:
    bpy.ops.mesh.primitive_plane_add(size=size)
    context.object.name = "Floor"
    return context.object


def roof(
    height: float = 0.5, size: float = 40, shader: str = "ShaderNodeBsdfDiffuse", **inputs: object
) -> Any:
    """A ceiling over all of the floor: everything but the horizon is blocked where it casts shadows."""
    bpy.ops.mesh.primitive_plane_add(size=40, location=(0, 0, height))
    context.object.data.materials.append(stage.material("Roof", shader, **inputs))
    return context.object


def bake(kind: str, out: Path, name: str = "Floor", **options: Any) -> BakeResult:
    spec = BakeSpec(kind=kind, **{"texels": 8, "bucket": CELLS, "samples": 4} | options)  # type: ignore[arg-type]
    return bake_object(context.scene, name, spec, out)


def bits(result: BakeResult) -> Bools:
    words, sidecar = read_shadow_of(result.files.sidecar)
    return unpack_bits(words, sidecar.bucket)


def ambient(result: BakeResult) -> tuple[Floats, Floats]:
    """Bent normals and values of all texels."""
    pixels, _ = read_buckets(result.files.sidecar)
    return pixels[..., :3].astype(float), pixels[..., 3].astype(float)


def share(kind: str, out: Path) -> float:
    """How much of the sky the floor's bake finds open."""
    result = bake(kind, out)
    return float(1 - bits(result).mean()) if kind == "shadow" else float(ambient(result)[1].mean())


# shadow


@pytest.mark.one_blender
def test_bits_agree_with_rays_that_blender_casts(out: Path) -> None:
    bpy.ops.mesh.primitive_monkey_add()
    context.object.name = "Suzanne"
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.4, location=(0.6, -1.2, 0.8))
    bpy.ops.mesh.primitive_plane_add(size=6, location=(0, 0, -1))
    spec = BakeSpec(kind="shadow", texels=64)  # type: ignore[arg-type]
    result = bake_object(context.scene, "Suzanne", spec, out)
    plan = plan_of_bake("Suzanne", spec)
    assert result.covered_texels == len(plan.texel)
    rng = np.random.default_rng(5)
    texel = rng.integers(0, len(plan.texel), 10_000)
    q, p = rng.integers(0, CELLS, (2, 10_000))
    centres = square_to_direction(cell_centres(CELLS))
    expected = blocked(all_meshes(), plan, texel, centres[q, p])
    cells = bits(result).reshape(-1, CELLS, CELLS)[plan.texel]
    agreement = float(np.mean(cells[texel, q, p] == expected))
    print(f"\n{agreement:.3%} of 10,000 cell centres agree; {expected.mean():.0%} are blocked")
    assert agreement >= 0.999
    assert 0.1 < expected.mean() < 0.9


@pytest.mark.one_blender
def test_a_texel_takes_as_many_bytes_as_it_has_words(out: Path) -> None:
    floor()
    for cells, count in ((4, 4), (8, 8), (16, 32)):
        result = bake("shadow", out / str(cells), bucket=cells)
        words, sidecar = read_shadow_of(result.files.sidecar)
        assert words[0, 0].nbytes == count
        assert (sidecar.kind, sidecar.bucket, sidecar.samples, sidecar.capture) == (
            "shadow",
            cells,
            1,
            "portal",
        )
        assert (words == 0).all()  # a flat floor, alone
        facts = json.loads(result.files.sidecar.read_text())
        assert facts["layout"] == "buckets"


@pytest.mark.one_blender
def test_gutters_hold_the_nearest_texels_bits(out: Path) -> None:
    """Two islands with room between them, one of them under a roof."""
    bpy.ops.mesh.primitive_cube_add(size=1)
    context.object.name = "Cube"
    roof(0.7)
    result = bake("shadow", out, "Cube", texels=48, padding=4)
    plan = plan_of_bake("Cube", BakeSpec(kind="shadow", texels=48, padding=4))  # type: ignore[arg-type]
    cells = bits(result)
    gutter = cells[~plan.covered].reshape(-1, CELLS * CELLS)
    known = {bytes(row) for row in cells[plan.covered].reshape(-1, CELLS * CELLS)}
    assert len(gutter) > 100
    assert {bytes(row) for row in gutter} <= known


@pytest.mark.one_blender
@pytest.mark.parametrize("kind", ["shadow", "ao"])
def test_what_is_stuck_into_the_mesh_darkens_nobody(out: Path, kind: str) -> None:
    """A ball on a post, whose texels in the ball nobody sees; the rest sees half of the sky and more."""
    bpy.ops.mesh.primitive_cylinder_add(radius=0.3, depth=2, location=(0, 0, -1))
    post = context.object
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.8)
    post.select_set(True)
    bpy.ops.object.join()
    context.object.name = "Ball"
    result = bake(kind, out, "Ball", texels=64, half=kind == "shadow")
    open_cells = 1 - bits(result).mean(axis=(2, 3)) if kind == "shadow" else ambient(result)[1]
    assert open_cells.min() > 0.2


@pytest.mark.parametrize(("alpha", "expected"), [(1.0, True), (0.9, True), (0.1, False), (0.0, False)])
def test_half_of_the_opacity_decides(out: Path, alpha: float, expected: bool) -> None:
    floor()
    roof(shader="ShaderNodeBsdfPrincipled", Alpha=alpha)
    up = bits(bake("shadow", out))[..., 2:6, 2:6]
    assert (up == expected).all()


@pytest.mark.parametrize("kind", KINDS)
def test_what_casts_no_shadow_is_not_in_the_way_and_what_is_only_hidden_is(out: Path, kind: str) -> None:
    floor()
    item = roof()

    dark = share(kind, out / "plain")
    assert dark < 0.2
    for name in ("visible_camera", "visible_diffuse", "visible_glossy"):
        setattr(item, name, False)
    assert share(kind, out / "hidden") == dark
    item.visible_camera = True
    item.is_holdout = True
    assert share(kind, out / "holdout") == dark
    item.is_holdout, item.is_shadow_catcher = False, True
    assert share(kind, out / "catcher") == dark
    item.is_shadow_catcher, item.visible_shadow = False, False
    assert share(kind, out / "casts none") == 1.0


@pytest.mark.parametrize("kind", KINDS)
def test_instances_follow_their_object_and_their_instancer(out: Path, kind: str) -> None:
    floor()
    item = roof()
    apart = bpy.data.collections.new("Apart")
    apart.objects.link(item)
    context.scene.collection.objects.unlink(item)
    instancer: Any = bpy.data.objects.new("Instancer", None)
    instancer.instance_type, instancer.instance_collection = "COLLECTION", apart
    context.scene.collection.objects.link(instancer)

    for owner in (item, instancer):
        owner.visible_camera = False
        assert share(kind, out / f"{owner.name} hidden") < 0.2
        owner.visible_camera, owner.visible_shadow = True, False
        assert share(kind, out / f"{owner.name} casts none") == 1.0
        owner.visible_shadow = True


@pytest.mark.parametrize("kind", KINDS)
def test_collections_that_camera_rays_pass_by_are_in_the_way(out: Path, kind: str) -> None:
    floor()
    item = roof()
    apart = bpy.data.collections.new("Apart")
    context.scene.collection.children.link(apart)
    apart.objects.link(item)
    context.scene.collection.objects.unlink(item)
    for flag in ("indirect_only", "holdout"):
        setattr(context.view_layer.layer_collection.children["Apart"], flag, True)
        assert share(kind, out / flag) < 0.2
        setattr(context.view_layer.layer_collection.children["Apart"], flag, False)


def test_lamps_worlds_and_volumes_of_the_world_block_nothing(out: Path) -> None:
    stage.lamps()
    made = stage.world()
    fog = made.node_tree.nodes.new("ShaderNodeVolumeScatter")
    output = next(node for node in made.node_tree.nodes if node.type == "OUTPUT_WORLD")
    made.node_tree.links.new(fog.outputs[0], output.inputs["Volume"])
    floor()
    assert not bits(bake("shadow", out)).any()
    np.testing.assert_array_equal(ambient(bake("ao", out))[1], 1)


@pytest.mark.one_blender
def test_what_a_smooth_normal_sends_below_its_facet_is_blocked(out: Path) -> None:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6)
    bpy.ops.object.shade_smooth()
    context.object.name = "Ball"
    spec = BakeSpec(kind="shadow", texels=32)  # type: ignore[arg-type]
    plan = plan_of_bake("Ball", spec)
    cells = bits(bake_object(context.scene, "Ball", spec, out)).reshape(-1, CELLS, CELLS)[plan.texel]
    local = square_to_direction(cell_centres(CELLS))
    frame = np.stack(
        [field.reshape(-1, 3)[: len(plan.texel)] for field in (plan.tangent, plan.bitangent, plan.normal)]
    )
    facet = plan.facet.reshape(-1, 3)[: len(plan.texel)].astype(float)
    height = np.einsum("qpa,akx,kx->kqp", local, frame, facet)
    sure = np.abs(height) > 2e-3  # a pixel's filter is a hundredth of it wide, and so is a cell's
    np.testing.assert_array_equal(cells[sure], height[sure] < 0)
    assert (height < 0).mean() > 0.02


def test_nothing_of_the_users_is_written_not_even_while_it_renders(out: Path) -> None:
    floor()
    item = roof()
    item.visible_shadow, item.is_holdout = False, True
    before, flags = fingerprint(), []

    def note(*_: object) -> None:
        flags.append((item.visible_shadow, item.visible_camera, item.is_holdout))

    def heard() -> None:  # handlers that were there before sleep during a bake
        for moment in ("render_pre", "render_post", "frame_change_post"):
            listeners = getattr(bpy.app.handlers, moment)
            if note not in listeners:
                listeners.append(note)

    bake("shadow", out)
    steps = bake_steps(context.scene, "Floor", BakeSpec(kind="ao", texels=8), out)  # type: ignore[arg-type]
    for step in steps:
        heard()
        if step.stage == "capture" and step.done:
            break
    steps.close()
    assert differences(before, fingerprint()) == {}
    assert len(flags) > 2
    assert set(flags) == {(False, True, True)}


@pytest.mark.one_blender
def test_the_same_bake_has_the_same_bits(out: Path) -> None:
    floor()
    roof(shader="ShaderNodeBsdfPrincipled", Alpha=0.5)
    for kind in ("shadow", "ao"):
        files = [
            bake(kind, out / str(run), memory_mb=memory).files.atlas for run, memory in enumerate((16, 1024))
        ]
        assert files[0].read_bytes() == files[1].read_bytes()


# ao


def test_the_open_is_one_and_the_buried_is_nothing(out: Path) -> None:
    floor()
    bent, value = ambient(bake("ao", out / "open"))
    np.testing.assert_array_equal(value, 1)
    np.testing.assert_allclose(bent, np.broadcast_to([0, 0, 1], bent.shape), atol=1e-3)
    bpy.ops.mesh.primitive_cube_add(size=10)
    bent, value = ambient(bake("ao", out / "buried"))
    np.testing.assert_array_equal(value, 0)
    np.testing.assert_array_equal(bent, np.broadcast_to([0, 0, 1], bent.shape))


@pytest.mark.one_blender
def test_a_long_wall_takes_its_known_share(out: Path) -> None:
    """Along a wall of height h, at the distance d, all of it aslant: 1 - (1 - d / sqrt(d² + h²)) / 2."""
    long, h = 400.0, 1.0
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=1, y_subdivisions=1, size=2)
    context.object.name = "Floor"
    context.object.location = (2.0, 0, 0)
    context.object.scale = (2, 0.5, 1)
    ground = context.object
    bpy.ops.mesh.primitive_plane_add(size=1, rotation=(0, np.pi / 2, 0), location=(0, 0, h / 2))
    context.object.scale = (h, long, 1)
    wall = context.object
    turn = bpy.data.objects.new("Turn", None)
    context.scene.collection.objects.link(turn)
    ground.parent = wall.parent = turn
    turn.rotation_euler = (np.radians(30), np.radians(30), 0)
    spec = BakeSpec(kind="ao", texels=64, bucket=8, samples=16, uv_layer="UVMap", half=False)  # type: ignore[arg-type]
    bent, value = ambient(bake_object(context.scene, "Floor", spec, out))
    for distance in (0.25, 0.5, 1.0, 2.0, 3.5):
        column = int(distance / 4 * 64)
        d = (column + 0.5) / 64 * 4
        expected = 1 - (1 - d / np.hypot(d, h)) / 2
        found = float(value[:, column].mean())
        off = found / expected - 1
        print(f"\nat {d:.3f} {found:.5f}, expected {expected:.5f}: {off:+.3%}")
        assert abs(off) < 0.01
        assert (bent[:, column, 0] > 0).all()  # away from the wall, along +x, which is along u
        np.testing.assert_allclose(bent[:, column, 1].mean(), 0, atol=0.01)


@pytest.mark.one_blender
@pytest.mark.parametrize("samples", [4, 5])
def test_what_is_farther_than_the_distance_counts_as_open(out: Path, samples: int) -> None:
    """Under a roof at height h, directions steeper than cos = h / D are blocked: (h / D)² is open."""
    floor(1)
    roof(0.5)
    for distance, expected in ((0.4, 1.0), (0.6, (0.5 / 0.6) ** 2), (1.0, 0.25), (3.0, (0.5 / 3) ** 2)):
        result = bake("ao", out / str(distance), samples=samples, ao_distance=distance, half=False)
        _, value = ambient(result)
        print(f"\nroof at 0.5, distance {distance}: {value.mean():.4f}, expected {expected:.4f}")
        assert value.mean() == pytest.approx(expected, abs=0.005)
        _, sidecar = read_buckets(result.files.sidecar)
        rays = CELLS * CELLS * {4: 4, 5: 9}[samples]
        assert (sidecar.ao_distance, sidecar.samples) == (distance, rays)
        assert result.paths == result.covered_texels * rays


@pytest.mark.one_blender
def test_a_high_wall_takes_the_known_share_of_what_is_near(out: Path) -> None:
    """At the distance d from it, rays with x above c = d / D: (acos(c) - c sqrt(1 - c²)) / pi."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=1, y_subdivisions=1, size=2)
    context.object.name = "Floor"
    context.object.location = (1.0, 0, 0)
    context.object.scale = (1, 0.5, 1)
    bpy.ops.mesh.primitive_plane_add(size=50, rotation=(0, np.pi / 2, 0))
    spec = BakeSpec(kind="ao", texels=64, samples=4, uv_layer="UVMap", half=False, ao_distance=1.0)  # type: ignore[arg-type]
    bent, value = ambient(bake_object(context.scene, "Floor", spec, out))
    for distance in (0.1, 0.25, 0.5, 0.75, 1.5):
        column = int(distance / 2 * 64)
        c = min((column + 0.5) / 64 * 2, 1.0)
        expected = 1 - (np.arccos(c) - c * np.sqrt(1 - c * c)) / np.pi
        found = float(value[:, column].mean())
        print(f"\nwall at {c:.3f}, distance 1: {found:.4f}, expected {expected:.4f}")
        assert abs(found / expected - 1) < 0.01
        assert (bent[:, column, 0] > 0.01).all() == (c < 1)


@pytest.mark.one_blender
def test_near_the_same_bake_has_the_same_bits_and_hidden_things_block(out: Path) -> None:
    floor()
    item = roof()
    item.visible_camera = False
    files = [
        bake("ao", out / str(memory), ao_distance=0.7, memory_mb=memory).files.atlas for memory in (16, 1024)
    ]
    assert files[0].read_bytes() == files[1].read_bytes()
    item.visible_camera, item.visible_shadow = True, False
    np.testing.assert_array_equal(ambient(bake("ao", out / "none", ao_distance=0.7))[1], 1)


def test_the_file_is_one_pixel_a_texel(out: Path) -> None:
    floor()
    result = bake("ao", out, samples=3)
    pixels, sidecar = read_buckets(result.files.sidecar)
    assert pixels.shape == (sidecar.height, sidecar.width, 4)
    assert pixels.dtype == np.float16
    assert (sidecar.kind, sidecar.bucket, sidecar.samples) == ("ao", 1, CELLS * CELLS * 3)
    assert result.layout.bucket == 1


# bad input


@pytest.mark.one_blender
@pytest.mark.parametrize(
    ("kind", "options", "said"),
    [
        ("shadow", {"half": False}, "shadow holds bits, not floats: leave"),
        ("shadow", {"compression": "dwaa"}, "dwaa is for light and spoils shadow: choose zip or piz"),
        ("ao", {"compression": "dwaa"}, "dwaa is for light and spoils ao"),
        ("ao", {"ao_distance": 0.0}, "ao distance 0: give one above 0"),
        ("ao", {"ao_distance": float("nan")}, "ao distance nan: give one above 0"),
        ("shadow", {"ao_distance": 1.0}, "shadow looks at any distance: bake ao, or leave the distance"),
        ("radiance", {"ao_distance": 1.0}, "radiance looks at any distance: bake ao"),
        ("shadow", {"layout": "layered"}, "the layered layout holds light, not shadow: choose layout"),
        ("ao", {"layout": "layered"}, "the layered layout holds light, not ao"),
        ("shadow", {"capture": "panoramic"}, "capture panoramic cannot bake shadow: capture by portal"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(kind: str, options: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        BakeSpec(kind=kind, **options)  # type: ignore[arg-type]


def test_a_shadow_sends_one_ray_a_cell_whatever_is_asked() -> None:
    assert BakeSpec(kind="shadow", samples=64).samples == 1  # type: ignore[arg-type]
    assert BakeSpec(kind="ao", samples=64).samples == 64  # type: ignore[arg-type]


def test_a_script_may_remove_an_object_and_bake_at_once_and_nobody_is_warned_of_darkness(out: Path) -> None:
    floor()
    item = roof()
    context.view_layer.update()
    bpy.data.objects.remove(item)
    assert not bits(bake("shadow", out)).any()
    for kind in ("shadow", "ao"):
        spec = BakeSpec(kind=kind)  # type: ignore[arg-type]
        assert check_request(context.scene, "Floor", spec, out / kind, False, False) == []
