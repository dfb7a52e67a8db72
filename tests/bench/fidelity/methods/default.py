# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake without options makes: the shared layout, condensed to 2 MB of textures."""

from __future__ import annotations

from radtex_addon.bake.spec import BakeSpec, Layout
from radtex_addon.job.layout_choice import DEFAULT_BUDGET

from .shared import Shared


def make(texels: int, samples: int) -> Shared:
    """The default layout of radiance, with about as many paths as the plain method spends."""
    spec = BakeSpec(layout=Layout.SHARED, texels=texels, samples=samples, budget=DEFAULT_BUDGET)
    return Shared("default", spec)
