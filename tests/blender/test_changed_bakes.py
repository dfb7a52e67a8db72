# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is told of bakes whose scene has changed since."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.sampler import Filter
from radtex_addon.formats.fingerprint import Fingerprint
from radtex_addon.job import bake_object
from radtex_addon.job.changed_bakes import BakeState, Changes, SceneReader, changes
from radtex_addon.preview.swap import switch_off, switch_on
from radtex_addon.settings.spec import BakeSpec, Kind, View
from radtex_addon.worker.handover import hand_over
from tests.blender import stage
from tests.blender.batch_process import process
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.test_job import pixels_of

pytestmark = [pytest.mark.one_blender, pytest.mark.usefixtures("temporary")]
context: Any = bpy.context  # to the stubs, every pointer may be None

SPEC = BakeSpec(texels=8, bucket=2, samples=1, uv_layer="UVMap")
NAMES = ("Ball", "Cup", "Table")
UNCHANGED = Changes(BakeState.UNCHANGED)
SEEN = Changes(BakeState.CHANGED, ("surroundings",))


def changed(*parts: str) -> Changes:
    return Changes(BakeState.CHANGED, parts)


@pytest.fixture
def scene(out: Path) -> Any:
    """Three baked objects with materials of their own, and a lamp; the ball has a modifier, an image file."""
    stage.world((0.2, 0.2, 0.2))
    for number, name in enumerate(NAMES):
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=2, y_subdivisions=2, location=(3 * number, 0, 0))
        context.object.name = name
        context.object.data.materials.append(stage.material(f"of {name}", "ShaderNodeBsdfDiffuse"))
    ball = item("Ball")
    ball.modifiers.new("wave", "DISPLACE").strength = 0.2
    picture = bpy.data.images.new("picture", 4, 4)
    picture.filepath_raw, picture.file_format = str(out.parent / "picture.png"), "PNG"
    picture.save()
    shown = bpy.data.images.load(picture.filepath_raw)
    tree = ball.data.materials[0].node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = shown
    tree.links.new(texture.outputs[0], tree.nodes["Diffuse BSDF"].inputs["Color"])
    bpy.ops.object.light_add(type="POINT", location=(0, 0, 4))
    context.object.name = "Lamp"
    for name in NAMES:
        bake_object(context.scene, name, SPEC, out)
    return context.scene


def item(name: str) -> Any:
    return context.scene.objects[name]


def diffuse(name: str) -> Any:
    return item(name).data.materials[0].node_tree.nodes["Diffuse BSDF"]


def told(out: Path, spec: BakeSpec = SPEC, **options: Any) -> tuple[Changes, ...]:
    reader = SceneReader(context.scene)
    return tuple(changes(context.scene, name, spec, out, reader=reader, **options) for name in NAMES)


def a_vertex() -> None:
    item("Cup").data.vertices[0].co.z += 1e-4


def a_smooth_face() -> None:
    item("Cup").data.polygons[0].use_smooth = True


def a_uv() -> None:
    item("Cup").data.uv_layers[0].uv[0].vector.x += 0.25


def a_modifier() -> None:
    item("Ball").modifiers["wave"].strength = 0.3


def a_colour() -> None:
    diffuse("Cup").inputs["Color"].default_value = (1, 0, 0, 1)


def a_place() -> None:
    item("Cup").location.y += 0.5


def a_colour_within_a_group() -> None:
    group: Any = bpy.data.node_groups.new("within", "ShaderNodeTree")
    group.nodes.new("ShaderNodeRGB")
    diffuse("Cup").id_data.nodes.new("ShaderNodeGroup").node_tree = group


def an_image_on_the_disk() -> None:
    (Path(bpy.data.images["picture.png"].filepath).parent / "picture.png").write_bytes(b"edited")


def a_lamp() -> None:
    item("Lamp").data.energy += 1


def the_world() -> None:
    nodes = context.scene.world.node_tree.nodes
    next(node for node in nodes if node.type == "BACKGROUND").inputs["Strength"].default_value = 2


def bounces() -> None:
    context.scene.cycles.max_bounces = 1


OF_CUP = {
    a_vertex: "mesh",
    a_smooth_face: "mesh",
    a_uv: "mesh",
    a_place: "moved",
    a_colour: "materials",
    a_colour_within_a_group: "materials",
}
OF_BALL = {a_modifier: "mesh", an_image_on_the_disk: "materials"}


@pytest.mark.usefixtures("scene")
def test_an_object_s_own_bake_and_its_neighbours_surroundings_have_changed(out: Path) -> None:
    assert told(out) == (UNCHANGED, UNCHANGED, UNCHANGED)
    bpy.ops.ed.undo_push(message="as it was baked")
    for change, part in (OF_CUP | OF_BALL).items():
        change()
        own, by_itself = changed(part), told(out, surroundings=False)
        if change in OF_CUP:
            assert told(out) == (SEEN, own, SEEN), change
            assert by_itself == (UNCHANGED, own, UNCHANGED), change
        else:
            assert told(out) == (own, SEEN, SEEN), change
            assert by_itself == (own, UNCHANGED, UNCHANGED), change
        take_back()


