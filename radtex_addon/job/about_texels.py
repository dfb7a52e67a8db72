# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""About how many texels an atlas will have whose size nobody named: by a texel density, or by its objects."""

from __future__ import annotations

from dataclasses import replace

import bpy

from ..core.messages import Message
from ..scene.mesh.about_area import AboutArea, about_area, about_islands
from ..scene.scratch import find_view_layer
from ..scene.surfaces import may_have_faces
from ..scene.units import metres_per_unit
from ..settings.spec import BakeSpec, Unwrap
from ..settings.texel_density import about_side, capped_warning, side_for, side_for_several


def with_about_texels(scene: bpy.types.Scene, name: str, spec: BakeSpec) -> BakeSpec:
    """The specification with an estimate of its texels, at most what a density may ask for.

    Without a density it is returned unchanged. A part counts as the whole object; objects that do not exist
    count as nothing. It is quick, as nothing is evaluated for a render.
    """
    if spec.density is None:
        return spec
    return replace(spec, texels=min(needed_texels(scene, name, spec), spec.most_texels))


def with_texels_of_several(scene: bpy.types.Scene, spec: BakeSpec) -> BakeSpec:
    """The specification with about as many texels as its objects would have had, where the layout allows.

    More, if a new unwrap keeps hundreds of islands. With a density it is returned unchanged.
    """
    if spec.density is not None:
        return spec
    islands = 0
    if spec.unwrap is Unwrap.AUTO and spec.uv_layer is None:
        there = (scene.objects[name] for name in spec.objects if name in scene.objects)
        islands = sum(about_islands(item) for item in there if may_have_faces(item))
    side = min(side_for_several(spec.texels, len(spec.objects), islands), spec.most_texels)
    return replace(spec, texels=max(spec.texels, side))


def needed_texels(scene: bpy.types.Scene, name: str, spec: BakeSpec) -> int:
    """About how many texels along a side the density asks for, which must be given."""
    assert spec.density is not None  # see above
    layer = find_view_layer(scene, None)
    if bpy.app.background:
        layer.update()  # without a window nothing else brings it up to date
    areas = [
        about_area(scene.objects[each], layer, spec.uv_layer)
        for each in spec.objects or (name,)
        if each in scene.objects and may_have_faces(scene.objects[each])
    ]
    return _side(areas, spec.density * metres_per_unit(scene))


def _side(areas: list[AboutArea], density: float) -> int:
    surface = sum(area.surface for area in areas)
    covered = [area.covered for area in areas if area.covered is not None]
    if covered and len(covered) == len(areas):
        return side_for(surface, density, sum(covered))
    return about_side(surface, density)


def foreseen_cap(scene: bpy.types.Scene, name: str, spec: BakeSpec) -> Message | None:
    """A warning that the density will be lower than asked for, as far as the estimate tells; None if not."""
    if spec.density is None:
        return None
    needed = needed_texels(scene, name, spec)
    if needed <= spec.most_texels:
        return None
    return capped_warning(f"'{name}'", spec.density, needed, spec.most_texels)
