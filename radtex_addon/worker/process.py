# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A worker: `bake.py` in a process of its own, which reports by JSON lines and can be ended at any time.

Its standard input is a pipe to which nothing is written. When the pipe closes, because the job is cancelled
or this Blender ended, the worker ends. No signal does that on every system.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread, Timer
from typing import Any, NamedTuple, TypeAlias

from ..core.errors import Cancelled, InputError
from ..core.messages import Message
from .job import JobState

PATIENCE = 1.0  # seconds that a cancelled worker has for itself
_NICER = 10  # levels of niceness above this process: Blender's window goes before
_LOG = 8000  # characters of a failed worker's standard error that are kept

Event: TypeAlias = Mapping[str, Any]


class Ended(NamedTuple):
    """The final state of a worker, why it failed, if it did, and what it last said on standard error then."""

    state: JobState
    message: Message
    log: str = ""


class Worker:
    """A running worker. Only `close` waits; call `events` regularly."""

    def __init__(self, command: Sequence[str], folder: Path, explain: Callable[[str], str]) -> None:
        """Start the process, with its temporary files in a new folder below `folder`.

        `explain` turns the reason of an early end into a message. Raises InputError if the program does not
        start, OSError if nothing can be written into `folder`.
        """
        self._temporary = tempfile.TemporaryDirectory(
            prefix="temporary-", dir=folder, ignore_cleanup_errors=True
        )
        self._errors = tempfile.TemporaryFile(dir=self._temporary.name)  # noqa: SIM115  # closed by close
        try:
            self._process = self._start(command)
        except OSError as error:
            self._clear()
            raise InputError(
                f"{command[0]} does not start ({error.strerror or error}): install Blender anew"
            ) from error
        self._said: SimpleQueue[Event | None] = SimpleQueue()
        self._explain = explain
        self._error: Message | None = None
        self._is_done = False
        self._cancelled = False
        self._ended: Ended | None = None
        self._thread = Thread(target=self._listen, name="RadTex worker", daemon=True)
        self._thread.start()

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def ended(self) -> Ended | None:
        """How it ended, as far as `events` has read; None while it runs."""
        return self._ended

    def events(self) -> list[Event]:
        """The events that it reported since the last call."""
        heard: list[Event] = []
        with suppress(Empty):
            while self._ended is None:
                event = self._said.get_nowait()
                if event is None:
                    self._ended = self._judge()
                elif event.get("event") == "error":
                    self._error = Message.of_facts(event)
                else:
                    self._is_done |= event.get("event") == "done"
                    heard.append(event)
        return heard

    def cancel(self) -> None:
        """Ask it to end, and kill it after PATIENCE seconds."""
        if not self._cancelled:
            self._ask()
            killer = Timer(PATIENCE, self.kill)
            killer.daemon = True
            killer.start()

    def kill(self) -> None:
        """Kill the process and its children at once."""
        if self._process.poll() is not None:
            return
        with suppress(OSError):  # it has ended meanwhile
            if sys.platform == "win32":
                self._process.kill()
            else:
                os.killpg(self._process.pid, signal.SIGKILL)

    def close(self) -> None:
        """End the process, within little more than PATIENCE seconds, and remove its temporary files."""
        if self._ended is None:
            self._ask()  # and no timer: a Python that ends starts no threads
            self._thread.join(PATIENCE)
            self.kill()
        self._thread.join()
        self.events()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None  # both are pipes, as asked for
            pipe.close()
        self._clear()

    def _clear(self) -> None:
        self._errors.close()
        self._temporary.cleanup()

    def _ask(self) -> None:
        self._cancelled = True
        assert self._process.stdin is not None  # a pipe, as asked for
        self._process.stdin.close()

    def _start(self, command: Sequence[str]) -> subprocess.Popen[bytes]:
        places = dict.fromkeys(("TMPDIR", "TEMP", "TMP"), self._temporary.name)
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env=os.environ | places,
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0)
            | getattr(subprocess, "BELOW_NORMAL_PRIORITY_CLASS", 0),
            start_new_session=True,  # a group: Ctrl-C in a terminal is ours, and we can end all of it
        )
        if sys.platform != "win32":
            with suppress(OSError):
                os.setpriority(os.PRIO_PROCESS, process.pid, os.getpriority(os.PRIO_PROCESS, 0) + _NICER)
        return process

    def _listen(self) -> None:
        stdout = self._process.stdout
        assert stdout is not None  # a pipe, as asked for
        for line in stdout:
            event = _event(line)
            if event is not None:
                self._said.put(event)
        self._process.wait()
        self._said.put(None)

    def _judge(self) -> Ended:
        code = self._process.wait()
        if code == 0 and self._is_done:  # a Blender that runs no scripts is content with itself
            return Ended(JobState.DONE, Message(""))
        if self._cancelled or code == Cancelled.exit_code:
            return Ended(JobState.CANCELLED, Message("cancelled"))
        self._errors.seek(0)
        log = self._errors.read().decode(errors="replace")
        message = self._error or Message(self._explain(_reason(code, log)))
        return Ended(JobState.FAILED, message, log[-_LOG:])


def _reason(code: int, log: str) -> str:
    """Why a worker ended without reporting an error: a signal, or the last line of its standard error."""
    if code < 0:
        return f"killed by signal {-code}"
    lines = log.splitlines()
    last = next((line.strip() for line in reversed(lines) if line.strip()), f"exit code {code}")
    return last.removeprefix("radtex: ")


def _event(line: bytes) -> Event | None:
    """The event in a line; None for Blender's own output."""
    if not line.startswith(b"{"):
        return None
    try:
        event = json.loads(line)
    except ValueError:  # half a line, where it was killed
        return None
    return event if isinstance(event, dict) else None
