# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Do two noisy measurements show the same light? A z-test for every value, corrected for their number.

After Mitsuba's render tests: a difference counts against its own standard error. Each measurement is repeated
with several seeds, and the means are compared by Welch's t-test; the smallest p of N values is held against
alpha / N (Bonferroni), and the mean of all values against alpha itself.
"""

from __future__ import annotations

import numpy as np
from scipy import stats

from radtex_addon.core.arrays import Floats


def same_light(
    name: str, first: Floats, second: Floats, alpha: float = 0.01, exact: float | Floats = 2e-4
) -> None:
    """Assert that two measurements (runs, values) have the same expectation.

    `exact` is what they may differ by for other reasons than noise: a share of the light (float32, say), or
    an absolute amount for each value.

    Prints what it saw, so that a run's log holds the figures.
    """
    difference = first.mean(axis=0) - second.mean(axis=0)
    error = [a.var(axis=0, ddof=1) / len(a) for a in (first, second)]
    variance = error[0] + error[1]
    floor = exact if isinstance(exact, np.ndarray) else exact * (np.abs(first.mean(axis=0)) + 1e-3)
    t = np.maximum(np.abs(difference) - floor, 0) / np.sqrt(variance + 1e-20)
    freedom = variance**2 / sum(
        (e**2 / (len(a) - 1) for e, a in zip(error, (first, second), strict=True)), 1e-40
    )
    p = np.where(np.abs(difference) <= floor, 1.0, 2 * stats.t.sf(t, np.maximum(freedom, 1)))
    smallest = float(p.min()) * p.size
    bias = float(difference.mean()) / max(float(np.abs(first).mean()), 1e-9)
    tolerated = float(np.mean(floor)) / max(float(np.abs(first).mean()), 1e-9)
    chance = 1.0
    if abs(bias) > tolerated:
        chance = float(stats.ttest_ind(first.mean(axis=1), second.mean(axis=1), equal_var=False).pvalue)
    print(
        f"\n{name}: {p.size} values, relative bias {bias:+.1e} (p {chance:.2f}), "
        f"corrected p of the worst value {min(smallest, 1):.2f}, "
        f"largest |difference| {np.abs(difference).max():.4f}"
    )
    assert smallest > alpha, f"{name}: value {int(p.argmin())} differs by {difference[p.argmin()]:.4f}"
    assert chance > alpha, f"{name}: means differ by {bias:.2e} of the light"
