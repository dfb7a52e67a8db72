# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests inside Blender: each starts from an empty file with factory settings."""

from __future__ import annotations

import bpy
import pytest


@pytest.fixture(autouse=True)
def empty_file() -> None:
    """Leave nothing of the test before: no objects, no render settings, no preferences."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
