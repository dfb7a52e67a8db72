# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""CI on a host runs what runs here, and nothing that somebody else can exchange."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.one_blender

ROOT = Path(__file__).resolve().parents[2]
WORKFLOWS = {
    path.name: path.read_text(encoding="utf-8") for path in (ROOT / ".github/workflows").glob("*.yml")
}


def test_actions_are_pinned_by_their_commit_and_name_its_version() -> None:
    used = [line for text in WORKFLOWS.values() for line in re.findall(r"uses: (.*)$", text, re.MULTILINE)]
    others = [line for line in used if not line.startswith("./")]
    assert others
    assert not [
        line for line in others if not re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+", line)
    ]


def test_what_runs_on_the_host_is_in_the_repository() -> None:
    steps = [step for text in WORKFLOWS.values() for step in re.findall(r"\.ci/[\w.]+", text)]
    assert {".ci/run", ".ci/build_zip.py", ".ci/release.py"} <= set(steps)
    assert not [step for step in set(steps) if not (ROOT / step).is_file()]


def test_every_system_that_the_zips_are_for_runs_all_checks() -> None:
    (systems,) = re.findall(r"system: \[(.*)\]", WORKFLOWS["ci.yml"])
    assert [name.partition("-")[0] for name in systems.split(", ")] == ["ubuntu", "macos", "windows"]


def test_a_workflow_may_read_and_only_the_release_writes() -> None:
    for name, text in WORKFLOWS.items():
        assert "\npermissions:\n  contents: read\n" in text
        assert text.count(": write") == (1 if name == "release.yml" else 0)


def test_what_starts_blender_has_its_libraries() -> None:
    """Hosts with Linux lack some: an earlier step of the same job installs them."""
    for command in (".ci/run", ".ci/build_docs.py"):
        job, _, _ = WORKFLOWS["ci.yml"].partition(f"{command}\n")
        assert "apt-get install" in job.rpartition("runs-on:")[2]


def test_every_test_can_be_collected_on_windows() -> None:
    """One module that does not import ends pytest's run before its first test."""
    posix = {"fcntl", "grp", "pty", "pwd", "resource", "termios"}
    by_hand = {ROOT / "tests/bench", ROOT / "tests/fuzz"}  # programs, but for their test_*.py
    for path in (ROOT / "tests").rglob("*.py"):
        if path.name.startswith("test_") or not by_hand & set(path.parents):
            imported = [
                alias.name
                for node in ast.parse(path.read_text(encoding="utf-8")).body  # not what is below an if
                if isinstance(node, ast.Import)
                for alias in node.names
            ]
            assert not posix & set(imported), path
