# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of this machine that are copied to a farm: checked for their type and size, and listed."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from ..core.errors import InputError
from ..formats.disk.kinds_of_files import FileKind, open_of_kind
from ..formats.disk.memory import readable_size

MOST_PACKED = (2 << 30) - 1  # bytes of a file in a .blend
MOST_BESIDE = 16 << 30  # bytes of a file beside it
MOST = 32 << 30  # bytes of all of them

_PUT_BACK = "put the right file there, or take it out of the scene"


@dataclass(frozen=True)
class Carried:
    """A file that is copied; `user` names the data-block that uses it; `bytes` is None if only a part is."""

    user: str
    path: str
    bytes: int | None
    how: str

    def __str__(self) -> str:
        size = "" if self.bytes is None else f", {readable_size(self.bytes)}"
        return f"{self.user}: {self.path} ({self.how}{size})"


class Luggage:
    """The files to be copied so far."""

    def __init__(self) -> None:
        self.carried: list[Carried] = []

    def add(self, user: str, path: Path, kind: FileKind, how: str, most: int = MOST_PACKED) -> None:
        """Check and add a file. Raises InputError as `opened` does."""
        with self.opened(user, path, kind, how, most):
            pass

    @contextmanager
    def opened(self, user: str, path: Path, kind: FileKind, how: str, most: int) -> Iterator[BinaryIO]:
        """Check and add a file, and return it open.

        Raises InputError, with its name, if it cannot be read, is no regular file, of another type than its
        user reads, or too large.
        """
        try:
            file = open_of_kind(path, kind)
        except OSError as error:
            raise InputError(
                f"{user}: {path} cannot be read ({error.strerror or error}): {_PUT_BACK}"
            ) from error
        except ValueError as error:
            raise InputError(f"{user}: {path} does not travel, for {error}: {_PUT_BACK}") from error
        with file:
            size = os.fstat(file.fileno()).st_size
            total = size + sum(each.bytes or 0 for each in self.carried)
            if size > most:
                raise InputError(
                    f"{user}: {path} has {readable_size(size)}, and {readable_size(most)} are the most that "
                    "travel: make it smaller, or bake without a farm"
                )
            if total > MOST:
                raise InputError(
                    f"{user}: with {path} {readable_size(total)} would travel, and {readable_size(MOST)} are "
                    "the most: make files smaller, or bake without a farm"
                )
            self.carried.append(Carried(user, str(path), size, how))
            yield file

    def copy(self, user: str, path: Path, kind: FileKind, target: Path) -> None:
        """Copy a file to `target`, which is new. Raises InputError as `opened` does, OSError."""
        with self.opened(user, path, kind, "beside the .blend", MOST_BESIDE) as file:
            size = os.fstat(file.fileno()).st_size
            free = shutil.disk_usage(target.parent).free
            if size > free:
                raise InputError(
                    f"{user}: {path} has {readable_size(size)}, and {target.parent} has room for "
                    f"{readable_size(free)}: free its disk, or choose another folder"
                )
            with target.open("xb") as copy:
                while size > 0 and (data := file.read(min(size, 1 << 22))):
                    copy.write(data)
                    size -= len(data)
