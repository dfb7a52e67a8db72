# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Odd names of folders, files and objects: baked in their place, or refused in one line with nothing left."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.formats.sidecar import read_sidecar
from tests.blender import stage
from tests.blender.batch_process import BAKE, QUICK, Batch, refusal

pytestmark = pytest.mark.one_blender

# Each is the name of an object in the scene; the last two are one name, composed in two ways.
NAMES = (
    "../../x",
    "/etc/passwd",
    "C:\\x",
    "con",
    "..",
    "日" * 21,
    "a\nb",
    "x ",
    "Card",
    "x",
    "X",
    "Card-Key",
    "é",
    "e\u0301",
)
posix = pytest.mark.skipif(sys.platform == "win32", reason="a POSIX system's names")


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plane for every name, in white light, and a lamp."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    context: Any = bpy.context
    for place, name in enumerate(NAMES):
        bpy.ops.mesh.primitive_plane_add(location=(3 * place, 0, 0))
        context.object.name = name
        assert context.object.name == name
        context.object.data.materials.append(bpy.data.materials.new(f"../../{name}"[:40]))
    bpy.ops.object.light_add(type="POINT", location=(0, 0, 5))
    context.object.name = "Key"
    bpy.ops.object.light_add(type="POINT", location=(0, 0, 5))
    context.object.name = "../../lamp"
    stage.world()
    path = tmp_path_factory.mktemp("scene") / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


@pytest.fixture
def place(tmp_path: Path, temporary: Path) -> Path:
    """A folder to have odd things in."""
    folder = tmp_path / "deep" / "place"
    folder.mkdir(parents=True)
    return folder


def found_in(folder: Path) -> dict[str, object]:
    """All that lies below a folder: links by where they lead, files by what they hold."""
    return {
        str(path.relative_to(folder)): path.readlink()
        if path.is_symlink()
        else path.read_bytes()
        if path.is_file()
        else oct(path.lstat().st_mode)
        for path in sorted(folder.rglob("*"))
    }


@contextmanager
def unchanged(folder: Path) -> Iterator[None]:
    """Nothing appears, changes or goes away below the folder, nor where temporary files go."""
    others = Path(tempfile.gettempdir())
    before = found_in(folder), found_in(others)
    yield
    assert (found_in(folder), found_in(others)) == before


# names of objects, materials and lamps


def test_objects_files_stay_in_their_folder(scene: Path, place: Path, batch: Batch) -> None:
    out = place / "a" / "b"
    names = [f"--object={name}" for name in NAMES[:8]]
    with unchanged(scene.parent):
        assert batch(scene, *names, *QUICK, "--out", out).code == 0
        ended = batch(scene, "--object=../../x", *QUICK, "--out", out, "--overwrite", "--save-preview")
        assert ended.code == 0
    made = [path for path in place.parent.rglob("*") if path.is_file()]
    assert len(made) == 2 * len(names) + 1
    assert {path.parent for path in made} == {out}
    assert {path.name.split(".", 1)[0] for path in made} & {"con", "nul", ""} == set()
    assert {read_sidecar(path).object_name for path in out.glob("*.json")} == set(NAMES[:8])


def test_parts_lamps_layers_and_frames_stay_in_their_folder(scene: Path, place: Path, batch: Batch) -> None:
    ways = (
        ("--split", "material"),
        ("--lights", "../../lamp"),
        ("--layer", "base"),
        ("--frames", "1"),
        ("--together", "../../all", "--object", "X", "--split", "material"),
    )
    out = place / "a" / "b"
    for way in ways:
        ended = batch(scene, "--object=../../x", *way, *QUICK, "--out", out, "--overwrite")
        assert ended.code == 0, ended.err
    made = [path for path in place.parent.rglob("*") if path.is_file()]
    assert {path.parent for path in made} == {out}
    assert len(made) == 2 + 2 + 3 + 2 + 4


@pytest.mark.parametrize(
    ("names", "more", "words"),
    [
        (("é", "e\u0301"), (), "'é' and 'e\u0301' would both become"),
        (
            ("Card", "Card-Key"),
            ("--lights", "all", "--lights", "Key"),
            "'Card', light of Key and 'Card-Key' would both",
        ),
    ],
)
def test_bakes_that_would_replace_one_another(
    names: tuple[str, ...], more: tuple[str, ...], words: str, scene: Path, place: Path, batch: Batch
) -> None:
    asked = (scene, *(f"--object={name}" for name in names), *more, *QUICK, "--out", place / "new")
    with unchanged(place.parent):
        line = refusal(batch(*asked))
        assert refusal(batch(*asked, "--overwrite")) == line
    if len(more) == 4:
        words = words if words in line else "'Card-Key' and 'Card', light of Key would both"
    assert words in line
    assert "rename one of them, or bake them into folders of their own" in line


