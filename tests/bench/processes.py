# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Processes that meet, stop and die: `python -m tests.bench.processes --rounds 3`, on POSIX systems.

Bakes and exports of one folder run at once, or are stopped, continued, hung up and interrupted twice.
Each must end with exit code 0, or with one line that says why not; in the end the files are those of an
undisturbed bake, to the last bit, with nothing beside them.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from tests.blender.batch_process import BAKE
from tests.blender.killed import Command, Ended, Running, digests, left_behind
from tests.blender.room import save_room

ARGUMENTS = (
    "--layout",
    "buckets",
    "--texels",
    "32",
    "--bucket",
    "6",
    "--samples",
    "4",
    "--sheet",
    "64",
    "--save-preview",
)
STAGES = ("evaluate", "unwrap", "probe", "capture", "write", "preview")
_PAUSE = 3.0  # seconds for which a process is stopped


class Bench:
    """An undisturbed bake, and rows of processes that are held against it."""

    def __init__(self, root: Path, seed: int) -> None:
        self.root, self.chance = root, random.Random(seed)
        self.command = Command(save_room(root / "room.blend"), root / "temporary", ARGUMENTS)
        whole = self.command.start(root / "undisturbed").end()
        if whole.code:
            raise SystemExit(f"the undisturbed bake failed: {whole.err}")
        self.expected = digests(root / "undisturbed")

    def new(self, name: str = "out") -> Path:
        return self.root / f"{name}-{time.monotonic_ns()}"

    def other(self, *words: object) -> Running:
        """Another of the batch's commands."""
        environment = {**os.environ, "TMPDIR": str(self.command.temporary)}
        line = [sys.executable, BAKE, *(str(word) for word in words), "--progress", "json"]
        return Running(line, environment)

    def at_some_stage(self, running: Running) -> str:
        """Wait until it is at a stage, and a moment more; returns which."""
        stage = self.chance.choice(STAGES)
        running.wait_for(stage)
        time.sleep(self.chance.uniform(0, 0.2))
        return list(running.stages)[-1]

    def wrong_files(self, out: Path) -> list[str]:
        """What differs from the undisturbed bake's files, exports apart."""
        found = {name: digest for name, digest in digests(out).items() if not name.endswith(".raw")}
        return [] if found == self.expected else [f"{out.name} holds {sorted(found)}"]

    def finished(self, out: Path) -> list[str]:
        """Go on until it is done; what differs then."""
        ended = self.command.start(out, "--resume").end()
        if ended.code and "nothing of object" not in ended.err:
            return [f"resumed: {ended.code} {ended.err!r}"]
        return self.wrong_files(out)


def wrong_end(ended: Ended, codes: tuple[int, ...] = (0, 1, 2)) -> list[str]:
    """A word too many, a traceback, or another exit code than these."""
    fine = ended.code in codes and ended.err.count("\n") == (1 if ended.code > 0 else 0)
    return [] if fine else [f"exit code {ended.code}, {ended.err!r}"]


def stopped(bench: Bench) -> list[str]:
    """Stopped by Ctrl-Z or SIGSTOP, it keeps its bake; continued, it goes on as if nothing was."""
    out = bench.new()
    running = bench.command.start(out)
    bench.at_some_stage(running)
    running.process.send_signal(bench.chance.choice((signal.SIGTSTP, signal.SIGSTOP)))
    begun = any(out.glob("*.radtex-unfinished/lock"))
    wrong = []
    if begun and running.process.poll() is None:
        second = bench.command.start(out, "--resume").end()
        if second.code != 2 or "is in use" not in second.err:
            wrong = [f"the second: {second.code} {second.err!r}"]
    else:
        time.sleep(_PAUSE)
    running.process.send_signal(signal.SIGCONT)
    return wrong + wrong_end(running.end(), (0,)) + bench.wrong_files(out)


def hung_up(bench: Bench) -> list[str]:
    """The terminal is closed."""
    out = bench.new()
    running = bench.command.start(out)
    bench.at_some_stage(running)
    running.process.send_signal(signal.SIGHUP)
    ended = running.end(60)
    wrong = [] if ended.code in (0, 130, -signal.SIGHUP) else [f"exit code {ended.code}, {ended.err!r}"]
    return wrong + bench.finished(out)


def twice(bench: Bench) -> list[str]:
    """An impatient Ctrl-C."""
    out = bench.new()
    running = bench.command.start(out)
    bench.at_some_stage(running)
    number = bench.chance.choice((signal.SIGINT, signal.SIGTERM))
    for _ in range(2):
        running.process.send_signal(number)
        time.sleep(bench.chance.uniform(0, 0.1))
    ended = running.end(60)
    wrong = wrong_end(ended, (0, 130)) if ended.code >= 0 else []
    return wrong + bench.finished(out)


