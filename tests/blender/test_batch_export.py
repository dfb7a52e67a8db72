# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""bake.py export: its words, its exit codes, in a process and inside Blender."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.cli.export_arguments import ExportRequest, parse_export
from radtex_addon.cli.options import ProgressStyle
from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.export.targets import web
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, Kind
from radtex_addon.textures.export_spec import Arrangement, ExportSpec, Target, TextureFormat
from tests.blender import stage
from tests.blender.batch_process import BAKE, Batch, Outcome, refusal

pytestmark = pytest.mark.one_blender

context: Any = bpy.context  # to the stubs, every pointer may be None

QUIET = ("--progress", "none")
STAGES = ["textures", "flat", "mesh", "pack"]


@pytest.fixture(scope="module")
def bakes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the bakes of two balls, one of which has no preview, and with incident light."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    folder = tmp_path_factory.mktemp("ein schöner Raum")
    for name, place in (("Ball", 0.0), ("Bare", 3.0), ("Lit", 6.0)):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=1, location=(place, 0, 0))
        context.object.name = name
        context.object.data.materials.append(stage.material(name, "ShaderNodeEmission"))
        kind = Kind.INCIDENT if name == "Lit" else Kind.RADIANCE
        spec = BakeSpec(texels=32, bucket=2, samples=1, kind=kind)
        preview = Filter.QUADRILINEAR if name == "Ball" else None
        bake_object(context.scene, name, spec, folder / "baked", preview=preview)
    return folder / "baked"


@pytest.fixture
def bake(bakes: Path, tmp_path: Path) -> Path:
    """The same for a test of its own."""
    return Path(shutil.copytree(bakes, tmp_path / "baked"))


def test_an_export_prints_json_lines_and_leaves_one_folder(bake: Path, batch: Batch) -> None:
    before = set(bake.iterdir())
    ended = batch("export", bake, "--object", "Ball", "--to", "gltf", "--progress", "json")
    assert (ended.code, ended.err) == (0, "")
    *progress, done = [json.loads(line) for line in ended.out.splitlines()]
    assert {event["event"] for event in progress} == {"progress"}
    assert list(dict.fromkeys(event["stage"] for event in progress)) == STAGES
    made = bake / "Ball.gltf"
    assert set(bake.iterdir()) == before | {made}
    assert (done["event"], done["object"], done["target"]) == ("done", "Ball", "gltf")
    assert done["files"] == [str(made)]
    assert {"Ball.glb", "Ball.flat.png", "Ball.radiance.ktx2"} <= set(done["contents"])
    assert done["summary"].startswith(f"Ball for gltf: {len(done['contents'])} files, ")


def test_inside_blender_the_open_file_stays_open(bake: Path, out: Path, batch: Batch) -> None:
    bpy.ops.mesh.primitive_cube_add()
    context.object.name = "Mine"
    ended = batch("export", bake / "Ball.radiance.json", "--to=unity", "--out", out, inside_blender=True)
    assert (ended.code, ended.err.splitlines()) == (
        0,
        [
            "Ball: storing textures",
            "Ball: averaging its light",
            "Ball: writing the mesh",
            "Ball: packing",
        ],
    )
    assert ended.out.splitlines()[1] == f"  {out}"
    assert [item.name for item in bpy.data.objects] == ["Mine"]


