# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the batch understands and says: its command line, its entry, its bar."""

from __future__ import annotations

import importlib
import io
import json
import re
import signal
import sys
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake.progress import Progress, Stage
from radtex_addon.cli import main as batch_module
from radtex_addon.cli import reporting, whole_progress
from radtex_addon.cli.arguments import parse
from radtex_addon.cli.compare_arguments import parse_compare
from radtex_addon.cli.export_arguments import parse_export
from radtex_addon.cli.interruption import Interruption
from radtex_addon.cli.options import ProgressStyle
from radtex_addon.cli.report_arguments import parse_report
from radtex_addon.core.errors import Cancelled, InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.job import OpenLayout
from radtex_addon.report.report_bake import ReportSpec
from radtex_addon.scene.demo import OBJECT
from radtex_addon.settings import spec
from radtex_addon.settings.spec import BakeSpec, Kind
from radtex_addon.textures.export_spec import Arrangement, Target, TextureFormat
from radtex_addon.version import VERSION
from tests.blender.batch_process import BAKE, process, refusal

pytestmark = pytest.mark.one_blender


HELP = {
    "": "--object --kind --layout --uv --unwrap --padding --texels --bucket --samples --capture --seed "
    "--device --memory --out --overwrite --save-preview --filter --no-denoise --float --compression "
    "--progress --help --verbose --version",
    "export": "--object --to --scene --format --no-zstd --arrangement --levels --limit --image-limit --mesh "
    "--out --overwrite --help --progress --verbose",
    "report": "--object --scene --views --pixels --samples --variants --min-psnr --out --progress --help",
    "compare": "--object --in-scene --bake --view --window --pixels --samples --min-psnr --out --parent-pipe",
}


