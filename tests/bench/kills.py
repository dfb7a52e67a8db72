# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake that is killed again and again: `python -m tests.bench.kills --kills 50 --layout buckets --seed 1`.

Real processes get SIGKILL at moments uniform over a bake's whole life, from the start of Python on; every
fifth is aimed at a stage that is too short to be hit by luck; after every five kills comes a polite signal,
SIGINT and SIGTERM in turn. Each process goes on, by --resume, with what the last one left. Whenever a bake
comes to its end, its files must be those of an uninterrupted one, to the last bit, with nothing beside them,
and no temporary file or process of ours may be left.
"""

from __future__ import annotations

import argparse
import random
import signal
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import bpy

from tests.blender.killed import (
    NAME,
    START,
    Command,
    Ended,
    Running,
    Worker,
    is_done,
    killed,
    left_behind,
)
from tests.blender.modifier_stacks import STACKS, add_stack
from tests.blender.room import save_room

ARGUMENTS = {
    "buckets": (
        *(
            "--layout",
            "buckets",
            "--uv",
            "UVMap",
            "--texels",
            "128",
            "--bucket",
            "8",
            "--samples",
            "2",
            "--sheet",
            "256",
        ),
        *("--layer", "diffuse", "--save-preview"),
    ),
    "small": (
        *("--layout", "buckets", "--texels", "32", "--bucket", "4", "--samples", "1", "--sheet", "32"),
        *("--layer", "diffuse", "--unwrap", "uvunwrap"),  # else on UVs that Blender may round otherwise
    ),
    "layered": ("--layout", "layered", "--texels", "48", "--samples", "2", "--save-preview"),
}
_POLITE = (signal.SIGINT, signal.SIGTERM)
_WORDS = "radtex: interrupted"


@dataclass
class Tally:
    """What happened: signals by where they hit, and bakes that came to their end."""

    hits: Counter[tuple[str, str]] = field(default_factory=Counter)
    survived: int = 0
    polite: int = 0
    went_on: int = 0
    bakes: int = 0
    problems: list[str] = field(default_factory=list)

    def table(self) -> str:
        """Signals by stage, in the order of their first hits."""
        names = sorted({name for _, name in self.hits})
        stages = list(dict.fromkeys(stage for stage, _ in self.hits))
        lines = ["| hit in | " + " | ".join(names) + " |", "|---|" + "---|" * len(names)]
        rows = [(stage, *(str(self.hits[stage, name]) for name in names)) for stage in stages]
        return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


class Torture:
    """Bakes below `root`, each killed until it is done."""

    def __init__(self, command: Command, root: Path, seed: int, *, late: bool = False) -> None:
        self._command, self._root, self._late = command, root, late
        self._chance = random.Random(seed)
        self.tally = Tally()
        whole = command.start(root / "uninterrupted").end()
        if whole.code:
            raise SystemExit(f"the uninterrupted bake failed: {whole.err}{whole.error}")
        self.life, self.stages = whole.seconds, whole.stages
        self.expected = command.found(root / "uninterrupted")

    def kill(self, kills: int) -> Tally:
        """Until so many kills were survived, and the last bake is done."""
        tally = self.tally
        compared = False
        while tally.survived < kills or not compared:
            ended = self._once(final=tally.survived >= kills)
            self._judge(ended)
            if compared := is_done(self._out):
                self._compare(ended)
        tally.problems += left_behind(self._command.temporary)
        return tally

    @property
    def _out(self) -> Path:
        return self._root / f"out {self.tally.bakes}"

    def _once(self, final: bool) -> Ended:
        """One process, and what is done to it."""
        tally = self.tally
        tally.went_on += any(self._out.glob("*.radtex-unfinished/*.piece"))
        running = self._command.start(self._out, "--resume")
        if final:
            return running.end()
        number, name = signal.SIGKILL, "SIGKILL"
        if tally.survived >= 5 * (tally.polite + 1):
            number = _POLITE[tally.polite % len(_POLITE)]
            name = number.name
        if number is signal.SIGKILL and tally.survived % 5 == 4:
            ended = self._aimed(running)
        else:
            begin = self.stages["evaluate"] if self._late and running.wait_for("evaluate") else 0.0
            ended = running.end_after(self._chance.uniform(0, self.life - begin), number)
        if ended.code:
            tally.hits[ended.stage, name] += 1
            tally.survived += killed(ended.code)
            tally.polite += not killed(ended.code)
        return ended

    def _aimed(self, running: Running) -> Ended:
        """Kill it within a stage that is short."""
        names = [name for name in self.stages if name != START]
        begins = [*self.stages.values(), self.life]
        lengths = {name: begins[place + 2] - begins[place + 1] for place, name in enumerate(names)}
        short = [name for name in names if lengths[name] < self.life / 8]
        stage = self._chance.choice(short)
        running.wait_for(stage)
        return running.end_after(self._chance.uniform(0, lengths[stage]), signal.SIGKILL)

    def _judge(self, ended: Ended) -> None:
        if ended.warnings:
            self.tally.problems += ended.warnings
        if ended.code == 0 and ended.err == "":
            return
        early = ended.code in (-signal.SIGINT, -signal.SIGTERM) and ended.stage == START
        asked = ended.code == 130 and ended.err.startswith(_WORDS) and ended.err.count("\n") == 1
        if not (early or asked or (killed(ended.code) and ended.err == "")):
            self.tally.problems.append(f"in {ended.stage}: exit code {ended.code}, {ended.err!r}")

    def _compare(self, ended: Ended) -> None:
        """Hold what is done against the uninterrupted bake."""
        if ended.code:  # killed when all was done: going on finds nothing to do, and tidies up
            late = self._command.start(self._out, "--resume").end()
            if late.code != 2 or "nothing of object" not in late.err + late.error:
                self.tally.problems.append(f"after its end: exit code {late.code}, {late.err!r}")
        found = self._command.found(self._out)
        if found != self.expected:
            differing = [name for name in found if found[name] != self.expected.get(name)]
            self.tally.problems.append(f"{self._out} differs: {differing or sorted(found)}")
        self.tally.bakes += 1


def _add_modifiers(room: Path, stack: str) -> None:
    """Give the open room's ball modifiers, and neighbours that have some, and save it."""
    context: Any = bpy.context
    ball = context.scene.objects[NAME]
    context.view_layer.objects.active = ball
    STACKS[stack](ball)
    for number, name in enumerate(("float boolean and bevel", "bevel and realized", "bevel and array")):
        add_stack(name, (3 - 3 * number, 4, 0))
    bpy.ops.wm.save_as_mainfile(filepath=str(room), copy=True)


