# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Prepare the folder of an unfinished bake before a bake starts there."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ..core.errors import InputError
from .checkpoint import Checkpoint
from .key import is_unfinished, read_key


def announce(folder: Path, replaces: Iterable[Path], blend: str = "") -> None:
    """Mark a bake as unfinished before it starts, so that resuming a killed run of several bakes includes it.

    Makes a checkpoint without pieces in `folder`; `replaces` and `blend` are as for `Checkpoint`. Raises
    InputError where a process works on it, BakeError where the system refuses.
    """
    publish_earlier(folder)
    with Checkpoint(folder, False, replaces, blend=blend) as coming:
        coming.begin()


def publish_earlier(folder: Path) -> None:
    """If a bake was killed while its finished files were moved to their final names, move the others too.

    Raises InputError where a process works on it, BakeError where the system refuses.
    """
    if not is_unfinished(folder):
        return
    try:
        key = read_key(folder)
    except InputError:  # a new bake does not need the old key
        return
    if key.made is not None:
        with Checkpoint(folder, resume=True) as left:
            left.publish(key.made)
