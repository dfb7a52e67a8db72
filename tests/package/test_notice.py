# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whoever's work is in the zip is named: in NOTICE.md, and in the manifest that the platform shows."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from zipfile import ZipFile

import pytest

pytestmark = pytest.mark.one_blender

ROOT = Path(__file__).resolve().parents[2]
NOTICE = (ROOT / "NOTICE.md").read_text(encoding="utf-8")
MANIFEST = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in NOTICE.splitlines()
    if line.startswith("| ") and not line.startswith("| part |")
]
# https://docs.blender.org/manual/en/latest/advanced/extensions/licenses.html
ACCEPTED = {"GPL-3.0-or-later", "MIT", "BSD-2-Clause", "BSD-3-Clause"}
# Crates that run while others are compiled: nothing of them is in a wheel.
COMPILING = {
    *("autocfg", "enum-as-inner", "heck", "proc-macro2", "quote", "syn"),
    *("target-lexicon", "unicode-ident", "version_check"),
}
# What in a compiled module tells that a library is linked into it.
LINKED = {b"zstd": "Zstandard", b"pybind11": "pybind11", b"nanobind": "robin-map", b"tinyexr": "tinyexr"}
_LINE = re.compile(r"^\s*copyright\s*(?:\(c\)|©)\s*(?P<rest>.+)$", re.IGNORECASE | re.MULTILINE)


def texts(zips: dict[str, Path], platform: str) -> dict[str, str]:
    """All licence texts in a platform's zip, those inside its wheels, too, by name."""
    found: dict[str, str] = {}
    with ZipFile(zips[platform]) as archive:
        for name in archive.namelist():
            if name.endswith(".whl"):
                with archive.open(name) as stream, ZipFile(stream) as wheel:
                    inner = [each for each in wheel.namelist() if "/licenses/" in each and each[-1] != "/"]
                    found |= {f"{name}/{each}": wheel.read(each).decode() for each in inner}
            elif Path(name).stem.upper() in {"LICENSE", "LICENSES"} and name != "LICENSE":
                found[name] = archive.read(name).decode()
    return found


def wheel_files(path: Path) -> Iterator[tuple[str, bytes]]:
    """The files in all wheels of a zip, by name."""
    with ZipFile(path) as archive:
        for name in [name for name in archive.namelist() if name.endswith(".whl")]:
            with archive.open(name) as stream, ZipFile(stream) as wheel:
                yield from ((each, wheel.read(each)) for each in wheel.namelist())


def words(line: str) -> str:
    """A holder's name: without years, marks and how to reach them."""
    name = re.sub(r"<[^>]*>|All rights reserved\.?|[\d–-]+present|\d{4}|\(faer.*", "", line)
    return " ".join(re.findall(r"[^\W\d_][\w'.&]*", name)).lower().rstrip(".")


def test_the_manifest_names_ours_and_all_holders_of_the_notice() -> None:
    holders = list(dict.fromkeys(row[-2] for row in ROWS))
    assert MANIFEST["copyright"] == ["2026 RadTex authors", *holders]
    assert all(re.match(r"\d{4}(-\d{4})? \S", holder) for holder in holders)


def test_the_manifest_names_all_licences_and_the_platform_accepts_them() -> None:
    said = {
        licence.partition(",")[0] for licence in (row[-1] for row in ROWS) if "system library" not in licence
    }
    assert {f"SPDX:{licence}" for licence in said} <= set(MANIFEST["license"])
    assert set(MANIFEST["license"]) == {f"SPDX:{licence}" for licence in ACCEPTED}
    for licence in ACCEPTED - {"GPL-3.0-or-later"}:  # whose text is LICENSE
        assert re.search(rf"^### .*{licence}", NOTICE, re.MULTILINE)


@pytest.mark.parametrize("platform", MANIFEST["platforms"])
def test_every_copyright_line_of_a_licence_text_is_in_the_notice(
    zips: dict[str, Path], platform: str
) -> None:
    named = " ; ".join(words(holder) for holder in MANIFEST["copyright"])
    found = texts(zips, platform)
    assert {"radtex_addon/export/web/built/LICENSES.txt", "shaders/LICENSE"} <= set(found)
    assert sum("flip_evaluator" in name for name in found) == (0 if platform == "macos-x64" else 2)
    for name, text in found.items():
        lines = [words(match["rest"]) for match in _LINE.finditer(text)]
        assert lines, name
        assert not [line for line in lines if line not in named], name


def test_every_wheel_and_every_package_of_the_page_has_a_row(zips: dict[str, Path]) -> None:
    patterns = " ".join(row[1] for row in ROWS if len(row) == 4)
    for wheel in MANIFEST["wheels"]:
        assert f"`{wheel.removeprefix('./wheels/').partition('-')[0]}-*.whl`" in patterns
    with ZipFile(zips["linux-x64"]) as archive:
        texts_of_page = archive.read("radtex_addon/export/web/built/LICENSES.txt").decode()
    (listed,) = re.findall(r"^It also holds (.*)\.$", texts_of_page, re.MULTILINE)
    parts = {part for row in ROWS if len(row) == 3 for part in row[0].split(", ")}
    assert set(listed.split(", ")) <= parts


def test_every_library_that_a_wheel_brings_along_has_a_row(zips: dict[str, Path]) -> None:
    told = " ".join(row[0] for row in ROWS)
    for path in zips.values():
        with ZipFile(path) as archive:
            for name in [name for name in archive.namelist() if name.endswith(".whl")]:
                with archive.open(name) as stream, ZipFile(stream) as wheel:
                    files = [Path(each).name for each in wheel.namelist()]
                others = [each for each in files if re.search(r"\.dll$|\.so\.\d|\.dylib$", each)]
                assert not [each for each in others if re.split(r"[-.]", each)[0] not in told], name


def test_every_crate_that_a_wheel_lists_has_a_row(zips: dict[str, Path]) -> None:
    rows = {part for row in ROWS if row[1].startswith("`uvunwrap") for part in re.split(", ", row[0].lower())}
    for platform, archive in zips.items():
        listed = {
            crate["name"]
            for name, content in wheel_files(archive)
            if name.endswith(".cyclonedx.json")
            for crate in json.loads(content)["components"]
        }
        assert "faer" in listed, platform
        families = {name for name in listed if re.match(rf"({'|'.join(map(re.escape, rows))})([-_]|$)", name)}
        assert listed - families - COMPILING - {"uvunwrap"} == set(), platform


def test_every_library_that_is_linked_into_a_wheel_has_a_row(zips: dict[str, Path]) -> None:
    told = " ".join(row[0] for row in ROWS if len(row) == 4)
    found = {
        mark
        for archive in zips.values()
        for name, content in wheel_files(archive)
        if name.endswith((".so", ".pyd"))
        for mark in LINKED
        if mark in content
    }
    assert found == set(LINKED), "the marks find what they are for"
    assert not [LINKED[mark] for mark in found if LINKED[mark] not in told]


def test_the_notice_says_which_wheels_are_changed(zips: dict[str, Path]) -> None:
    """By name: those for Linux differ from what was published, all others do not."""
    assert "RadTex changes the wheels for Linux, and no others" in NOTICE
    for platform, path in zips.items():
        with ZipFile(path) as archive:
            for name in [name for name in archive.namelist() if name.endswith(".whl")]:
                published = (ROOT / "wheels/fetched" / Path(name).name).read_bytes()
                assert (archive.read(name) == published) == (platform != "linux-x64"), name
