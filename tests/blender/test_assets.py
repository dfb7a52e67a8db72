# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that touch become one asset where that is asked for, with a name of its own and texels for all."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import bmesh
import bpy
import pytest

from radtex_addon.cli.arguments import parse
from radtex_addon.cli.prepare_arguments import parse_prepare
from radtex_addon.job.assets import Asset, asset_requests, find_assets, read_shown, spec_of_asset
from radtex_addon.job.layout_choice import OpenLayout
from radtex_addon.settings.spec import BakeSpec, Kind, Layout, Split, Unwrap
from radtex_addon.settings.texel_density import side_for_several
from radtex_addon.store.checkpoint import announce
from radtex_addon.store.output_files import OutputFiles
from tests.blender import stage
from tests.blender.batch_process import Batch

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

LAMP = ("Foot", "Shade")
ALL = ("Ball", "Floor", *LAMP)
QUICK = ["--texels=16", "--samples=1", "--unwrap=blender"]


@pytest.fixture
def blend(tmp_path: Path) -> Path:
    """A lamp of two parts and a ball on a floor; the lamp's parts are in a collection of their own."""
    stage.world()
    gloss = stage.material("Gloss", "ShaderNodeBsdfPrincipled", Roughness=0.3)
    home = bpy.data.collections.new("Lamp")
    context.scene.collection.children.link(home)
    bpy.ops.mesh.primitive_plane_add(size=6)
    context.object.name = "Floor"
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.3, location=(2, 0, 0.29))
    context.object.name = "Ball"
    for name, size, z in (("Foot", 0.5, 0.25), ("Shade", 0.6, 0.8)):
        bpy.ops.mesh.primitive_cube_add(size=size, location=(0, 0, z))
        item = context.object
        item.name = name
        context.scene.collection.objects.unlink(item)
        home.objects.link(item)
    for item in context.scene.objects:
        item.data.materials.append(gloss)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "lamp.blend"))
    return tmp_path / "lamp.blend"


def assets(
    names: Sequence[str] = ALL,
    spec: BakeSpec | None = None,
    wish: OpenLayout | None = OpenLayout(),  # noqa: B008 (it is frozen)
    folder: Path | None = None,
) -> tuple[Asset, ...]:
    scene = context.scene
    return find_assets(scene, names, spec or BakeSpec(), wish, folder, read_shown(scene))


@pytest.mark.usefixtures("blend")
def test_an_asset_is_called_like_what_holds_it_alone() -> None:
    assert assets() == (Asset("Lamp", LAMP),)
    collection = bpy.data.collections["Lamp"]
    collection.name = "Collection.001"
    assert assets() == (Asset("Shade_asset", LAMP),), (
        "Blender's own name says nothing, and the shade is larger"
    )
    root = bpy.data.objects.new("Reading Lamp", None)
    collection.objects.link(root)
    for name in LAMP:
        bpy.data.objects[name].parent = root
    assert assets() == (Asset("Reading Lamp", LAMP),)
    bpy.data.objects["Ball"].parent = root
    assert assets() == (Asset("Shade_asset", LAMP),), "the parent has another mesh, too"
    bpy.data.objects["Ball"].name = "Shade_asset"
    assert assets(LAMP) == (Asset("Shade_asset_asset", LAMP),)


@pytest.mark.usefixtures("blend")
def test_what_cannot_gain_or_is_refused_in_one_atlas_is_left_alone() -> None:
    plain = BakeSpec()
    for spec in (
        BakeSpec(kind=Kind.INCIDENT),
        BakeSpec(kind=Kind.AO),
        BakeSpec(kind=Kind.PROXY),
        replace(plain, source="Ball"),
        replace(plain, uv_layer="UVMap"),
        replace(plain, split=Split.MATERIAL),
        replace(plain, refresh=True),
    ):
        assert assets(spec=spec) == (), spec
    assert assets(wish=OpenLayout(6)) == (), "cells of one's own make it buckets"
    assert assets(wish=None) == (), "buckets were named"
    assert len(assets(spec=BakeSpec(layout=Layout.LAYERED), wish=None)) == 1
    assert assets(("Foot", "Ball", "Nothing")) == ()
    bpy.data.objects["Shade"].hide_render = True
    assert assets() == ()


@pytest.mark.usefixtures("blend")
def test_a_part_that_layered_does_not_take_is_left_alone_and_the_others_stay_one() -> None:
    bpy.ops.mesh.primitive_cube_add(size=0.2, location=(0, 0, 1.19))
    context.object.name = "Smoke"
    names = (*ALL, "Smoke")
    assert [asset.objects for asset in assets(names)] == [(*LAMP, "Smoke")]
    fog = stage.material("Fog", "ShaderNodeBsdfDiffuse")
    tree: Any = fog.node_tree
    volume = tree.nodes.new("ShaderNodeVolumePrincipled")
    tree.links.new(volume.outputs[0], tree.get_output_node("CYCLES").inputs["Volume"])
    context.object.data.materials.append(fog)
    assert [asset.objects for asset in assets(names)] == [LAMP]


