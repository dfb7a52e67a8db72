# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake to which the system says no, once, at its n-th call: `python -m tests.bench.failing_calls`.

An audit hook raises an OSError where Python is about to open, rename or remove a file, make or list a folder,
or start a process, for each n in turn. The batch must end with one line and no traceback, or bear it and make
the files of an undisturbed bake; Blender's data must be what they were; nothing half-written may bear a final
name; and --resume must go on to the same bits.
"""

from __future__ import annotations

import argparse
import errno
import os
import shutil
import sys
import tempfile
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy

from radtex_addon.cli.main import main as batch
from tests.blender.killed import digests
from tests.blender.room import save_room

EVENTS = frozenset(
    (
        *(
            "open",
            "os.rename",
            "os.remove",
            "os.mkdir",
            "os.rmdir",
            "os.listdir",
            "os.scandir",
            "os.truncate",
        ),
        *("subprocess.Popen", "tempfile.mkstemp", "tempfile.mkdtemp", "shutil.rmtree", "fcntl.flock"),
    )
)
LINES = {
    "buckets": ("--layout", "buckets", "--texels", "16", "--bucket", "4", "--samples", "1", "--save-preview"),
    "layers": (
        "--layout",
        "buckets",
        "--texels",
        "12",
        "--bucket",
        "4",
        "--samples",
        "1",
        "--layer",
        "diffuse",
        "--uv",
        "UVMap",
    ),
    "layered": ("--texels", "16", "--samples", "1", "--layout", "layered", "--uv", "UVMap"),
    "ao": ("--texels", "12", "--bucket", "4", "--samples", "1", "--kind", "ao", "--uv", "UVMap"),
}
_ERRORS = (errno.ENOSPC, errno.EACCES, errno.EIO, errno.EMFILE, errno.EROFS)
_FIRST = 2  # the first call opens /dev/null, without which there is no place for what Blender says
_REMOVING = ("os.remove", "os.rmdir", "os.scandir", "os.listdir", "shutil.rmtree")  # what fails to go is left
_NOTHING = {  # where the .blend was not opened
    **dict.fromkeys(("objects", "meshes", "images", "materials", "node_groups", "collections"), 0),
    "scenes": 1,
    "cameras": 0,
    "texts": 0,
}


@dataclass
class Fault:
    """Calls counted while `on`; the one at place `at` fails."""

    on: bool = False
    at: int = 0
    code: int = errno.EIO
    seen: int = 0
    what: str = ""

    def hook(self, event: str, arguments: tuple[Any, ...]) -> None:
        if not self.on or event not in EVENTS:
            return
        if event == "open" and not self._counts(arguments):
            return
        self.seen += 1
        if self.seen == self.at:
            self.what = f"{event} {arguments[0]!r}"
            raise OSError(self.code, os.strerror(self.code), str(arguments[0]))

    def _counts(self, arguments: tuple[Any, ...]) -> bool:
        """Python's own modules are none of a bake's files."""
        path = arguments[0]
        return isinstance(path, (str, bytes)) and not str(path).endswith((".py", ".pyc", ".so", ".pth"))


class Bench:
    """A command line, run in this process again and again."""

    def __init__(self, root: Path, line: tuple[str, ...]) -> None:
        self.root, self._line = root, line
        self._blend = save_room(root / "room.blend")
        self.fault = Fault()
        sys.addaudithook(self.fault.hook)
        self.run(root / "first")  # what is loaded once is loaded now
        code, said = self.run(root / "undisturbed", at=-1)
        if code:
            raise SystemExit(f"the undisturbed bake failed: {said}")
        self.calls = self.fault.seen
        self.expected, self._blocks = digests(root / "undisturbed"), _blocks()

    def run(self, out: Path, *more: str, at: int = 0, code: int = errno.EIO) -> tuple[int, str]:
        """Exit code, -1 where something was raised, and what was said on standard error."""
        line = [str(self._blend), "--object", "Ball", "--out", str(out), *self._line, *more]
        bpy.ops.wm.read_factory_settings(use_empty=True)
        with _said(self.root / "said") as said:
            self.fault.seen, self.fault.at, self.fault.code, self.fault.what = 0, at, code, ""
            self.fault.on = at != 0
            try:
                result = batch([*line, "--progress", "none"], False)
            except Exception:  # noqa: BLE001  # a finding
                result = -1
                traceback.print_exc()
            finally:
                self.fault.on = False
        return result, said[0]

    def fail(self, at: int, code: int) -> list[str]:
        """What is wrong where the call at place `at` fails."""
        out = self.root / f"out {at}"
        ended, said = self.run(out, at=at, code=code)
        what, blocks = self.fault.what, _blocks()
        wrong = []
        if ended not in (0, 1, 2) or "Traceback" in said:
            wrong.append(f"exit code {ended}: {said[-1500:]}")
        elif ended and (said.count("\n") != 1 or not said.startswith("radtex: ")):
            wrong.append(f"says {said!r}")
        if blocks not in (self._blocks, _NOTHING):
            wrong.append(f"Blender holds {blocks}")
        if not what.startswith(_REMOVING):
            left = [*self.root.glob("temporary/radtex*"), *out.rglob(".radtex-*")]
            wrong += [f"{path.relative_to(self.root)} is left" for path in left if str(path) not in what]
        found = digests(out) if out.exists() else {}
        wrong += [f"{n} is half-written" for n, d in found.items() if d and d != self.expected.get(n)]
        if ended:
            again, words = self.run(out, "--resume")
            if again:
                wrong.append(f"resumed: {again} {words[-300:]!r} after {said[-200:]!r}")
        if digests(out) != self.expected:
            wrong.append(f"ends with {ended}, and holds {sorted(digests(out))}")
        if not wrong:
            shutil.rmtree(out, ignore_errors=True)
        return [f"{errno.errorcode[code]} at call {at}, {what}: {word}" for word in wrong]


def _blocks() -> dict[str, int]:
    """How many data-blocks of each kind Blender holds."""
    return {name: len(getattr(bpy.data, name)) for name in _NOTHING}


@contextmanager
def _said(path: Path) -> Iterator[list[str]]:
    """Standard error, and standard output, into a file."""
    kept = os.dup(2), os.dup(1)
    said: list[str] = []
    with path.open("w+b") as file:
        sys.stderr.flush()
        os.dup2(file.fileno(), 2)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        try:
            yield said
        finally:
            sys.stderr.flush()
            for number, descriptor in zip((2, 1), kept, strict=True):
                os.dup2(descriptor, number)
                os.close(descriptor)
            file.seek(0)
            said.append(file.read().decode(errors="replace"))


def main() -> None:
    """Let calls fail, and print what came of it."""
    keep_lines = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=keep_lines)
    parser.add_argument("--line", choices=list(LINES), default="buckets")
    parser.add_argument("--every", type=int, default=1, help="of the calls")
    parser.add_argument("--shift", type=int, default=0, help="which error the first call gets")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        (root / "temporary").mkdir()
        tempfile.tempdir = str(root / "temporary")
        bench = Bench(root, LINES[options.line])
        places = range(_FIRST, bench.calls + 1, options.every)
        findings = 0
        for number, at in enumerate(places):
            for each in bench.fail(at, _ERRORS[(number + options.shift) % len(_ERRORS)]):
                findings += 1
                print(each, flush=True)
    print(f"{options.line}: {len(places)} of {bench.calls} calls failed, {findings} findings")
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
