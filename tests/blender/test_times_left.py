# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The time left that is told of recorded bakes, and its words."""

from __future__ import annotations

import json
from pathlib import Path
from statistics import median

import pytest

from radtex_addon.settings.estimate import START, Estimate
from radtex_addon.settings.time_left import Course, Left, expected_time, time_left, told_left, told_range
from tests.bench import times_left

pytestmark = pytest.mark.one_blender

_LINES = (Path(times_left.__file__).parent / "recorded_bakes.jsonl").read_text().splitlines()
RECORDED = [json.loads(line) for line in _LINES]  # 12 objects, on a busy machine, and on a busier one


@pytest.mark.parametrize("mode", ["idle", "busy"])
def test_the_time_left_of_recorded_bakes_is_true(mode: str) -> None:
    found = [one for one in times_left.replayed(RECORDED) if one.mode == mode]
    assert len(found) == 12 * len(times_left.SHARES)
    for share in times_left.SHARES:
        some = [one for one in found if one.share == share]
        assert median(one.ratio for one in some) < 1.5
        assert sum(one.left.least <= one.needed <= one.left.most for one in some) >= 8
        assert max(one.ratio for one in some) < 3.0


def test_no_bake_is_said_to_end_long_before_it_does() -> None:
    for one in times_left.replayed(RECORDED, (0.08, 0.3, 0.6)):
        assert one.left.most > one.needed / 3
        assert told_range(one.left) != "a few seconds"


def test_a_stage_that_reports_nothing_lengthens_the_time() -> None:
    course = Course(Estimate({START: 2.0, "capture": 10.0, "write": 1.0}, common=0.3)).at("capture", 0.0, 2.0)
    lefts = [time_left(course, now) for now in (2.0, 6.0, 60.0, 120.0)]
    assert lefts[1].seconds < lefts[0].seconds
    assert lefts[3].seconds > lefts[2].seconds > lefts[1].seconds
    assert [left.late for left in lefts] == [False, False, True, True]
    assert told_left(lefts[3]).startswith("longer than expected, ")


def test_slow_stages_lengthen_those_to_come() -> None:
    fresh = Course(Estimate({START: 2.0, "evaluate": 10.0, "capture": 40.0}, common=0.5))
    slow = time_left(fresh.at("evaluate", 0.0, 6.0).at("capture", 0.0, 36.0), 36.0)
    usual = time_left(fresh.at("evaluate", 0.0, 2.0).at("capture", 0.0, 12.0), 12.0)
    assert slow.seconds > 1.5 * usual.seconds
    assert usual.most / usual.least < expected_time(fresh.expected).most / expected_time(fresh.expected).least


@pytest.mark.parametrize(
    ("left", "words"),
    [
        (Left(2, 1, 3), "a few seconds left"),
        (Left(41, 36, 47), "about 40 s left"),
        (Left(85, 62, 125), "1 to 2 min left"),
        (Left(60, 38, 110), "40 s to 2 min left"),
        (Left(10, 2, 28), "up to 30 s left"),
        (Left(60, 10, 300), "time left: not known yet"),
        (Left(41, 36, 47, late=True), "longer than expected, about 40 s left"),
        (None, "time left: not known yet"),
    ],
)
def test_the_time_left_in_words(left: Left | None, words: str) -> None:
    assert told_left(left) == words
