# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which targets can show which kinds of bakes, and import which textures."""

from __future__ import annotations

from pathlib import Path

from ..bake.kinds import KINDS, Kind
from ..core.errors import InputError
from ..core.messages import Setting, do, leave_out
from ..formats.image_files import Shapes
from ..textures.export_spec import Arrangement, ExportSpec, Target


def check_target(bake: Path | str, kind: str, target: Target) -> None:
    """Raise InputError, naming the `bake`, if the target cannot show bakes of its kind."""
    if kind not in tuple(Kind):
        raise InputError(f"{bake} is of kind {kind}, which this RadTex does not export: update RadTex")
    takers = KINDS[Kind(kind)].exports
    if target not in takers:
        words = ", ".join(takers)
        raise InputError(f"{bake} is of kind {kind}, which {target} does not show: choose {words}")


def check_importable(bake: Path | str, spec: ExportSpec, shapes: Shapes) -> None:
    """Raise InputError, naming the `bake`, if the target's importer cannot take its textures.

    Unreal's keeps no mip levels of arrays, by which slices are filtered; and pages are arrays, too. `shapes`
    are of the bake's images.
    """
    if spec.target is not Target.UNREAL:
        return
    if spec.arrangement is Arrangement.SLICES:
        found = f"{bake} in slices would be a texture array, whose mip levels Unreal does not import"
        raise InputError(found, leave_out(Setting.ARRANGEMENT))
    width, height = max((shape[:2] for shape in shapes.values()), key=max)
    if max(width, height) > spec.most_pixels:
        raise InputError(
            f"{bake} would be a texture of {width} x {height} pixels, and Unreal takes none cut into pages",
            do(f"raise the limit of {spec.most_pixels}", Setting.LIMIT),
            do("bake fewer texels"),
        )
