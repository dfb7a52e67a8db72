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

import bpy

from radtex_addon.cli.arguments import parse
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.store.checkpoint_files import KEY
from radtex_addon.worker.handover import hand_over, this_program
from radtex_addon.worker.order import command_line, write_order
from radtex_addon.worker.orders import order_bake
from tests.blender.batch_process import BAKE

START = "start-up"
NAME = "Ball"
_ROUNDED = ("mesh", "fingerprint")  # facts that differ between evaluations


@dataclass(frozen=True)
class Command:
    """A bake of the room's ball; `temporary` is where temporary files go, `through` what runs the program."""

    blend: Path
    temporary: Path
    arguments: tuple[str, ...]
    through: tuple[str, ...] = ()
    rounded: bool = False  # Blender makes the ball otherwise each time: its digests tell nothing

    def start(self, out: Path, *more: str) -> Running:
        self.temporary.mkdir(exist_ok=True, parents=True)
        command = [sys.executable, BAKE, str(self.blend), "--object", NAME, "--out", str(out)]
        environment = {**os.environ, "TMPDIR": str(self.temporary)}
        return Running([*self.through, *command, *self.arguments, *more, "--progress", "json"], environment)

    def found(self, out: Path) -> dict[str, str]:
        """Digests of what lies in a folder; of a rounded ball those of the light, and the other facts."""
        found = digests(out)
        if self.rounded:
            for image in out.glob("*.exr"):  # facts are in there, too
                found[image.name] = hashlib.sha256(read_atlas(image)[0].tobytes()).hexdigest()
            for sidecar in out.glob("*.json"):
                facts = json.loads(sidecar.read_text())
                found[sidecar.name] = str({key: facts[key] for key in facts if key not in _ROUNDED})
        return found


class Worker(Command):
    """The same by a worker, as Blender's window bakes: with the file that is open here, anew each time."""

    def start(self, out: Path, *more: str) -> Running:
        self.temporary.mkdir(exist_ok=True, parents=True)
        bpy.ops.wm.open_mainfile(filepath=str(self.blend))
        scene: Any = bpy.context.scene
        handover = hand_over(scene, self.temporary.parent / "jobs")
        preview = Filter.NEAREST if "--save-preview" in self.arguments else None
        order = order_bake(handover, NAME, self._spec(), out, preview, resume="--resume" in more)
        environment = {**os.environ, "TMPDIR": str(self.temporary)}
        return Running(command_line(this_program(), order, write_order(order)), environment, is_worker=True)

    def _spec(self) -> BakeSpec:
        words = ["x.blend", "--object", NAME, "--out", "x", *self.arguments]
        return parse(words, inside_blender=False).bakes.spec


@dataclass
class Ended:
    """How a process ended, and where it was."""

    code: int
    stage: str
    warnings: list[str]
    err: str
    seconds: float
    stages: dict[str, float] = field(default_factory=dict)  # when each began
    error: str = ""  # as an event


class Running:
    """A bake, from the moment at which its process begins."""

    def __init__(self, command: list[str], environment: dict[str, str], *, is_worker: bool = False) -> None:
        self.since = time.monotonic()
        self._input = subprocess.PIPE if is_worker else None
        self.process = subprocess.Popen(
            command,
            stdin=self._input,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment,
        )
        self.stages: dict[str, float] = {START: 0.0}
        self._warnings: list[str] = []
        self._err = self._error = ""
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
            elif event["event"] == "error":
                self._error = event["message"]

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
        """Send a signal `seconds` from now, unless it has ended by then; a worker's input ends instead."""
        try:
            self.process.wait(max(seconds, 0.0))
        except subprocess.TimeoutExpired:
            if number != signal.SIGKILL and self.process.stdin is not None:
                self.process.stdin.close()
            else:
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
        return Ended(
            self.process.returncode, stage, self._warnings, self._err, seconds, self.stages, self._error
        )


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
