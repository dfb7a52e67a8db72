# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Convert any exception that ends a run to a RadTexError."""

from __future__ import annotations

import errno

from ..core.errors import BakeError, Cancelled, InputError, RadTexError
from .interruption import INTERRUPTED
from .terminal import show_traceback


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
