# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Entry point of the command line: from arguments to exit code."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

from ..core.errors import RadTexError
from ..core.messages import Message
from ..worker.order import WORK
from .arguments import parse
from .assemble_arguments import parse_assemble
from .compare_arguments import parse_compare
from .export_arguments import parse_export
from .failure import as_ours
from .interruption import Interruption, interruptible
from .opening import scripts_off
from .options import ASSEMBLE, COMPARE, EXPORT, PREPARE, REPORT
from .prepare_arguments import parse_prepare
from .report_arguments import parse_report
from .reporting import Report, reporting
from .run_assemble import run_assemble
from .run_bake import run_bake
from .run_compare import run_compare
from .run_export import run_export
from .run_prepare import run_prepare
from .run_report import run_report
from .run_task import run_tasks
from .run_work import WorkRequest, parse_work, run_work
from .terminal import tell
from .wording import told, worded
from .work_arguments import TaskRequest, is_of_tasks, parse_tasks


def _parse_work(arguments: list[str], inside_blender: bool) -> WorkRequest | TaskRequest:
    """Parse what follows `work`: a farm's folder and tasks, or the panel's order."""
    parsed = parse_tasks if is_of_tasks(arguments) else parse_work
    return parsed(arguments, inside_blender)


def _run_work(request: WorkRequest | TaskRequest, report: Report, interruption: Interruption) -> None:
    if isinstance(request, TaskRequest):
        run_tasks(request, report, interruption)
    else:
        run_work(request, report, interruption)


class _Command(NamedTuple):
    """A command: the parser of its arguments, and the function that runs the request."""

    parse: Callable[[list[str], bool], Any]
    run: Callable[[Any, Report, Interruption], None]


_COMMANDS = {
    REPORT: _Command(parse_report, run_report),
    EXPORT: _Command(parse_export, run_export),
    COMPARE: _Command(parse_compare, run_compare),
    PREPARE: _Command(parse_prepare, run_prepare),
    ASSEMBLE: _Command(parse_assemble, run_assemble),
    WORK: _Command(_parse_work, _run_work),
}
_BAKE = _Command(parse, run_bake)


def main(arguments: list[str], inside_blender: bool) -> int:
    """Run a command with `arguments`; returns the exit code. An error is one line on standard error."""
    named = arguments[0] if arguments else ""
    command = _COMMANDS.get(named, _BAKE)
    try:
        request = command.parse(arguments[1:] if named in _COMMANDS else arguments, inside_blender)
    except RadTexError as error:
        return _complain(error)
    with reporting(request.progress, request.verbose) as report:
        try:
            with scripts_off(inside_blender), _warnings_to(report), interruptible() as interruption:
                command.run(request, report, interruption)
                report.check()
        except (Exception, KeyboardInterrupt) as raised:  # noqa: BLE001  # else Blender would go on and exit with 0
            failure = as_ours(raised)
            report.event("error", **told(failure.message), exit_code=failure.exit_code)
            report.close()
            return _complain(failure)
    return 0


def _complain(error: RadTexError) -> int:
    tell(f"radtex: {worded(error.message)}")
    return error.exit_code


@contextmanager
def _warnings_to(report: Report) -> Iterator[None]:
    """Send the library's log warnings to the report, each message once."""
    library = logging.getLogger(__name__.rpartition(".cli.")[0])
    handler = _Warnings(report)
    library.addHandler(handler)
    try:
        yield
    finally:
        library.removeHandler(handler)


class _Warnings(logging.Handler):
    def __init__(self, report: Report) -> None:
        super().__init__(logging.WARNING)
        self._report = report
        self._said: set[Message] = set()

    def emit(self, record: logging.LogRecord) -> None:
        message = record.msg if isinstance(record.msg, Message) else Message(record.getMessage())
        if message not in self._said:
            self._said.add(message)
            self._report.event("warning", **told(message))
