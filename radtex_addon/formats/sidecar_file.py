# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A sidecar's file, read once and passed on, so that no command reads it twice."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from ..core.errors import FormatError
from .disk.regular import read_regular
from .json_reader import Facts


@dataclass(frozen=True)
class SidecarFile:
    """A sidecar that was read: where it lies, and the JSON in it."""

    path: Path
    facts: Facts

    @classmethod
    def read(cls, path: Path) -> SidecarFile:
        """Read the file. Raises FormatError, with the path, if it is missing, not JSON, or not an object."""
        return cls(path, Facts.parse(read_text(path), str(path)))

    def __str__(self) -> str:
        return str(self.path)


AnySidecar: TypeAlias = Path | SidecarFile  # readers take either, and read the file only if it is a path


def opened(sidecar: AnySidecar) -> SidecarFile:
    """The sidecar's file, now read if it is a path. Raises FormatError as `SidecarFile.read` does."""
    return sidecar if isinstance(sidecar, SidecarFile) else SidecarFile.read(sidecar)


def read_facts(sidecar: AnySidecar) -> Facts:
    """The JSON of a sidecar of any layout and kind. Raises FormatError as `SidecarFile.read` does."""
    return opened(sidecar).facts


def read_text(path: Path) -> str:
    """Read the text of a sidecar or another text file of ours.

    Raises FormatError, with the path, if it cannot be read, is not UTF-8 or is far larger than any of ours.
    """
    try:
        return read_regular(path).decode("utf-8")
    except UnicodeDecodeError as error:
        raise FormatError(f"{path} is not text: it is no RadTex sidecar") from error
    except OSError as error:
        raise FormatError(f"{path} cannot be read: {error.strerror or error}") from error
    except ValueError as error:  # a zero byte in its name
        raise FormatError(f"{path} cannot be read: {error}") from error


def mismatch_error(image: Path, sidecar: AnySidecar) -> FormatError:
    """The error for an image whose header or digest does not match the sidecar beside it."""
    path = sidecar.path if isinstance(sidecar, SidecarFile) else sidecar
    return FormatError(
        f"{image} is of another bake than {path}: put one bake's files together, or bake again"
    )
