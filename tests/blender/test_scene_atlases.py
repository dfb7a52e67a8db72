# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A whole scene in one go: its groups, their names and texels, one progress for all, and a kill amid it."""

from __future__ import annotations

import json
import math
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake.progress import Progress, Stage
from radtex_addon.cli.arguments import parse
from radtex_addon.cli.prepare_arguments import parse_prepare
from radtex_addon.cli.whole_progress import WholeProgress
from radtex_addon.core.errors import InputError
from radtex_addon.job.assets import read_shown
from radtex_addon.job.bake_request import BakeRequest
from radtex_addon.job.layout_choice import OpenLayout
from radtex_addon.job.scene_atlases import SceneAtlas, find_scene_atlases, requests_of
from radtex_addon.settings.estimate import Estimate
from radtex_addon.settings.spec import BakeSpec, Kind
from radtex_addon.textures.export_spec import ExportStep, ExportTask
from tests.blender import stage
from tests.blender.batch_process import ROOT, Batch
from tests.blender.killed import digests

context: Any = bpy.context  # to the stubs, every pointer may be None

SHELL = ("Ceiling", "Floor", "Picture", "Rug", "Wall E", "Wall N", "Wall W")
TABLE = ("Cup", "Leg", "Top")
SOFA = ("Cushion", "Sofa")
QUICK = ["--texels=12", "--samples=1", "--unwrap=blender"]


@pytest.fixture
def blend(tmp_path: Path) -> Path:
    """A room, open to the south, of matt walls and a polished floor, with furniture, and what is no mesh."""
    stage.world()
    matt = stage.material("Matt", "ShaderNodeBsdfPrincipled", Roughness=0.7)
    gloss = stage.material("Gloss", "ShaderNodeBsdfPrincipled", Roughness=0.1)
    side, half = math.pi / 2, math.pi
    _plane("Floor", (5, 4), (0, 0, 0), (0, 0, 0), gloss)
    _plane("Ceiling", (5, 4), (0, 0, 2.7), (half, 0, 0), matt)
    _plane("Wall N", (5, 2.7), (0, 2, 1.35), (side, 0, 0), matt)
    _plane("Wall W", (2.7, 4), (-2.5, 0, 1.35), (0, side, 0), matt)
    _plane("Wall E", (2.7, 4), (2.5, 0, 1.35), (0, -side, 0), matt)
    _box("Picture", (1, 0.03, 0.8), (-1, 1.97, 1.5), matt)
    _box("Rug", (2, 1.5, 0.02), (0, -0.5, 0.011), matt)
    _box("Top", (1, 0.8, 0.04), (1.7, -0.8, 0.72), gloss)
    _box("Leg", (0.3, 0.3, 0.7), (1.7, -0.8, 0.351), matt)
    _box("Cup", (0.1, 0.1, 0.1), (1.7, -0.8, 0.79), gloss)
    _box("Sofa", (0.9, 2, 0.45), (-2, -0.2, 0.226), matt)
    _box("Cushion", (0.3, 0.5, 0.4), (-2.1, 0, 0.65), matt)
    bpy.ops.curve.primitive_bezier_circle_add()
    bpy.ops.object.light_add(type="POINT", location=(0, 0, 2.4))
    _box("Cutter", (1, 1, 1), (0, 0, 1), matt)
    context.object.hide_render = True
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "room.blend"))
    return tmp_path / "room.blend"


def _plane(name: str, size: tuple[float, float], place: Any, turn: Any, material: Any) -> None:
    bpy.ops.mesh.primitive_plane_add(size=1, location=place, rotation=turn)
    _called(name, (*size, 1), material)


def _box(name: str, size: tuple[float, float, float], place: Any, material: Any) -> None:
    bpy.ops.mesh.primitive_cube_add(size=1, location=place)
    _called(name, size, material)


def _called(name: str, size: tuple[float, ...], material: Any) -> None:
    context.object.name, context.object.scale = name, size
    context.object.data.materials.append(material)


def asked(spec: BakeSpec | None = None, names: tuple[str, ...] = ()) -> BakeRequest:
    meshes = sorted(
        item.name for item in context.scene.objects if item.type == "MESH" and not item.hide_render
    )
    return BakeRequest(
        names or tuple(meshes), spec or BakeSpec(), Path("nowhere"), open_layout=OpenLayout(), as_scene=True
    )


def atlases(spec: BakeSpec | None = None, names: tuple[str, ...] = ()) -> dict[str, SceneAtlas]:
    scene = context.scene
    found = find_scene_atlases(scene, asked(spec, names), read_shown(scene))
    assert len({atlas.name for atlas in found}) == len(found)
    return {atlas.name: atlas for atlas in found}