def test_a_request_is_what_was_said() -> None:
    words = "baked --to web --no-zstd --arrangement slices --format ktx2-rgba16f --limit 4096 --levels 2"
    assert parse_export(words.split(), inside_blender=False) == ExportRequest(
        bakes=(Path("baked"),),
        object=None,
        spec=ExportSpec(
            Target.WEB, TextureFormat.KTX2_RGBA16F, False, Arrangement.SLICES, levels=2, limit=4096
        ),
        out=None,
        overwrite=False,
        progress=ProgressStyle.BAR,
        verbose=False,
    )
    plain = parse_export(["baked", "--to", "raw"], inside_blender=True)
    assert plain.spec == ExportSpec(Target.RAW)
    scene = parse_export(["a", "b", "--to", "web", "--scene", "Room"], inside_blender=False)
    assert (scene.bakes, scene.scene) == ((Path("a"), Path("b")), "Room")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "which bake"),
        (["baked"], r"for whom\? --to web, godot, gltf, unity, unreal, raw"),
        (["baked", "--to", "wii"], r"--to wii: choose from web, godot"),
        (["baked", "--to", "web", "--format", "png"], r"--format png: choose from auto, exr"),
        (["baked", "--to", "web", "--format", "exr"], r"format exr: web does not read it: choose from"),
        (["baked", "--to", "web", "--limit", "many"], r"--limit many: give a whole number"),
        (["baked", "--to", "web", "--limit", "1"], r"limit 1: a texture needs"),
        (["baked", "--to", "web", "--levels", "99"], r"levels 99: give a whole number from 1"),
        (["baked", "", "--to", "web"], r"DIR is empty: give a name"),
        (["baked", "--to", "web", "--scene", ""], r"--scene is empty: give the scene a name"),
    ],
)
def test_what_is_missing_or_wrong_is_named(arguments: list[str], words: str) -> None:
    with pytest.raises(InputError, match=words):
        parse_export(arguments, inside_blender=False)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere"], "there is no nowhere"),
        (["."], "holds no bake"),
        (["baked"], "holds bakes of 'Ball', 'Bare'"),
        (["baked", "--object", "Bare"], "Bare.preview.blend is missing"),
        (["baked", "--object", "Lit"], "Lit.preview.blend is missing"),
        (["baked", "--object", "Ball", "--out", "baked"], "holds the bake itself"),
        (["baked", "--object", "Ball", "--out", "baked/Ball.radiance.json"], "is a file"),
    ],
)
def test_a_refusal_is_one_line_and_leaves_nothing(
    arguments: list[str], words: str, bake: Path, monkeypatch: pytest.MonkeyPatch, batch: Batch
) -> None:
    monkeypatch.chdir(bake.parent)
    before = set(bake.parent.rglob("*"))
    assert words in refusal(batch("export", *arguments, "--to", "gltf", *QUIET))
    assert set(bake.parent.rglob("*")) == before


def test_a_truncated_atlas_is_one_line(bake: Path, batch: Batch) -> None:
    atlas = bake / "Ball.radiance.exr"
    atlas.write_bytes(atlas.read_bytes()[:-64])
    before = set(bake.rglob("*"))
    ended = batch("export", bake / "Ball.radiance.json", "--to", "raw", *QUIET)
    assert "Ball.radiance.exr is damaged" in refusal(ended)
    assert set(bake.rglob("*")) == before


def test_a_web_page_that_was_not_built_is_missed_before_the_work(
    bake: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, batch: Batch
) -> None:
    monkeypatch.setattr(web, "BUILT", tmp_path / "built")
    ended = batch("export", bake / "Ball.radiance.json", "--to", "web", "--progress", "bar")
    assert "the web page lacks index.html: build it" in refusal(ended)
    assert not (bake / "Ball.web").exists()


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells what a process has loaded")
def test_a_signal_while_blender_starts_is_one_line(bake: Path) -> None:
    hearing = "import runpy, signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
    hearing += "sys.argv = sys.argv[1:]; runpy.run_path(sys.argv[0], run_name='__main__')"
    command = [sys.executable, "-c", hearing, BAKE, "export", str(bake / "Ball.radiance.json"), "--to", "raw"]
    before = set(bake.rglob("*"))
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        watchdog = threading.Timer(100, running.kill)
        watchdog.start()
        loaded = Path(f"/proc/{running.pid}/maps")
        while "/bpy/__init__" not in loaded.read_text() and running.poll() is None:
            time.sleep(0.01)
        running.send_signal(signal.SIGINT)
        out, err = running.communicate()
        watchdog.cancel()
    assert "interrupted" in refusal(Outcome(running.returncode, out, err), code=130)
    assert set(bake.rglob("*")) == before


def test_an_export_that_takes_more_memory_than_allowed_is_refused_before_it_begins(
    bake: Path, batch: Batch
) -> None:
    sidecar = bake / "Ball.radiance.json"
    said = refusal(batch("export", sidecar, "--to", "raw", "--memory", "64MB", *QUIET))
    assert (
        f"an export of {sidecar} takes about 192 MiB of memory, 61 MiB are allowed: allow more (--memory)"
        in said
    )
    assert not (bake / "Ball.raw").exists()
    request = parse_export([str(sidecar), "--to", "raw", "--memory", "2GB"], inside_blender=False)
    assert request.spec.memory_mb == 1907
