# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One process of fuzzing: damages files, reads them, and dies of the first that is not refused as it should.

What it was reading then lies in its folder, whatever it died of. `run.py` starts it.
"""

from __future__ import annotations

import argparse
import faulthandler
import logging
import os
import resource
import shutil
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random
from types import FunctionType
from typing import TextIO

from radtex_addon.core.errors import RadTexError

from .corpus import make_corpus
from .mutate import mutated
from .readers import LONGEST, READERS, Reader, named

HANG = 10  # seconds
MOST_MEMORY = 1 << 30  # bytes beyond what the process took before
_MOST_ADDRESSES = 24 << 30  # bytes: what is asked for and never touched counts here
_MOST_BYTES = 1 << 16  # of an input


class Judge:
    """Gives one reader one input after another, and raises AssertionError for what no reader may do."""

    def __init__(self, reader: Reader, folder: Path, aloud: TextIO) -> None:
        """`folder` holds a corpus; `aloud` hears of a reader that hangs."""
        self.reader, self._path, self.aloud = reader, folder / reader.target, aloud
        self.seeds = [path.read_bytes() for path in sorted(folder.glob(reader.seeds or reader.target))]
        self._sidecars = {path: path.read_bytes() for path in folder.glob("*.json")}
        self._before = _most_resident()
        self.read = self.refused = 0

    def __call__(self, data: bytes) -> None:
        for path, text in self._sidecars.items() if self.reader.follow else ():
            path.write_bytes(text)
        self._path.write_bytes(data)
        if self.reader.follow is not None:
            self.reader.follow(self._path)
        faulthandler.dump_traceback_later(HANG, exit=True, file=self.aloud)
        try:
            self.reader.read(self._path)
            self.read += 1
        except self.reader.raises as error:
            self.refused += 1
            named(error, self._path)
        except RadTexError as error:
            raise AssertionError(f"raised {type(error).__name__}: {error}") from error
        finally:
            faulthandler.cancel_dump_traceback_later()
        assert self.taken < MOST_MEMORY, f"took {self.taken / 2**20:.0f} MiB of memory"
        sys.stdout.flush()
        assert self.reader.blender or not os.fstat(1).st_size, f"it printed {_printed()!r}"

    @property
    def taken(self) -> int:
        """The most memory, in bytes, that was taken beyond what the process had before."""
        return _most_resident() - self._before


def main() -> None:
    """Run some executions of each reader; a line for each says how they ended."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("readers", choices=READERS, nargs="+")
    parser.add_argument("--executions", type=int, required=True, help="of each")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=Path, required=True, help="gets a folder for each reader")
    parser.add_argument("--guided", action="store_true", help="of one reader")
    parser.add_argument(
        "--replay", type=Path, help="first give each reader all files in this folder's READER"
    )
    options = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (_MOST_ADDRESSES, _MOST_ADDRESSES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    warnings.simplefilter("error")
    logging.getLogger("radtex_addon").addHandler(_OneLine())
    with os.fdopen(os.dup(1), "w") as aloud, tempfile.TemporaryFile() as silence:
        os.dup2(silence.fileno(), 1)
        faulthandler.enable(aloud)
        try:
            make_corpus(options.folder / "corpus")
            for name in options.readers:
                shutil.copytree(options.folder / "corpus", options.folder / name)
                judge = Judge(READERS[name], options.folder / name, aloud)
                for data in judge.seeds:
                    judge(data)
                for path in sorted((options.replay / name).glob("*")) if options.replay else ():
                    judge(path.read_bytes())
                _give(judge, options.executions, options.seed, options.guided, name)
        except BaseException:  # noqa: BLE001  # whatever it is, it is a finding
            traceback.print_exc(file=aloud)
            aloud.flush()
            os._exit(1)
    os._exit(0)  # threads of libraries may wait for ever


def _give(judge: Judge, executions: int, seed: int, guided: bool, name: str) -> None:
    def say() -> None:
        print(f"done {name} {judge.read} {judge.refused} {judge.taken}", file=judge.aloud, flush=True)

    if guided:
        _guided(judge, executions, seed, say)
    else:
        _plain(judge, executions, seed)
        say()


class _OneLine(logging.Handler):
    """Hears warnings, which are one line as errors are."""

    def emit(self, record: logging.LogRecord) -> None:
        said = record.getMessage()
        assert said.count("\n") == 0, f"not one line: {said!r}"
        assert len(said) <= LONGEST, f"of {len(said)} characters: {said!r}"


def _plain(judge: Judge, executions: int, seed: int) -> None:
    """Damage the corpus's files alone; each seed makes the same inputs everywhere."""
    for number in range(executions):
        random = Random(f"{seed} {number}")
        judge(mutated(random.choice(judge.seeds), random, (judge.reader.way,), _MOST_BYTES))


def _guided(judge: Judge, executions: int, seed: int, say: Callable[[], None]) -> None:
    """Let atheris (libFuzzer) damage further what reached new lines of ours; the process ends with it."""
    import atheris  # noqa: PLC0415  # only here is it needed

    def mutate(data: bytes, most: int, number: int) -> bytes:
        return mutated(data, Random(number), (judge.reader.way,), most)

    left = executions

    def one_input(data: bytes) -> None:
        nonlocal left
        judge(data)
        left -= 1
        if not left:
            say()
            os._exit(0)

    for function in _functions():
        atheris.instrument_func(function)
    with tempfile.TemporaryDirectory() as corpus:
        for number, data in enumerate(judge.seeds):
            Path(corpus, f"{number}").write_bytes(data)
        options = [f"-runs={2 * executions}", f"-seed={seed + 1}", f"-max_len={_MOST_BYTES}"]
        options += ["-mutate_depth=1"]  # ours changes enough at once
        options += ["-rss_limit_mb=0", "-verbosity=0", f"-artifact_prefix={corpus}/"]
        atheris.Setup([sys.argv[0], *options, corpus], one_input, custom_mutator=mutate)
        atheris.Fuzz()


def _functions() -> Iterator[FunctionType]:
    """All of ours that are loaded."""
    for name, module in list(sys.modules.items()):
        if name.startswith("radtex_addon."):
            places = [module, *(item for item in vars(module).values() if isinstance(item, type))]
            for place in places:
                found = (item for item in vars(place).values() if isinstance(item, FunctionType))
                yield from (function for function in found if function.__module__ == name)


def _printed() -> bytes:
    """How what was printed begins."""
    os.lseek(1, 0, os.SEEK_SET)
    return os.read(1, 300)


def _most_resident() -> int:
    """Bytes of memory that this process has had at most."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


if __name__ == "__main__":
    main()
