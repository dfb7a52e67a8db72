# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The window and the command line each call a setting by their own name for it, and a bake by one title."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import pytest

from radtex_addon.bake.bake_title import bake_title, variant_title
from radtex_addon.bake.progress import Stage
from radtex_addon.cli import wording
from radtex_addon.core.errors import InputError
from radtex_addon.core.messages import Message, Setting, do, leave_out
from radtex_addon.farm.farm_progress import FarmTask
from radtex_addon.job.variants import title_of, variant_of
from radtex_addon.report.report_progress import ReportTask
from radtex_addon.settings.options import CALLED
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.textures.export_spec import ExportTask
from radtex_addon.ui import registration
from radtex_addon.ui.panel import fitting, labels
from radtex_addon.ui.panel.labels import remark
from radtex_addon.worker.orders import EXPORTING
from tests.blender.ui_stage import context, properties_of, registered

ANEW = do("begin anew", Setting.OVERWRITE, without=(Setting.RESUME,))
PACKAGE = Path(labels.__file__).parents[2]
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]+")
# The command line itself, the table that it is made from, the command line of a worker, and a page whose
# style sheet has such names.
WITH_OPTIONS = {"cli", "settings/options.py", "worker", "ui/jobs/jobs.py", "report/page.py"}


def strings(tree: ast.AST) -> Iterator[str]:
    """All strings of a module but its docstrings."""
    docstrings = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
            yield node.value


@pytest.mark.one_blender
def test_only_the_command_line_names_options() -> None:
    found = {
        f"{name}: {text}"
        for path in sorted(PACKAGE.rglob("*.py"))
        if not WITH_OPTIONS & {name := path.relative_to(PACKAGE).as_posix(), name.partition("/")[0]}
        for text in strings(ast.parse(path.read_text(encoding="utf-8")))
        if OPTION.search(text)
    }
    assert not found


def test_every_setting_has_an_option() -> None:
    paths = [*sorted((PACKAGE / "cli").glob("*.py")), PACKAGE / "settings" / "options.py"]
    sources = [path.read_text(encoding="utf-8") for path in paths]
    offered = {text.removeprefix("--") for source in sources for text in strings(ast.parse(source))}
    options = {wording.option(setting) for setting in {*Setting, *CALLED} - {Setting.SCRIPTS}}
    assert {option.removeprefix("--") for option in options} <= offered


def test_the_window_has_what_messages_name() -> None:
    with registered():
        shown = {one.name for cls in registration.CLASSES for one in properties_of(cls)}
    named = {label.partition(",")[0] for label in labels.LABELS.values()}
    assert named <= shown


