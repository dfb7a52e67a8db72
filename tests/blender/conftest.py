# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests inside Blender: each starts from an empty file with factory settings."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from math import inf
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.cli import interruption
from radtex_addon.cli import main as batch_module
from radtex_addon.ui.operators import bake_operator
from radtex_addon.ui.panel import forecast
from tests.blender import surroundings
from tests.blender.batch_process import Batch, Outcome

context: Any = bpy.context  # to the stubs, every pointer may be None


class PlannedError(Exception):
    """What a test lets fail."""


@pytest.fixture(scope="module", autouse=True)
def factory_settings() -> None:
    """Begin each file as a new Blender."""
    _read_factory_settings()


@pytest.fixture(autouse=True)
def empty_file() -> None:
    """Leave nothing of the test before: no objects, no render settings, no preferences.

    Those are read again only where a test changed them: with them all add-ons are, which takes five times as
    long as the empty file.
    """
    if context.preferences.is_dirty:
        _read_factory_settings()
    else:
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def _read_factory_settings() -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    context.preferences.is_dirty = False


@pytest.fixture(scope="module", autouse=True)
def small_surroundings() -> Iterator[None]:
    """Let layered bakes in this process take small pictures of the surroundings."""
    with pytest.MonkeyPatch.context() as patch:
        surroundings.make_small(patch)
        yield


@pytest.fixture(scope="module", autouse=True)
def enough_time() -> Iterator[None]:
    """Let the panel look at all objects, however busy the machine: in a window it stops after a moment."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(forecast, "_PATIENCE", inf)
        patch.setattr(bake_operator, "_PATIENCE", inf)
        yield


@pytest.fixture
def whole_surroundings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let them be as large as users', for a test that is about them."""
    surroundings.make_whole(monkeypatch)


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Where temporary files go: empty after every bake, however it ends."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    yield folder
    assert list(folder.iterdir()) == []


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """Where a bake writes to; not there yet."""
    return tmp_path / "out"


@pytest.fixture
def batch(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Batch:
    """Run the batch in this process, which no signal ends."""
    monkeypatch.setattr(interruption, "_PATIENCE", 600.0)

    def run(*arguments: object, inside_blender: bool = False) -> Outcome:
        capfd.readouterr()
        code = batch_module.main([str(argument) for argument in arguments], inside_blender)
        return Outcome(code, *capfd.readouterr())

    return run
