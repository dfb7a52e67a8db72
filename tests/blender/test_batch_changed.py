# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The batch bakes collections, and only what has changed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.cli.arguments import parse
from radtex_addon.cli.prepare_arguments import parse_prepare
from radtex_addon.core.errors import InputError
from radtex_addon.store.checkpoint import announce
from tests.blender import stage
from tests.blender.batch_process import QUICK, Batch, refusal

pytestmark = [pytest.mark.one_blender, pytest.mark.usefixtures("temporary")]
context: Any = bpy.context  # to the stubs, every pointer may be None


@pytest.fixture
def blend(tmp_path: Path) -> Path:
    """A collection with a ball, a cutter that does not render, and a collection with a cup in it; a table."""
    stage.world()
    homes: dict[str, Any] = {name: bpy.data.collections.new(name) for name in ("Things", "Small", "Empty")}
    context.scene.collection.children.link(homes["Things"])
    context.scene.collection.children.link(homes["Empty"])
    homes["Things"].children.link(homes["Small"])
    kept_in = {"Table": None, "Cup": "Small", "Ball": "Things", "Cutter": "Things"}
    for number, (name, home) in enumerate(kept_in.items()):
        bpy.ops.mesh.primitive_plane_add(location=(3 * number, 0, 0))
        item = context.object
        item.name, item.hide_render = name, name == "Cutter"
        item.data.materials.append(stage.material(f"of {name}", "ShaderNodeBsdfDiffuse"))
        if home is not None:
            context.scene.collection.objects.unlink(item)
            homes[home].objects.link(item)
    return saved(tmp_path / "room.blend")


def saved(path: Path) -> Path:
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def notes(err: str) -> list[str]:
    prefix = "radtex: note: "
    return [line.removeprefix(prefix) for line in err.splitlines() if line.startswith(prefix)]


def test_objects_of_a_collection_can_share_an_atlas(blend: Path, out: Path, batch: Batch) -> None:
    sizes = ["--layout=buckets", "--texels=16", "--bucket=2", "--samples=1", "--progress=none"]
    words = ["--collection=Small", "--object=Table", "--together=All", "--changed", *sizes, "--out", out]
    said = []
    for _ in range(2):
        ended = batch(blend, *words)
        assert ended.code == 0, ended.err
        said.append(notes(ended.err)[0])
    bpy.data.objects["Cup"].location.y = 1
    saved(blend)
    said.append(notes(batch(blend, *words).err)[0])
    assert said == ["All: not baked yet, baking", "All: unchanged", "All: moved, baking again"]


def test_what_cannot_be_baked_of_a_collection_is_left_out_with_a_line_and_what_is_named_refused(
    blend: Path, out: Path, batch: Batch
) -> None:
    things, small = bpy.data.collections["Things"], bpy.data.collections["Small"]
    for name in ("Empty Mesh", "Empty Too"):
        things.objects.link(bpy.data.objects.new(name, bpy.data.meshes.new(name)))
    bpy.data.objects["Ball"].scale.y = 0
    bpy.ops.curve.primitive_bezier_circle_add()
    things.objects.link(context.object)
    bpy.ops.object.light_add()
    small.objects.link(context.object)
    context.view_layer.layer_collection.children["Empty"].exclude = True
    bpy.ops.mesh.primitive_plane_add()
    excluded = context.object
    excluded.name = "Excluded"
    bpy.data.collections["Empty"].objects.link(excluded)
    context.scene.collection.objects.unlink(excluded)
    ended = batch(saved(blend), "--collection=Scene Collection", *QUICK, "--out", out)
    assert ended.code == 0, ended.err
    assert sorted(path.name for path in out.glob("*.json")) == ["Cup.radiance.json", "Table.radiance.json"]
    lines = [line for line in ended.err.splitlines() if "left out" in line]
    told = {item.name: sum(f"'{item.name}'" in line for line in lines) for item in bpy.data.objects}
    assert told == {name: name not in ("Cup", "Table") for name in told}, ended.err
    for words in (
        "'Cutter' is hidden from render: enable it in renders",
        "'BézierCircle' has no faces in renders: give it some, or name another; likewise 'Empty Mesh'",
        "'Ball' is scaled to nothing along an axis",
        "include its collection 'Empty'",
        "as they have no surface: 'Point'",
    ):
        assert sum(words in line for line in lines) == 1, (words, lines)
    before = contents(out)
    named = batch(blend, "--object=Cutter", "--collection=Small", *QUICK, "--out", out, "--overwrite")
    assert (named.code, "object 'Cutter' is hidden from render" in named.err) == (2, True)
    bpy.data.objects["Cup"].visible_camera = False
    none = batch(saved(blend), "--collection=Small", *QUICK, "--out", out, "--overwrite")
    assert "'Cup' would be see-through" in refusal(none)
    assert contents(out) == before


