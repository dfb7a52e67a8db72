# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One command makes a release: it cuts the changelog and sets the version everywhere, or changes nothing."""

from __future__ import annotations

import datetime as dt
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from radtex_addon.formats.changelog import parse_changelog
from radtex_addon.version import VERSION

pytestmark = pytest.mark.one_blender

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / ".ci/release.py"
PLACES = re.findall(r'^    "([\w./-]+)": rf', SCRIPT.read_text(encoding="utf-8"), re.MULTILINE)


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """The files that a release changes, with something to release."""
    for name in (*PLACES, "CHANGELOG.md"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, tmp_path / name)
    changelog = tmp_path / "CHANGELOG.md"
    text = changelog.read_text(encoding="utf-8")
    new = (
        "## [Unreleased]\n\n### Fixed\n\n- Something that\n  was wrong ([a](docs/a.md#b), [b](https://b.c))."
    )
    earlier = text[text.index(f"## [{VERSION}]") :]
    head = text[: text.index("## [Unreleased]")]
    changelog.write_text(f"{head}{new}\n\n{earlier}", encoding="utf-8")
    return tmp_path


def run(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, str(SCRIPT), *map(str, arguments)], capture_output=True, text=True, check=False
    )


def texts(folder: Path) -> dict[str, str]:
    return {name: (folder / name).read_text(encoding="utf-8") for name in (*PLACES, "CHANGELOG.md")}


def test_this_version_stands_everywhere_and_in_the_changelog() -> None:
    process = run("--check", f"v{VERSION}")
    assert (process.returncode, process.stderr) == (0, "")
    process = run("--check", "v98.7.6")
    assert process.returncode == 1
    assert process.stderr.count(f"has {VERSION}") == len(PLACES) + 1
    assert len(PLACES) == 13


def test_a_release_cuts_the_changelog_and_sets_every_version(clone: Path) -> None:
    before = texts(clone)
    process = run("98.7.6", "--root", clone)
    assert process.returncode == 0, process.stderr
    assert run("--check", "v98.7.6", "--root", clone).returncode == 0
    after = texts(clone)
    for name in PLACES:
        changed = [
            line
            for line, earlier in zip(after[name].splitlines(), before[name].splitlines(), strict=True)
            if line != earlier
        ]
        assert changed, name
        assert all("98.7.6" in line for line in changed), name
    unreleased, made, *earlier = parse_changelog(after["CHANGELOG.md"])
    assert unreleased.groups == {}
    assert (made.version, made.date) == ("98.7.6", dt.datetime.now(dt.UTC).date().isoformat())
    assert made.groups == {"Fixed": ["Something that was wrong ([a](docs/a.md#b), [b](https://b.c))."]}
    assert earlier == parse_changelog(before["CHANGELOG.md"])[1:]
    notes = run("--notes", "--root", clone).stdout
    assert notes == "### Fixed\n\n- Something that\n  was wrong ([a](docs/a.md#b), [b](https://b.c)).\n"
    based = run("--notes", "--base", "https://host/blob/v98.7.6/", "--root", clone).stdout
    assert based == notes.replace("(docs/", "(https://host/blob/v98.7.6/docs/")


@pytest.mark.parametrize(
    ("version", "said"),
    [("98.7", "98.7 is no version"), (VERSION, f"{VERSION} is not later"), ("0.0.9", "0.0.9 is not later")],
)
def test_what_is_no_next_version_changes_nothing(version: str, said: str, clone: Path) -> None:
    before = texts(clone)
    process = run(version, "--root", clone)
    assert process.returncode == 1
    assert process.stderr.startswith(said)
    assert texts(clone) == before


def test_nothing_new_is_no_release(clone: Path) -> None:
    shutil.copyfile(ROOT / "CHANGELOG.md", clone / "CHANGELOG.md")
    text = (clone / "CHANGELOG.md").read_text(encoding="utf-8")
    emptied = re.sub(r"(## \[Unreleased\]\n).*?(?=^## )", r"\1\n", text, flags=re.MULTILINE | re.DOTALL)
    (clone / "CHANGELOG.md").write_text(emptied, encoding="utf-8")
    process = run("98.7.6", "--root", clone)
    assert process.returncode == 1
    assert "nothing to release" in process.stderr
