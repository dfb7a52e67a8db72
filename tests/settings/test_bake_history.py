# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The file of finished bakes survives damage, other writers, and years of bakes."""

from __future__ import annotations

import json
import logging
import subprocess
import sys
from pathlib import Path

import pytest

from radtex_addon.settings import bake_history
from radtex_addon.settings.bake_history import read_history, remember
from radtex_addon.settings.estimate import BakeWork, Measurement
from radtex_addon.settings.spec import BakeSpec

ROOT = Path(__file__).parents[2]
WRITER = """
import sys
from pathlib import Path
from radtex_addon.settings.bake_history import remember
from tests.settings.test_bake_history import bake
for number in range(20):
    remember(Path(sys.argv[1]), bake(f"{sys.argv[2]} {number}"))
"""


def bake(name: str) -> Measurement:
    work = BakeWork.of(BakeSpec(), 12, covered=9000, preview=True, device="CPU")
    return Measurement("a place", name, work, {"start": 1.5, "capture": 20.125})


def test_what_is_remembered_is_read_again(tmp_path: Path) -> None:
    file = tmp_path / "new" / "times.jsonl"
    assert read_history(file) == ()
    remember(file, bake("A"))
    remember(file, bake("Ä"))
    assert read_history(file) == (bake("A"), bake("Ä"))
    assert [path.name for path in file.parent.iterdir()] == ["times.jsonl"]
    remember(tmp_path, bake("A"))  # a folder in its place is no error
    assert read_history(tmp_path) == ()


@pytest.mark.parametrize(
    "change",
    [
        lambda _: "half a li",
        lambda _: "[]",
        lambda _: "\0\xff",
        lambda one: json.dumps(one | {"seconds": {"capture": -1}}),
        lambda one: json.dumps(one | {"seconds": {"capture": float("nan")}}),
        lambda one: json.dumps(one | {"seconds": {"cooking": 1.0}}),
        lambda one: json.dumps(one | {"work": one["work"] | {"texels": "many"}}),
        lambda one: json.dumps(one | {"work": one["work"] | {"covered": 0}}),
        lambda one: json.dumps(one | {"work": one["work"] | {"kind": "cake"}}),
        lambda one: json.dumps(one | {"work": one["work"] | {"surroundings": 0.0}}),
        lambda one: json.dumps(one | {"work": one["work"] | {"of a later version": 1}}),
    ],
)
def test_lines_that_are_no_bakes_are_left_out(
    change: object, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    assert callable(change)
    file = tmp_path / "times.jsonl"
    remember(file, bake("A"))
    good = file.read_text()
    file.write_text(good + change(json.loads(good)) + "\n", encoding="utf-8")
    with caplog.at_level(logging.INFO):
        assert read_history(file) == (bake("A"),)
    assert "1 lines" in caplog.text
    remember(file, bake("B"))
    assert [one.name for one in read_history(file)] == ["A", "B"]


def test_only_the_latest_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bake_history, "MOST", 3)
    for name in "ABCDE":
        remember(tmp_path / "times.jsonl", bake(name))
    assert [one.name for one in read_history(tmp_path / "times.jsonl")] == ["C", "D", "E"]


def test_several_processes_may_write(tmp_path: Path) -> None:
    file = tmp_path / "times.jsonl"
    writers = [
        subprocess.Popen([sys.executable, "-c", WRITER, str(file), name], cwd=ROOT) for name in ("A", "B")
    ]
    assert [writer.wait(60) for writer in writers] == [0, 0]
    names = {one.name for one in read_history(file)}
    assert names == {f"{name} {number}" for name in "AB" for number in range(20)}
