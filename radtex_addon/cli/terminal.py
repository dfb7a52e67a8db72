# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The one place where the batch prints: no name drives a terminal, and no lost line ends a run."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import TextIO

from ..core.errors import BakeError, Cancelled
from ..core.printable import printable


def tell(text: str) -> None:
    """Print a line on standard error, if it can be written."""
    _print(f"{printable(text)}\n")


def draw(text: str) -> None:
    r"""Write over the line of standard error that was drawn before; the text may begin with \r."""
    _print("\r" * text.startswith("\r") + printable(text.removeprefix("\r")))


def _print(text: str) -> None:
    """Print on standard error; where that takes nothing (any more), the rest goes nowhere."""
    if sys.stderr is None:
        return
    try:
        print(text, end="", file=sys.stderr, flush=True)
    except (OSError, ValueError):  # full, without a reader, or closed
        with suppress(OSError, ValueError):
            _send_nowhere(sys.stderr)


def show_traceback(raised: BaseException) -> None:
    """Print where an error of our own came from."""
    for part in traceback.format_exception(raised):
        for line in part.splitlines():
            tell(line)


class Output:
    """Our standard output. Where it can no longer be written, as on a full disk, that is said at the end."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._lost: OSError | None = None

    def say(self, lines: Iterable[str]) -> None:
        """Print lines that are fit to print. Raises Cancelled where whoever read them has gone (`| head`)."""
        try:
            print(*lines, sep="\n", file=self._stream, flush=True)
        except BrokenPipeError:
            _send_nowhere(self._stream)
            raise Cancelled(
                "nobody reads the standard output any more: the run was given up, and files that are there "
                "are complete"
            ) from None
        except OSError as error:
            _send_nowhere(self._stream)
            self._lost = self._lost or error

    def check(self) -> None:
        """Raise BakeError if something could not be said."""
        if self._lost is not None:
            reason = self._lost.strerror or self._lost
            raise BakeError(
                f"the standard output cannot be written ({reason}): all files are complete, but what "
                "was made is not said"
            )


def _send_nowhere(stream: TextIO) -> None:
    """Let the null device take what a stream still holds, and all that follows."""
    with Path(os.devnull).open("w") as nowhere:
        os.dup2(nowhere.fileno(), stream.fileno())
