# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every run is alike: Blender sees an empty home, not the user's; hypothesis draws the same examples."""

from __future__ import annotations

import os
import sys
import tempfile

import hypothesis
import pytest

if "bpy" in sys.modules:
    pytest.exit("bpy was imported before the user's settings could be hidden from it", returncode=4)

# Blender reads this once, at `import bpy`; the folder goes away with the process.
_BLENDER_HOME = tempfile.TemporaryDirectory(prefix="radtex-blender-home-")
os.environ["BLENDER_USER_RESOURCES"] = _BLENDER_HOME.name

# Where tests share finished bakes (finished_bakes.py), unless the run gives a folder.
_BAKES = tempfile.TemporaryDirectory(prefix="radtex-test-bakes-")
os.environ.setdefault("RADTEX_TEST_BAKES", _BAKES.name)

hypothesis.settings.register_profile("radtex", derandomize=True, deadline=None)
hypothesis.settings.load_profile("radtex")

pytest_plugins = ["tests.costs"]

# Folders of numbers and files alone. What numpy 1.26 and Python 3.11, which the oldest Blender brings, could
# change of them runs with every Blender: the maths (tests/core), and these.
_ONE_BLENDER = ("bake", "export", "formats", "fuzz", "layered", "report", "settings", "store")
_EVERY_BLENDER = ("test_atomic.py", "test_block_codecs.py", "test_lock.py", "test_rgb9e5.py")

_EXIT_CODE = pytest.StashKey[int]()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what runs with the newest Blender alone, before `-m` looks at it."""
    for item in items:
        if item.path.parent.name in _ONE_BLENDER and item.path.name not in _EVERY_BLENDER:
            item.add_marker(pytest.mark.one_blender)


@pytest.hookimpl(tryfirst=True)
def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """Remember how the tests went."""
    session.config.stash[_EXIT_CODE] = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config: pytest.Config) -> None:
    """End at once: a run once hung in what Blender or a driver tidies up at a process's exit."""
    if _EXIT_CODE in config.stash:
        _BLENDER_HOME.cleanup()
        _BAKES.cleanup()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(config.stash[_EXIT_CODE])
