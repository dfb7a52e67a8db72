# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The time left of jobs, as a range: from what their stages were expected to take, and what they took so far.

The logarithm of a stage's time over its expected time is taken to be a sum of normal deviations: one of all
stages (how fast this machine is now, with what else it does), one of the job, one of the stage in all jobs,
and one of that stage alone. Stages that have ended, and the share that is done of the one that runs, are
observations of such sums; what is to come follows from them by conditioning. So a machine that was slow in
the first stages is expected to be slow in the later ones, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import exp, log, sqrt
from statistics import NormalDist

import numpy as np

from ..bake.progress import Stage
from ..core.arrays import Floats
from .estimate import STAGES, START, Estimate

_QUANTILE = 1.28  # standard deviations from the middle to an end of a range: 80 % of times are within
_OF_JOB = 0.1  # deviation of a job, as a logarithm
_OF_ALL_JOBS = 0.75  # of the variance of a stage, the part that it has in all jobs
_POLLED = 0.3  # seconds by which the times of a stage's beginning and end are off
_EXACT = 0.02  # deviation of a stage that has ended, besides
# Deviations of a time that is extrapolated from a share of a stage, as recorded bakes show: of the renders …
_UNEVEN, _SET_UP = 0.2, 0.06  # … in proportion to the rest, and to the rest over what is done
# … and of stages of steps whose times have little in common
_BY_LUCK, _UNEVEN_STAGES = 0.7, frozenset({str(Stage.UNWRAP), str(Stage.FIT), str(Stage.EVALUATE)})
_OUTLIER = 2.0  # deviations, to which observations are cut: they may be of something else, such as no unwrap
_SHORT = 0.05  # seconds
_REMEMBERED = 6  # jobs that have ended, of which the pace is taken
_VAGUE = 4.0  # a range whose end is so many times as far as its beginning is no answer
_VAGUE_SECONDS = 30.0  # … if it is also wider than this
_LATE = 1.9  # deviations above the middle, from which on a stage takes longer than was expected
_FAR = 6.0  # ratio of a range's ends, above which its end alone is told
_SAME = 1.5  # ratio of a range's ends, below which its middle is told


@dataclass(frozen=True)
class Course:
    """How a job goes: what its stages are `expected` to take, in their order, and what they took.

    `stage` is the one that runs, since `since` seconds after the job's beginning; of it a `share` was done at
    `reported`. `entered` are all stages that were begun.
    """

    expected: Estimate
    took: Mapping[str, float] = field(default_factory=dict)
    stage: str = START
    since: float = 0.0
    share: float = 0.0
    reported: float = 0.0
    entered: frozenset[str] = frozenset({START})
    ended: bool = False

    def at(self, stage: str, share: float, now: float) -> Course:
        """The job has done a `share` of a stage, 0 to 1, `now` seconds after its beginning."""
        course = self if stage == self.stage else self._entering(stage, now)
        if share > course.share:
            course = replace(course, share=min(share, 1.0), reported=now)
        return course

    def end(self, now: float) -> Course:
        """The job has ended."""
        return replace(self._entering("", now), ended=True)

    def _entering(self, stage: str, now: float) -> Course:
        spent = self.took.get(self.stage, 0.0) + max(0.0, now - self.since)
        took = {**self.took, self.stage: spent}
        return replace(
            self, took=took, stage=stage, since=now, share=0.0, reported=now, entered=self.entered | {stage}
        )

    @property
    def is_back(self) -> bool:
        """Whether the stage that runs is one that was over already."""
        return self.stage in self.took

    @property
    def done(self) -> float:
        """Expected seconds of what is done."""
        left = 0.0 if self.is_back or self.ended else 1.0 - self.share
        of_stage = left * self.expected.seconds.get(self.stage, 0.0)
        return max(0.0, self.expected.total - sum(self.to_come.values()) - of_stage)

    @property
    def to_come(self) -> Mapping[str, float]:
        """Expected seconds of stages that have not begun, and come after all that have."""
        order = list(self.expected.seconds)
        begun = max(_place_of(one, order) for one in self.entered)
        return {} if self.ended else {stage: self.expected.seconds[stage] for stage in order[begun:]}


def _place_of(stage: str, order: Sequence[str]) -> int:
    """How many of a job's stages are over or run when this one runs, which may be none of them."""
    if stage in order:
        return order.index(stage) + 1
    if stage not in STAGES:
        return 0
    rank = STAGES.index(stage)
    return sum(other in STAGES and STAGES.index(other) < rank for other in order)


