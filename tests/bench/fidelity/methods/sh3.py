# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lightmap of spherical harmonics with one band more: 16 colours a texel."""

from __future__ import annotations

from functools import partial

from radtex_addon.settings.spec import BakeSpec

from ..captured import OfCapture
from .sh import of_capture


def make(texels: int, samples: int) -> OfCapture:
    """The lightmap of 16 spherical harmonics of a stage's single paths."""
    return OfCapture("sh3", BakeSpec(texels=texels, samples=samples), partial(of_capture, bands=3))