def test_names_that_differ_in_case_are_two_files_where_the_system_says_so(
    scene: Path, place: Path, batch: Batch
) -> None:
    (place / "lower").touch()
    joined = (place / "LOWER").exists()
    ended = batch(scene, "--object", "x", "--object", "X", *QUICK, "--out", place / "new")
    if joined:
        assert "would both become" in refusal(ended)
    else:
        assert ended.code == 0
        assert len(list((place / "new").iterdir())) == 4


# folders


@pytest.mark.parametrize(
    ("folder", "name"),
    [
        ("with space/ü日本🦊/e\u0301/trail. ", "new\nline. "),
        ("a/../-rf", "a\\b.blend"),
        ("new\nline%s\"'$(x)", "ü 日本🦊 e\u0301.blend"),
    ],
)
@posix
def test_a_folder_and_a_blend_of_any_name(
    folder: str, name: str, scene: Path, place: Path, batch: Batch
) -> None:
    (place / name).write_bytes(scene.read_bytes())
    ended = batch(place / name, "--object", "Card", *QUICK, "--save-preview", f"--out={place}/out/{folder}")
    assert ended.code == 0, ended.err
    assert len(list(Path(place, "out", folder).iterdir())) == 3


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("x" * 300, "a name in it has 300 bytes, 255 is the most"),
        ("d/" * 3000, "bytes, 4096 is the most"),
        ("long/" * 220, "bytes, and Blender handles 1023"),
        ("back\\slash", "Blender takes a backslash for a slash"),
        ("\udcff", "this name is not Unicode"),
        ("file", "file is a file; choose another folder"),
        ("file/below", "file is a file; choose another folder"),
        ("pipe", "pipe is a file; choose another folder"),
        ("gone", "gone is a link that leads nowhere"),
        ("loop/below", "loop is a link that leads nowhere"),
    ],
)
@posix
def test_a_folder_that_cannot_be(name: str, words: str, scene: Path, place: Path, batch: Batch) -> None:
    (place / "file").write_text("mine")
    os.mkfifo(place / "pipe")
    (place / "gone").symlink_to(place / "nowhere")
    (place / "loop").symlink_to(place / "loop")
    with unchanged(place.parent):
        ended = batch(scene, "--object", "Card", *QUICK, "--save-preview", f"--out={place}/{name}")
        assert words in refusal(ended)


@pytest.mark.parametrize("option", ["--out", "--thumbnail"])
def test_a_place_without_a_name(option: str, scene: Path, batch: Batch) -> None:
    assert f"{option} is empty" in refusal(batch(scene, "--object", "Card", *QUICK, option, ""))
    assert "SCENE is empty" in refusal(batch("", "--object", "Card", *QUICK))


@posix
def test_a_folder_that_one_may_only_read(scene: Path, place: Path, tmp_path: Path) -> None:
    place.chmod(0o555)
    bounds: list[str] = []
    if os.geteuid() == 0:  # who may write anywhere
        bounds = ["setpriv", "--bounding-set=-dac_override,-dac_read_search"]
        if shutil.which("setpriv") is None or subprocess.run([*bounds, "true"], check=False).returncode:
            pytest.skip("root's right to write anywhere cannot be taken away here")
    (home := tmp_path / "home").mkdir()
    ended = subprocess.run(
        [*bounds, sys.executable, BAKE, str(scene), "--object", "Card", *QUICK, "--out", str(place / "new")],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"TMPDIR": str(home)},
    )
    assert (ended.returncode, ended.stdout) == (2, "")
    assert ended.stderr == (
        f"radtex: {place / 'new'} cannot be written: Permission denied; choose another folder\n"
    )
    assert list(place.iterdir()) == list(home.iterdir()) == []


# things in the place of what a bake writes


@pytest.mark.parametrize("kind", ["link", "link to nowhere", "pipe"])
@posix
def test_links_and_pipes_are_replaced_and_never_written_through(
    kind: str, scene: Path, place: Path, batch: Batch
) -> None:
    other, out = place / "other.txt", place / "out"
    other.write_text("mine")
    out.mkdir()
    names = [f"Card.{ending}" for ending in ("radiance.exr", "radiance.json", "preview.blend", "png")]

    def put(name: str) -> None:
        if kind == "pipe":
            os.mkfifo(out / name)
        else:
            (out / name).symlink_to(other if kind == "link" else place / "nowhere")

    bake = (scene, "--object", "Card", *QUICK, "--save-preview", "--out", out, "--thumbnail", out / names[-1])
    for name in names[:-1]:  # the thumbnail is there to be written anew all the time
        put(name)
        with unchanged(place):
            assert f"{out / name} is already there: overwrite it (--overwrite)" in refusal(batch(*bake))
        (out / name).unlink()
    for name in names:
        put(name)
    assert batch(*bake, "--overwrite").code == 0
    assert sorted(path.name for path in out.iterdir()) == sorted(names)
    assert all(path.is_file() and not path.is_symlink() for path in out.iterdir())
    assert other.read_text() == "mine"
    assert not (place / "nowhere").exists()


