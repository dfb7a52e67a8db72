# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C that Blender cannot swallow.

Cycles renders inside a Python callback, and what is raised there Blender prints and forgets: a
KeyboardInterrupt would be lost, and the bake go on. So a signal leaves a mark, and the run looks at it
between its steps.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from threading import Thread
from time import sleep
from types import FrameType
from typing import TypeVar

from ..bake.progress import finished, relayed
from ..core.errors import Cancelled

_Step = TypeVar("_Step")
_Result = TypeVar("_Result")

INTERRUPTED = "interrupted: nothing unfinished is left"
_GRACE = 3.0  # seconds that a step has to end when nobody is there any more
_SIGNALS = (signal.SIGINT, signal.SIGTERM)  # Ctrl-C, and how a farm ends a job


class Interruption:
    """Whether somebody wants the run to end."""

    def __init__(self) -> None:
        self._asked = False

    def ask(self, number: int, _frame: FrameType | None) -> None:
        """A signal's handler. The second signal ends the process at once, as if we were not there."""
        self._asked = True
        signal.signal(number, signal.SIG_DFL)

    def ask_when_input_ends(self) -> None:
        """End the run when our standard input does: who started us has cancelled, or has died.

        A step that goes on after that, such as a long render, is ended with the process.
        """

        def watch() -> None:
            while os.read(0, 1024):
                pass
            self._asked = True
            sleep(_GRACE)
            os._exit(Cancelled.exit_code)

        Thread(target=watch, daemon=True).start()

    def check(self) -> None:
        """Raise Cancelled if the run shall end."""
        if self._asked:
            raise Cancelled(INTERRUPTED)

    def between(self, steps: Generator[_Step, None, _Result], tell: Callable[[_Step], None]) -> _Result:
        """Run a generator to its end, `tell` of each of its steps, and return its value.

        Raises Cancelled, and closes it, if the run shall end before that.
        """

        def told(step: _Step) -> None:
            tell(step)
            self.check()

        self.check()
        return finished(relayed(steps, told))


@contextmanager
def interruptible() -> Iterator[Interruption]:
    """Listen for signals, but for those that whoever started us has silenced; only in the main thread."""
    interruption = Interruption()
    before = {number: signal.getsignal(number) for number in _SIGNALS}
    heard = [number for number, handler in before.items() if handler is not signal.SIG_IGN]
    for number in heard:
        signal.signal(number, interruption.ask)
    try:
        yield interruption
    finally:
        for number in heard:
            handler = before[number]  # None for Blender's own, which Python cannot put back
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