def take_back() -> None:
    """What has changed since the last step to undo."""
    bpy.ops.ed.undo_push(message="changed")
    bpy.ops.ed.undo()


@pytest.mark.usefixtures("scene")
def test_light_is_of_the_surroundings(out: Path) -> None:
    bpy.ops.ed.undo_push(message="as it was baked")
    for change in (a_lamp, the_world):
        change()
        assert told(out) == (SEEN, SEEN, SEEN), change
        assert told(out, surroundings=False) == (UNCHANGED, UNCHANGED, UNCHANGED), change
        take_back()


@pytest.mark.usefixtures("scene")
def test_settings_are_the_specification_and_how_light_travels(out: Path) -> None:
    assert told(out, replace(SPEC, samples=2)) == (changed("settings"),) * 3
    assert told(out, replace(SPEC, memory_mb=3000, device="cpu")) == (UNCHANGED,) * 3
    bounces()
    assert told(out) == (changed("settings"),) * 3


@pytest.mark.usefixtures("scene")
def test_what_no_render_shows_is_no_change(out: Path) -> None:
    cup = item("Cup")
    cup.data.name, cup.data.materials[0].name = "renamed", "renamed"
    cup.data.materials[0].diffuse_color = (1, 0, 0, 1)
    diffuse("Cup").location.x += 100
    item("Table").name = "Desk"
    bpy.ops.object.empty_add(location=(5, 5, 5))
    bpy.ops.object.camera_add()
    cup.select_set(True)
    assert changes(context.scene, "Cup", SPEC, out) == UNCHANGED


def test_a_saved_file_and_a_workers_copy_are_unchanged(scene: Any, out: Path, tmp_path: Path) -> None:
    """Also the values of animated properties, which the file holds as they last were."""
    colour = diffuse("Table").inputs["Color"]
    for frame, value in ((1, 0.1), (20, 0.9)):
        colour.default_value = (value, value, value, 1)
        colour.keyframe_insert("default_value", frame=frame)
    item("Table").keyframe_insert("location", frame=1)
    item("Table").location.z = 2
    item("Table").keyframe_insert("location", frame=20)
    scene.frame_set(7)
    framed = replace(SPEC, frame=3)
    for name in NAMES:
        bake_object(scene, name, SPEC, out, overwrite=True)
        bake_object(scene, name, framed, out)
    assert told(out) == (UNCHANGED,) * 3
    assert [changes(scene, name, framed, out) for name in NAMES] == [UNCHANGED] * 3
    moved = changed("moved", "materials")
    scene.frame_set(8)
    assert told(out) == (SEEN, SEEN, moved)
    scene.frame_set(7)
    blend = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend), relative_remap=True)
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    assert told(out) == (UNCHANGED,) * 3
    handed = hand_over(context.scene, tmp_path / "jobs")
    words = [f"--object={name}" for name in NAMES]
    words += ["--uv=UVMap", "--layout=buckets", "--texels=8", "--bucket=2", "--samples=1", "--no-denoise"]
    ended = process(handed.blend, *words, "--out", out / "other", "--progress=none")
    assert ended.code == 0, ended.err
    for name in NAMES:
        assert note(out / "other" / f"{name}.radiance.json") == note(out / f"{name}.radiance.json")


def note(sidecar: Path) -> Any:
    return json.loads(sidecar.read_text())["fingerprint"]


@pytest.mark.usefixtures("scene")
def test_linked_duplicates_change_together(out: Path) -> None:
    twin = item("Cup").copy()
    context.scene.collection.objects.link(twin)
    twin.name, twin.location.x = "Twin", -3
    spec = SPEC
    for name in ("Cup", "Twin"):
        bake_object(context.scene, name, spec, out, overwrite=True)
    a_vertex()
    both = changed("mesh", "surroundings")
    assert changes(context.scene, "Cup", spec, out) == both
    assert changes(context.scene, "Twin", spec, out) == both


def test_states_besides_changed(scene: Any, out: Path) -> None:
    assert changes(scene, "Cup", replace(SPEC, frame=5), out).state is BakeState.MISSING
    for sidecar in out.glob("Cup.*json"):
        sidecar.write_text(sidecar.read_text().replace('"fingerprint"', '"noted"'))
    (out / "Ball.radiance.exr").unlink()
    table = out / "Table.radiance.json"
    table.write_text(table.read_text().replace(bpy.app.version_string, "3.6.1"))
    a_vertex()
    ball, cup, other = told(out)
    assert (ball.state, cup.state, other.state) == (BakeState.MISSING, BakeState.UNKNOWN, BakeState.UNKNOWN)
    assert str(cup) == "may have changed: it was baked by a RadTex that did not note what it is of"
    assert str(other) == "may have changed: it was baked by Blender 3.6.1"
    assert str(changed("mesh", "moved", "materials", "settings")) == (
        "moved, mesh, materials and settings changed"
    )


