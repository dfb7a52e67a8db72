# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress that is passed on is changed on the way, and nothing else."""

from __future__ import annotations

from collections.abc import Generator

import pytest

from radtex_addon.bake.progress import Progress, Stage, relayed


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
    steps = relayed(three([]), doubled)
    assert [next(steps) for _ in range(3)] == [Progress(Stage.FIT, done, 4) for done in (0, 2, 4)]
    with pytest.raises(StopIteration) as stop:
        next(steps)
    assert stop.value.value == "value"


def test_the_inner_steps_are_closed_with_the_outer() -> None:
    ended: list[str] = []
    steps = relayed(three(ended), doubled)
    next(steps)
    assert ended == []
    steps.close()
    assert ended == ["ended"]