@posix
def test_an_unfinished_bake_behind_a_link_is_not_touched(scene: Path, place: Path, batch: Batch) -> None:
    other, out = place / "other", place / "out"
    other.mkdir()
    out.mkdir()
    for name in ("key.json", "tile.piece", ".radtex-1"):
        (other / name).write_text("mine")
    unfinished = out / "Card.radiance.radtex-unfinished"
    for target in (other, place / "nowhere", None):
        if target is None:
            unfinished.touch()
        else:
            unfinished.symlink_to(target)
        for way in ((), ("--overwrite",), ("--resume",)):
            with unchanged(place):
                line = refusal(batch(scene, "--object", "Card", *QUICK, *way, "--out", out))
            assert "is a file, or a link, where a folder must go" in line
        unfinished.unlink()


@posix
def test_an_export_that_finds_no_place_is_refused_before_the_bake(
    scene: Path, place: Path, batch: Batch
) -> None:
    (place / "other").mkdir()
    (place / "Card.raw").symlink_to(place / "other")
    bake = (scene, "--object", "Card", *QUICK, "--save-preview", "--export", "raw", "--out", place)
    for way in ((), ("--overwrite",)):
        with unchanged(place):
            assert "Card.raw is a file, or a link" in refusal(batch(*bake, *way))


@posix
def test_a_thumbnail_that_cannot_be(scene: Path, place: Path, batch: Batch) -> None:
    bake = (scene, "--object", "Card", *QUICK, "--out", place / "new")
    with unchanged(place):
        line = refusal(batch(*bake, "--thumbnail", place / f"{'x' * 300}.png"))
        assert "this name is longer than 255 bytes" in line
        assert "give the name of a PNG" in refusal(batch(*bake, "--thumbnail", scene))


# .blend files


@posix
def test_a_blend_that_cannot_be(scene: Path, place: Path, batch: Batch) -> None:
    os.mkfifo(place / "pipe")
    (place / "gone").symlink_to(place / "nowhere")
    deep = place.parent / "/".join(["deep"] * 220)
    deep.mkdir(parents=True)
    content = scene.read_bytes()
    for path, words in (
        (place / "pipe", "there is no file"),
        (Path("/dev/zero"), "there is no file"),
        (place / "gone", "there is no file"),
        (deep / "scene.blend", "and Blender handles 1023"),
        (place / "\udcff.blend", "this name is not Unicode"),
    ):
        if path.parent in (deep, place) and words.startswith(("and", "this")):
            path.write_bytes(content)
        with unchanged(place):
            line = refusal(batch(path, "--object", "Card", *QUICK, "--out", place / "out"))
        assert words in line


@pytest.mark.parametrize("compress", [False, True])
def test_a_blend_that_is_cut_or_compressed(compress: bool, scene: Path, place: Path, batch: Batch) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(scene))
    path = place / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True, compress=compress)
    content = path.read_bytes()
    assert batch(path, "--object", "Card", *QUICK, "--out", place / "out").code == 0
    for left in (0, 1, 12, 17, len(content) // 2):
        path.write_bytes(content[:left])
        with unchanged(place):
            ended = batch(path, "--object", "Card", *QUICK, "--out", place / "out", "--overwrite")
        line = refusal(ended._replace(out="", err=ended.err[ended.err.rindex("radtex: ") :]))
        assert f"{path} does not open as a .blend" in line
        assert "name another" in line


def test_a_newer_blenders_file(scene: Path, place: Path, batch: Batch) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(scene))
    path = place / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True, compress=False)
    content = path.read_bytes()
    major, minor = bpy.app.version[:2]
    now = f"{major}{minor:02}".encode()
    for newer in (f"{major}{minor + 1:02}".encode(), f"{major + 1}00".encode()):
        assert now in content[:17]
        path.write_bytes(content[:17].replace(now, newer) + content[17:])
        ended = batch(path, "--object", "Card", *QUICK, "--out", place / "out", "--overwrite")
        assert (ended.code, "newer than this: some of it is lost" in ended.err) == (0, True)
