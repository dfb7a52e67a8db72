# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How many cells buckets of the layered layout have along a side, and the sizes of what surrounds them."""

from typing import NamedTuple


class Cells(NamedTuple):
    """Cells along a bucket's side: of what the object shows of `own`, and of the `rest`.

    If it has `every` texel, each has a bucket of the rest, else those that share one of own light.
    """

    own: int
    rest: int
    every: bool = False


CELLS = (Cells(14, 8), Cells(8, 14))  # as many bytes both
CLEAR = (Cells(2, 8), Cells(2, 14))  # the same of an object that mirrors nothing of itself
HOLLOW = Cells(2, 8, every=True)  # as many bytes, where own light tells less than more buckets of the rest
EXIT_CELLS = 16  # of rays that leave the object
FIELD_SAMPLES = 64  # along the longest side of a clear object, of the distances to it
THROUGH_CELLS = 8  # of the rest of what comes through
PICTURE_SIZE = 512  # of pictures of what surrounds the object, at their sharpest
DISTANCES = 128  # of the map of distances to it
