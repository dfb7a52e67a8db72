# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls that nothing can interrupt, such as renders, and in whose midst the process may end.

They write nothing that stays.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Lock

_lock = Lock()  # held while a call begins, while it ends, and while it is abandoned
_inside = [0]  # calls


@contextmanager
def abandonable() -> Iterator[None]:
    """Tell that such a call is made inside."""
    _count(1)
    try:
        yield
    finally:
        _count(-1)


def abandon(leave: Callable[[], None]) -> None:
    """Call `leave`, which ends the process, if it is in such a call; from another thread."""
    with _lock:
        if _inside[0]:
            leave()


def _count(change: int) -> None:
    with _lock:
        _inside[0] += change
