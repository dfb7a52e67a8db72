# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests inside Blender: each starts from an empty file with factory settings."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import bpy
import pytest


class PlannedError(Exception):
    """What a test lets fail."""


@pytest.fixture(autouse=True)
def empty_file() -> None:
    """Leave nothing of the test before: no objects, no render settings, no preferences."""
    bpy.ops.wm.read_factory_settings(use_empty=True)


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
