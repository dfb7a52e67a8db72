# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lightmap of spherical harmonics with one band more: 16 colours a texel."""

from __future__ import annotations

from radtex_addon.bake.spec import BakeSpec

from .sh import HarmonicsLightmap


def make(texels: int, samples: int) -> HarmonicsLightmap:
    """The lightmap of 16 spherical harmonics of a stage's single paths."""
    return HarmonicsLightmap(BakeSpec(texels=texels, samples=samples), bands=3)
