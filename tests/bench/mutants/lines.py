# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which lines of the package run, by Python's own monitoring, which costs little: each line is told once.

It needs nothing but Python 3.12 or later, because it also runs in processes that tests start.
"""

from __future__ import annotations

import sys
from types import CodeType
from typing import Any

PACKAGE = "/radtex_addon/"
_TOOL = 4  # a number that neither debuggers, coverage nor profilers take

Line = tuple[str, int]  # the file from radtex_addon/ on, and its line
_seen: set[Line] = set()
_python: Any = sys  # Python 3.11's stubs do not know the monitoring


def begin() -> None:
    """Note each line of the package that runs from now on, outside of modules' own bodies."""
    monitoring = _python.monitoring
    monitoring.use_tool_id(_TOOL, "radtex lines")
    monitoring.register_callback(_TOOL, monitoring.events.PY_START, _start)
    monitoring.register_callback(_TOOL, monitoring.events.LINE, _line)
    monitoring.set_events(_TOOL, monitoring.events.PY_START)


def take() -> set[Line]:
    """The lines that ran since the last call."""
    global _seen
    taken, _seen = _seen, set()
    _python.monitoring.restart_events()
    return taken


def _start(code: CodeType, offset: int) -> object:
    if PACKAGE in code.co_filename and code.co_name != "<module>":
        _python.monitoring.set_local_events(_TOOL, code, _python.monitoring.events.LINE)
    return _python.monitoring.DISABLE


def _line(code: CodeType, line: int) -> object:
    file = code.co_filename
    _seen.add((file[file.rindex(PACKAGE) + 1 :], line))
    return _python.monitoring.DISABLE
