# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The times of this machine's finished bakes, in a small file of JSON lines, for estimates of more."""

from __future__ import annotations

import json
import logging
from dataclasses import asdict, fields
from math import isfinite
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from ..core.errors import RadTexError
from ..formats.disk.atomic import write_text
from ..formats.disk.lock import HeldError, Lock, take_lock
from ..formats.disk.regular import read_regular
from .estimate import STAGES, BakeWork, Measurement
from .kinds import Kind

log = logging.getLogger(__name__)

MOST = 400  # bakes; older ones are dropped
_MOST_BYTES = 1 << 20  # a larger file is not ours
_PATIENCE = 2.0  # seconds to wait for another Blender that writes


def read_history(path: Path) -> tuple[Measurement, ...]:
    """The finished bakes in the file, the latest last; the log says what cannot be read of it."""
    try:
        data = read_regular(path)
    except FileNotFoundError:
        return ()
    except (OSError, RadTexError) as error:
        log.info("the times of earlier bakes in %s cannot be read: %s", path, error)
        return ()
    if len(data) > _MOST_BYTES:
        log.info("%s is too large to hold the times of earlier bakes: it is ignored", path)
        return ()
    found, broken = [], 0
    for line in data.decode(errors="replace").splitlines():
        try:
            found.append(_parsed(line))
        except (ValueError, TypeError, KeyError, RecursionError):
            broken += 1
    if broken:
        log.info("%d lines of %s hold no times of bakes: they are ignored", broken, path)
    return tuple(found[-MOST:])


def remember(path: Path, made: Measurement) -> None:
    """Add a finished bake to the file, and drop the oldest above `MOST`. Several processes may do so at once.

    Where the file cannot be written the log says so, and the bake is forgotten.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        lock = _locked(path.with_suffix(".lock"))
        try:
            kept = (*read_history(path), made)[-MOST:]
            write_text(path, "".join(f"{_line(one)}\n" for one in kept))
        finally:
            lock.release()
    except (OSError, RadTexError, HeldError) as error:
        log.info("the time of this bake cannot be kept in %s: %s", path, error)


def _locked(path: Path) -> Lock:
    """The lock, once other processes have released it. Raises HeldError after `_PATIENCE`, OSError."""
    until = monotonic() + _PATIENCE
    while True:
        try:
            return take_lock(path)
        except HeldError:
            if monotonic() > until:
                raise
            sleep(0.01)


def _line(one: Measurement) -> str:
    seconds = {stage: round(value, 3) for stage, value in one.seconds.items()}
    told = {"place": one.place, "name": one.name, "work": asdict(one.work), "seconds": seconds}
    return json.dumps(told | {"shown_triangles": one.shown_triangles})


def _parsed(line: str) -> Measurement:
    """Inverse of `_line`. Raises ValueError, TypeError or KeyError for anything else."""
    told = json.loads(line)
    place, name, seconds = told["place"], told["name"], told["seconds"]
    if not isinstance(place, str) or not isinstance(name, str) or not isinstance(seconds, dict):
        raise TypeError("no measurement")
    if not all(stage in STAGES and _is_time(value) for stage, value in seconds.items()):
        raise ValueError("no seconds by stage")
    shown = told.get("shown_triangles", 0)  # earlier versions did not keep it
    if type(shown) is not int or shown < 0:
        raise TypeError("no number of triangles")
    return Measurement(place, name, work_in(told["work"]), seconds, shown_triangles=shown)


def work_in(told: Any) -> BakeWork:
    """The work in JSON's `told`. Raises ValueError or TypeError for anything else."""
    if not isinstance(told, dict):
        raise TypeError("no work")
    work = BakeWork(**told)
    for one in fields(BakeWork):
        value, kind = getattr(work, one.name), type(one.default) if one.name in _DEFAULTS else None
        if one.name in ("kind", "layout", "device", "unwrap"):
            kind = str
        if type(value) is not (kind or int):
            raise TypeError(f"{one.name} is of another type")
    Kind(work.kind)
    if (
        min(work.texels, work.covered, work.bucket, work.samples, work.values) < 1
        or min(work.triangles, work.exports) < 0
    ):
        raise ValueError("no amount of work")
    if not 0 < work.surroundings <= 1:
        raise ValueError("no width of surroundings")
    return work


_DEFAULTS = ("values", "denoise", "preview", "surroundings", "exports")


def _is_time(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value) and value >= 0
