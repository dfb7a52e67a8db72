# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Several objects in one atlas, and one object in several: every surface finds its own light."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.formats.sidecar import Part, read_sidecar
from radtex_addon.job import bake_object, part_specs
from radtex_addon.job.split_parts import may_lack_parts
from radtex_addon.settings.parts import tile_name, tile_place
from radtex_addon.settings.spec import BakeSpec, Kind, Split
from tests.blender import stage
from tests.blender.batch_process import Batch
from tests.blender.fingerprint import differences, fingerprint

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

QUICK = BakeSpec(texels=48, bucket=2, samples=1, half=False)
RED, GREEN, BLUE = (1.0, 0.25, 0.25), (0.25, 1.0, 0.25), (0.25, 0.25, 1.0)
ROOM = {"Left": RED, "Middle": GREEN, "Right": BLUE}


def glow(name: str, colour: tuple[float, float, float]) -> bpy.types.Material:
    return stage.material(name, "ShaderNodeEmission", Color=(*colour, 1))


def cube(name: str, material: bpy.types.Material, x: float) -> Any:
    bpy.ops.mesh.primitive_cube_add(size=1, location=(x, 0, 0), rotation=(0.1, x, 0.3))
    made = context.object
    made.name = name
    made.data.materials.append(material)
    return made


def room() -> None:
    """Three cubes that glow in a colour each and touch, the middle one mirrored and stretched."""
    for index, (name, colour) in enumerate(ROOM.items()):
        cube(name, glow(name, colour), index - 1)
    context.scene.objects["Middle"].scale = (-1.5, 1, 0.5)


def triangles_in(preview: Path, name: str) -> tuple[Any, Any]:
    """UVs (F, 3, 2) of the baked copy in a preview, and the name of the material that each triangle wears."""
    bpy.ops.wm.open_mainfile(filepath=str(preview))
    item: Any = bpy.data.objects[name]
    uv = np.empty(len(item.data.loops) * 2, dtype=np.float32)
    item.data.uv_layers.active.data.foreach_get("uv", uv)
    worn = [item.material_slots[polygon.material_index].material.name for polygon in item.data.polygons]
    return uv.reshape(-1, 3, 2), worn


def light_at(sidecar: Path, uv: Any) -> Any:
    """What the texels at the middles of triangles show, (F, 3)."""
    pixels, facts = read_buckets(sidecar)
    middle = uv.mean(axis=1) * [facts.width, facts.height]
    column, row = np.floor(middle).astype(int).T
    return pixels[row * facts.bucket, column * facts.bucket, :3]


def test_objects_share_an_atlas_and_each_finds_its_light(out: Path) -> None:
    room()
    before = fingerprint()
    spec = replace(QUICK, objects=tuple(ROOM))
    made = bake_object(context.scene, "Room", spec, out, preview=Filter.NEAREST)
    assert differences(before, fingerprint()) == {}
    assert sorted(path.name for path in out.iterdir()) == [
        "Room.preview.blend",
        "Room.radiance.exr",
        "Room.radiance.json",
    ]
    facts = read_sidecar(made.files.sidecar)
    assert (facts.object_name, facts.objects, facts.surfaces) == ("Room", tuple(ROOM), tuple(ROOM))
    assert made.files.preview is not None
    shown = {name: triangles_in(made.files.preview, name) for name in ROOM}
    for name, colour in ROOM.items():
        uv, worn = shown[name]
        np.testing.assert_allclose(light_at(made.files.sidecar, uv), [colour] * 12, atol=1e-5)
        assert set(worn) == {"RadTex Room"}
    corners = np.concatenate([uv for uv, _ in shown.values()]).reshape(-1, 2)
    assert len(np.unique(corners.round(5), axis=0)) >= 3 * 8  # nobody lies on another's texels


def test_objects_share_an_atlas_on_a_layer_of_their_own(out: Path) -> None:
    room()
    for index, name in enumerate(ROOM):
        layer = context.scene.objects[name].data.uv_layers[0]
        for each in layer.uv:
            each.vector.x = (index + 0.98 * each.vector.x) / 3
    spec = replace(QUICK, objects=tuple(ROOM), uv_layer="UVMap", texels=30)
    made = bake_object(context.scene, "Room", spec, out, preview=Filter.NEAREST)
    assert made.files.preview is not None
    for name, colour in ROOM.items():
        uv, _ = triangles_in(made.files.preview, name)
        np.testing.assert_allclose(light_at(made.files.sidecar, uv), [colour] * 12, atol=1e-5)


