# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Who does which task, where several machines take tasks from a shared folder by themselves.

A claim is a file whose text its owner changes every few seconds. One that stays the same for a while, by the
clock of whoever looks, is left by a machine that died. Claims only save work: what two do at once comes out
the same.
"""

from __future__ import annotations

import os
import platform
import secrets
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Event, Thread
from time import monotonic

from ..core.errors import BakeError
from ..formats.disk.atomic import refusal
from .tasks import TaskFarm

BEAT = 5.0  # seconds between changes of a claim …
PATIENCE = 60.0  # … and after which one that has not changed is nobody's

_held: set[Path] = set()  # this process's claims


@dataclass(frozen=True)
class Claim:
    """A claim's text, and since when, by this machine's clock, it is so."""

    text: str
    since: float


@contextmanager
def claimed(farm: TaskFarm, task: str, seen: dict[str, Claim]) -> Iterator[bool]:
    """Claim a task for the time of the context, and yield whether nobody else does it.

    `seen` keeps what this process has seen of others' claims. Raises BakeError where the system refuses.
    """
    path = farm.folder / "claims" / task
    own = f"{_machine()} {os.getpid()} {secrets.token_hex(8)}"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        taken = _take(path, own, seen)
    except OSError as error:
        raise BakeError(refusal(path, error)) from error
    if not taken:
        yield False
        return
    _held.add(path)
    ended = Event()
    beat = Thread(target=_beat, args=(path, own, ended), name="RadTex claim", daemon=True)
    beat.start()
    try:
        yield True
    finally:
        ended.set()
        beat.join()
        _held.discard(path)
        with suppress(OSError):
            if path.read_text(encoding="utf-8").startswith(own):
                path.unlink()


def release_claims() -> None:
    """Give up what this process has claimed, as before an end in the midst of a render."""
    for path in list(_held):
        with suppress(OSError):
            path.unlink()


def _take(path: Path, own: str, seen: dict[str, Claim]) -> bool:
    """Make the claim, unless another one is alive. Raises OSError where nothing can be written."""
    if _make(path, own):
        return True
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError):  # its owner has just removed it, or writes it
        return False
    if not _has_died(text):
        known = seen.get(path.name)
        if known is None or known.text != text:
            seen[path.name] = Claim(text, monotonic())
            return False
        if monotonic() - known.since < PATIENCE:
            return False
    with suppress(OSError):  # others may be quicker, or take the claim that was just made anew
        left = path.with_name(f".radtex-left-{secrets.token_hex(8)}")
        path.replace(left)
        left.unlink()
    return _make(path, own)


def _has_died(text: str) -> bool:
    """Whether a claim is of a process of this machine that is no more."""
    machine, _, rest = text.partition(" ")
    pid = rest.partition(" ")[0]
    if machine != _machine() or not pid.isdecimal() or sys.platform == "win32":
        return False
    try:
        os.kill(int(pid), 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        return False
    return False


def _machine() -> str:
    """This machine as long as it runs, and on Linux the container: its processes have their own numbers."""
    parts = [platform.node()]
    with suppress(OSError):
        parts.append(Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip())
        parts.append(str(Path("/proc/self/ns/pid").readlink()))
    return ",".join(parts).replace(" ", "_")


def _make(path: Path, own: str) -> bool:
    """Write a claim where there is none. Raises OSError where nothing can be written."""
    try:
        with path.open("x", encoding="utf-8") as stream:
            stream.write(own)
    except FileExistsError:
        return False
    except PermissionError:
        if path.exists():  # on Windows, while its owner writes it
            return False
        raise
    return True


def _beat(path: Path, own: str, ended: Event) -> None:
    number = 0
    while not ended.wait(BEAT):
        number += 1
        with suppress(OSError):
            path.write_text(f"{own} {number}", encoding="utf-8")