@pytest.mark.parametrize(
    ("name", "said"),
    [
        (
            "Thing",
            "no collection 'Thing' in scene 'Scene': it has 'Scene Collection', 'Things', 'Small', 'Empty'",
        ),
        ("Empty", "those that have some are 'Scene Collection', 'Things', 'Small'"),
    ],
)
def test_a_collection_without_meshes_is_refused_and_others_named(
    blend: Path, out: Path, batch: Batch, name: str, said: str
) -> None:
    assert said in refusal(batch(blend, "--collection", name, *QUICK, "--out", out))


def test_only_what_has_changed_is_baked(blend: Path, out: Path, batch: Batch) -> None:
    """With --ignore-surroundings; else the neighbours of what has changed are baked again, too."""
    words = ["--collection=Scene Collection", "--changed", "--ignore-surroundings", *QUICK, "--out", out]
    first = batch(blend, *words)
    assert first.code == 0, first.err
    assert notes(first.err) == [f"{name}: not baked yet, baking" for name in ("Ball", "Cup", "Table")]
    whole = contents(out)
    again = batch(blend, *words)
    assert (again.code, notes(again.err)) == (
        0,
        [
            *(f"{name}: unchanged" for name in ("Ball", "Cup", "Table")),
            "all 3 bakes are unchanged: nothing is left to do",
        ],
    )
    assert contents(out) == whole
    one = batch(blend, "--object=Ball", "--changed", "--ignore-surroundings", *QUICK, "--out", out)
    assert notes(one.err) == ["Ball: unchanged", "the bake is unchanged: nothing is left to do"]
    table: Any = bpy.data.materials["of Table"]
    table.node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (1, 0, 0, 1)
    bpy.data.objects["Table"].location.z -= 1
    saved(blend)
    announce(out / "Cup.radiance.radtex-unfinished", [])
    ended = batch(blend, *words)
    assert ended.code == 0, ended.err
    assert notes(ended.err) == [
        "Ball: unchanged",
        "Cup: unfinished, baking again",
        "Table: moved, materials changed, baking again",
    ]
    made = contents(out)
    assert made["Table.radiance.exr"] != whole["Table.radiance.exr"]
    assert all(made[f"Ball.radiance.{kind}"] == whole[f"Ball.radiance.{kind}"] for kind in ("exr", "json"))
    words.remove("--ignore-surroundings")
    assert notes(batch(blend, *words).err)[0] == "Ball: surroundings changed, baking again"


def contents(out: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in out.iterdir()}


def test_what_is_unchanged_and_lacks_a_preview_gets_one(blend: Path, out: Path, batch: Batch) -> None:
    words = ["--object=Table", "--frames=1,2", *QUICK, "--out", out]
    assert batch(blend, *words).code == 0
    whole = contents(out)
    ended = batch(blend, *words, "--changed", "--save-preview")
    assert ended.code == 0, ended.err
    lacks = "unchanged, but lacks its preview or an export, which is made"
    assert notes(ended.err) == [f"Table, frame 1: {lacks}", f"Table, frame 2: {lacks}"]
    made = contents(out)
    assert made.keys() - whole.keys() == {"Table-0001.preview.blend", "Table-0002.preview.blend"}
    assert whole.items() <= made.items()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--changed", "--overwrite"], "--overwrite everything: give one of them"),
        (["--changed", "--resume"], "go on with them by --resume first"),
        (["--changed", "--accumulate"], "--accumulate adds to what is there"),
        (["--changed", "--passes=2"], "--passes adds to what is there"),
        (["--ignore-surroundings"], "give --changed too"),
    ],
)
def test_what_does_not_go_with_changed_is_refused(words: list[str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        parse(["room.blend", "--object=Cup", "--layout=buckets", *words], inside_blender=False)


def test_the_demo_has_no_collections_and_a_farm_takes_them() -> None:
    with pytest.raises(InputError, match="leave --collection out"):
        parse(["demo", "--collection=Things"], inside_blender=False)
    asked = parse_prepare(["room.blend", "--collection=Things"], inside_blender=False)
    assert (asked.collections, asked.bakes.objects) == (("Things",), ())
