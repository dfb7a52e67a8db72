# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bench of lookups draws every picture that it times, here at 64 x 64, and its table has all rows."""

from __future__ import annotations

import ast
import json
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from tests.bench.drawing import canvas
from tests.bench.gpu.__main__ import drawn, main, speed, table
from tests.bench.gpu.lookups import lookups_of
from tests.bench.gpu.stillness import main as film_all
from tests.bench.gpu.subject import Subject, names
from tests.bench.gpu.timing import Device, device

pytestmark = pytest.mark.one_blender

ROOT = Path(__file__).parents[2]
KEPT = ROOT / "docs" / "results" / "speed"
OBJECTS = ["convex", "film", "lights", "rough", "shared"]
SIZE = (64, 64)


@pytest.fixture(scope="module")
def opened() -> Iterator[Device]:
    with device() as found:
        yield found


@pytest.fixture(scope="module")
def ran(opened: Device, tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], Path]:
    """The figures of one frame of each lookup, and the folder with the pictures."""
    out = tmp_path_factory.mktemp("speed")
    return speed(opened, names(), SIZE, 1, 1, None, out), out


def picture(folder: Path, name: str) -> Any:
    with Image.open(folder / f"{name.replace(', ', '-').replace(' ', '-')}.png") as image:
        return np.asarray(image.convert("RGB"), dtype=float)


def test_all_rows_are_there(ran: tuple[dict[str, Any], Path]) -> None:
    figures, _ = ran
    assert list(figures["objects"]) == OBJECTS
    assert all(figures[key] for key in ("card", "driver", "clock"))
    rows = [list(each["lookups"]) for each in figures["objects"].values()]
    assert all(each == rows[0] for each in rows)
    assert {"diffuse", "physically based", "buckets, nearest", "layered", "layered, one lobe"} <= set(rows[0])
    for each in figures["objects"].values():
        assert each["covered"] > 0.85
        for name, row in each["lookups"].items():
            assert row["ms"] > 0
            assert row["fetches"] > 0
            assert row["fetches_made"] > 0
            if "levels" not in name:  # between two levels both are read
                assert row["fetches_made"] <= row["fetches"]
            assert row["bytes"] > 0
    assert table(figures).count("\n| ") == 1 + len(rows[0])


def test_no_picture_is_black_or_that_of_another_object(ran: tuple[dict[str, Any], Path]) -> None:
    figures, out = ran
    for name in figures["objects"]["convex"]["lookups"]:
        pictures = {each: picture(out / each, name) for each in OBJECTS}
        for each, found in pictures.items():
            assert found.mean() > 10, f"{each}, {name}"
            assert found.std() > 5, f"{each}, {name}"
        for one, other in combinations(OBJECTS, 2):
            assert np.abs(pictures[one] - pictures[other]).mean() > 10, f"{one} and {other}, {name}"


@pytest.mark.parametrize("each", OBJECTS)
def test_lookups_of_an_object_show_the_same_thing(ran: tuple[dict[str, Any], Path], each: str) -> None:
    """The variants by what they leave out; buckets, and a lightmap with a probe, by all that they lack."""
    figures, out = ran
    layered = picture(out / each, "layered")
    off = {
        name: np.abs(picture(out / each, name) - layered).mean()
        for name in figures["objects"][each]["lookups"]
    }
    print({name: round(float(value), 1) for name, value in off.items()})
    assert off["layered, all of it"] < 3
    assert off["layered, one lobe, no distances"] < 12
    assert off["buckets, quadrilinear"] < 35  # of film: a cell has several of its colours
    assert (
        abs(picture(out / each, "buckets, quadrilinear") - picture(out / each, "buckets, slices")).mean() < 3
    )


@pytest.mark.parametrize("times", [1, 2])
def test_textures_in_blocks_show_the_same(opened: Device, times: int) -> None:
    """Blocks are what cards are given; larger bakes show what the small one does, more finely."""
    subject, target = Subject.read("rough", times), canvas(opened.context, SIZE)
    view = subject.view(SIZE)
    plain = lookups_of(opened.context, Subject.read("rough"), blocks=False)
    for name, lookup in lookups_of(opened.context, subject, blocks=True).items():
        found, expected = (drawn(way.painter, view, target)[..., :3] for way in (lookup, plain[name]))
        off = np.abs(found - expected).mean() / expected.mean()
        print(f"{name}: {off:.4f}")
        assert off < (0.03 if times == 1 else 0.12), name  # slices have other blocks; nearest, smaller texels


def test_the_bench_needs_neither_blender_nor_openexr() -> None:
    """All that it imports, from file to file, is numpy, moderngl, Python's own, or ours."""
    seen: set[Path] = set()
    pending = [ROOT / "tests/bench/gpu/__main__.py"]
    while pending:
        path = pending.pop()
        if path in seen:
            continue
        seen.add(path)
        for module in imported(path):
            assert module.split(".")[0] not in {"bpy", "mathutils", "OpenEXR", "PIL", "scipy", "zstandard"}, (
                path
            )
            for near in (ROOT / module.replace(".", "/"),):
                pending += [
                    each for each in (near.with_suffix(".py"), near / "__init__.py") if each.is_file()
                ]
    assert ROOT / "tests/bench/gpu/lookups.py" in seen


def imported(path: Path) -> Iterator[str]:
    """Dotted names of what a file imports, and of the packages they are in."""
    here = path.relative_to(ROOT).with_suffix("").parts
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(here[: len(here) - node.level]) if node.level else ""
            module = ".".join(part for part in (base, node.module or "") if part)
            found = [module, *(f"{module}.{alias.name}" for alias in node.names)]
        else:
            continue
        for name in found:
            parts = name.split(".")
            yield from (".".join(parts[: count + 1]) for count in range(len(parts)))


def test_the_page_has_the_tables_of_the_results(capsys: pytest.CaptureFixture[str]) -> None:
    page = (ROOT / "docs" / "speed.md").read_text(encoding="utf-8")
    for path in sorted(KEPT.glob("*.json")):
        assert table(json.loads(path.read_text(encoding="utf-8"))) in page, path.name
        assert main(["--table", str(path)]) == 0
        assert capsys.readouterr().out.strip() in page


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["teapot"], "teapot: choose of convex"),
        (["--device", "99"], "no device 99; EGL knows these: "),
        (["--texels", "100"], "64 times a whole number"),
    ],
)
def test_what_is_not_there_is_refused(
    words: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(words)
    assert says in capsys.readouterr().err


def test_films_are_stiller_with_wider_lobes(opened: Device, capsys: pytest.CaptureFixture[str]) -> None:
    """A bowl under a thin film, ten times as far away."""
    film_all(["film"])
    rows = [line.split(" | ") for line in capsys.readouterr().out.splitlines()[2:]]
    assert [row[1] for row in rows] == ["RadTex", "RadTex, without RADTEX_STEADY", "physically based"]
    steady, plain, _ = (float(row[-1].strip(" |")) for row in rows)
    assert steady > plain + 1