@pytest.mark.parametrize("command", HELP)
def test_help_shows_every_option_with_its_default(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        batch_module.main([*command.split(), "--help"], inside_blender=False)
    assert left.value.code == 0
    told = capsys.readouterr().out
    assert [flag for flag in HELP[command].split() if flag not in told] == []
    assert max(len(line) for line in told.splitlines()) <= 80
    if not command:
        usage = "usage: bake.py SCENE --object NAME [options]\n       bake.py SCENE --all [options]\n"
        assert told.startswith(usage)
    told = " ".join(told.split())
    if command == "export":
        assert told.startswith("usage: bake.py export DIR [DIR ...] --to TARGET [options] ")
        assert [word for word in (*Target, *TextureFormat, *Arrangement) if word not in told] == []
    elif command == "report":
        assert told.startswith("usage: bake.py report DIR --scene SCENE [options] ")
        for name in ("views", "pixels", "samples", "device"):
            assert f"(default: {getattr(ReportSpec(), name)})" in told
    elif not command:
        for name in ("kind", "unwrap", "texels", "samples", "capture", "seed", "device", "compression"):
            assert f"(default: {getattr(BakeSpec(), name)})" in told
        for words in (
            "(default: 8 in layout buckets; layered chooses them itself)",
            "(default: layered; buckets for other kinds, for an object with hair or a volume, and for",
            "(default: radtex/NAME beside NAME.blend; without a file, radtex)",
            "(default: quadrilinear)",
            "(default: bar)",
            "exit codes:",
        ):
            assert words in told


def test_help_inside_blender_shows_blenders_way(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        parse(["--help"], inside_blender=True)
    assert left.value.code == 0
    told = capsys.readouterr().out
    assert told.startswith("usage: blender -b SCENE -P bake.py -- --object NAME [options]\n")
    assert "the file that Blender has open is baked" in " ".join(told.split())


def test_the_version_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        parse(["--version"], inside_blender=False)
    assert left.value.code == 0
    assert capsys.readouterr().out == f"RadTex {VERSION}\n"


def test_what_is_not_said_is_the_specs_default_and_the_layout_stays_open() -> None:
    request = parse(["a.blend", "--object", "A"], inside_blender=False)
    assert request.bakes.open_layout == OpenLayout()
    assert request.bakes.spec == BakeSpec(denoise=True), "scripts get raw means"
    assert (request.scene, request.bakes.objects, request.bakes.folder) == (
        Path("a.blend"),
        ("A",),
        Path("radtex/a"),
    )
    assert (request.bakes.preview, request.bakes.overwrite, request.progress) == (
        None,
        False,
        ProgressStyle.BAR,
    )


def test_what_is_said_reaches_the_spec() -> None:
    line = "--object A --object B --kind reflection --texels 9 --bucket 3 --samples 5 --uv Light"
    line += " --unwrap blender --padding 3 --seed 4 --memory 99 --float --compression dwaa --out x"
    line += " --save-preview --filter linear --overwrite --capture panoramic --device cpu"
    request = parse(line.split(), inside_blender=True)
    wanted = BakeSpec(
        denoise=True,
        kind=Kind.REFLECTION,
        texels=9,
        bucket=3,
        samples=5,
        uv_layer="Light",
        seed=4,
        half=False,
        compression=spec.Compression.DWAA,
        unwrap=spec.Unwrap.BLENDER,
        padding=3,
        memory_mb=99,
        capture=spec.CaptureMethod.PANORAMIC,
        device="cpu",
    )
    assert request.bakes.spec == wanted
    assert (request.scene, request.bakes.objects) == (None, ("A", "B"))
    assert (request.bakes.preview, request.bakes.overwrite) == (Filter.LINEAR, True)


@pytest.mark.parametrize(
    ("word", "mib"),
    [
        ("512", 512),
        ("2GB", 1907),
        ("2 gib", 2048),
        ("1.5GiB", 1536),
        ("800MB", 762),
        ("64M", 61),
        ("1T", 953674),
    ],
)
def test_memory_is_a_size_and_a_number_alone_counts_mebibytes(word: str, mib: int) -> None:
    line = ["a.blend", "--object", "A", "--texels=16", f"--memory={word}"]
    assert parse(line, inside_blender=False).bakes.spec.memory_mb == mib


@pytest.mark.parametrize("word", ["", "much", "-1", "2 XB", "1e9", "0GB", "2GB 3", "0x10", "9" * 13])
def test_memory_that_is_no_size_is_refused_with_examples(word: str) -> None:
    line = ["a.blend", "--object", "A", f"--memory={word}"]
    with pytest.raises(InputError, match=r"^--memory .*: give a size, such as 2GB or 800MB$"):
        parse(line, inside_blender=False)


@pytest.mark.parametrize("word", ["1MB", "1", "0", "15", "16MB", "17TiB", "9" * 12])
def test_memory_that_no_bake_can_have_is_refused_by_the_option_s_name(word: str) -> None:
    line = ["a.blend", "--object", "A", f"--memory={word}"]
    with pytest.raises(InputError, match=rf"^--memory {word}: give 16MiB at least, and 16TiB at most$"):
        parse(line, inside_blender=False)


@pytest.mark.parametrize(
    ("read", "words"),
    [
        (parse_report, ["baked", "--scene=demo"]),
        (parse_compare, ["demo"]),
        (parse_export, ["baked", "--to=raw"]),
    ],
)
def test_no_memory_is_refused_everywhere(read: Callable[[list[str], bool], Any], words: list[str]) -> None:
    assert read([*words, "--memory=1MiB"], False).spec.memory_mb == 1
    with pytest.raises(InputError, match=r"^--memory 1MB: give 1MiB at least, and 16TiB at most$"):
        read([*words, "--memory=1MB"], False)


def test_exports_are_listed_once_and_need_the_preview() -> None:
    line = ["a.blend", "--object", "A", "--export", "web", "--export", "raw", "--export", "web"]
    assert parse([*line, "--save-preview"], inside_blender=False).bakes.exports == (Target.WEB, Target.RAW)
    assert parse(line[:3], inside_blender=False).bakes.exports == ()
    with pytest.raises(InputError, match="give --save-preview too"):
        parse(line, inside_blender=False)
    with pytest.raises(InputError, match="the bake is of kind shadow, which unity does not show: choose web"):
        parse([*line[:3], "--kind", "shadow", "--save-preview", "--export", "unity"], inside_blender=False)


def test_inside_blender_a_scene_is_refused_for_it_is_open_already() -> None:
    with pytest.raises(InputError, match=r"open room\.blend by blender -b room\.blend"):
        parse(["room.blend", "--object", "A"], inside_blender=True)


def test_demo_needs_no_object_and_shows_itself() -> None:
    for inside in (True, False):
        request = parse(["demo"], inside_blender=inside)
        assert (request.demo, request.scene, request.bakes.objects) == (True, None, (OBJECT,))
        assert (request.bakes.preview, request.bakes.overwrite) == (Filter.QUADRILINEAR, True)
        assert request.bakes.open_layout == OpenLayout()


# the entry


def entry() -> Any:
    specification = importlib.util.spec_from_file_location("bake", BAKE)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (["blender", "-b", "x.blend", "-P", "bake.py", "--", "--object", "A"], (["--object", "A"], True)),
        (["blender", "-b", "x.blend", "-P", "bake.py"], ([], True)),
        (["bake.py", "x.blend", "--object", "A"], (["x.blend", "--object", "A"], False)),
    ],
)
def test_the_entry_knows_how_it_was_started(
    line: list[str], expected: tuple[list[str], bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    given: list[tuple[list[str], bool]] = []

    def main(arguments: list[str], inside_blender: bool) -> int:
        given.append((arguments, inside_blender))
        return 7

    monkeypatch.setattr(batch_module, "main", main)
    monkeypatch.setattr(sys, "argv", line)
    monkeypatch.setattr(sys, "path", list(sys.path))
    program = type("App", (), {"module": not expected[1]})
    monkeypatch.setattr(bpy, "app", program)
    assert entry().run() == 7
    assert given == [expected]


def test_a_missing_module_is_one_line_that_says_how_to_get_it() -> None:
    code = "import runpy, sys; sys.modules['bpy'] = None; sys.argv = sys.argv[1:]; "
    code += "runpy.run_path(sys.argv[0], run_name='__main__')"
    line = refusal(process("demo", start=["-c", code, BAKE]))
    assert "'bpy' is missing" in line
    assert "install the RadTex extension" in line
    assert "uv run bake.py" in line


# the bar


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def terminal(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    """A terminal of 80 columns on standard error, and a clock of 10 seconds a tick."""
    screen = Terminal()
    ticks = iter(range(0, 10_000, 10))
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setattr(whole_progress, "monotonic", lambda: float(next(ticks)))
    monkeypatch.setenv("COLUMNS", "80")
    return screen


def test_the_bar_shows_the_share_and_the_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = terminal(monkeypatch)
    with reporting.reporting(ProgressStyle.BAR, verbose=False) as report:
        for done in (0, 10, 20, 40):
            report.progress("Vase", Progress(Stage.CAPTURE, done, 100))
    drawn = [line.rstrip() for line in screen.getvalue().split("\r") if line.strip()]
    begin = f"Vase  {'rendering the light':<27} "
    assert drawn[0].startswith(f"{begin}[{' ' * 12}]   0%  ")
    assert drawn[2].startswith(f"{begin}[{'#' * 2}{' ' * 10}]  20%  ")
    assert drawn[3].startswith(f"{begin}[{'#' * 4}{' ' * 8}]  40%  ")
    assert re.search(r"40%  ([\d.]+|about|up) .*(s|min) left", drawn[3])
    assert screen.getvalue().endswith(" \r"), "wiped in the end"


def test_the_bar_never_wraps(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = terminal(monkeypatch)
    with reporting.reporting(ProgressStyle.BAR, verbose=False) as report:
        report.progress("V" * 200, Progress(Stage.CAPTURE, 1, 100))
        report.progress("W", Progress(Stage.CAPTURE, 1, 100))
    assert max(len(line) for line in screen.getvalue().split("\r")) <= 79


def test_the_bar_makes_way_for_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = terminal(monkeypatch)
    with reporting.reporting(ProgressStyle.BAR, verbose=False) as report:
        report.progress("Vase", Progress(Stage.CAPTURE, 50, 100))
        report.event("warning", message="no light")
    wiped, warning = screen.getvalue().rsplit("\r", 1)
    assert wiped.endswith(" ")
    assert warning == "radtex: warning: no light\n"


def test_names_that_are_no_unicode_still_make_json(capfd: pytest.CaptureFixture[str]) -> None:
    with reporting.reporting(ProgressStyle.JSON, verbose=False) as report:
        report.event("done", files=["caf\udce9", "Wände"])
    assert json.loads(capfd.readouterr().out)["files"] == ["caf\udce9", "Wände"]


def counting(ended: list[str]) -> Generator[int, None, str]:
    """Three steps, and a word."""
    try:
        yield from range(3)
    finally:
        ended.append("ended")
    return "done"


def test_steps_are_told_and_their_value_returned() -> None:
    told: list[int] = []
    assert Interruption().between(counting([]), told.append) == "done"
    assert told == [0, 1, 2]


def test_whoever_wants_the_end_gets_it_between_steps() -> None:
    interruption, told, ended = Interruption(), list[int](), list[str]()

    def tell(step: int) -> None:
        told.append(step)
        if step == 1:
            interruption.ask(signal.SIGTERM, None)

    with pytest.raises(Cancelled, match="nothing unfinished is left"):
        interruption.between(counting(ended), tell)
    assert (told, ended) == ([0, 1], ["ended"])
    with pytest.raises(Cancelled):
        interruption.between(counting(ended), tell)
    assert told == [0, 1], "not even begun"
