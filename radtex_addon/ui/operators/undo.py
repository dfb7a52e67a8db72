# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Push undo steps from operators.

Blender pushes an undo step when the user clicks an operator with the option UNDO, but not when a script calls
it. Data-blocks created or removed without an undo step make Blender crash at a later undo. So operators
that change the file do not set UNDO, and always push the step themselves.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import bpy


def push_step(message: str) -> None:
    """Push an undo step called `message` for all changes since the last one."""
    with in_a_window():
        bpy.ops.ed.undo_push(message=message)


@contextmanager
def in_a_window() -> Iterator[None]:
    """Context manager that sets a window for operators that need one: timers run without a window."""
    context: Any = bpy.context  # the stubs do not type temp_override as a context manager
    windows = context.window_manager.windows
    if context.window is not None or not windows:
        yield
        return
    with context.temp_override(window=windows[0]):
        yield
