# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every error that RadTex raises on purpose: one line that names the thing and says what to do."""

from __future__ import annotations

from .printable import printable

_HEAD, _TAIL = 4500, 500  # characters of a message that quotes something endless


class RadTexError(Exception):
    """Root of our errors; `exit_code` is what the batch leaves with.

    Whatever names the message quotes, it is one line: what would end it, or drive a terminal, is escaped. Of
    one that is longer than any path the middle is left out.
    """

    exit_code = 2

    def __init__(self, message: str = "") -> None:
        if len(message) > _HEAD + _TAIL:
            message = f"{message[:_HEAD]}…{message[-_TAIL:]}"
        super().__init__(printable(message))


class InputError(RadTexError):
    """What the user asked for cannot be done; nothing was started."""


class MemoryLimitError(InputError):
    """What was asked for needs more memory than the machine has, or than is allowed."""


class FormatError(RadTexError):
    """A file is not what it should be."""


class ShapeError(RadTexError, ValueError):
    """An array has the wrong shape or type."""


class BakeError(RadTexError):
    """The bake began and failed."""

    exit_code = 1


class Cancelled(RadTexError):
    """The user stopped the bake."""

    exit_code = 130
