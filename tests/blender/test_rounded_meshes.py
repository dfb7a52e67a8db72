# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that Blender makes otherwise each time, by rounding or in another order: they have not changed.

`python -m tests.bench.evaluations` tries every modifier in processes of their own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.progress import Stage
from radtex_addon.core.errors import InputError
from radtex_addon.core.near_digest import NearDigest
from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object, bake_steps
from radtex_addon.job.bake_fingerprint import read_now
from radtex_addon.job.changed_bakes import BakeState, Changes, changes
from radtex_addon.prepare.unwrapping import Unwraps
from radtex_addon.scene.digests import differing, looks_of, scene_digests
from radtex_addon.scene.geometry_digests import mesh_digest
from radtex_addon.scene.mesh.evaluated import evaluate
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.worker.handover import hand_over
from tests.blender import stage
from tests.blender.modifier_stacks import add_stack
from tests.blender.test_job import pixels_of

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

NAMES = ("bevel", "float boolean and bevel", "bevel and realized")
BOXES = ("Box", "Other")
SPEC = BakeSpec(texels=16, bucket=2, samples=1)
UNCHANGED = Changes(BakeState.UNCHANGED)
MESH = Changes(BakeState.CHANGED, ("mesh",))
SEEN = Changes(BakeState.CHANGED, ("surroundings",))


@pytest.fixture
def stacks() -> None:
    """Three objects that Blender makes otherwise from one time to another."""
    for number, name in enumerate(NAMES):
        add_stack(name, (4 * number, 0, 0))


