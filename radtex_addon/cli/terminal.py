# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All printing of the command line: escapes control characters, and survives an unwritable terminal."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import TextIO

from ..core.errors import BakeError, Cancelled
from ..core.quoting import printable


def tell(text: str) -> None:
    """Print a line on standard error; does nothing if that cannot be written."""
    _print(f"{printable(text)}\n")


def draw(text: str) -> None:
    r"""Print text on standard error without a line end; a leading \r overwrites the current line."""
    _print("\r" * text.startswith("\r") + printable(text.removeprefix("\r")))


def _print(text: str) -> None:
    """Print on standard error; if writing fails, discard this and all later output."""
    if sys.stderr is None:
        return
    try:
        print(text, end="", file=sys.stderr, flush=True)
    except (OSError, ValueError):  # the disk is full, the reader has gone, or the stream is closed
        with suppress(OSError, ValueError):
            _send_nowhere(sys.stderr)


def show_traceback(raised: BaseException) -> None:
    """Print the traceback of an unexpected error."""
    for part in traceback.format_exception(raised):
        for line in part.splitlines():
            tell(line)


class Output:
    """Our standard output. If a write fails, as on a full disk, `check` reports it at the end of the run."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._lost: OSError | None = None

    def say(self, lines: Iterable[str]) -> None:
        """Print escaped lines. Raises Cancelled if the reader has closed the pipe (`| head`)."""
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
        """Raise BakeError if any output was lost."""
        if self._lost is not None:
            reason = self._lost.strerror or self._lost
            raise BakeError(
                f"the standard output cannot be written ({reason}): all files are complete, but what "
                "was made is not said"
            )


def _send_nowhere(stream: TextIO) -> None:
    """Redirect a stream to the null device, with its unwritten buffer and all later output."""
    with Path(os.devnull).open("w") as nowhere:
        os.dup2(nowhere.fileno(), stream.fileno())
