# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a texel density means for each of the selected objects, in lines for the panel."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from .labels import iface_, remark

if TYPE_CHECKING:
    from ...settings.spec import BakeSpec
    from .layouts import Chosen

_MOST = 8  # lines


def told_sizes(scene: bpy.types.Scene, chosen: Chosen, folder: Path, unseen: int = 0) -> tuple[str, ...]:
    """A line for each atlas whose size follows from a density: of a bake in `folder`, or an estimate.

    Atlases beyond `_MOST` are counted in a last line, and so many that were `unseen` for lack of time.
    """
    bakes = [(name, choice.spec) for name, choice in chosen if name and choice.spec.density is not None]
    lines = [_told(scene, name, spec, folder) for name, spec in bakes[:_MOST]]
    if more := len(bakes) - len(lines) + (unseen if lines else 0):
        lines.append(iface_("and {} more").format(more))
    return tuple(lines)


def _told(scene: bpy.types.Scene, name: str, spec: BakeSpec, folder: Path) -> str:
    from ...job.about_texels import foreseen_cap

    size = _baked(name, spec, folder)
    if size is not None:
        return iface_("{}: {} × {} texels, as baked").format(name, *size)
    cap = foreseen_cap(scene, name, spec)
    if cap is not None:
        return remark(cap)
    return iface_("{}: about {} × {} texels").format(name, spec.texels, spec.texels)


def _baked(name: str, spec: BakeSpec, folder: Path) -> tuple[int, int] | None:
    """Width and height of the finished bake with the same density, None if there is none."""
    from ...core.errors import FormatError
    from ...formats.sidecar import density_in
    from ...formats.sidecar_file import read_facts
    from ...store.output_files import OutputFiles

    sidecar = OutputFiles.of(name, spec, folder).sidecar
    if not sidecar.is_file():
        return None
    try:
        facts = read_facts(sidecar)
        density = density_in(facts)
        return facts.size("texels") if density is not None and density.asked == spec.density else None
    except FormatError:
        return None