def test_layers_that_lie_on_one_another_are_refused_by_name(out: Path) -> None:
    room()
    spec = replace(QUICK, objects=tuple(ROOM), uv_layer="UVMap")
    with pytest.raises(InputError, match="'UVMap' of objects 'Left', 'Middle', 'Right' together overlaps"):
        bake_object(context.scene, "Room", spec, out)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"objects": ("Left",)}, "object 'Left' is alone: name others to share its atlas"),
        ({"objects": ("A", "B"), "kind": Kind.PROXY}, "a proxy is not baked for several objects"),
        ({"objects": ("A", "B"), "source": "High"}, "is not baked for several objects in one atlas"),
        ({"split": "udim"}, r"UDIM tiles are a UV layer's: name the layer"),
        ({"split": "faces"}, "there is no way to split 'faces': choose from material, udim"),
        ({"part": "Steel"}, "part 'Steel' is for an object that is split: split it by material or udim"),
    ],
)
def test_what_does_not_fit_is_refused(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        BakeSpec(**fields)


def two_coloured() -> Any:
    """A cube whose upper half glows red, its lower half green; UVs in two tiles, 1001 and 1012."""
    made = cube("Cube", glow("Hot", RED), 0)
    made.data.materials.append(glow("Cold / wet", GREEN))
    for polygon in made.data.polygons:
        polygon.material_index = int(polygon.index >= 3)
        for loop in polygon.loop_indices:
            place = made.data.uv_layers[0].uv[loop].vector
            place.x, place.y = (0.98 * value + 0.01 for value in place)
            if polygon.index >= 3:
                place.x, place.y = place.x + 1, place.y + 1
    return made


def test_each_material_has_an_atlas_and_one_preview_shows_all(out: Path) -> None:
    two_coloured()
    spec = replace(QUICK, split=Split.MATERIAL)
    with pytest.raises(InputError, match="'Cube' has an atlas for each material"):
        bake_object(context.scene, "Cube", spec, out)
    parts = part_specs(context.scene, "Cube", spec)
    assert [each.part for each in parts] == ["Hot", "Cold / wet"]
    before = fingerprint()
    first = bake_object(context.scene, "Cube", parts[0], out, preview=Filter.NEAREST)
    assert first.files.preview == out / "Cube.material.preview.blend"
    shutil.copy(first.files.preview, out.parent / "alone.blend")
    second = bake_object(context.scene, "Cube", parts[1], out, preview=Filter.NEAREST)
    assert differences(before, fingerprint()) == {}
    assert read_sidecar(second.files.sidecar).part == Part("material", "Cold / wet", 1)
    assert first.files.sidecar == out / "Cube.Hot.radiance.json"
    uv, worn = triangles_in(first.files.preview, "Cube")
    assert worn == ["RadTex Cube Hot"] * 6 + ["RadTex Cube Cold / wet"] * 6
    np.testing.assert_allclose(light_at(first.files.sidecar, uv[:6]), [RED] * 6, atol=1e-5)
    np.testing.assert_allclose(light_at(second.files.sidecar, uv[6:]), [GREEN] * 6, atol=1e-5)
    _, worn = triangles_in(out.parent / "alone.blend", "Cube")
    assert worn == ["RadTex Cube Hot"] * 6 + ["Cold / wet"] * 6, "the others as they are"


def test_a_part_that_is_not_there_is_named(out: Path) -> None:
    two_coloured()
    with pytest.raises(InputError, match="'Cube' has no material 'Warm' in renders: it has 'Hot', 'Cold / w"):
        bake_object(context.scene, "Cube", replace(QUICK, split=Split.MATERIAL, part="Warm"), out)


def test_a_guess_misses_parts_of_empty_slots_geometry_nodes_and_tiles(empty_file: None) -> None:
    spec = replace(QUICK, split=Split.MATERIAL)

    def may_lack(spec: BakeSpec = spec) -> bool:
        return may_lack_parts(context.scene, ["Cube"], spec)

    made = cube("Cube", glow("Hot", RED), 0)
    assert not may_lack()
    assert not may_lack(QUICK), "nothing is split"
    assert not may_lack(replace(spec, part="Hot")), "the part is named"
    assert may_lack(replace(spec, split=Split.UDIM, uv_layer="UVMap"))
    made.data.materials.append(None)
    assert may_lack(), "a slot is empty"
    made.data.materials.clear()
    assert may_lack(), "there are no slots"
    made.data.materials.append(glow("Cold", BLUE))
    made.modifiers.new("Paint", "NODES")
    assert may_lack(), "nodes may set materials"


def test_each_tile_has_an_atlas_of_its_own(out: Path) -> None:
    two_coloured()
    spec = replace(QUICK, split=Split.UDIM, uv_layer="UVMap", texels=24)
    parts = part_specs(context.scene, "Cube", spec)
    assert [each.part for each in parts] == ["1001", "1012"]
    made = [bake_object(context.scene, "Cube", part, out, preview=Filter.NEAREST) for part in parts]
    assert sorted(path.name for path in out.iterdir()) == [
        "Cube.1001.radiance.exr",
        "Cube.1001.radiance.json",
        "Cube.1012.radiance.exr",
        "Cube.1012.radiance.json",
        "Cube.udim.preview.blend",
    ]
    assert made[1].files.preview is not None
    uv, worn = triangles_in(made[1].files.preview, "Cube")
    assert worn == ["RadTex Cube 1001"] * 6 + ["RadTex Cube 1012"] * 6
    assert uv.min() >= 0  # readers know nothing of tiles
    assert uv.max() <= 1
    np.testing.assert_allclose(light_at(made[0].files.sidecar, uv[:6]), [RED] * 6, atol=1e-5)
    np.testing.assert_allclose(light_at(made[1].files.sidecar, uv[6:]), [GREEN] * 6, atol=1e-5)


def test_a_face_across_tiles_is_refused(out: Path) -> None:
    made = two_coloured()
    made.data.uv_layers[0].uv[0].vector.x += 1
    with pytest.raises(InputError, match="'UVMap' of object 'Cube' has 2 triangles across the border"):
        part_specs(context.scene, "Cube", replace(QUICK, split=Split.UDIM, uv_layer="UVMap"))


@pytest.mark.parametrize(("column", "row", "name"), [(0, 0, "1001"), (9, 0, "1010"), (1, 1, "1012")])
def test_tiles_are_numbered_as_udim_has_it(column: int, row: int, name: str) -> None:
    assert tile_name(column, row) == name
    assert tile_place(name) == (column, row)


@pytest.mark.one_blender
def test_the_batch_bakes_together_and_in_parts(tmp_path: Path, out: Path, batch: Batch) -> None:
    room()
    two_coloured()
    scene = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(scene))
    quick = ["--layout=buckets", "--texels=32", "--bucket=2", "--samples=1", f"--out={out}"]
    several = [*(f"--object={name}" for name in ROOM), "--together=Room", *quick]
    assert batch(scene, *several).code == 0
    parts = ["--object=Cube", "--split=material", "--save-preview", *quick]
    assert batch(scene, *parts).code == 0
    again = batch(scene, *parts, "--resume")
    assert again.code == 0, again.err
    refused = batch(scene, "--object=Left", "--together=Room", *quick)
    assert refused.code == 2
    assert "object 'Left' is alone" in refused.err
    assert sorted(path.name for path in out.glob("*.*e*")) == [
        "Cube.Cold _ wet-69571a04.radiance.exr",
        "Cube.Cold _ wet-69571a04.radiance.json",
        "Cube.Hot.radiance.exr",
        "Cube.Hot.radiance.json",
        "Cube.material.preview.blend",
        "Room.radiance.exr",
        "Room.radiance.json",
    ]


