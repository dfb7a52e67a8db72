# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The machine's memory: refuse jobs and files that do not fit, before starting."""

from __future__ import annotations

import ctypes
import os
import sys

from ...core.errors import FormatError, InputError
from ...core.messages import Setting, do


def physical_memory() -> int | None:
    """The machine's physical memory in bytes; None if the system does not report it."""
    if sys.platform == "win32":
        return _windows_memory()
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError):
        return None


def readable_size(count: float) -> str:
    """A number of bytes in readable units: 1610612736 is "1.5 GiB"."""
    for unit in ("bytes", "KiB", "MiB"):
        if count < 1024:
            return f"{count:.0f} {unit}"
        count /= 1024
    return f"{count:.1f} GiB"


def check_memory(what: str, needed: int) -> None:
    """Make sure that the machine has `needed` bytes for `what`. Raises FormatError if not."""
    memory = physical_memory()
    if memory is not None and needed > memory:
        needs, has = readable_size(needed), readable_size(memory)
        raise FormatError(f"{what} needs {needs} of memory, this machine has {has}")


def check_allowed(what: str, needed: int, allowed_mb: int | None) -> None:
    """Make sure that `needed` bytes for `what` exceed neither the user's limit, in MiB, nor the memory.

    Raises InputError for the user's limit, FormatError for the machine's memory.
    """
    if allowed_mb is not None and needed > allowed_mb * 2**20:
        needs, allowed = readable_size(needed), readable_size(allowed_mb * 2**20)
        raise InputError(
            f"{what} takes about {needs} of memory, {allowed} are allowed", do("allow more", Setting.MEMORY)
        )
    check_memory(what, needed)


def _windows_memory() -> int | None:
    class MemoryStatus(ctypes.Structure):  # MEMORYSTATUSEX
        _fields_ = (
            ("length", ctypes.c_uint32),
            ("load", ctypes.c_uint32),
            ("physical", ctypes.c_uint64),
            ("others", ctypes.c_uint64 * 6),
        )

    status = MemoryStatus(length=ctypes.sizeof(MemoryStatus))
    told = ctypes.CDLL("kernel32").GlobalMemoryStatusEx(ctypes.byref(status))
    return int(status.physical) if told else None
