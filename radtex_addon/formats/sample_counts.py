# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The number of samples of each texel, if they differ, as a line of text in the sidecar.

Run-length encoded, row by row from the bottom: "16x1200 24x30 16x15018" means 1200 texels with 16 samples per
cell, then 30 with 24, and so on.
"""

from __future__ import annotations

import re

import numpy as np

from ..core.arrays import Ints
from ..core.errors import FormatError

_RUN = re.compile(r"([1-9]\d{0,17})x([1-9]\d{0,9})")


def count_text(counts: Ints) -> str:
    """Encode samples (H, W), row 0 at v = 0, as text; empty if all are equal."""
    flat = counts.ravel()
    starts = np.flatnonzero(np.concatenate([[True], flat[1:] != flat[:-1]]))
    if len(starts) == 1:
        return ""
    lengths = np.diff([*starts, len(flat)])
    return " ".join(f"{value}x{length}" for value, length in zip(flat[starts], lengths, strict=True))


def read_counts(text: str, width: int, height: int, source: str) -> Ints:
    """Inverse of `count_text`: samples (H, W). Raises FormatError, with the `source`, if malformed."""
    runs = [_RUN.fullmatch(word) for word in text.split(" ")]
    pairs = [(int(run[1]), int(run[2])) for run in runs if run is not None]
    told = sum(length for _, length in pairs)
    if len(pairs) < len(runs) or told != width * height:
        raise FormatError(
            f'{source} has a "texel_samples" that does not tell {width} x {height} texels: bake it again'
        )
    values, lengths = zip(*pairs, strict=True)
    return np.repeat(np.array(values, dtype=np.int64), lengths).reshape(height, width)
