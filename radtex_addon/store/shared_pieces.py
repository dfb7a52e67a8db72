# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The pieces of one bake in a folder that several machines write to, each for a task of its own.

Nobody holds a lock. A piece is written beside under a name of its own, then linked to its name: it appears
whole, and the first one that is there stays. So a task may be done twice, and at once.
"""

from __future__ import annotations

import json
import logging
import os
import secrets
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import numpy.typing as npt

from ..bake.piece_store import Arrays, Facts, PieceStore
from ..core.errors import BakeError, InputError
from ..formats.disk.atomic import flush_folder, refusal
from ..formats.disk.regular import read_regular
from .checkpoint_files import PIECE, Key, label_of, read_piece, read_rows, write_piece

log = logging.getLogger(__name__)

PATIENCE = 10.0  # seconds that others' files may take to appear
_LOOK = 0.5  # seconds between looks
_FACTS = "facts.json"
_BESIDE = ".radtex-"  # how the names of unfinished files begin


class SharedPieces(PieceStore):
    """The pieces in `folder`, of which this process makes some.

    `makes` tells of which names. Others are only read: BakeError says by `whose`, with the reason, where one
    is not there or damaged. Of pieces that can be shared out, and that it makes, it makes the part number
    `share[0]` of `share[1]`. The bake's own files are written into `results`. `ignored` facts may differ.
    """

    def __init__(
        self,
        folder: Path,
        results: Path,
        makes: Callable[[str], bool],
        whose: Callable[[str, str], BakeError],
        share: tuple[int, int] = (0, 1),
        ignored: Collection[str] = (),
    ) -> None:
        self._folder, self._results = folder, results
        self._makes, self._whose, self._share, self._ignored = makes, whose, share, frozenset(ignored)
        self._facts: dict[str, str] = {}
        self._known: Facts | None = None
        self.used: dict[str, None] = {}  # the names of the pieces that this process was to make

    @property
    def keeps(self) -> bool:
        return True

    def set_facts(self, facts: Facts) -> None:
        """Set the facts that the pieces belong to. Raises InputError if those of other machines differ."""
        if self._known is None:
            self._known = self._read_facts()
        self._facts.update(facts if self._known is None else self._same(self._known, facts))

    def names(self) -> list[str]:
        return sorted(path.stem for path in self._folder.glob(f"*{PIECE}") if not _is_beside(path))

    def found(self, name: str) -> Arrays | None:
        own = self._makes(name)
        if own:
            self._begin()
            self.used[name] = None
        path = self._path(name)
        if not own:
            appears(path)
        try:
            return read_piece(path, label_of(name, self._facts))
        except FileNotFoundError:
            if own:
                return None
            raise self._whose(name, "is not there") from None
        except OSError as error:
            raise BakeError(f"{path} cannot be read ({error.strerror or error})") from error
        except Exception as error:  # numpy's header parser may raise anything
            if not own:
                raise self._whose(name, f"is damaged ({error})") from error
            log.warning("%s is damaged and is made again (%s)", path, error)
            with suppress(OSError):
                path.unlink()
            return None

    def keep(self, name: str, arrays: Arrays) -> None:
        self._begin()
        with appearing(self._path(name)) as beside:
            write_piece(beside, label_of(name, self._facts), arrays)

    def get_or_make(self, name: str, make: Callable[[], Arrays]) -> Arrays:
        """The stored piece; what `make` makes is stored, unless another machine was quicker."""
        kept = self.found(name)
        if kept is not None:
            return kept
        made = make()
        self.keep(name, made)
        return self.found(name) or made

    def rows(self, name: str, array: str, first: int, count: int) -> npt.NDArray[Any]:
        path = self._path(name)
        try:
            return read_rows(path, array, first, count)
        except Exception as error:
            raise BakeError(f"{path} can no longer be read ({error}): do this task again") from error

    def place(self, path: Path) -> Path:
        try:
            self._results.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BakeError(refusal(self._results, error)) from error
        return self._results / path.name

    def share_of(self, names: Sequence[str]) -> Sequence[int]:
        number, count = self._share
        if not names or not self._makes(names[0]):
            return range(len(names))
        return range(number * len(names) // count, (number + 1) * len(names) // count)

    def _begin(self) -> None:
        """Write the facts, or take those of the machine that was quicker."""
        if self._known is not None:
            return
        with appearing(self._folder / _FACTS) as beside:
            beside.write_text(json.dumps({"facts": self._facts}, indent=2) + "\n", encoding="utf-8")
        self._known = self._read_facts() or {}
        self._facts.update(self._same(self._known, self._facts))

    def _read_facts(self) -> Facts | None:
        path = self._folder / _FACTS
        try:
            found = json.loads(read_regular(path))["facts"]
        except FileNotFoundError:
            return None
        except OSError as error:
            raise BakeError(f"{path} cannot be read ({error.strerror or error})") from error
        except (ValueError, LookupError, TypeError, RecursionError) as error:
            raise BakeError(f"{path} is damaged: prepare the farm anew") from error
        return {str(name): str(value) for name, value in dict(found).items()}

    def _same(self, known: Facts, facts: Facts) -> dict[str, str]:
        """The known facts of these names, which differ by rounding at most. Raises InputError."""
        compared = {name: value for name, value in facts.items() if name not in self._ignored}
        if said := Key(known, [], []).differences(compared):
            raise InputError(
                f"what this machine would bake differs from what others have begun in {self._folder} in "
                f"{said}: use the same file, version of Blender and kind of device on each"
            )
        return {name: known.get(name, facts[name]) for name in facts}

    def _path(self, name: str) -> Path:
        return piece_file(self._folder, name)


def piece_file(folder: Path, name: str) -> Path:
    """The file of the piece of that name."""
    return folder / f"{name}{PIECE}"


def _is_beside(path: Path) -> bool:
    return path.name.startswith(_BESIDE)


def appears(path: Path) -> bool:
    """Whether a file that others write is there, or is within a while: disks of a network show names late."""
    since = monotonic()
    while not path.exists():
        if monotonic() - since > PATIENCE:
            return False
        sleep(_LOOK)
        with suppress(OSError):
            list(path.parent.iterdir())  # asks the disk anew
    return True


@contextmanager
def appearing(path: Path) -> Iterator[Path]:
    """Yield a path beside `path`; the file that is written there gets that name, unless there is one already.

    It appears whole or not at all. Creates the folder if needed. Raises BakeError where the system refuses.
    """
    beside = path.with_name(f"{_BESIDE}{secrets.token_hex(12)}{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            yield beside
            with beside.open("r+b") as stream:
                os.fsync(stream.fileno())
            _link(beside, path)
            flush_folder(path.parent)
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:
        raise BakeError(refusal(path, error).replace(str(beside), str(path))) from error


def _link(beside: Path, path: Path) -> None:
    """Give a file its name, if that is free. Raises OSError."""
    try:
        os.link(beside, path)
    except FileExistsError:
        return
    except OSError:  # a disk without hard links
        if not path.exists():
            beside.replace(path)
