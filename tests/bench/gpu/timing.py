# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The device that draws, and how long it takes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter, process_time

import moderngl
import numpy as np

from radtex_addon.core.arrays import Floats

from ..drawing import Painter, View, canvas

_ON_PROCESSORS = ("llvmpipe", "softpipe", "swrast", "SwiftShader")
_UNUSABLE = "not usable"
_MOST = 16  # devices that are asked for
_WARM_UP = 10  # rounds, at most: a card's clock speeds up
TIMER, PROCESSORS = "timer query", "processor time of all threads"


class NoDeviceError(Exception):
    """A device that is not there."""


@dataclass(frozen=True, eq=False)
class Device:
    """A device that draws: its OpenGL `context`, and what its driver says of it."""

    context: moderngl.Context

    @property
    def card(self) -> str:
        return str(self.context.info["GL_RENDERER"])

    @property
    def driver(self) -> str:
        return f"{self.context.info['GL_VENDOR']}, OpenGL {self.context.info['GL_VERSION']}"

    @property
    def is_processor(self) -> bool:
        """Whether it draws on the processor, where timer queries say nothing and blocks are slow to read."""
        return any(name in self.card for name in _ON_PROCESSORS)

    @property
    def clock(self) -> str:
        return PROCESSORS if self.is_processor else TIMER


@contextmanager
def device(number: int | None = None) -> Iterator[Device]:
    """The device of that number, over EGL, without a window; without one the first that is a card, if any is.

    Raises NoDeviceError if there is no such device.
    """
    found = cards()
    if number is None:
        usable = [each for each, card in enumerate(found) if not card.startswith(_UNUSABLE)]
        real = [each for each in usable if not any(name in found[each] for name in _ON_PROCESSORS)]
        number = min(real or usable or [0])
    if number >= len(found):
        raise NoDeviceError(f"no device {number}; EGL knows these: {', '.join(found) or 'none'}")
    with _opened(number) as context:
        yield Device(context)


def cards() -> list[str]:
    """All devices that EGL knows, by number."""
    found: list[str] = []
    for number in range(_MOST):
        try:
            with _opened(number) as context:
                found.append(context.info["GL_RENDERER"])
        except Exception as error:  # noqa: BLE001  # moderngl has no narrower one
            if "requested device index" in str(error):
                break
            found.append(f"{_UNUSABLE}: {error}")
    return found


def _opened(number: int) -> moderngl.Context:
    return moderngl.create_context(standalone=True, backend="egl", device_index=number)  # type: ignore[arg-type]  # wrong stub


@dataclass(frozen=True, eq=False)
class Frames:
    """Milliseconds of a lookup's frames by the device's clock, and by the wall's (N,)."""

    clock: Floats
    wall: Floats


def measured(
    device: Device,
    painters: Mapping[str, tuple[Painter, View]],
    size: tuple[int, int],
    frames: int,
    draws: int = 1,
) -> dict[str, Frames]:
    """Frames of each painter, drawn in turns into 8-bit colours, which are cleared before the clock runs.

    A frame draws `draws` times, each fragment again, and counts as one of them.
    """
    context = device.context
    target = canvas(context, size, dtype="f1").drawn
    query = context.query(time=True)
    clock: dict[str, list[float]] = {name: [] for name in painters}
    wall: dict[str, list[float]] = {name: [] for name in painters}
    warm_up = min(frames - 1, 1 if device.is_processor else _WARM_UP)
    for number in range(-warm_up, frames):
        for name, (painter, view) in painters.items():
            painter.bind(target, view)
            target.clear()
            context.finish()
            started, used = perf_counter(), process_time()
            with query:
                for _ in range(draws):
                    painter.render()
            context.finish()
            seconds, used = perf_counter() - started, process_time() - used
            if number >= 0:
                elapsed = used if device.is_processor else query.elapsed / 1e9
                clock[name].append(1e3 * elapsed / draws)
                wall[name].append(1e3 * seconds / draws)
    return {name: Frames(np.array(clock[name]), np.array(wall[name])) for name in painters}
