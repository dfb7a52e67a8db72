# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Give the batch odd command lines.

    python -m tests.fuzz.lines --executions 100000 [--seed 0] [--processes 200]

Each is run as the batch runs it, in this process, outside and inside of Blender, up to where a scene would be
opened; `--processes` more as `python bake.py …`. It ends with 0 for help and the version, else with 2 and one
line on standard error. Anything else is a finding: it is printed, and kept in tests/fuzz/failures/lines.json,
where test_lines.py finds it. The exit code is 1 if there were findings.
"""

from __future__ import annotations

import argparse
import contextlib
import faulthandler
import io
import json
import os
import subprocess
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from random import Random
from time import perf_counter

import bpy

from radtex_addon.cli import main as batch
from radtex_addon.core.errors import RadTexError

from .corpus import make_corpus
from .grammar import HARMLESS, command_line
from .readers import UNSEEN

KEPT = Path(__file__).with_name("failures") / "lines.json"
FOLDER = "<corpus>"  # in kept lines
_AS_WRITTEN = argparse.RawDescriptionHelpFormatter
_BAKE = Path(__file__).resolve().parents[2] / "bake.py"
_HANG = 10  # seconds
_LONGEST = 30_000  # characters: a message is cut, and what it quotes may be escaped
_SLOW = 120  # seconds for a process, most of which Blender needs to start


def main() -> int:
    """Run, and say how the lines ended; 1 if there were findings."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=_AS_WRITTEN)
    parser.add_argument("--executions", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--processes", type=int, default=0, help="how many more, each in its own process")
    options = parser.parse_args()
    warnings.simplefilter("error")
    begin, endings, findings = perf_counter(), Counter[int](), []
    with tempfile.TemporaryDirectory(prefix="radtex-fuzz-") as place:
        folder = Path(place)
        make_corpus(folder)
        for number in range(options.executions + options.processes):
            words = command_line(Random(f"{options.seed} {number}"), folder)
            in_process = number < options.executions
            faulthandler.dump_traceback_later(_HANG if in_process else _SLOW, exit=True)
            try:
                endings[judge(words, bool(number % 2)) if in_process else judge_process(words)] += 1
            except Exception:  # noqa: BLE001  # whatever it is, it is a finding
                findings.append(traceback.format_exc())
                keep([word.replace(place, FOLDER) for word in words], bool(number % 2))
            faulthandler.cancel_dump_traceback_later()
    print(*findings, sep="\n")
    ended = ", ".join(f"{count} with {code}" for code, count in sorted(endings.items()))
    seconds = perf_counter() - begin
    print(f"{sum(endings.values())} lines in {seconds:.1f} s: {ended}; {len(findings)} findings")
    return 1 if findings else 0


def judge(words: Sequence[str], inside_blender: bool) -> int:
    """Run a line here and return its exit code. Raises AssertionError for an end that no line may have."""
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said), _silent_stdout():
            code = _run(list(words), inside_blender)
    except SystemExit as ended:
        code = int(ended.code or 0)
    check(words, code, said.getvalue())
    return code


def judge_process(words: Sequence[str]) -> int:
    """The same in a process of its own, which is what people start."""
    given = [os.fsencode(word.replace("\0", "")) for word in words if word not in HARMLESS and _encodes(word)]
    if any(len(word) > 100_000 for word in given):  # Linux starts no process with such a word
        given = []
    command: list[str | bytes] = [sys.executable, str(_BAKE), *given]
    ended = subprocess.run(command, capture_output=True, stdin=subprocess.DEVNULL, timeout=_SLOW, check=False)
    check([*map(os.fsdecode, given)], ended.returncode, ended.stderr.decode(errors="replace"))
    return ended.returncode


def check(words: Sequence[str], code: int, said: str) -> None:
    """See that a line ended as it may."""
    asked = any(word.startswith(("-h", "--help", "--version")) for word in words)
    assert code == 2 or (code == 0 and asked), f"exit code {code}: {said[-2000:]!r}"
    lines = [line for line in said.split("\n") if line]
    if "--verbose" in words:  # Blender's own lines come before
        lines, said = lines[-1:], "".join(lines[-1:])
    assert len(lines) == (code == 2), f"{len(lines)} lines: {said[-2000:]!r}"
    if code:
        assert said.startswith("radtex: "), f"of nobody: {said[:300]!r}"
        assert not UNSEEN.search(said.rstrip("\n")), f"not one line: {said[:300]!r}"
        assert 10 < len(said) < _LONGEST, f"of {len(said)} characters"


def keep(words: list[str], inside_blender: bool) -> None:
    """Keep a line of a finding."""
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else []
    kept.append([inside_blender, words])
    KEPT.parent.mkdir(exist_ok=True)
    KEPT.write_text(json.dumps(kept, indent=1) + "\n")


def _run(words: list[str], inside_blender: bool) -> int:
    """As `main`, but what would bake, or end with its parent, is only understood."""
    if not set(words).intersection(HARMLESS):
        return batch.main(words, inside_blender)
    command = batch._COMMANDS.get(words[0], batch._BAKE)
    try:
        command.parse(words[1:] if words[0] in batch._COMMANDS else words, inside_blender)
    except RadTexError as error:
        return batch._complain(error)
    return batch._complain(RadTexError("this line is understood"))


@contextlib.contextmanager
def _silent_stdout() -> Iterator[None]:
    """Nothing is seen of Blender's words, nor of help."""
    before = os.dup(1)
    with Path(os.devnull).open("w") as nowhere, contextlib.redirect_stdout(nowhere):
        os.dup2(nowhere.fileno(), 1)
        try:
            yield
        finally:
            os.dup2(before, 1)
            os.close(before)


def _encodes(word: str) -> bool:
    try:
        os.fsencode(word)
    except UnicodeEncodeError:
        return False
    return True


if __name__ == "__main__":
    assert bpy.app.background
    sys.exit(main())
