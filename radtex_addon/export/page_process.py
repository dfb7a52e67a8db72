# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Serve exported web pages from a process of its own, which ends when this one does, however that ends."""

from __future__ import annotations

import json
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread

import bpy

from ..core.child_process import pipes_of
from ..core.errors import BakeError, InputError

_SERVER = Path(__file__).with_name("page_server.py")
_PATIENCE = 15.0  # seconds for an answer: the first one waits for Python to start
_REMEDY = "serve the folder by another program, such as `python -m http.server`"


class PageProcess:
    """A running server of folders, at 127.0.0.1 alone.

    In a process of its own pages are there also while Blender is busy. Its standard input is a pipe: when
    that closes, by `close` or because this process is gone, the server ends.
    """

    def __init__(self) -> None:
        """Start it. Raises InputError if there is no Python to run it."""
        if not sys.executable or sys.executable == bpy.app.binary_path:
            raise InputError(f"this Blender names no Python that could serve the page: {_REMEDY}")
        command = [sys.executable, "-I", str(_SERVER)]  # isolated: no module beside it hides a standard one
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
                start_new_session=True,  # Ctrl-C in Blender's terminal is not for it
            )
        except OSError as error:
            reason = error.strerror or error
            raise InputError(
                f"{sys.executable} does not start to serve the page ({reason}): {_REMEDY}"
            ) from error
        self._answers: SimpleQueue[bytes] = SimpleQueue()
        Thread(target=self._listen, name="RadTex page server", daemon=True).start()

    @property
    def is_running(self) -> bool:
        return self._process.poll() is None

    def address_of(self, folder: Path) -> str:
        """Serve the folder, if that is not done yet; returns its address. Raises BakeError if that fails."""
        stdin = pipes_of(self._process)[0]
        line = b""
        with suppress(OSError, Empty):  # it has ended, or does not answer
            stdin.write(json.dumps(str(folder.absolute())).encode() + b"\n")
            stdin.flush()
            line = self._answers.get(timeout=_PATIENCE)
        if not line:
            self.close()
            raise BakeError(f"the server for {folder} ended, or does not answer: try again, or {_REMEDY}")
        return str(json.loads(line))

    def close(self) -> None:
        """End it, and what it is sending."""
        self._process.kill()
        self._process.wait()
        for pipe in pipes_of(self._process):
            with suppress(OSError):  # a line may be left in it
                pipe.close()

    def _listen(self) -> None:
        with suppress(OSError, ValueError):  # closed meanwhile
            for line in pipes_of(self._process)[1]:
                self._answers.put(line)
        self._answers.put(b"")