@pytest.mark.usefixtures("blend")
def test_a_room_is_its_shell_and_furniture_by_nearness() -> None:
    glass = stage.material("Glass", "ShaderNodeBsdfGlass")
    _plane("Pane", (1, 1), (0.5, 1.97, 1.5), (math.pi / 2, 0, 0), glass)
    context.view_layer.update()
    found = atlases()
    assert {name: atlas.objects for name, atlas in found.items()} == {
        "Scene_shell": SHELL,
        "Top_group": TABLE,
        "Pane": ("Pane",),
        "Sofa_group": SOFA,
    }, "a pane is clear: it is no part of the shell"
    backwards = atlases(names=tuple(reversed(asked().objects)))
    assert {name: set(atlas.objects) for name, atlas in backwards.items()} == {
        name: set(atlas.objects) for name, atlas in found.items()
    }
    bpy.data.objects["Cup"].name = "Scene_shell"
    assert "Scene_shell_2" in atlases()
    context.scene.name = "Salon"
    assert "Salon_shell" in atlases()
    assert atlases(BakeSpec(kind=Kind.INCIDENT)) == {}, "only what is seen gains from one atlas"


@pytest.mark.usefixtures("blend")
def test_a_room_in_one_piece_and_what_hangs_on_it_are_the_shell() -> None:
    for name in ("Ceiling", "Floor", "Wall N", "Wall W", "Wall E"):
        bpy.data.objects.remove(bpy.data.objects[name])
    _box("Room", (5, 4, 2.7), (0, 0, 1.35), bpy.data.materials["Matt"])
    context.view_layer.update()
    assert atlases()["Scene_shell"].objects == ("Picture", "Room", "Rug")


@pytest.mark.usefixtures("blend")
def test_a_scene_has_as_many_texels_as_a_dozen_objects_and_an_object_its_own() -> None:
    found = atlases()
    whole = sum(atlas.texels**2 for atlas in found.values())
    assert 1 <= whole / (12 * 128**2) < 1.25, "sides are rounded up"
    assert sum(atlas.texels**2 for atlas in atlases(BakeSpec(texels=64)).values()) < 0.4 * whole
    assert found["Top_group"].density > 1.2 * found["Scene_shell"].density, "small things get more"
    before = found["Sofa_group"].texels
    for name in SOFA:
        bpy.data.objects[name].data.materials[0] = bpy.data.materials["Gloss"]
    assert atlases()["Sofa_group"].texels > before, "and so do glossy ones"
    requests = requests_of(asked(), tuple(found.values()))
    assert [(each.shared, each.spec.texels) for each in requests] == [
        (atlas.name if len(atlas.objects) > 1 else None, atlas.texels) for atlas in found.values()
    ]


@pytest.mark.usefixtures("blend")
def test_a_density_is_that_of_all_atlases_but_of_those_that_would_be_too_large() -> None:
    found = atlases(BakeSpec(density=32))
    assert {atlas.density for atlas in found.values()} == {32}
    assert [
        each.spec.density for each in requests_of(asked(BakeSpec(density=32)), tuple(found.values()))
    ] == [32] * len(found)
    finer = atlases(BakeSpec(density=100))
    shells = [atlas for name, atlas in finer.items() if "shell" in name or "Wall" in name]
    assert len(shells) > 1, "a shell that wants more than 512 texels a side has several atlases"
    assert all(atlas.texels <= 512 for atlas in finer.values())
    finest = atlases(BakeSpec(density=500))["Floor"]
    assert finest.texels == 512
    message = finest.capped(500)
    assert message is not None
    assert f"would need about {finest.wanted} texels along a side" in message.problem
    (request,) = requests_of(replace(asked(BakeSpec(density=500)), objects=("Floor",)), [finest])
    assert (request.spec.density, request.spec.texels) == (None, 512)


def test_all_is_refused_where_there_is_one_atlas(blend: Path) -> None:
    with pytest.raises(InputError, match="the demo has one object: leave --all out"):
        parse(["demo", "--all"], False)
    assert parse_prepare([str(blend), "--all"], False).bakes.as_scene  # a farm takes scenes
    with pytest.raises(InputError, match="name it: --object NAME, or bake the whole scene: --all"):
        parse([str(blend)], False)
    together = parse([str(blend), "--all", "--together=Everything"], False)
    assert (together.everything, together.bakes.as_scene, together.bakes.shared) == (
        True,
        False,
        "Everything",
    )
    named = parse([str(blend), "--all", "--object=Floor"], False)
    assert (named.everything, named.bakes.as_scene, named.bakes.objects) == (False, True, ("Floor",))


