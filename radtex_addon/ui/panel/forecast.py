# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What to expect of the next bake, computed for the panel."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..operators.bake_lookup import selected_meshes
from .panel_state import Forecast

if TYPE_CHECKING:
    from ..settings.bake_settings import BakeSettings

_PATIENCE = 0.05  # seconds that examining the objects may take


def chosen_objects(view_layer: bpy.types.ViewLayer) -> tuple[str, ...]:
    """Names of the objects to bake: the selected meshes, or else the active one; originals, not previews."""
    from ...preview.swap import original_of

    found = (original_of(item) or item for item in selected_meshes(view_layer))
    return tuple(sorted({item.name for item in found}))


def compute_forecast(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Forecast:
    """Check and estimate a bake of the chosen objects with the scene's settings. Changes nothing."""
    from ...core.errors import InputError
    from ...forms import cost_of
    from ...preview.swap import is_on
    from ..jobs import estimates
    from ..settings.request import has_folder, request_of, spec_of, values_of
    from ..settings.surfaces import have_own_atlases
    from .atlas_sizes import told_sizes
    from .layouts import chosen_layouts, told_layouts
    from .remedies import foreseen, forgets, remedies

    names = chosen_objects(view_layer)
    settings: BakeSettings = scene.radtex  # type: ignore[attr-defined]  # ours, not Blender's
    values = values_of(settings)
    try:
        asked = spec_of(values)
        chosen = chosen_layouts(scene, names, values, asked, _PATIENCE)
    except InputError as error:
        return Forecast(names, (error.message,), ())
    costs = {choice.spec: cost_of(choice.spec) for _, choice in chosen}
    spec = max(costs, key=lambda one: costs[one].gpu)
    cost, seconds, layout = costs[spec], None, told_layouts(values, chosen)
    if have_own_atlases(values, asked, len(names)) and len(chosen) >= len(names):
        seconds = estimates.seconds_known(scene, [(name, choice.spec) for name, choice in chosen if name])
    try:
        request = request_of(values, names)
    except InputError as error:
        wanting = () if has_folder(values) else ("directory",)
        return Forecast(names, (error.message,), (), spec, cost, seconds, remedies=wanting, layout=layout)
    seen = foreseen(scene, request, _PATIENCE)
    if seconds is not None and not seen.errors:
        seconds *= len(request.specs(scene))
    ways_out = remedies(scene, request, seen.errors, _PATIENCE) if seen.errors else {}
    loses = not seen.errors and forgets(scene, request, _PATIENCE)
    return Forecast(
        names,
        seen.errors,
        seen.warnings,
        spec,
        cost,
        seconds,
        request.folder,
        remedies=tuple(ways_out),
        baked=ways_out == {"overwrite": 0},
        forgets=loses,
        shown=tuple(name for name in names if is_on(scene.objects[name])),
        layout=layout,
        sizes=told_sizes(scene, chosen, request.folder),
    )
