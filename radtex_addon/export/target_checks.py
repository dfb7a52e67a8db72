# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which targets can show which kinds of bakes."""

from __future__ import annotations

from pathlib import Path

from ..bake.kinds import KINDS, Kind
from ..core.errors import InputError
from ..textures.export_spec import Target


def check_target(bake: Path | str, kind: str, target: Target) -> None:
    """Raise InputError, naming the `bake`, if the target cannot show bakes of its kind."""
    if kind not in tuple(Kind):
        raise InputError(f"{bake} is of kind {kind}, which this RadTex does not export: update RadTex")
    takers = KINDS[Kind(kind)].exports
    if target not in takers:
        words = ", ".join(takers)
        raise InputError(f"{bake} is of kind {kind}, which {target} does not show: choose {words}")
