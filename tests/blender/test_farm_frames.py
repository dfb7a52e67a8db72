# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of light and ends that any Blender renders: tasks make of them what one machine makes."""

from __future__ import annotations

import json
import random
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake.plan import Tile, plan_capture
from radtex_addon.bake.progress import finished
from radtex_addon.core.errors import BakeError, FormatError, InputError
from radtex_addon.cycles import sampling
from radtex_addon.cycles.portal import PortalCapture
from radtex_addon.farm.assemble_tasks import assemble_tasks_steps
from radtex_addon.farm.farm_files import tasks_file
from radtex_addon.farm.part_frames import PartFrames, RenderedPart
from radtex_addon.farm.prepare_tasks import prepare_tasks_steps
from radtex_addon.farm.tasks import TaskFarm, read_tasks
from radtex_addon.forms.layered.capture import capturing
from radtex_addon.forms.layered.capture.parts import Part
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, Kind
from tests.blender import stage
from tests.blender.batch_process import Batch, refusal
from tests.blender.farming import BALL, LAYERED, PLATE, build, do, rewrite_frame

SPEC = LAYERED
BAKES = ((BALL, SPEC), (PLATE, SPEC))
SHEET, TILE = 32, 400  # in pixels: several sheets, which tiles do not fit


@pytest.fixture(scope="module", autouse=True)
def small_sheets() -> Any:
    """Plans of several sheets, and of more tiles."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(capturing, "plan_capture", partial(plan_capture, sheet=SHEET))
        patch.setattr(sampling, "TILE_PIXELS", TILE)
        patch.setattr("radtex_addon.store.shared_pieces.PATIENCE", 0.0)
        patch.setattr("radtex_addon.store.shared_pieces._LOOK", 0.01)
        yield


def build_lively(folder: Path) -> bpy.types.Scene:
    """Red glass above a plate whose gloss depends on its name, among things that move, at frame 7."""
    scene: Any = build(folder)
    glass = next(each for each in bpy.data.materials["glass"].node_tree.nodes if "Roughness" in each.inputs)
    glass.inputs["Color"].default_value = (1.0, 0.3, 0.0, 1.0)
    shown: Any = bpy.data.materials["painted"].node_tree
    gloss, mix, info, glow, add = (
        shown.nodes.new(f"ShaderNode{kind}")
        for kind in ("BsdfAnisotropic", "MixShader", "ObjectInfo", "Emission", "AddShader")
    )
    diffuse = next(each for each in shown.nodes if each.type == "BSDF_DIFFUSE")
    out = next(each for each in shown.nodes if each.type == "OUTPUT_MATERIAL")
    shown.links.new(info.outputs["Random"], mix.inputs[0])
    shown.links.new(diffuse.outputs[0], mix.inputs[1])
    shown.links.new(gloss.outputs[0], mix.inputs[2])
    shown.links.new(mix.outputs[0], add.inputs[0])
    shown.links.new(glow.outputs[0], add.inputs[1])
    shown.links.new(add.outputs[0], out.inputs[0])
    lamp: Any = next(each for each in bpy.data.lights)
    lamp.driver_add("energy").driver.expression = "frame * 5"
    bpy.ops.mesh.primitive_cube_add(size=0.4, location=(0.9, 0, 0.6))
    mover = bpy.context.object
    mover.name = "Mover"
    mover.data.materials.append(stage.material("moved", "ShaderNodeBsdfDiffuse"))
    mover.modifiers.new("wave", "WAVE").height = 0.1
    for frame, place in ((1, 0.9), (20, 2.0)):
        mover.location.x = place
        mover.keyframe_insert("location", frame=frame)
    scene.frame_set(7)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "things.blend"))
    made: bpy.types.Scene = scene
    return made


def render(farm: TaskFarm, frames: PartFrames, *which: str) -> None:
    """Render frames with the bpy module, which sees none of our modules and no user's settings."""
    blend = str(frames.blend(farm.folder))
    runner = str(farm.folder / "frames" / "render_frames.py")
    command = [sys.executable, "-I", runner, "-b", blend, *(which or ("-a",))]
    subprocess.run(command, check=True, capture_output=True, timeout=120, cwd=farm.folder)


