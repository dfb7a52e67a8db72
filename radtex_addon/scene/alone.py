# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Take all other surfaces out of a scratch scene, for objects that are baked as if they stood alone."""

from __future__ import annotations

from collections.abc import Collection

import bpy

from .objects import rendered_homes
from .regroup import regroup
from .scratch import find_view_layer

_NO_SURFACE = frozenset(("LIGHT", "LIGHT_PROBE", "CAMERA", "SPEAKER", "ARMATURE", "LATTICE"))


def leave_alone(scratch: bpy.types.Scene, kept: Collection[str | None]) -> None:
    """Leave the objects called `kept`, lamps and cameras in a scratch scene, each as visible as it was.

    Objects that the kept ones need, such as parents and cutters, are evaluated all the same.
    """
    layer = find_view_layer(scratch, None)
    layer.update()  # or it lacks objects that were linked since
    stays = [item for item in scratch.objects if item.name in kept or item.type in _NO_SURFACE]
    here = set(layer.objects)
    renders = {item for item in stays if item in here and any(True for _ in rendered_homes(item, layer))}
    hidden = regroup(
        scratch,
        {
            "RadTex alone": [item for item in stays if item in renders],
            "RadTex alone, hidden": [item for item in stays if item not in renders],
        },
    )["RadTex alone, hidden"]
    hidden.collection.hide_render = True
    layer.update()
