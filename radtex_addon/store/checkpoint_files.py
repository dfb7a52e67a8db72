# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of a checkpoint: its key, which says what bake it is of, and the pieces that are done.

A piece is named arrays, after a first line that says which bake and piece they belong to, and before a digest
of all that, so that half-written or damaged files are noticed.
"""

from __future__ import annotations

import hashlib
import json
import os
from contextlib import suppress
from dataclasses import asdict, dataclass
from math import prod
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from ..bake.piece_store import Arrays, Facts
from ..core.errors import InputError
from ..core.messages import Setting, do
from ..core.near_digest import DIGEST, is_same
from ..formats.disk.atomic import write_text
from ..formats.disk.regular import MOST_TEXT, open_regular, read_regular
from ..formats.json_reader import shown

# Raise it by one with every change after which this program would make, or expect, another piece or frame of
# the same bake: which arrays a piece has, their names, shapes, types and units; how sheets, tiles and bands
# are cut; which rays are traced, in which order and with which seeds; what a stage of a fit hands to the next
# one; what the filling of gutters and hidden cells stores. RadTex's version is compared besides: it tells
# releases apart, this number what was built between them, and farms, whose frames later releases may join.
PIECE_FORMAT = 8

KEY = "key.json"
LOCK = "lock"
PIECE = ".piece"
_VERSION = 1  # of the key
ANEW = do("begin anew", Setting.OVERWRITE, without=(Setting.RESUME,))
_DIGEST_BYTES = 32
_CHUNK = 1 << 22  # bytes
_NUMPY: Any = np.lib.format  # older stubs leave it untyped


@dataclass(frozen=True)
class Key:
    """The `facts` of a bake, the names of the files that it `replaces`, the `processes` that worked on it.

    `made` is the bake's result once all its files are written; some may not have their final names yet.
    `blend` is the name of the .blend that is baked, empty if it is not known.
    """

    facts: Facts
    replaces: list[str]
    processes: list[int]
    made: dict[str, Any] | None = None
    blend: str = ""

    def differences(self, facts: Facts) -> str:
        """The facts that differ from `facts`, in words for a message; empty if none does.

        Digests of meshes that differ by rounding alone are the same.
        """
        said = [_difference(name, self.facts.get(name), value) for name, value in facts.items()]
        return ", ".join(words for words in said if words)


def _difference(name: str, before: str | None, now: str) -> str:
    if before is not None and is_same(before, now):
        return ""
    if before is None or now.startswith(DIGEST):
        return name
    return f"{name} ({shown(before, 200)}, now {now})"


def is_unfinished(folder: Path) -> bool:
    """Whether the folder holds the checkpoint of a bake that was not finished."""
    return (folder / KEY).is_file()


def write_key(folder: Path, key: Key) -> None:
    """Write the key into the folder. Raises BakeError where the system refuses."""
    known = {"version": _VERSION, "pieces": PIECE_FORMAT}
    write_text(folder / KEY, json.dumps(known | asdict(key), indent=2) + "\n")


def read_key(folder: Path) -> Key:
    """Read the folder's key. Raises InputError, which says how to bake without it.

    Also for pieces of another format than this program's: they stay as they are.
    """
    key, pieces = _read_any(folder)
    if key.facts and pieces != PIECE_FORMAT:
        raise InputError(
            f"{folder} holds pieces of format {shown(str(pieces), 20)}, this RadTex makes those "
            f"of format {PIECE_FORMAT}",
            do("go on with the RadTex that made them"),
            ANEW,
        )
    return key


def known_key(folder: Path) -> Key | None:
    """The key of the unfinished bake in `folder`, whatever the format of its pieces; None without one."""
    with suppress(InputError):
        return _read_any(folder)[0] if is_unfinished(folder) else None
    return None


def _read_any(folder: Path) -> tuple[Key, object]:
    """The folder's key, and of which format its pieces are said to be. Raises InputError."""
    path = folder / KEY
    try:
        key = json.loads(read_regular(path))
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror or error})", ANEW) from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is damaged", ANEW) from error
    if not isinstance(key, dict) or key.pop("version", None) != _VERSION or not _is_key(key):
        raise InputError(f"{path} is damaged, or of another RadTex", ANEW)
    known = Key(key["facts"], key["replaces"], key["processes"], key.get("made"), key.get("blend", ""))
    return known, key.get("pieces")


