# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The key of an unfinished bake: facts that its pieces belong to, files it may replace, its processes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeAlias

from ..core.errors import InputError
from ..core.messages import Remedy, Setting, do
from ..core.near_digest import is_same
from ..formats.disk.atomic import write_text
from ..formats.disk.lock import NoLockError, holder
from ..formats.disk.regular import read_regular
from ..formats.json_reader import shown
from . import piece_format

Facts: TypeAlias = Mapping[str, str]

VERSION = 1
KEY = "key.json"
LOCK = "lock"
DIGEST = "sha256:"  # prefix of facts that are hashes, which messages do not show


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


def is_unfinished(folder: Path) -> bool:
    """Whether the folder holds the checkpoint of a bake that was not finished."""
    return (folder / KEY).is_file()


def is_announced(folder: Path) -> bool:
    """Whether the bake in `folder` was only announced and has not started."""
    try:
        return is_unfinished(folder) and not read_key(folder).facts
    except InputError:
        return False


def check_free(folder: Path) -> None:
    """Raises InputError where a process works on the bake in `folder`, or its lock is no lock file."""
    try:
        who = holder(folder / LOCK)
    except NoLockError as error:
        raise InputError(str(error)) from error
    if who:
        raise InputError(in_use(folder, who))


def in_use(folder: Path, who: str) -> str:
    """The message for a folder that the process `who` is working on."""
    return f"{folder} is in use, {who} bakes into it: wait for its end, or end it"


def replaced_by(folder: Path) -> frozenset[str]:
    """The names of files that the unfinished bake in `folder` may replace, as it may have written them."""
    return frozenset(read_key(folder).replaces) if is_unfinished(folder) else frozenset()


def workers(folder: Path) -> list[int]:
    """The processes that have worked on the bake in `folder`, of any format; none if its key is damaged."""
    with suppress(InputError):
        return _read_any(folder)[0].processes if is_unfinished(folder) else []
    return []


def write_key(folder: Path, key: Key) -> None:
    """Write the key into the folder. Raises BakeError where the system refuses."""
    known = {"version": VERSION, "pieces": piece_format.PIECE_FORMAT}
    write_text(folder / KEY, json.dumps(known | asdict(key), indent=2) + "\n")


def read_key(folder: Path) -> Key:
    """Read the folder's key. Raises InputError, which says how to bake without it.

    Also for pieces of another format than this program's: they stay as they are.
    """
    key, pieces = _read_any(folder)
    if key.facts and pieces != piece_format.PIECE_FORMAT:
        raise InputError(
            f"{folder} holds pieces of format {shown(str(pieces), 20)}, this RadTex makes those "
            f"of format {piece_format.PIECE_FORMAT}",
            do("go on with the RadTex that made them"),
            _anew(),
        )
    return key


def known_key(folder: Path) -> Key | None:
    """The key of the unfinished bake in `folder`, whatever the format of its pieces; None without one."""
    with suppress(InputError):
        return _read_any(folder)[0] if is_unfinished(folder) else None
    return None


def _read_any(folder: Path) -> tuple[Key, object]:
    """The folder's key, and of which format its pieces are said to be. Raises InputError."""
    path, anew = folder / KEY, _anew()
    try:
        key = json.loads(read_regular(path))
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror or error})", anew) from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is damaged", anew) from error
    if not isinstance(key, dict) or key.pop("version", None) != VERSION or not _is_key(key):
        raise InputError(f"{path} is damaged, or of another RadTex", anew)
    known = Key(key["facts"], key["replaces"], key["processes"], key.get("made"), key.get("blend", ""))
    return known, key.get("pieces")


def _anew() -> Remedy:
    return do("begin anew", Setting.OVERWRITE, without=(Setting.RESUME,))


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


def _difference(name: str, before: str | None, now: str) -> str:
    if before is not None and is_same(before, now):
        return ""
    if before is None or now.startswith(DIGEST):
        return name
    return f"{name} ({shown(before, 200)}, now {now})"