@pytest.mark.usefixtures("blend")
def test_samples_are_added_to_an_asset_that_was_baked_as_one(out: Path) -> None:
    adding = BakeSpec(accumulate=True)
    assert assets(spec=adding, folder=out) == ()
    files = OutputFiles.of("Lamp", BakeSpec(objects=LAMP), out)
    announce(files.unfinished, ())
    assert len(assets(spec=adding, folder=out)) == 1


@pytest.mark.parametrize(
    ("side", "count", "shared"),
    [(128, 2, 192), (128, 4, 256), (128, 6, 320), (128, 100, 512), (32, 6, 128), (600, 6, 600)],
)
def test_an_atlas_has_about_as_many_texels_as_its_objects_would_have(
    side: int, count: int, shared: int
) -> None:
    assert side_for_several(side, count) == shared


def test_hundreds_of_islands_get_an_atlas_more_texels() -> None:
    assert side_for_several(128, 3, 750) == 384
    assert side_for_several(128, 3, 40_000) == 512
    assert side_for_several(64, 3, 750) == 192  # a draft stays one


@pytest.mark.usefixtures("blend")
def test_islands_of_assets_are_counted() -> None:
    asset = Asset("Lamp", LAMP)
    assert spec_of_asset(context.scene, BakeSpec(), asset).texels == 192
    for name in LAMP:
        mesh = context.scene.objects[name].data
        apart = bmesh.new()
        apart.from_mesh(mesh)
        bmesh.ops.subdivide_edges(apart, edges=apart.edges[:], cuts=9, use_grid_fill=True)
        bmesh.ops.split_edges(apart, edges=apart.edges[:])
        apart.to_mesh(mesh)
        apart.free()
    assert spec_of_asset(context.scene, BakeSpec(), asset).texels == 512
    bare = BakeSpec(unwrap=Unwrap.UVUNWRAP)
    assert spec_of_asset(context.scene, bare, asset).texels == 192, "it takes no islands of the layer"


@pytest.mark.parametrize(
    ("words", "texels"),
    [
        ("--together Lamp", [192]),
        ("--together Lamp --texels 128", [128]),
        ("--together auto", [192, 128]),
        ("--together auto --texels 64", [64, 64]),
        ("", [128]),
    ],
)
def test_texels_that_were_not_named_grow_with_the_objects(blend: Path, words: str, texels: list[int]) -> None:
    request = parse([str(blend), *(f"--object={name}" for name in ALL), *words.split()], False).bakes
    if words == "--together Lamp":
        request = replace(request, objects=LAMP)
    asked = [one for each in asset_requests(context.scene, request) for one in each.specs(context.scene)]
    assert [spec.texels for spec in asked] == texels


def test_a_farm_takes_assets(blend: Path) -> None:
    assert parse_prepare([str(blend), "--object=Foot", "--together=auto"], False).bakes.assets


@pytest.mark.one_blender
def test_the_batch_tells_of_objects_that_touch_and_bakes_them_as_one_if_asked(
    blend: Path, out: Path, batch: Batch
) -> None:
    named = [f"--object={name}" for name in ("Ball", *LAMP)]
    ended = batch(blend, *named, *QUICK, "--out", out, "--progress=json")
    assert ended.code == 0, ended.err
    events = [json.loads(line) for line in ended.out.splitlines()]
    told = [event["message"] for event in events if event["event"] == "note"]
    (line,) = told
    assert line.startswith("'Foot' and 'Shade' touch, and each is baked by itself")
    assert line.endswith("bake them as one asset (--together auto)")
    stems = {path.name.partition(".")[0] for path in out.iterdir()}
    assert stems == {"Ball", *LAMP}, "files are called as ever"

    ended = batch(blend, *named, *QUICK, "--together=auto", "--out", out, "--overwrite", "--progress=none")
    assert ended.code == 0, ended.err
    assert "radtex: note: 'Foot' and 'Shade' touch: they are baked as one asset, 'Lamp'" in ended.err
    assert json.loads((out / "Lamp.radiance.json").read_text())["objects"] == list(LAMP)

    for path in out.glob("Ball.*"):
        path.unlink()
    resumed = batch(blend, *named, *QUICK, "--together=auto", "--out", out, "--resume", "--progress=none")
    assert resumed.code == 0, resumed.err
    assert (out / "Ball.radiance.json").exists()
    again = batch(blend, *named, *QUICK, "--together=auto", "--out", out, "--resume", "--progress=none")
    assert again.code == 0, again.err
    assert "all 2 bakes are finished" in again.err