def _is_key(key: dict[str, Any]) -> bool:
    facts, replaces, processes = (key.get(name) for name in ("facts", "replaces", "processes"))
    return (
        isinstance(facts, dict)
        and all(isinstance(value, str) for value in facts.values())
        and isinstance(replaces, list)
        and all(isinstance(value, str) for value in replaces)
        and isinstance(processes, list)
        and all(isinstance(value, int) for value in processes)
        and isinstance(key.get("made"), dict | None)
        and isinstance(key.get("blend", ""), str)
    )


def label_of(name: str, facts: Facts) -> dict[str, str]:
    """The label in a piece's file: a piece of another bake, or of another name, is not used."""
    told = json.dumps([PIECE_FORMAT, facts], sort_keys=True)
    return {"piece": name, "of": hashlib.sha256(told.encode()).hexdigest()}


def write_piece(path: Path, label: dict[str, str], arrays: Arrays) -> None:
    """Write a piece with this label."""
    with path.open("wb") as stream:
        hashing = _Hashing(stream)
        hashing.write((json.dumps({**label, "arrays": list(arrays)}) + "\n").encode())
        for array in arrays.values():
            _NUMPY.write_array(hashing, array, allow_pickle=False)
        stream.write(hashing.digest())


def read_piece(path: Path, label: dict[str, str]) -> Arrays:
    """Read the piece with this label.

    Raises OSError, such as FileNotFoundError, and any other error if it is another piece or damaged.
    """
    with open_regular(path) as stream:
        end = left = os.fstat(stream.fileno()).st_size - _DIGEST_BYTES
        found = hashlib.sha256()
        while left > 0 and (chunk := stream.read(min(_CHUNK, left))):
            found.update(chunk)
            left -= len(chunk)
        if left or stream.read() != found.digest():
            raise ValueError("its digest is wrong")
        stream.seek(0)
        says = json.loads(stream.readline(MOST_TEXT))
        names = says.pop("arrays")
        if says != label:
            raise ValueError("it is of another bake")
        return {name: _read_array(stream, end) for name in names}


def read_rows(path: Path, array: str, first: int, count: int) -> npt.NDArray[Any]:
    """Read rows of an array from a piece that was complete before; the digest is not checked again.

    Raises OSError, and any other error if the file is damaged now.
    """
    with open_regular(path) as stream:
        end = os.fstat(stream.fileno()).st_size - _DIGEST_BYTES
        before = json.loads(stream.readline(MOST_TEXT))["arrays"].index(array)
        shape, dtype = _array_header(stream, end)
        for _ in range(before):
            stream.seek(prod(shape) * dtype.itemsize, os.SEEK_CUR)
            shape, dtype = _array_header(stream, end)
        if not 0 <= first <= first + count <= shape[0]:
            raise ValueError("it has other rows")
        stream.seek(first * prod(shape[1:]) * dtype.itemsize, os.SEEK_CUR)
        found: npt.NDArray[Any] = np.fromfile(stream, dtype, count * prod(shape[1:]))
        if found.size != count * prod(shape[1:]):
            raise OSError("it has become shorter")
        return found.reshape(count, *shape[1:])


def _read_array(stream: BinaryIO, end: int) -> npt.NDArray[Any]:
    """Read an array that ends before `end`; its header is checked before memory is allocated."""
    place = stream.tell()
    _array_header(stream, end)
    stream.seek(place)
    array: npt.NDArray[Any] = _NUMPY.read_array(stream, allow_pickle=False)
    return array


def _array_header(stream: BinaryIO, end: int) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Shape and type of an array that must end before `end`. Raises ValueError if it does not."""
    version = _NUMPY.read_magic(stream)
    shape, _, dtype = _NUMPY.read_array_header_1_0(stream)
    if version != (1, 0) or min(shape, default=0) < 0 or prod(shape) * dtype.itemsize > end - stream.tell():
        raise ValueError("an array in it is not of its size")
    return shape, dtype


class _Hashing:
    """Writes to a stream, and computes the digest of what was written."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream, self._hash = stream, hashlib.sha256()

    def write(self, data: bytes) -> int:
        self._hash.update(data)
        return self._stream.write(data)

    def digest(self) -> bytes:
        return self._hash.digest()
