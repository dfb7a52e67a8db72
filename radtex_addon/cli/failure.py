# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Convert any exception that ends a run to a RadTexError, and end a run in the midst of a render."""

from __future__ import annotations

import errno
import os
import shutil
from typing import NoReturn

import bpy

from ..core.errors import BakeError, Cancelled, InputError, RadTexError
from ..formats.disk.lock import release_all
from ..formats.disk.temporary import remove_open
from .interruption import INTERRUPTED
from .reporting import Report
from .terminal import show_traceback, tell
from .wording import told, worded


def as_ours(raised: BaseException) -> RadTexError:
    """The error to show to the user; for an unexpected exception, also print the traceback."""
    if isinstance(raised, RadTexError):
        return raised
    if isinstance(raised, KeyboardInterrupt):
        return Cancelled(INTERRUPTED)
    if isinstance(raised, MemoryError):
        return BakeError("out of memory: use fewer texels or cells, or a smaller --memory")
    if isinstance(raised, OSError) and raised.errno == errno.ENAMETOOLONG:
        return InputError(f"{raised.filename}: the system takes no name that long: choose another")
    if isinstance(raised, OSError):
        return BakeError(f"the system refuses: {raised}; make room, or choose another folder")
    show_traceback(raised)
    return BakeError(f"a mistake in RadTex ({type(raised).__name__}): please report it, with its traceback")


def end_process(failure: RadTexError, report: Report) -> NoReturn:
    """Report a failure, and end the process at once, leaving no temporary files."""
    try:
        remove_open()
        release_all()
        shutil.rmtree(bpy.app.tempdir, ignore_errors=True)
        report.event("error", **told(failure.message), exit_code=failure.exit_code)
        report.close()
        tell(f"radtex: {worded(failure.message)}")
    finally:
        os._exit(failure.exit_code)
