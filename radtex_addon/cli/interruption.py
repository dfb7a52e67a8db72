# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Handle Ctrl-C in a way that works inside Blender.

Cycles renders inside a Python callback, and Blender prints exceptions raised there and ignores them: a
KeyboardInterrupt would be lost and the bake would continue. So a signal only sets a flag, and the run checks
the flag between its steps.

A render may take minutes, and Python acts on a signal only after it. So a thread of its own hears of signals,
too, and ends the process in the midst of a render where nothing is lost by that.
"""

from __future__ import annotations

import os
import select
import signal
import sys
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from threading import Thread
from time import sleep
from types import FrameType
from typing import TypeVar

from ..bake.progress import finished, relayed
from ..core.abandonable import abandon
from ..core.errors import Cancelled

_Step = TypeVar("_Step")
_Result = TypeVar("_Result")

INTERRUPTED = "interrupted: nothing unfinished is left"
_GRACE = 3.0  # seconds that a step has to end after standard input has closed
_PATIENCE = 1.0  # seconds that a step has to end after a signal, before its render is left
_LOOK = 0.2  # seconds between looks at the flag
_SIGNALS = (signal.SIGINT, signal.SIGTERM)  # Ctrl-C, and the signal by which farms stop a job


class Interruption:
    """A flag: whether the run should be cancelled."""

    def __init__(self) -> None:
        self._asked = False
        self._leave: Callable[[], None] | None = None

    def ask(self, number: int, _frame: FrameType | None) -> None:
        """Signal handler: request cancellation. A second signal ends the process at once."""
        self._asked = True
        signal.signal(number, signal.SIG_DFL)

    def ask_when_input_ends(self) -> None:
        """Cancel the run when standard input closes: the parent process has cancelled it, or has died.

        If a step, such as a long render, does not end within `_GRACE` seconds, the process exits.
        """

        def watch() -> None:
            while os.read(0, 1024):
                pass
            self._asked = True
            sleep(_GRACE)
            os._exit(Cancelled.exit_code)

        Thread(target=watch, daemon=True).start()

    @contextmanager
    def leaving(self, leave: Callable[[], None]) -> Iterator[None]:
        """Inside, a signal that comes in a long render calls `leave` from a thread: it ends the process."""
        self._leave = leave
        try:
            yield
        finally:
            self._leave = None

    def leave_renders(self, signals: int) -> None:
        """Leave renders once a signal has come, at once after a second; ends when the pipe is closed."""
        while (found := os.read(signals, 1)) and found[0] not in _SIGNALS:
            pass
        select.select([signals], [], [], _PATIENCE)
        while found:
            if self._leave is not None:
                abandon(self._leave)
            if select.select([signals], [], [], _LOOK)[0]:
                found = os.read(signals, 1)
        os.close(signals)

    def wait(self) -> None:
        """Return when cancellation is requested."""
        while not self._asked:
            sleep(_LOOK)

    def check(self) -> None:
        """Raise Cancelled if cancellation was requested."""
        if self._asked:
            raise Cancelled(INTERRUPTED)

    def between(self, steps: Generator[_Step, None, _Result], tell: Callable[[_Step], None]) -> _Result:
        """Run a generator to its end, call `tell` with each of its steps, and return its value.

        Raises Cancelled, after closing the generator, if cancellation is requested before its end.
        """

        def told(step: _Step) -> None:
            tell(step)
            self.check()

        self.check()
        return finished(relayed(steps, told))


@contextmanager
def interruptible() -> Iterator[Interruption]:
    """Handle signals, except those that the parent process set to be ignored. Main thread only."""
    interruption = Interruption()
    before = {number: signal.getsignal(number) for number in _SIGNALS}
    heard = [number for number, handler in before.items() if handler is not signal.SIG_IGN]
    for number in heard:
        signal.signal(number, interruption.ask)
    try:
        with _heard_in_renders(interruption):
            yield interruption
    finally:
        for number in heard:
            handler = before[number]  # None if set by Blender's C code: Python cannot restore that
            signal.signal(number, signal.SIG_DFL if handler is None else handler)


@contextmanager
def _heard_in_renders(interruption: Interruption) -> Iterator[None]:
    if sys.platform == "win32":  # where C code hears of Ctrl-C alone
        yield
        return
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    before = signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    Thread(target=interruption.leave_renders, args=(reader,), name="RadTex signals", daemon=True).start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        os.close(writer)
