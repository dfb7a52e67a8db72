# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The errors that RadTex raises on purpose: one line that names the object, file or value and the remedy."""

from __future__ import annotations

from typing import Self

from .messages import Message, Remedy
from .quoting import printable

_HEAD, _TAIL = 4500, 500  # characters kept from the start and the end of an overlong message


class RadTexError(Exception):
    """Base class of our errors; `exit_code` is the exit status of the batch.

    `message` holds the problem and the remedies separately, so that the command line and the panel can insert
    their own names of settings. It is always one line: line breaks and terminal control characters in quoted
    names are escaped. The middle of an overlong message (longer than any path) is left out.
    """

    exit_code = 2

    def __init__(self, problem: str = "", *remedies: Remedy) -> None:
        if len(problem) > _HEAD + _TAIL:
            problem = f"{problem[:_HEAD]}…{problem[-_TAIL:]}"
        self.message = Message(printable(problem), remedies)
        super().__init__(str(self.message))

    @classmethod
    def of(cls, message: Message) -> Self:
        """The error with this message."""
        return cls(message.problem, *message.remedies)

    def saying(self, problem: str, *more: Remedy) -> Self:
        """The same error with another problem and `more` remedies after its own."""
        return type(self)(problem, *self.message.remedies, *more)


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


class QualityError(RadTexError):
    """Everything was done and written, but the result is worse than the user allows."""

    exit_code = 3


class Cancelled(RadTexError):
    """The user stopped the bake."""

    exit_code = 130
