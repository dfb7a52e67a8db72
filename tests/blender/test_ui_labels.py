# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The window speaks of its own settings, never of the batch's options."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import blf
import pytest

from radtex_addon.bake.progress import Stage
from radtex_addon.report.progress import Task
from radtex_addon.textures.progress import Task as ExportTask
from radtex_addon.ui import labels, registration
from radtex_addon.ui import messages as messages_module
from radtex_addon.ui.labels import remark
from tests.blender.ui_stage import context, properties_of, registered

PACKAGE = Path(labels.__file__).parents[1]
OPTION = re.compile(r"--([a-z][a-z-]+)")
# Not shown in the window: the batch itself, and the report's page.
ELSEWHERE = {"cli", "report/page.py", "report/causes.py", "farm"}
SHIPPED = "export/web/"  # a page's sources


def messages(tree: ast.AST) -> Iterator[str]:
    """What a module may say, with X for what it fills in; docstrings say nothing."""
    silent = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            parts = [part.value if isinstance(part, ast.Constant) else "X" for part in node.values]
            silent |= {id(part) for part in node.values}
            yield "".join(str(part) for part in parts)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in silent:
            yield node.value


def found() -> list[tuple[str, str]]:
    """Every message that names an option, and its file."""
    paths = {path.relative_to(PACKAGE).as_posix(): path for path in sorted(PACKAGE.rglob("*.py"))}
    return [
        (name, message)
        for name, path in paths.items()
        if not (ELSEWHERE & {name, name.partition("/")[0]} or name.startswith(SHIPPED))
        for message in messages(ast.parse(path.read_text(encoding="utf-8")))
        if OPTION.search(message) and " " in message  # or it is an option of a worker's command line
    ]


FOUND = found()


def test_the_search_finds_what_is_there() -> None:
    assert len(FOUND) >= 20
    assert {"formats/disk/atomic.py", "job/unfinished.py", "bake/checkpoint.py"} <= {
        name for name, _ in FOUND
    }


@pytest.mark.parametrize(("name", "message"), FOUND, ids=[f"{name}-{said[:40]}" for name, said in FOUND])
def test_no_message_names_an_option_in_the_window(name: str, message: str) -> None:
    outside = re.sub(r"\([^()]*\)", "", message)  # what is in brackets may be left out
    unknown = (
        set(OPTION.findall(outside)) - set(labels.LABELS) - {"capture"}
    )  # always the portal in the window
    assert not unknown, name
    assert "--" not in remark(message)


def test_the_window_has_what_messages_name() -> None:
    with registered():
        shown = {one.name for cls in registration.CLASSES for one in properties_of(cls)}
    named = {label.partition(",")[0] for label in labels.LABELS.values()}
    assert named <= shown


def test_whatever_is_reported_speaks_the_windows_words() -> None:
    for path in sorted((PACKAGE / "ui").glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if (
                isinstance(node, ast.Call)
                and isinstance(node.func, ast.Attribute)
                and node.func.attr == "report"
            ):
                told = ast.unparse(node.args[1])
                assert "error" not in told or told.startswith("remark("), f"{path.name}: {told}"


@pytest.mark.parametrize(
    ("said", "shown"),
    [
        ("a.exr is already there: overwrite it (--overwrite)", "A.exr is already there: overwrite it"),
        (
            "x holds an unfinished bake: go on with it (--resume), or begin anew (--overwrite)",
            "X holds an unfinished bake: go on with it (Resume), or begin anew (Overwrite)",
        ),
        ("it differs: anew (--overwrite, without --resume)", "It differs: anew (Overwrite, without Resume)"),
        ("leave --uv out to have one made", "Leave UV Layer empty to have one made"),
        ("leave --arrangement and --levels out", "Leave Arrangement and Mip Levels as they were"),
        ("try --unwrap blender, or another", "Try Unwrap: Blender, or another"),
        ("choose --format dds-rgba16f", "Choose Format DDS RGBA16F"),
        ("no picture: bake fewer texels (--verbose tells more)", "No picture: bake fewer texels"),
        ("texels 9 with bucket 8 needs much", "Texels 9 with cells 8 needs much"),
        ("/my--out/--uv/a--b.exr is gone", "/my--out/--uv/a--b.exr is gone"),
    ],
)
def test_remarks_read_well(said: str, shown: str) -> None:
    assert remark(said) == shown


def test_files_of_the_folder_go_by_their_names(tmp_path: Path) -> None:
    assert remark(f"{tmp_path / 'A.exr'} is already there", tmp_path) == "A.exr is already there"
    assert remark(f"{tmp_path} cannot be written", tmp_path) == f"{tmp_path} cannot be written"


@pytest.mark.parametrize("room", [60, 160, 400])
def test_messages_are_wrapped_to_the_sidebar(room: float) -> None:
    text = "Card.radiance.exr is already there: overwrite it, or choose another folder"
    lines = messages_module.wrapped(text, room)
    blf.size(0, context.preferences.ui_styles[0].widget.points)
    assert " ".join(lines) == text
    assert all(blf.dimensions(0, line)[0] <= room for line in lines if " " in line)
    for line, following in pairwise(lines):
        assert blf.dimensions(0, f"{line} {following.split()[0]}")[0] > room


def test_every_stage_of_a_job_has_its_words() -> None:
    compared = {Task.REFERENCE, Task.COMPARE}
    assert set(labels.STAGES) == {stage.value for stages in (Stage, ExportTask, compared) for stage in stages}
    assert labels.stage(None) == "Starting"
    assert labels.stage("capture") == "Tracing paths"


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
