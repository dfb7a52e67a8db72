# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Digests of files."""

from __future__ import annotations

import hashlib
from pathlib import Path

from ...core.errors import FormatError
from .regular import open_regular


def digest(path: Path) -> str:
    """A file's SHA-256 in hexadecimal digits. Raises FormatError, with the path, if it cannot be read."""
    try:
        with open_regular(path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise FormatError(f"{path} cannot be read: {error.strerror or error}") from error
