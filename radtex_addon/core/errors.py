# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The errors that RadTex raises on purpose: one line that names the object, file or value and the remedy."""

from __future__ import annotations

from .printable import printable

_HEAD, _TAIL = 4500, 500  # characters kept from the start and the end of an overlong message


class RadTexError(Exception):
    """Base class of our errors; `exit_code` is the exit status of the batch.

    The message is always one line: line breaks and terminal control characters in quoted names are escaped.
    The middle of an overlong message (more than any path has) is left out.
    """

    exit_code = 2

    def __init__(self, message: str = "") -> None:
        if len(message) > _HEAD + _TAIL:
            message = f"{message[:_HEAD]}…{message[-_TAIL:]}"
        super().__init__(printable(message))


class InputError(RadTexError):
    """What the user asked for cannot be done; nothing was started."""


class MemoryLimitError(InputError):
    """The job needs more memory than the machine has, or than the user allows."""


class FormatError(RadTexError):
    """A file is missing, damaged, or of another format or bake than expected."""


class ShapeError(RadTexError, ValueError):
    """An array has the wrong shape or type."""


class BakeError(RadTexError):
    """The bake began and failed."""

    exit_code = 1


class Cancelled(RadTexError):
    """The user stopped the bake."""

    exit_code = 130
