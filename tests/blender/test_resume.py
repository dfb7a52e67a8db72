# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that are gone on with: what is kept and used, and what is refused by name."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.progress import Stage
from radtex_addon.bake.thumbnail import Thumbnail
from radtex_addon.core.errors import BakeError, FormatError, InputError
from radtex_addon.cycles import building_blocks, portal
from radtex_addon.formats.disk.temporary import mark_of
from radtex_addon.job import bake_object, bake_steps, check_request
from radtex_addon.settings.spec import BakeSpec, Layout, Unwrap
from radtex_addon.store.checkpoint_files import KEY, PIECE_FORMAT
from tests.blender import stage
from tests.blender.batch_process import Batch
from tests.blender.farming import BOX, assembled, build_moving_scene, prepared
from tests.blender.killed import digests
from tests.blender.room import fill_room, save_room

pytestmark = pytest.mark.one_blender

context: Any = bpy.context  # to the stubs, every pointer may be None

PLAIN = ("--layout", "buckets", "--uv", "UVMap", "--texels", "24", "--bucket", "16", "--samples", "1")
QUICK = BakeSpec(texels=16, bucket=4, samples=1)
FOLDER = "Ball.radiance.radtex-unfinished"


@pytest.fixture(autouse=True)
def scene() -> None:
    fill_room()


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return save_room(tmp_path_factory.mktemp("room") / "room.blend")


def begun(out: Path, spec: BakeSpec = QUICK, at: Stage = Stage.CAPTURE) -> list[str]:
    """Bake until something of a stage is kept, drop it there, and name what is kept."""
    steps = bake_steps(context.scene, "Ball", spec, out)
    for step in steps:
        if step.stage is at and step.done:
            steps.close()
            break
    return sorted(path.name for path in (out / FOLDER).iterdir())