@pytest.mark.usefixtures("scene")
def test_what_is_added_to_an_atlas_leaves_unknown_what_differed(out: Path) -> None:
    more = replace(SPEC, accumulate=True)
    bake_object(context.scene, "Cup", more, out)
    assert changes(context.scene, "Cup", SPEC, out) == UNCHANGED
    a_colour()
    bake_object(context.scene, "Cup", more, out)
    assert changes(context.scene, "Cup", SPEC, out) == changed("materials")
    bake_object(context.scene, "Cup", replace(SPEC, refresh=True), out)
    assert changes(context.scene, "Cup", SPEC, out) == UNCHANGED


def test_only_lamps_that_light_a_bake_count(scene: Any, out: Path) -> None:
    bpy.ops.object.light_add(type="POINT", location=(0, 4, 4))
    context.object.name = "Other"
    by = {name: replace(SPEC, lights=(name,)) for name in ("Lamp", "Other", "world")}
    for spec in by.values():
        bake_object(scene, "Cup", spec, out)
    a_lamp()
    assert [changes(scene, "Cup", spec, out) for spec in by.values()] == [SEEN, UNCHANGED, UNCHANGED]


def test_shown_bakes_count_as_their_objects_and_nothing_is_left(scene: Any, out: Path) -> None:
    bake_object(scene, "Cup", SPEC, out, preview=Filter.NEAREST, overwrite=True)
    switch_on(item("Cup"), out / "Cup.radiance.json")
    before = fingerprint()
    assert told(out) == (UNCHANGED,) * 3
    assert differences(before, fingerprint()) == {}
    switch_off(item("Cup"))
    assert told(out) == (UNCHANGED,) * 3


def test_a_bake_sees_the_objects_whose_bakes_are_shown_as_its_fingerprint_says(out: Path) -> None:
    """A lamp's bake has red light; the lamp itself is green by now, and lights the floor."""
    for name, height, shader in (("Floor", 0, "ShaderNodeBsdfDiffuse"), ("Panel", 1, "ShaderNodeEmission")):
        bpy.ops.mesh.primitive_plane_add(size=2, location=(0, 0, height))
        context.object.name = name
        context.object.data.materials.append(stage.material(name, shader))
    stage.world((0, 0, 0))
    glow = item("Panel").data.materials[0].node_tree.nodes["Emission"].inputs["Color"]
    glow.default_value = (1, 0, 0, 1)
    bake_object(context.scene, "Panel", SPEC, out, preview=Filter.NEAREST)
    glow.default_value = (0, 1, 0, 1)
    alone = pixels_of(bake_object(context.scene, "Floor", SPEC, out))
    switch_on(item("Panel"), out / "Panel.radiance.json")
    before = fingerprint()
    beside = pixels_of(bake_object(context.scene, "Floor", SPEC, out, overwrite=True))
    assert differences(before, fingerprint()) == {}
    np.testing.assert_array_equal(beside, alone)
    assert beside[..., 1].mean() > 0.1
    assert beside[..., 0].max() == 0
    assert changes(context.scene, "Floor", SPEC, out) == UNCHANGED
    switch_off(item("Panel"))
    assert changes(context.scene, "Floor", SPEC, out) == UNCHANGED


@pytest.mark.usefixtures("scene")
def test_a_source_is_the_objects_own_and_a_camera_counts_where_it_looks() -> None:
    bpy.ops.object.camera_add(location=(0, -5, 2))
    context.scene.camera = context.object
    onto = replace(SPEC, source="Ball")
    seen = BakeSpec(kind=Kind.TRANSFER, view=View.CAMERA)
    before = noted(onto), noted(seen), noted(SPEC)
    item("Camera").location.x = 1
    after = noted(onto), noted(seen), noted(SPEC)
    assert [old.differences(new) for old, new in zip(before, after, strict=True)] == [
        (),
        ("surroundings",),
        (),
    ]
    item("Ball").location.z = 1
    moved = noted(onto), noted(seen), noted(SPEC)
    assert [old.differences(new) for old, new in zip(after, moved, strict=True)] == [
        ("transform",),
        ("surroundings",),
        ("surroundings",),
    ]


def noted(spec: BakeSpec) -> Fingerprint:
    """The fingerprint of the cup's bake, if it was baked now."""
    return SceneReader(context.scene).at(None).of_bake("Cup", spec, context.view_layer)