@dataclass(frozen=True)
class Left:
    """Seconds that are left, most likely, at least and at most; `late` if it takes longer than expected."""

    seconds: float
    least: float
    most: float
    late: bool = False

    @property
    def is_known(self) -> bool:
        """Whether the range is narrow enough to tell it."""
        return self.most <= max(_VAGUE * self.least, self.least + _VAGUE_SECONDS)

    def __add__(self, other: Left) -> Left:
        """The time of both, one after the other, whose errors are alike."""
        return Left(
            self.seconds + other.seconds,
            self.least + other.least,
            self.most + other.most,
            self.late or other.late,
        )

    def __mul__(self, factor: float) -> Left:
        return Left(factor * self.seconds, factor * self.least, factor * self.most, self.late)


NO_TIME = Left(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class _Term:
    """The time of a stage of one job, or of all that wait: a variable of the model."""

    stage: str
    job: int
    spread: float
    common: float


def expected_time(expected: Estimate) -> Left:
    """How long a job takes that has not begun."""
    return _sum_of(Course(expected), [Course(expected)], {})


def time_left(
    running: Course, now: float, ended: Sequence[Course] = (), waiting: Sequence[Estimate] = ()
) -> Left:
    """The time left of a job that is `running` since `now` seconds, and of those that wait for it.

    `ended` are the courses of jobs before it, the latest last.
    """
    known = [*ended[-_REMEMBERED:], running]
    later: dict[str, float] = dict(running.to_come)
    for one in waiting:
        for stage, seconds in one.seconds.items():
            later[stage] = later.get(stage, 0.0) + seconds
    rest = _sum_of(running, known, later)
    begun = _left_of_stage(running, known, now)
    seconds = begun.seconds + rest.seconds
    least = seconds - _joint(begun.seconds - begun.least, rest.seconds - rest.least)
    most = seconds + _joint(begun.most - begun.seconds, rest.most - rest.seconds)
    return Left(seconds, max(0.0, least), most, begun.late)


def _joint(one: float, other: float) -> float:
    """How far a sum reaches from its middle, where its terms reach so far, and are half alike."""
    return sqrt(one**2 + other**2 + one * other)


def _sum_of(running: Course, known: Sequence[Course], later: Mapping[str, float]) -> Left:
    """The time of stages to come, `later`; of all of `running` if it has not begun."""
    wanted = dict(later)
    if not running.took and not running.share and len(known) == 1 and not later:
        wanted = dict(running.expected.seconds)
    wanted = {stage: seconds for stage, seconds in wanted.items() if seconds > 0}
    if not wanted:
        return NO_TIME
    terms = [_term(running.expected, stage, len(known) - 1) for stage in wanted]
    mean, cov = _posterior(terms, known)
    middle = np.array(list(wanted.values())) * np.exp(mean)
    weights = middle / middle.sum()
    deviation = sqrt(max(0.0, float(weights @ cov @ weights)))
    # the mean of a sum of log-normal times is that of each; its median is below
    seconds = float((middle * np.exp(np.diagonal(cov) / 2)).sum()) * exp(-(deviation**2) / 2)
    reach = exp(_QUANTILE * deviation)
    return Left(seconds, seconds / reach, seconds * reach)


def _left_of_stage(running: Course, known: Sequence[Course], now: float) -> Left:
    """The time left of the stage that runs, which has not ended so far."""
    spent = max(0.0, now - running.since)
    typical = running.expected.seconds.get(running.stage, 0.0)
    if running.is_back or running.share >= 1.0 or typical <= 0.0 or running.ended:
        return NO_TIME
    term = _term(running.expected, running.stage, len(known) - 1)
    mean, cov = _posterior([term], known, of_share=False)
    late = spent > typical * exp(float(mean[0]) + _LATE * sqrt(float(cov[0, 0]))) + 1.0
    mean, cov = _posterior([term], known)
    whole = NormalDist(log(typical) + float(mean[0]), sqrt(max(1e-4, float(cov[0, 0]))))
    over = min(whole.cdf(log(max(spent, 1e-3))), 1.0 - 1e-6)

    def quantile(share: float) -> float:
        return max(0.0, exp(whole.inv_cdf(min(over + share * (1.0 - over), 1.0 - 1e-9))) - spent)

    return Left(quantile(0.5), quantile(0.1), quantile(0.9), late)


def _posterior(
    wanted: Sequence[_Term], known: Sequence[Course], of_share: bool = True
) -> tuple[Floats, Floats]:
    """Mean and covariance of the wanted terms' logarithms, of what is known of all jobs.

    The last of `known` runs; `of_share`: its stage that runs is observed, too.
    """
    terms: list[_Term] = []
    seen: list[float] = []
    noise: list[float] = []
    for number, course in enumerate(known):
        for stage, value, error in _observed(course, of_share or number < len(known) - 1):
            term = _term(course.expected, stage, number)
            most = _OUTLIER * sqrt(_covariance(term, term) + error**2)
            terms.append(term)
            seen.append(min(max(value, -most), most))
            noise.append(error**2)
    prior = np.array([[_covariance(one, other) for other in wanted] for one in wanted])
    if not terms:
        return np.zeros(len(wanted)), prior
    among = np.array([[_covariance(one, other) for other in terms] for one in terms]) + np.diag(noise)
    across = np.array([[_covariance(one, other) for other in terms] for one in wanted])
    gain = np.linalg.solve(among, across.T).T
    return gain @ np.array(seen), prior - gain @ across.T


def _observed(course: Course, of_share: bool) -> list[tuple[str, float, float]]:
    """Of stages that ended, and of the one that runs: its name, logarithm and the deviation of that."""
    found = []
    for stage, seconds in course.took.items():
        typical = course.expected.seconds.get(stage, 0.0)
        if typical > 0.0 and stage != course.stage:
            error = _EXACT + _POLLED / max(seconds, typical)
            found.append((stage, log(max(seconds, _SHORT) / typical), error))
    typical = course.expected.seconds.get(course.stage, 0.0)
    spent = course.reported - course.since
    if of_share and typical > 0.0 and spent > 0.0 and 0.0 < course.share < 1.0 and not course.is_back:
        rest = 1.0 - course.share
        error = _UNEVEN * rest + _SET_UP * rest / course.share + _EXACT + _POLLED / spent
        error += _BY_LUCK if course.stage in _UNEVEN_STAGES else 0.0
        found.append((course.stage, log(spent / course.share / typical), error))
    return found


def _term(expected: Estimate, stage: str, job: int) -> _Term:
    return _Term(stage, job, expected.spread_of(stage), expected.common)


def _covariance(one: _Term, other: _Term) -> float:
    found = one.common * other.common
    if one.job == other.job:
        found += _OF_JOB**2
    if one.stage == other.stage:
        alone = 1.0 if one.job == other.job else _OF_ALL_JOBS
        found += alone * one.spread * other.spread
    return found


def told_left(left: Left | None, say: Callable[[str], str] = str) -> str:
    """The time left in words, such as "1 to 2 min left"; `say` translates."""
    if left is None or not left.is_known:
        told = say("time left: not known yet")
        return say("longer than expected, {}").format(told) if left is not None and left.late else told
    told = say("{} left").format(told_range(left, say))
    return say("longer than expected, {}").format(told) if left.late else told


def told_range(left: Left, say: Callable[[str], str] = str) -> str:
    """The range in words, as "about 40 s" or "1 to 2 min"; `say` translates."""
    if left.most < 4.0:
        return say("a few seconds")
    low, high = _rounded(left.least), _rounded(left.most)
    if left.most > _FAR * left.least:
        return say("up to {}").format(f"{high[0]:g} {say(high[1])}")
    if left.most <= _SAME * left.least or low == high:
        number, unit = _rounded(left.seconds)
        return say("about {}").format(f"{number:g} {say(unit)}")
    if low[1] == high[1]:
        return say("{} to {}").format(f"{low[0]:g}", f"{high[0]:g} {say(high[1])}")
    return say("{} to {}").format(f"{low[0]:g} {say(low[1])}", f"{high[0]:g} {say(high[1])}")


def _rounded(seconds: float) -> tuple[float, str]:
    """A number and its unit, without false precision: 5 s, 40 s, 1.5 min, 12 min, 2.5 h."""
    if seconds < 7.5:
        return max(1.0, float(round(seconds))), "s"
    if seconds < 57.5:
        return 5.0 * round(seconds / 5), "s"
    minutes = seconds / 60
    if minutes < 2.75:
        return round(2 * minutes) / 2, "min"
    if minutes < 57.5:
        return float(round(minutes) if minutes < 15 else 5 * round(minutes / 5)), "min"
    hours = minutes / 60
    return (round(2 * hours) / 2 if hours < 5 else float(round(hours))), "h"