def rendered(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the files that renders go to, as they are made."""
    seen: list[str] = []
    render = building_blocks.render_layers

    def counted(scene: bpy.types.Scene, file: Path) -> Any:
        seen.append(file.name)
        return render(scene, file)

    monkeypatch.setattr(portal, "render_layers", counted)
    return seen


def a_vertex() -> None:
    context.scene.objects["Ball"].data.vertices[3].co.x += 1e-3


def a_uv() -> None:
    context.scene.objects["Ball"].data.uv_layers[0].uv[0].vector.x += 1e-3


def a_material() -> None:
    node = bpy.data.materials["floor"].node_tree.nodes
    next(one for one in node if one.bl_idname == "ShaderNodeBsdfDiffuse").inputs["Color"].default_value[0] = (
        0.3
    )


def the_sky() -> None:
    nodes = context.scene.world.node_tree.nodes
    next(one for one in nodes if one.bl_idname == "ShaderNodeBackground").inputs["Strength"].default_value = 7


def a_place(name: str) -> Callable[[], None]:
    def move() -> None:
        context.scene.objects[name].location.z -= 0.25

    return move


def a_new_object() -> None:
    bpy.ops.mesh.primitive_cube_add(location=(4, 0, 0))


def the_lamp() -> None:
    bpy.data.lights[0].color = (1, 0.5, 0.5)


def bounces() -> None:
    context.scene.cycles.max_bounces = 1


def the_frame() -> None:
    context.scene.frame_set(5)


CHANGES: list[tuple[Callable[[], None], str]] = [
    (a_vertex, "in mesh: bake"),
    (a_uv, "in mesh: bake"),
    (a_place("Ball"), "in object's place: bake"),
    (a_material, "in materials: bake"),
    (the_sky, "in world: bake"),
    (a_place("Floor"), "in objects: bake"),
    (a_place("Lamp"), "in lights: bake"),
    (a_new_object, "in objects: bake"),
    (the_lamp, "in lights: bake"),
    (bounces, "in light paths: bake"),
    (the_frame, r"in frame \(1, now 5\): bake"),
]


def test_what_changed_in_the_scene_is_named(out: Path) -> None:
    kept = begun(out)
    for change, words in CHANGES:
        fill_room()
        change()
        with pytest.raises(InputError, match=rf"differs {words}") as raised:
            bake_object(context.scene, "Ball", QUICK, out, resume=True)
        assert "\n" not in str(raised.value)
        assert sorted(path.name for path in (out / FOLDER).iterdir()) == kept


def test_what_changed_of_the_specification_is_named_before_anything_is_done(out: Path) -> None:
    begun(out)
    other = BakeSpec(texels=16, bucket=4, samples=2, seed=3)
    with pytest.raises(
        InputError, match=r"differs in samples \(1, now 2\), seed \(0, now 3\): bake as before"
    ):
        check_request(context.scene, "Ball", other, out, False, False, resume=True)


def test_another_version_is_named(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    begun(out)
    monkeypatch.setattr("radtex_addon.store.bake_folder.VERSION", "99.0")
    with pytest.raises(InputError, match=r"RadTex's version \(\S+, now 99\.0\)"):
        bake_object(context.scene, "Ball", QUICK, out, resume=True)


def test_what_does_not_matter_may_differ(out: Path, tmp_path: Path) -> None:
    bake_object(context.scene, "Ball", QUICK, tmp_path / "whole")
    begun(out)
    context.scene.cycles.samples = 7
    context.scene.render.filepath = "/elsewhere"
    bpy.data.materials["floor"].node_tree.nodes[0].location.x += 100
    bpy.ops.object.camera_add(location=(1, 2, 3))
    spec = BakeSpec(texels=16, bucket=4, samples=1, memory_mb=64)
    bake_object(context.scene, "Ball", spec, out, resume=True)
    assert digests(out) == digests(tmp_path / "whole")


def test_an_unfinished_bake_is_begun_anew_only_if_that_is_said(out: Path, tmp_path: Path) -> None:
    bake_object(context.scene, "Ball", QUICK, tmp_path / "whole")
    kept = begun(out, BakeSpec(texels=16, bucket=2, samples=1))
    with pytest.raises(InputError, match=r"unfinished bake: go on with it, or begin an"):
        bake_object(context.scene, "Ball", QUICK, out)
    assert sorted(path.name for path in (out / FOLDER).iterdir()) == kept
    bake_object(context.scene, "Ball", QUICK, out, overwrite=True)
    assert digests(out) == digests(tmp_path / "whole")


def test_what_is_finished_is_neither_traced_again_nor_overwritten(
    out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise BakeError("the disk is full")

    with monkeypatch.context() as patch:
        patch.setattr("radtex_addon.forms.buckets.bake.write_bands", full)
        with pytest.raises(BakeError, match="full"):
            bake_object(context.scene, "Ball", QUICK, out)
    seen = rendered(monkeypatch)
    bake_object(context.scene, "Ball", QUICK, out, resume=True)
    assert seen == []
    with pytest.raises(InputError, match="nothing of object 'Ball' is unfinished: bake it anew"):
        bake_object(context.scene, "Ball", QUICK, out, resume=True)
    bake_object(context.scene, "Ball", QUICK, out, resume=True, overwrite=True)
    assert seen


def test_files_that_a_killed_bake_had_written_already_are_replaced(out: Path) -> None:
    begun(out)
    key = json.loads((out / FOLDER / KEY).read_text())
    assert set(key["replaces"]) == {"Ball.radiance.exr", "Ball.radiance.json"}
    (out / "Ball.radiance.exr").write_text("of the killed bake")
    bake_object(context.scene, "Ball", QUICK, out, resume=True)
    assert {path.name for path in out.iterdir()} == set(key["replaces"])
    assert (out / "Ball.radiance.exr").read_bytes()[:4] == b"\x76\x2f\x31\x01"


def test_what_cannot_be_baked_leaves_nothing_to_go_on_with(out: Path) -> None:
    spec = BakeSpec(texels=2, bucket=4, samples=1, unwrap=Unwrap.UVUNWRAP)
    with pytest.raises(InputError, match="texels"):
        bake_object(context.scene, "Ball", spec, out)
    assert not (out / FOLDER).exists()


@pytest.mark.parametrize("layout", list(Layout))
def test_a_thumbnail_shows_what_there_is(layout: Layout, tmp_path: Path, out: Path) -> None:
    context.scene.objects["Ball"].data.materials.clear()
    context.scene.objects["Ball"].data.materials.append(
        stage.material("glow", "ShaderNodeEmission", Color=(1, 0, 0, 1))
    )
    told: list[Path] = []
    path = tmp_path / "small.png"
    cells = 14 if layout is Layout.LAYERED else 4
    spec = BakeSpec(layout=layout, texels=24, bucket=cells, samples=1)
    bake_object(context.scene, "Ball", spec, out, thumbnail=Thumbnail(path, told.append))
    assert told
    assert set(told) == {path}
    picture: Any = bpy.data.images.load(str(path))
    pixels = np.array(picture.pixels).reshape(-1, 4)
    assert max(picture.size) == 24
    red = (pixels[:, :3] == (1, 0, 0)).all(axis=1)
    assert red.any()
    assert len(np.unique(pixels[~red], axis=0)) <= 1, "the rest is of one grey"


def test_the_batch_tells_of_pictures_and_goes_on(room: Path, out: Path, tmp_path: Path, batch: Batch) -> None:
    asked = (room, "--object", "Ball", *PLAIN, "--out", out, "--progress", "json")
    path = tmp_path / "small.png"
    ended = batch(*asked, "--thumbnail", path)
    assert ended.code == 0
    events = [json.loads(line) for line in ended.out.splitlines()]
    assert {"event": "picture", "object": "Ball", "path": str(path)} in events
    assert path.read_bytes()[:4] == b"\x89PNG"
    ended = batch(*asked, "--resume")
    assert ended.code == 2
    assert "nothing of object 'Ball' is unfinished" in ended.err
    path = path.with_suffix(".jpg")
    ended = batch(*asked, "--overwrite", "--thumbnail", path)
    assert ended.code == 2
    assert ended.err.startswith(f"radtex: --thumbnail {path}: give the name of a PNG, such as ")


# pieces and frames of another format

UNFINISHED = {
    "tiles": (QUICK, Stage.CAPTURE),
    "fills of hidden cells": (QUICK, Stage.FILL),
}


@pytest.mark.parametrize("what", UNFINISHED)
def test_pieces_of_another_format_are_refused_and_a_new_bake_is_whole(
    what: str, out: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    spec, at = UNFINISHED[what]
    with monkeypatch.context() as earlier:
        earlier.setattr("radtex_addon.store.checkpoint_files.PIECE_FORMAT", PIECE_FORMAT - 1)
        kept = begun(out, spec, at)
    assert any(name.endswith(".piece") for name in kept)
    said = (
        f"holds pieces of format {PIECE_FORMAT - 1}, this RadTex makes those of format {PIECE_FORMAT}: "
        "go on with the RadTex that made them, or begin anew"
    )
    with pytest.raises(InputError, match=said):
        bake_object(context.scene, "Ball", spec, out, resume=True)
    with pytest.raises(InputError, match="holds an unfinished bake"):
        bake_object(context.scene, "Ball", spec, out)
    assert sorted(path.name for path in (out / FOLDER).iterdir()) == kept, "nothing is deleted unasked"
    (worker,) = json.loads((out / FOLDER / KEY).read_text())["processes"]
    left = out / f"{mark_of(worker)}left"  # as when it was killed while it wrote
    left.touch()
    bake_object(context.scene, "Ball", spec, out, overwrite=True)
    assert not left.exists()
    bake_object(context.scene, "Ball", spec, tmp_path / "whole")
    assert digests(out) == digests(tmp_path / "whole")


def test_frames_of_another_format_are_not_joined(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spec = BakeSpec(texels=16, bucket=2, samples=1)
    scene = build_moving_scene(tmp_path)
    with monkeypatch.context() as earlier:
        earlier.setattr("radtex_addon.store.checkpoint_files.PIECE_FORMAT", PIECE_FORMAT + 1)
        farm = prepared(scene, spec, tmp_path / "far").files.folder
    frames = digests(farm)
    said = (
        f"are of format {PIECE_FORMAT + 1}, this RadTex joins those of format {PIECE_FORMAT}: assemble with"
    )
    with pytest.raises(FormatError, match=re.escape(said)):
        assembled(farm)
    assert digests(farm) == frames
    assert not list((tmp_path / "far").glob(f"{BOX}.radiance.exr"))
