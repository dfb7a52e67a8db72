# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes in processes of their own that are ended at some moment, and what must then be left."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from threading import Thread
from typing import Any

from radtex_addon.bake.key import KEY
from tests.blender.batch_process import BAKE

START = "start-up"
NAME = "Ball"


@dataclass(frozen=True)
class Command:
    """A bake of the room's ball; `temporary` is where temporary files go, `through` what runs the program."""

    blend: Path
    temporary: Path
    arguments: tuple[str, ...]
    through: tuple[str, ...] = ()

    def start(self, out: Path, *more: str) -> Running:
        self.temporary.mkdir(exist_ok=True, parents=True)
        command = [sys.executable, BAKE, str(self.blend), "--object", NAME, "--out", str(out)]
        environment = {**os.environ, "TMPDIR": str(self.temporary)}
        return Running([*self.through, *command, *self.arguments, *more, "--progress", "json"], environment)


@dataclass
class Ended:
    """How a process ended, and where it was."""

    code: int
    stage: str
    warnings: list[str]
    err: str
    seconds: float
    stages: dict[str, float] = field(default_factory=dict)  # when each began


class Running:
    """A bake, from the moment at which its process begins."""

    def __init__(self, command: list[str], environment: dict[str, str]) -> None:
        self.since = time.monotonic()
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
        )
        self.stages: dict[str, float] = {START: 0.0}
        self._warnings: list[str] = []
        self._err = ""
        self._threads = [Thread(target=self._listen), Thread(target=self._hear_errors)]
        for thread in self._threads:
            thread.start()

    def _listen(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            try:
                event: dict[str, Any] = json.loads(line)
            except ValueError:  # half a line of a killed process
                continue
            if event["event"] == "progress":
                self.stages.setdefault(event["stage"], time.monotonic() - self.since)
            elif event["event"] == "warning":
                self._warnings.append(event["message"])

    def _hear_errors(self) -> None:
        assert self.process.stderr is not None
        self._err = self.process.stderr.read()

    def wait_for(self, stage: str) -> bool:
        """Until it is at a stage; False where it ended before."""
        while stage not in self.stages and self.process.poll() is None:
            time.sleep(0.002)
        return stage in self.stages

    def end(self, timeout: float = 600) -> Ended:
        """Wait for its end."""
        self.process.wait(timeout)
        return self._ended()

    def end_after(self, seconds: float, number: int) -> Ended:
        """Send a signal `seconds` from now, unless it has ended by then; a polite one twice if need be."""
        try:
            self.process.wait(max(seconds, 0.0))
        except subprocess.TimeoutExpired:
            self.process.send_signal(number)
        return self.end(60)

    def _ended(self) -> Ended:
        seconds = time.monotonic() - self.since
        for thread in self._threads:
            thread.join()
        for pipe in (self.process.stdout, self.process.stderr):
            assert pipe is not None
            pipe.close()
        stage = list(self.stages)[-1]
        return Ended(self.process.returncode, stage, self._warnings, self._err, seconds, self.stages)


def digests(folder: Path) -> dict[str, str]:
    """Of all files in a folder but previews, which tell when they were saved; of these the name alone."""
    found = {}
    for path in sorted(folder.iterdir()):
        whole = path.is_file() and not path.name.endswith(".preview.blend")
        found[path.name] = hashlib.sha256(path.read_bytes()).hexdigest() if whole else ""
    return found


def is_done(out: Path) -> bool:
    """Whether nothing is to be resumed; an empty folder may be left, if the kill came before its removal."""
    unfinished = list(out.glob(f"*.radtex-unfinished/{KEY}"))
    return any(out.glob("*.json")) and not unfinished


def left_behind(temporary: Path) -> list[str]:
    """Our temporary files, and processes that still work in `temporary` (on Linux)."""
    files = [path.name for path in temporary.iterdir() if path.name.startswith("radtex")]
    wanted = f"TMPDIR={temporary}".encode()
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if wanted in (process / "environ").read_bytes().split(b"\0"):
                files.append(f"process {process.name}")
        except OSError:  # it has ended, or is another's
            continue
    return files


def killed(code: int) -> bool:
    return code == -signal.SIGKILL