def test_whatever_is_reported_speaks_the_windows_words() -> None:
    for path in sorted((PACKAGE / "ui").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if (
                isinstance(node, ast.Call)
                and isinstance(node.func, ast.Attribute)
                and node.func.attr == "report"
            ):
                told = ast.unparse(node.args[1])
                assert "error" not in told or told.startswith("remark("), f"{path.name}: {told}"


@pytest.mark.parametrize(
    ("error", "told", "shown"),
    [
        (
            InputError("it is unfinished", do("go on with it", Setting.RESUME), ANEW),
            "it is unfinished: go on with it (--resume), or begin anew (--overwrite, without --resume)",
            "It is unfinished: go on with it (Resume), or begin anew (Overwrite, without Resume)",
        ),
        (
            InputError("a.exr is already there", do("overwrite it", Setting.OVERWRITE)),
            "a.exr is already there: overwrite it (--overwrite)",
            "A.exr is already there: overwrite it",
        ),
        (
            InputError("no layer", leave_out(Setting.UV, to="to have one made")),
            "no layer: leave --uv out to have one made",
            "No layer: leave UV Map empty to have one made",
        ),
        (
            InputError("bits", leave_out(Setting.ARRANGEMENT, Setting.LEVELS)),
            "bits: leave --arrangement and --levels out",
            "Bits: leave Arrangement and Mip Levels as they were",
        ),
        (
            InputError("blocks", do("choose DDS RGBA16F", Setting.FORMAT, value="dds-rgba16f")),
            "blocks: choose DDS RGBA16F (--format dds-rgba16f)",
            "Blocks: choose DDS RGBA16F (Format)",
        ),
        (
            InputError("no picture", do("bake fewer texels"), do("read its messages", Setting.VERBOSE)),
            "no picture: bake fewer texels, or read its messages (--verbose)",
            "No picture: bake fewer texels, or read its messages",
        ),
        (InputError("/my--out/--uv is gone"), "/my--out/--uv is gone", "/my--out/--uv is gone"),
    ],
)
def test_a_message_has_the_names_of_whoever_shows_it(error: InputError, told: str, shown: str) -> None:
    assert wording.worded(error.message) == told
    assert remark(error) == shown
    assert Message.of_facts(json.loads(json.dumps(error.message.facts()))) == error.message


def test_files_of_the_folder_go_by_their_names(tmp_path: Path) -> None:
    assert remark(f"{tmp_path / 'A.exr'} is already there", tmp_path) == "A.exr is already there"
    assert remark(f"{tmp_path} cannot be written", tmp_path) == f"{tmp_path} cannot be written"


@pytest.mark.parametrize("room", [24, 60, 160, 400])
def test_messages_are_wrapped_to_the_sidebar(room: float) -> None:
    text = "Card.radiance.exr is already there: overwrite it, or choose another folder"
    lines = fitting.wrapped(text, room)
    assert all(fitting.text_width(line) <= room for line in lines)
    assert "".join(lines).replace(" ", "") == text.replace(" ", "")
    for line, following in pairwise(lines):
        if room >= 160:  # where every word fits, as much as fits is on each line
            assert fitting.text_width(f"{line} {following.split()[0]}") > room


@pytest.mark.parametrize(("room", "whole"), [(120, True), (70, False)])
def test_a_long_path_is_broken_after_a_slash_and_its_file_stays_readable(room: float, whole: bool) -> None:
    path = "//textures/kitchen/wood/oak_planks_colour_4k.png"
    lines = fitting.wrapped(f"image 'Oak' is missing: put {path} back", room)
    assert all(fitting.text_width(line) <= room for line in lines)
    assert "".join(lines).replace(" ", "").endswith(f"put{path}back")
    assert not any("…" in line for line in lines)
    assert any(line.startswith("oak_planks") for line in lines) or not whole


def test_a_name_that_is_too_long_keeps_its_end() -> None:
    shorter = fitting.shortened("Kitchen_Cabinet_Door.012", 80)
    assert fitting.text_width(shorter) <= 80
    assert shorter.startswith("Ki")
    assert shorter.endswith(".012")
    assert fitting.shortened("Door.012", 80) == "Door.012"
    assert fitting.fitting(80, "Kitchen_Cabinet_Door.012", "Door") == "Door"


def test_text_is_measured_at_the_scale_of_the_interface(monkeypatch: pytest.MonkeyPatch) -> None:
    narrow = SimpleNamespace(width=165)
    usual = SimpleNamespace(system=SimpleNamespace(ui_scale=1.0), ui_styles=context.preferences.ui_styles)
    large = SimpleNamespace(system=SimpleNamespace(ui_scale=1.5), ui_styles=context.preferences.ui_styles)
    rooms = {}
    for name, preferences in (("usual", usual), ("large", large)):
        fake = SimpleNamespace(context=SimpleNamespace(region=narrow, preferences=preferences))
        monkeypatch.setattr(fitting, "bpy", fake)
        rooms[name] = fitting.sidebar_room(), fitting.text_width("Bake the Scene")
    assert rooms["large"][0] == pytest.approx(rooms["usual"][0] - 55)
    assert rooms["large"][1] == pytest.approx(rooms["usual"][1], rel=0.06), "in pixels at UI scale 1"


def test_every_stage_of_a_job_has_its_words() -> None:
    compared = {ReportTask.REFERENCE, ReportTask.COMPARE}
    stages = {stage.value for stages in (Stage, ExportTask, compared, FarmTask) for stage in stages}
    assert set(labels.STAGES) == {*stages, EXPORTING}
    assert labels.stage(None) == "Starting"
    assert labels.stage("capture") == "Rendering the light"


@pytest.mark.parametrize(
    ("seconds", "said"),
    [(0.2, "under a second"), (42, "42 s"), (89.9, "90 s"), (600, "10 min"), (3600 * 1.75, "1.8 h")],
)
def test_times_are_rounded(seconds: float, said: str) -> None:
    assert labels.duration(seconds) == said


@pytest.mark.parametrize(
    ("count", "said"), [(999, "999 B"), (1500, "1.5 kB"), (128e6, "128 MB"), (2.5e12, "2500 GB")]
)
def test_sizes_are_rounded(count: float, said: str) -> None:
    assert labels.size(count) == said


def test_a_title_has_what_tells_bakes_of_an_object_apart() -> None:
    assert bake_title("Cup") == "Cup"
    assert bake_title("Cup", part="Glaze", kind="Shadow", variant="frame 3") == "Cup, Glaze, Shadow, frame 3"
    assert variant_title(None, ()) == ""
    assert variant_title(0, ("Key", "Fill")) == "frame 0, light of Key, Fill"


def test_a_bake_that_is_to_be_made_has_the_title_of_the_finished_one() -> None:
    spec = BakeSpec(frame=3, lights=("Key",))
    assert variant_of(spec) == variant_title(3, ("Key",))
    assert title_of("Cup", spec) == bake_title("Cup", variant=variant_title(3, ("Key",)))