def child_killed(bench: Bench) -> list[str]:
    """The system kills xatlas, as where memory runs out."""
    out = bench.new()
    running = bench.command.start(out)
    running.wait_for("unwrap")
    killed = False
    until = time.monotonic() + 20
    while not killed and running.process.poll() is None and time.monotonic() < until:
        listed = subprocess.run(
            ["ps", "-o", "pid=", "--ppid", str(running.process.pid)],
            capture_output=True,
            text=True,
            check=False,
        )
        for pid in listed.stdout.split():
            os.kill(int(pid), signal.SIGKILL)
            killed = True
    ended = running.end(60)
    return wrong_end(ended, (0, 1)) + bench.finished(out)


def two_resume(bench: Bench) -> list[str]:
    """Two go on with what a third left."""
    out = bench.new()
    running = bench.command.start(out)
    running.wait_for("capture")
    running.process.kill()
    running.end()
    both = [bench.command.start(out, "--resume") for _ in range(2)]
    ends = [each.end() for each in both]
    wrong = [word for ended in ends for word in wrong_end(ended)]
    if not any(ended.code == 0 for ended in ends):
        wrong.append(f"neither is done: {[ended.err for ended in ends]}")
    return wrong + bench.wrong_files(out)


def two_overwrite(bench: Bench) -> list[str]:
    """Two bake anew what is there, while two more export it."""
    out = bench.new()
    shutil.copytree(bench.root / "undisturbed", out)
    both = [bench.command.start(out, "--overwrite") for _ in range(2)]
    bench.at_some_stage(both[0])
    others = [bench.other("export", out, "--to", "raw", "--overwrite") for _ in range(2)]
    ends = [each.end() for each in (*both, *others)]
    wrong = [word for ended in ends for word in wrong_end(ended)]
    if ends[0].code and ends[1].code:
        wrong.append(f"neither is done: {[ended.err for ended in ends]}")
    return wrong + bench.wrong_files(out) + _whole_export(out)


def two_exports(bench: Bench) -> list[str]:
    """Two exports into one folder."""
    out = bench.new()
    shutil.copytree(bench.root / "undisturbed", out)
    ends = [
        each.end() for each in [bench.other("export", out, "--to", "raw", "--overwrite") for _ in range(3)]
    ]
    wrong = [word for ended in ends for word in wrong_end(ended)]
    if not any(ended.code == 0 for ended in ends):
        wrong.append(f"none is done: {[ended.err for ended in ends]}")
    return wrong + bench.wrong_files(out) + _whole_export(out)


def _whole_export(out: Path) -> list[str]:
    for folder in out.glob("*.raw"):
        lines = (folder / ".radtex-files").read_text(encoding="utf-8").splitlines()
        listed = {line.partition("\t")[0] for line in lines}
        found = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
        if listed != found:
            return [f"the export holds {sorted(found ^ listed)}"]
    return []


def two_accumulate(bench: Bench) -> list[str]:
    """Two add samples to one bake: both are in it, or the other is refused."""
    out = bench.new()
    shutil.copytree(bench.root / "undisturbed", out)
    both = [bench.command.start(out, "--accumulate", "--seed", str(seed)) for seed in (1, 2)]
    ends = [each.end() for each in both]
    wrong = [word for ended in ends for word in wrong_end(ended)]
    samples = json.loads((out / "Ball.radiance.json").read_text(encoding="utf-8"))["samples"]
    done = sum(ended.code == 0 for ended in ends)
    if samples != 4 * (1 + done) or not done:
        wrong.append(f"{samples} samples after {done} were done: {[ended.err for ended in ends]}")
    return wrong + [f"{path.name} is left" for path in out.iterdir() if "radtex-" in path.name]


ROWS: dict[str, Callable[[Bench], list[str]]] = {
    "stopped and continued": stopped,
    "hung up": hung_up,
    "interrupted twice": twice,
    "xatlas is killed": child_killed,
    "two resume at once": two_resume,
    "two bake anew, two export": two_overwrite,
    "three exports at once": two_exports,
    "two accumulate": two_accumulate,
}


def main() -> None:
    """Let them meet, and print what came of it."""
    keep_lines = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=keep_lines)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="of rows whose titles hold this")
    options = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job is deaf to it
    findings = 0
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        bench = Bench(Path(folder), options.seed)
        print("| processes | tries | findings |\n|---|---|---|")
        for title, row in ROWS.items():
            if options.only in title:
                wrong = [f"{number}: {word}" for number in range(options.rounds) for word in row(bench)]
                findings += len(wrong)
                print(f"| {title} | {options.rounds} | {'; '.join(wrong)} |", flush=True)
        left = left_behind(bench.command.temporary)
    print(f"left behind: {left or 'nothing'}")
    sys.exit(1 if findings or left else 0)


if __name__ == "__main__":
    main()
