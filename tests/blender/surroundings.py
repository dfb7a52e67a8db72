# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What surrounds an object, in tests: pictures and maps of it take most of the time of a small bake."""

from __future__ import annotations

from typing import Any, cast

import bpy
import pytest

from radtex_addon.forms.layered.capture import lamps, panoramas

_WHOLE = [
    (module, name, int(getattr(module, name)))
    for module, name in (
        (panoramas, "WORLD_WIDTH"),
        (panoramas, "NEAR_WIDTH"),
        (panoramas, "PICTURE_SIZE"),
        (lamps, "_SIZE"),
    )
]


def make_small(patch: pytest.MonkeyPatch, smaller: int = 4) -> None:
    """Let bakes in this process take small pictures of the surroundings, so many times as narrow."""
    for module, name, size in _WHOLE:
        patch.setattr(module, name, size // smaller)


def sizes() -> list[int]:
    """How large they are now."""
    return [int(getattr(module, name)) for module, name, _ in _WHOLE]


def make_whole(patch: pytest.MonkeyPatch) -> None:
    """Let them be as large as users' again."""
    make_small(patch, 1)


def sample_sky_coarsely() -> None:
    """Let Cycles sample the open scene's world by a map as fine as Blender's own HDRIs.

    If the sky is turned, its own choice is so fine a map that each render takes two seconds more.
    """
    settings = cast(Any, bpy.context).scene.world.cycles
    settings.sampling_method, settings.sample_map_resolution = "MANUAL", 512
