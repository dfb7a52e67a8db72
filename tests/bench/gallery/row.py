# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What every module of the gallery gives: pictures side by side, and how near they are."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto

from radtex_addon.report.metrics import Mask, Picture, compare


class Use(Enum):
    """Where the page has a view: `PICTURE`, in the table and perhaps as the row's picture; in the `TABLE`
    alone, beside what the row is about; or as a frame of the row's `FILM`, which repeats."""

    PICTURE = auto()
    TABLE = auto()
    FILM = auto()


@dataclass(frozen=True, eq=False)
class Row:
    """One view: path traced, and ours, linear light (H, W, 3) from the top; figures are inside `mask`.

    `note` says in words what else was measured. Around the mask, pictures show what `around` (H, W) has.
    """

    name: str
    reference: Picture
    ours: Picture
    mask: Mask
    note: str = ""
    around: Mask | None = None
    use: Use = Use.PICTURE

    @property
    def psnr(self) -> float:
        """Decibels of what a display shows."""
        return compare(self.ours, self.reference, self.mask, self.mask).psnr

    @property
    def flip(self) -> float | None:
        """FLIP's mean error; None where there is no FLIP."""
        return compare(self.ours, self.reference, self.mask, self.mask).flip
