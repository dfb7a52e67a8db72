# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps to undo that operators push themselves.

Blender pushes one where an operator with the option UNDO was clicked, but none where a script called it: data
that came and went unnoticed makes it crash at a later undo. So operators that change the file have no such
option, and push their step by whatever way they were called.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import bpy


def push_step(message: str) -> None:
    """Make what was done till now one step to undo, called `message`."""
    with in_a_window():
        bpy.ops.ed.undo_push(message=message)


@contextmanager
def in_a_window() -> Iterator[None]:
    """A context for operators that want a window, which timers have none of."""
    context: Any = bpy.context  # to the stubs, an override is no context manager
    windows = context.window_manager.windows
    if context.window is not None or not windows:
        yield
        return
    with context.temp_override(window=windows[0]):
        yield