@pytest.fixture
def boxes() -> None:
    """Two bevelled boxes, whose UVs `shake` changes by a bit or two: by themselves so few seldom differ."""
    stage.world()
    tree: Any = bpy.data.node_groups.new("Shaken", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    begin, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    hand = bpy.data.objects.new("Hand", None)
    context.scene.collection.objects.link(hand)
    hand.hide_render = True
    info, named = tree.nodes.new("GeometryNodeObjectInfo"), tree.nodes.new("GeometryNodeInputNamedAttribute")
    added, stored = tree.nodes.new("ShaderNodeVectorMath"), tree.nodes.new("GeometryNodeStoreNamedAttribute")
    info.inputs["Object"].default_value = hand
    named.data_type = stored.data_type = "FLOAT_VECTOR"
    stored.data_type, stored.domain = "FLOAT2", "CORNER"
    named.inputs["Name"].default_value = stored.inputs["Name"].default_value = "UVMap"
    tree.links.new(next(each for each in named.outputs if each.enabled), added.inputs[0])
    tree.links.new(info.outputs["Location"], added.inputs[1])
    tree.links.new(begin.outputs[0], stored.inputs["Geometry"])
    tree.links.new(
        added.outputs[0], next(each for each in stored.inputs if each.name == "Value" and each.enabled)
    )
    tree.links.new(stored.outputs[0], end.inputs[0])
    for number, name in enumerate(BOXES):
        add_stack("bevelled cube", (4 * number, 0, 0)).name = name
        item(name).modifiers.new("Shaken", "NODES").node_group = tree


def shake() -> None:
    """Another evaluation, as Blender may make it: UVs differ by up to 1.2e-7."""
    hand = item("Hand")
    hand.location.x = 1.2e-7 if hand.location.x == 0 else 0


def item(name: str) -> Any:
    return context.scene.objects[name]


def seen() -> tuple[dict[str, NearDigest], NearDigest]:
    """Digests of the meshes as they are baked, and of all objects, as a key has them."""
    with scratch_scene(context.scene) as scratch:
        found = {name: mesh_digest(evaluate(scratch, scratch.objects[name])) for name in NAMES}
        return found, NearDigest.parse(scene_digests(scratch)["objects"])


def rounder(name: str = "bevel") -> None:
    item(name).modifiers[0].profile = 0.6


def a_vertex() -> None:
    item("bevel").data.vertices[7].co.x += 1e-5


def a_uv() -> None:
    item("bevel").data.uv_layers[0].uv[7].vector.x += 1e-4


def another_layer() -> None:
    layers = item("bevel").data.uv_layers
    layers.new(name="Other").active_render = True
    layers.active = layers["Other"]


def one_more() -> None:
    item("bevel").modifiers.new("weld", "WELD").merge_threshold = 0.3


def a_cutter() -> None:
    cutter = item("float boolean and bevel").modifiers[0].object
    cutter.location.x += 1e-3


def a_shape_of_a_cutter() -> None:
    for vertex in item("float boolean and bevel").modifiers[0].object.data.vertices:
        vertex.co *= 1.001


def a_node() -> None:
    tree = item("bevel and realized").modifiers[1].node_group
    cube = next(node for node in tree.nodes if node.bl_idname == "GeometryNodeMeshCube")
    cube.inputs[0].default_value[0] = 0.06


CHANGES: dict[Callable[[], None], str] = {
    **dict.fromkeys((rounder, a_vertex, a_uv, another_layer, one_more), "bevel"),
    **dict.fromkeys((a_cutter, a_shape_of_a_cutter), "float boolean and bevel"),
    a_node: "bevel and realized",
}


@pytest.mark.usefixtures("stacks")
def test_meshes_that_differ_by_rounding_are_like_and_what_a_user_changes_is_not() -> None:
    first, all_of_it = seen()
    exact = {name: {digest.exact} for name, digest in first.items()}
    for _ in range(4):
        again, everything = seen()
        for name, digest in again.items():
            exact[name].add(digest.exact)
            assert digest.is_like(first[name]), name
        assert everything.is_like(all_of_it)
    assert len(exact["bevel"]) > 1  # else Blender no longer does that, and this test shows nothing
    for change, changed in CHANGES.items():
        change()
        now, everything = seen()
        assert [name for name in NAMES if not now[name].is_like(first[name])] == [changed], change
        assert not everything.is_like(all_of_it), change
        first, all_of_it = now, everything


@pytest.mark.one_blender
@pytest.mark.usefixtures("boxes")
def test_a_bake_is_unchanged_until_a_user_changes_something(out: Path) -> None:
    """Also its unwrap is found again, a later preview fits it, and more samples are added to it."""
    unwraps: Unwraps = {}
    for overwrite in (False, True):
        for name in BOXES:
            bake_object(context.scene, name, SPEC, out, unwraps=unwraps, overwrite=overwrite)
            shake()
    assert len(unwraps) == 2
    for _ in range(3):
        shake()
        assert [changes(context.scene, name, SPEC, out) for name in BOXES] == [UNCHANGED] * 2
    made = bake_object(context.scene, "Box", SPEC, out, preview=Filter.NEAREST, resume=True)
    assert made.was_finished
    bake_object(context.scene, "Box", replace(SPEC, accumulate=True), out)
    shake()
    assert changes(context.scene, "Box", SPEC, out) == UNCHANGED
    rounder("Other")
    assert changes(context.scene, "Other", SPEC, out) == MESH
    assert changes(context.scene, "Box", SPEC, out) != UNCHANGED


def begun(out: Path, spec: BakeSpec) -> None:
    """Bake until the first render is kept, and drop it there."""
    steps = bake_steps(context.scene, "Box", spec, out)
    for step in steps:
        if step.stage is Stage.CAPTURE and step.done:
            steps.close()
            return


@pytest.mark.one_blender
@pytest.mark.usefixtures("boxes")
@pytest.mark.parametrize("source", [None, "Other"])
def test_an_unfinished_bake_keeps_the_meshes_that_it_began_with(source: str | None, out: Path) -> None:
    spec = replace(SPEC, source=source, extrusion=9.0 if source else None)
    item("Other").location = item("Box").location if source else (4, 0, 0)
    whole = bake_object(context.scene, "Box", spec, out / "whole")
    begun(out, spec)
    (folder,) = out.glob("*.radtex-unfinished")
    kept = {path.name for path in folder.glob("mesh-*")}
    assert kept == ({"mesh-0.piece", "mesh-source.piece"} if source else {"mesh-0.piece"})
    shake()
    made = bake_object(context.scene, "Box", spec, out, resume=True)
    np.testing.assert_array_equal(pixels_of(made), pixels_of(whole))
    assert changes(context.scene, "Box", spec, out) == UNCHANGED


@pytest.mark.one_blender
@pytest.mark.usefixtures("boxes")
def test_an_unfinished_bake_of_what_was_changed_since_is_refused(out: Path) -> None:
    begun(out, SPEC)
    for name, words in (("Other", "objects"), ("Box", "mesh")):
        rounder(name)
        with pytest.raises(InputError, match=f"differs in {words}: bake as before"):
            bake_object(context.scene, "Box", SPEC, out, resume=True)


@pytest.mark.one_blender
@pytest.mark.usefixtures("boxes")
def test_a_farm_finds_nothing_that_moves(out: Path) -> None:
    with scratch_scene(context.scene) as scratch:
        first = looks_of(scratch)
        for _ in range(2):
            shake()
            assert differing(first, looks_of(scratch)) == []
    rounder("Other")
    with scratch_scene(context.scene) as scratch:
        assert differing(first, looks_of(scratch)) == ["Other"]


@pytest.mark.usefixtures("stacks")
def test_names_how_modifiers_are_shown_and_a_workers_copy_are_no_change(tmp_path: Path) -> None:
    before = made_of()
    bevel = item("bevel").modifiers[0]
    bevel.name, bevel.show_expanded, bevel.show_viewport = "other", False, False
    item("float boolean and bevel").modifiers[0].object.name = "renamed"
    tree = item("bevel and realized").modifiers[1].node_group
    tree.name, tree.nodes[0].location.x = "renamed", 500
    assert made_of() == before
    assert all(before.values())
    bpy.ops.wm.open_mainfile(filepath=str(hand_over(context.scene, tmp_path / "jobs").blend))
    assert made_of() == before


def made_of() -> dict[str, str]:
    found = read_now(context.scene).objects
    return {each.of: each.mesh.of for each in found if not each.is_instance}