@dataclass(frozen=True)
class Framed:
    """A farm whose frames are rendered, no task but maps done, and the folder of the same bakes made here."""

    farm: TaskFarm
    local: Path


@pytest.fixture(scope="module")
def framed(tmp_path_factory: pytest.TempPathFactory, small_sheets: None) -> Framed:
    folder = tmp_path_factory.mktemp("frames")
    scene = build_lively(folder)
    for name, spec in BAKES:
        bake_object(scene, name, spec, folder / "local")
    made = finished(prepare_tasks_steps(scene, BAKES, folder / "far", frames=True))
    (folder / "picture.png").unlink()  # what machines need travels
    farm = read_tasks(made.farm.folder)
    assert farm.frames == made.farm.frames
    for frames in farm.frames:
        render(farm, frames)
    return Framed(farm, folder / "local")


@pytest.fixture
def farm(framed: Framed, tmp_path: Path) -> TaskFarm:
    """A copy to do harm to."""
    copy = shutil.copytree(framed.farm.folder, tmp_path / framed.farm.folder.name)
    return read_tasks(Path(copy))


def frames_of(farm: TaskFarm, bake: str, part: Part) -> PartFrames:
    return next(each for each in farm.frames if (each.bake, each.part) == (bake, part))


def pieces_of(farm: TaskFarm, bake: str, part: Part) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in farm.pieces(bake).glob(f"{part}-*.piece")}