def main() -> None:
    """Kill, and say what came of it."""
    keep_lines = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=keep_lines)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--layout", choices=list(ARGUMENTS), default="buckets")
    parser.add_argument("--stack", choices=sorted(STACKS), help="modifiers of the ball; neighbours have some")
    parser.add_argument("--late", action="store_true", help="not while Blender starts")
    parser.add_argument("--worker", action="store_true", help="by a worker, as Blender's window bakes")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job is deaf to it
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        room = save_room(root / "room.blend", 4 if options.stack is None else 2)
        if options.stack is not None:
            _add_modifiers(room, options.stack)
        kind = Worker if options.worker else Command
        rounded = options.stack is not None
        command = kind(room, root / "temporary", ARGUMENTS[options.layout], rounded=rounded)
        torture = Torture(command, root, options.seed, late=options.late)
        at = ", ".join(f"{stage} {begun:.1f}" for stage, begun in torture.stages.items())
        print(f"uninterrupted: {torture.life:.1f} s (stages begin at: {at})", flush=True)
        tally = torture.kill(options.kills)
    print(tally.table())
    print(
        f"{tally.survived} kills and {tally.polite} polite signals, {tally.went_on} processes went on with "
        f"pieces of another, {tally.bakes} bakes came to their end"
    )
    if tally.problems:
        sys.exit("\n".join(tally.problems))
    print(f"all files as those of the uninterrupted bake: {', '.join(torture.expected)}; nothing left behind")


if __name__ == "__main__":
    main()