@pytest.mark.one_blender
def test_walls_around_an_object_hide_nothing_of_it(out: Path) -> None:
    cube("Box", glow("Box", GREEN), 0)
    shell = cube("Shell", glow("Shell", BLUE), 0)
    shell.scale = (4, 4, 4)  # whose walls face away from the box
    spec = replace(QUICK, objects=("Box", "Shell"))
    made = bake_object(context.scene, "Room", spec, out, preview=Filter.NEAREST)
    assert made.files.preview is not None
    uv, _ = triangles_in(made.files.preview, "Box")
    np.testing.assert_allclose(light_at(made.files.sidecar, uv), [GREEN] * 12, atol=1e-5)


@pytest.mark.one_blender
def test_rays_start_as_near_to_a_small_object_as_if_it_were_alone(out: Path) -> None:
    for name, colour, z in (("Lower", RED, 0.0), ("Upper", GREEN, 0.004)):
        bpy.ops.mesh.primitive_plane_add(size=1, location=(0, 0, z))
        context.object.name = name
        context.object.data.materials.append(glow(name, colour))
    cube("Far", glow("Far", BLUE), 30)
    spec = replace(QUICK, objects=("Lower", "Upper", "Far"))
    made = bake_object(context.scene, "Room", spec, out, preview=Filter.NEAREST)
    assert made.files.preview is not None
    shown = {name: triangles_in(made.files.preview, name)[0] for name in ("Lower", "Upper")}
    for name, colour in (("Lower", RED), ("Upper", GREEN)):
        np.testing.assert_allclose(light_at(made.files.sidecar, shown[name]), [colour] * 2, atol=1e-5)


@pytest.mark.one_blender
def test_more_samples_go_to_the_same_objects_alone(out: Path) -> None:
    for index, (name, colour) in enumerate(ROOM.items()):
        made = cube(name, glow(name, colour), 2 * index)
        made.rotation_euler = (0, 0, 0)
    bake_object(context.scene, "Room", replace(QUICK, objects=("Left", "Middle")), out)
    other = replace(QUICK, objects=("Middle", "Left"), accumulate=True)
    with pytest.raises(InputError, match="is of other objects, or names them in another order"):
        bake_object(context.scene, "Room", other, out)
