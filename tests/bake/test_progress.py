# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress that is passed on is changed on the way, and nothing else."""

from __future__ import annotations

from collections.abc import Generator
from threading import Event, Timer

import pytest

from radtex_addon.bake.progress import Progress, Stage, finished, in_a_thread, relayed
from radtex_addon.core.errors import InputError


def three(ended: list[str]) -> Generator[Progress, None, str]:
    try:
        for done in range(3):
            yield Progress(Stage.FIT, done, 2)
    finally:
        ended.append("ended")
    return "value"


def doubled(step: Progress) -> Progress:
    return Progress(step.stage, 2 * step.done, 2 * step.total)


def test_each_step_is_passed_on_changed_and_the_value_as_it_is() -> None:
    ended: list[str] = []
    steps = relayed(three(ended), doubled)
    assert [next(steps) for _ in range(3)] == [Progress(Stage.FIT, done, 4) for done in (0, 2, 4)]
    with pytest.raises(StopIteration) as stop:
        next(steps)
    assert stop.value.value == "value"
    assert ended.pop() == "ended"
    steps = relayed(three(ended), doubled)
    next(steps)
    assert ended == []
    steps.close()
    assert ended == ["ended"]


def test_a_thread_works_while_its_progress_is_told() -> None:
    """As often as it takes; what it raises is raised here, and closing waits for it."""
    told, go, done = Progress(Stage.UNWRAP, 3, 10), Event(), Event()

    def work() -> int:
        go.wait()
        done.set()
        return 7

    steps = in_a_thread(work, told)
    assert [next(steps), next(steps)] == [told, told]
    go.set()
    assert finished(steps) == 7
    go.clear()
    done.clear()
    steps = in_a_thread(work, told)
    next(steps)
    Timer(0.05, go.set).start()
    steps.close()
    assert done.is_set()

    def failing() -> int:
        raise InputError("no area")

    with pytest.raises(InputError, match="no area"):
        finished(in_a_thread(failing, told))
