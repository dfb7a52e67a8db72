# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is done in the folder of an unfinished bake before a bake begins there."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ..core.errors import InputError
from .checkpoint import Checkpoint
from .key import is_unfinished, read_key


def announce(folder: Path, replaces: Iterable[Path]) -> None:
    """Make an unfinished bake in `folder`, without pieces: killed before it starts, the run goes on with it.

    `replaces` are as a checkpoint's. Raises InputError where a process works on it, BakeError where the
    system refuses.
    """
    settle_earlier(folder)
    with Checkpoint(folder, False, replaces) as coming:
        coming.begin()


def settle_earlier(folder: Path) -> None:
    """Give the files of a bake that was killed amid their moves their places, all of them.

    Raises InputError where a process works on it, BakeError where the system refuses.
    """
    if not is_unfinished(folder):
        return
    try:
        key = read_key(folder)
    except InputError:  # who begins anew needs none
        return
    if key.made is not None:
        with Checkpoint(folder, resume=True) as left:
            left.settle(key.made)