def test_frames_of_any_blender_become_what_one_machine_makes(
    framed: Framed, farm: TaskFarm, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert [task.name for task in farm.tasks if farm.is_done(task.name)] == [
        f"{name}.maps" for name in (BALL, PLATE)
    ]
    assert min(frames_of(farm, BALL, part).sheets for part in (Part.LIGHT, Part.ENDS)) > 1
    rendered: dict[str, int] = {}
    render_tile = PortalCapture.render_passes

    def counted(capture: PortalCapture, tile: Tile) -> Any:
        rendered[now] = rendered.get(now, 0) + 1
        return render_tile(capture, tile)

    monkeypatch.setattr(PortalCapture, "render_passes", counted)
    for task in farm.left():
        now = task.name
        do(farm, [now])
    tiles = len(pieces_of(farm, BALL, Part.ENDS))
    assert {f"{BALL}.light", f"{PLATE}.light", f"{PLATE}.ends"}.isdisjoint(rendered)
    assert 0 < rendered[f"{BALL}.ends"] <= 2 * tiles  # the other two turns, where red glass is almost black
    finished(assemble_tasks_steps(farm, out))
    assert {path.name for path in out.iterdir()} == {path.name for path in framed.local.iterdir()}
    for path in framed.local.iterdir():
        assert (out / path.name).read_bytes() == path.read_bytes(), path.name


def test_the_list_of_tasks_says_which_frames_any_program_renders(farm: TaskFarm) -> None:
    told = json.loads(tasks_file(farm.folder).read_text())["frames"]
    assert [(each["bake"], each["part"]) for each in told] == [
        (bake, part) for bake in (BALL, PLATE) for part in ("light", "ends")
    ]
    for each in told:
        assert (farm.folder / each["blend"]).is_file()
        assert each["seconds"] > 0
        first, last = each["frames"]
        folder, name = each["pictures"].rsplit("/", 1)
        pictures = {path.name for path in (farm.folder / folder).iterdir()}
        assert pictures == {f"{number:0{len(name.split('.')[0])}d}.exr" for number in range(first, last + 1)}
    bpy.ops.wm.open_mainfile(filepath=str(farm.folder / told[0]["blend"]))
    assert bpy.data.libraries[:] == []
    assert bpy.utils.blend_paths(absolute=True, packed=False) == []


@pytest.mark.one_blender
def test_frames_that_cannot_be_used_are_named_with_what_renders_just_them(farm: TaskFarm) -> None:
    light, ends = (frames_of(farm, BALL, part) for part in (Part.LIGHT, Part.ENDS))
    place = partial(ends.picture, farm.folder)
    before = {number: place(number).read_bytes() for number in range(1, ends.count + 1)}
    place(1).unlink()
    place(2).write_bytes(before[3])
    place(3).write_bytes(light.picture(farm.folder, 1).read_bytes())
    place(4).write_bytes(before[4][: len(before[4]) // 2])
    rewrite_frame(place(5), Software="Blender 4.4.1")
    name = f"{BALL}.ends"
    with pytest.raises(InputError) as caught:
        do(farm, [name])
    said = str(caught.value)
    assert "\n" not in said
    assert "1 missing; 3 of another job; 2 another frame's picture (2 is 3); 4 damaged; " in said
    assert "5 of another version of Blender (Blender 4.4.1)" in said
    assert not farm.is_done(name)
    assert pieces_of(farm, BALL, Part.ENDS) == {}
    found = re.search(
        r"render just those: (blender -b \S+ -f 1\.\.5) .* with the bpy module: (python .*?)  ", said
    )
    assert found is not None
    assert shlex.split(found[1])[2] == str(ends.blend(farm.folder))
    again = [sys.executable, "-I", *shlex.split(found[2])[1:]]
    subprocess.run(again, check=True, capture_output=True, timeout=120)
    do(farm, [name])
    assert farm.is_done(name)


@pytest.mark.one_blender
def test_frames_that_are_damaged_within_are_all_named(farm: TaskFarm) -> None:
    light = frames_of(farm, BALL, Part.LIGHT)
    first, second, third = (light.picture(farm.folder, number) for number in (1, 2, 3))
    whole = first.read_bytes()
    for path in (first, third):
        text = bytearray(path.read_bytes())
        text[-200:] = bytes(200)
        path.write_bytes(bytes(text))
    rewrite_frame(second, rows=4, Software=f"Blender {bpy.app.version_string}")
    with pytest.raises(InputError, match=r"1\.\.3 damaged; render just those: "):
        do(farm, [f"{BALL}.light"])
    first.write_bytes(whole)
    part = RenderedPart(farm.folder, farm.job, farm.blender, light, (0, 1))
    assert part.sheet(0, 0).raw_whole.shape[:2] == light.pixels
    with pytest.raises(InputError, match=r"2 of 3 frames of .* cannot be used: 2\.\.3 damaged"):
        part.sheet(0, 1)


@pytest.mark.one_blender
def test_frames_of_numbers_that_are_none_are_named(farm: TaskFarm, monkeypatch: pytest.MonkeyPatch) -> None:
    light = frames_of(farm, BALL, Part.LIGHT)
    monkeypatch.setattr("radtex_addon.cycles.passes._ASTRAY", 1e-6)
    rewrite_frame(
        light.picture(farm.folder, 2), value=float("nan"), Software=f"Blender {bpy.app.version_string}"
    )
    with pytest.raises(InputError, match=r"2 not numbers \(look for a material that divides by 0\)"):
        do(farm, [f"{BALL}.light"])


def test_a_machine_without_the_blend_renders_by_itself(framed: Framed, farm: TaskFarm) -> None:
    do(farm, [f"{PLATE}.light"])
    before = pieces_of(farm, PLATE, Part.LIGHT)
    light = frames_of(farm, PLATE, Part.LIGHT)
    light.blend(farm.folder).unlink()
    shutil.rmtree(light.picture(farm.folder, 1).parent)
    for name in before:
        (farm.pieces(PLATE) / name).unlink()
    do(farm, [f"{PLATE}.light"])
    assert pieces_of(farm, PLATE, Part.LIGHT) == before


def test_every_share_names_the_frames_of_its_tiles() -> None:
    draw = random.Random(7)
    for _ in range(40):
        frames = PartFrames(
            "x", draw.choice([Part.LIGHT, Part.ENDS]), columns=draw.randint(1, 9), rows=draw.randint(1, 60),
            sheet_rows=draw.randint(1, 9), cells=draw.randint(1, 4), seconds=1.0,
        )  # fmt: skip
        height = sampling.rows_of_tiles(frames.columns, frames.cells)
        tiles = [range(row, min(row + height, frames.rows)) for row in range(0, frames.rows, height)]
        count = draw.randint(1, len(tiles))
        for number in range(count):
            some = tiles[number * len(tiles) // count : (number + 1) * len(tiles) // count]
            sheets = {row // frames.sheet_rows for tile in some for row in tile}
            numbers = {frames.number(light, sheet) for sheet in sheets for light in range(frames.lights)}
            assert frames.of_share((number, count)) == sorted(numbers)


@pytest.mark.one_blender
def test_a_parent_that_is_in_another_scene_travels(tmp_path: Path) -> None:
    scene = build(tmp_path)
    anchor = bpy.data.objects.new("Anchor", None)
    anchor.location = (0, 0, 0.25)
    bpy.data.objects[PLATE].parent = anchor
    bpy.data.scenes.new("Workshop").collection.objects.link(anchor)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "things.blend"))
    made = finished(prepare_tasks_steps(scene, ((PLATE, SPEC),), tmp_path / "far"))
    bpy.ops.wm.open_mainfile(filepath=str(made.farm.scene_file))
    plate: Any = bpy.data.objects[PLATE]
    assert plate.matrix_world.translation[:] == (0, 0, 0.25)


@pytest.mark.one_blender
def test_what_cannot_be_frames_is_refused_before_anything_is_made(tmp_path: Path) -> None:
    scene = build(tmp_path)
    far = tmp_path / "far"
    shadow = BakeSpec(kind=Kind.SHADOW, texels=16, bucket=4, samples=1)
    with pytest.raises(InputError, match="not of shadow in layout buckets: prepare without them"):
        finished(prepare_tasks_steps(scene, ((PLATE, shadow),), far, frames=True))
    seeded = BakeSpec(layout=SPEC.layout, texels=12, samples=1, seed=2**23 + 1)
    with pytest.raises(InputError, match="give one below 8388608"):
        finished(prepare_tasks_steps(scene, ((PLATE, seeded),), far, frames=True))
    bpy.ops.mesh.primitive_cube_add(size=0.2, location=(0, 0, 3))
    bpy.context.object.name = "Source"
    bpy.context.object.modifiers.new("dust", "PARTICLE_SYSTEM")
    bpy.context.object.particle_systems[0].point_cache.use_disk_cache = False
    with pytest.raises((InputError, BakeError), match="'Source'"):
        finished(prepare_tasks_steps(scene, BAKES, far, frames=True))
    assert list(far.iterdir() if far.exists() else ()) == []


@pytest.mark.one_blender
def test_a_list_that_tells_of_impossible_frames_is_refused(farm: TaskFarm) -> None:
    path = tasks_file(farm.folder)
    told = json.loads(path.read_text())
    for plan in ([0, 1, 1, 4], [8, 18, 1 << 20, 4], [8, 1 << 40, 6, 4]):
        told["frames"][0]["plan"] = plan
        path.write_text(json.dumps(told))
        with pytest.raises(FormatError, match="tells of frames that no bake has: prepare it anew"):
            read_tasks(farm.folder)


@pytest.mark.one_blender
def test_the_batch_prepares_frames(tmp_path: Path, batch: Batch) -> None:
    build(tmp_path)
    options = ("--texels", "12", "--samples", "1", "--progress", "json", "--stock-frames")
    plate = ("prepare", tmp_path / "things.blend", "--object", PLATE)
    done = batch(*plate, *options, "--out", tmp_path / "far")
    assert done.code == 0, done.err
    event = json.loads(done.out.splitlines()[-1])
    folder = Path(event["files"][0])
    assert [each["blend"] for each in event["stock_frames"]] == [
        f"frames/{PLATE}.light.blend", f"frames/{PLATE}.ends.blend",
    ]  # fmt: skip
    said = refusal(batch("work", folder, f"{PLATE}.light", "--progress", "none"))
    assert "1 of 1 frames of " in said
    assert f"{PLATE}.light.blend cannot be used: 1 missing; render just those: blender -b " in said
    for frames in read_tasks(folder).frames:
        render(read_tasks(folder), frames)
    assert batch("work", folder, "--progress", "none").code == 0
    out = ("--layout", "buckets", "--progress", "none", "--out", tmp_path / "other")
    said = refusal(batch(*plate, *options, *out))
    assert "--stock-frames: in layout buckets all is frames already: leave it out" in said