def test_the_time_left_follows_what_stages_took() -> None:
    """Bakes whose stages take three times as long as is typical."""
    now = [0.0]
    work = {"capture": 20.0, "fit": 10.0}
    progress = WholeProgress([Estimate(work, common=0.5)] * 3, clock=lambda: now[0])
    shares, errors = [], []
    for bake in range(3):
        progress.begin()
        for stage_ in (Stage.CAPTURE, Stage.FIT):
            for done in range(11):
                whole = progress.at(Progress(stage_, done, 10))
                shares.append(whole.share)
                truth = 3 * 30 * 3 - now[0]
                if bake and truth > 0:
                    assert whole.left.is_known
                    errors.append(abs(whole.left.seconds - truth) / (truth + 30))
                now[0] += 0.3 * work[str(stage_)] if done < 10 else 0
    assert shares == sorted(shares)
    assert shares[0] == 0
    assert shares[-1] == 1
    assert max(errors) < 0.3


def test_an_export_comes_after_all_stages_of_a_bake() -> None:
    progress = WholeProgress([Estimate({"capture": 20.0, "fit": 10.0})] * 2)
    progress.begin()
    progress.at(Progress(Stage.CAPTURE, 10, 10))
    assert progress.at(ExportStep(ExportTask.TEXTURES, 1, 2)).share == 0.5


@pytest.mark.one_blender
def test_the_batch_bakes_a_scene_with_one_progress_and_says_what_it_leaves_out(
    blend: Path, out: Path, batch: Batch
) -> None:
    ended = batch(blend, "--all", *QUICK, "--out", out, "--progress=json")
    assert ended.code == 0, ended.err
    events = [json.loads(line) for line in ended.out.splitlines()]
    said = [event["message"] for event in events if event["event"] in ("note", "warning")]
    assert any(line.startswith("left out: object 'BézierCircle' has no faces in renders") for line in said)
    assert any("'Cutter' is hidden from render" in line for line in said)
    assert any(
        line.startswith("'Scene_shell' has 'Ceiling', 'Floor'") and "per metre" in line for line in said
    )
    assert not any("touch" in line for line in said)
    done = [event["object"] for event in events if event["event"] == "done"]
    assert done == list(atlases(BakeSpec(texels=12)))
    whole = [event["whole"] for event in events if event["event"] == "progress"]
    assert whole == sorted(whole)
    assert whole[0] < 0.02
    assert whole[-1] > 0.95
    facts = json.loads((out / "Scene_shell.radiance.json").read_text())
    assert facts["objects"] == list(SHELL)
    again = batch(blend, "--all", *QUICK, "--out", out, "--resume", "--progress=none")
    assert again.code == 0, again.err
    assert f"all {len(done)} bakes are finished" in again.err


@pytest.mark.one_blender
@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals")
def test_a_scene_that_was_killed_is_gone_on_with_to_the_same_bits(
    blend: Path, tmp_path: Path, batch: Batch
) -> None:
    words = [blend, "--all", *(f"--object={name}" for name in (*TABLE, *SOFA)), *QUICK]
    out, whole = tmp_path / "out", tmp_path / "whole"
    ended = batch(*words, "--out", whole, "--progress=none")
    assert ended.code == 0, ended.err
    start = (
        "import sys, pytest\n"
        "from tests.blender import surroundings\n"
        "from radtex_addon.cli import main\n"
        "surroundings.make_small(pytest.MonkeyPatch())\n"
        "sys.exit(main.main(sys.argv[1:], False))"
    )
    command = [sys.executable, "-c", start, *map(str, words), "--out", str(out), "--progress=json"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, cwd=ROOT
    ) as run:
        assert run.stdout is not None
        for line in run.stdout:
            event = json.loads(line) if line.startswith("{") else {}  # Blender speaks first
            if (event.get("object"), event.get("stage")) == ("Sofa_group", "surroundings"):
                run.kill()
                break
        run.stdout.read()
    assert run.returncode == -signal.SIGKILL
    assert (out / "Top_group.radiance.json").exists()
    assert not (out / "Sofa_group.radiance.json").exists()
    finished = (out / "Top_group.radiance.json").stat().st_mtime_ns
    resumed = batch(*words, "--out", out, "--resume", "--progress=none")
    assert resumed.code == 0, resumed.err
    assert (out / "Top_group.radiance.json").stat().st_mtime_ns == finished, "what is done stays"
    assert digests(out) == digests(whole)


@pytest.mark.one_blender
def test_an_atlas_that_cannot_be_baked_does_not_keep_the_others_from_it(
    blend: Path, out: Path, batch: Batch
) -> None:
    _plane("Thread", (1000, 1e-4), (0, 0, 5), (0, 0, 0), bpy.data.materials["Matt"])
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    named = [f"--object={name}" for name in ("Thread", "Cup")]
    ended = batch(blend, "--all", *named, *QUICK, "--out", out, "--progress=none")
    assert ended.code == 2
    last = ended.err.splitlines()[-1]
    assert last.startswith("radtex: 1 of 2 atlases were left out: object 'Thread' is as thin as a thread")
    assert (out / "Cup.radiance.json").exists()
