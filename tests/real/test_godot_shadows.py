# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene of docs/godot.md with shadows on a bake and under it, in a real Godot.

With RADTEX_FIGURES=docs/figures godot-shadows.png is kept: Compatibility, Forward+, Mobile.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from radtex_addon.report.metrics import Mask, Picture, display
from tests.real.exhibit import CAMERAS, Exhibit
from tests.real.godot import ALL_RENDERERS, Shot, imported, pictures
from tests.real.godot_demo import write_shadows
from tests.real.root import Root

CAMERA = replace(CAMERAS[0], place=(2.2, -4.6, 1.7), target=(0.15, -0.15, -0.05))
DARKNESS = 0.6  # of shadow_catcher.gdshader
UNDER = (slice(182, 192), slice(160, 175))  # rows and columns of the floor beside the neck
FIGURES = os.environ.get("RADTEX_FIGURES")


def test_shadows_fall_on_a_bake_and_under_it(exhibit: Exhibit, root: Root, tmp_path: Path) -> None:
    """The ball's shadow darkens the head in Forward+ and Mobile, to what the overlay says, and nothing
    else of it; the floor is dark under the head in all renderers."""
    bake = exhibit.plain
    write_shadows(bake.sidecar, tmp_path / "project")
    place = imported(root, tmp_path / "project")
    shots = [Shot(CAMERA), Shot(CAMERA, hidden=["Ball"]), Shot(CAMERA, hidden=["ContactShadow"])]
    shown = {renderer: pictures(root, place, renderer, shots) for renderer in ALL_RENDERERS}
    if FIGURES:
        strip = display(np.concatenate([taken[0] for taken in shown.values()], axis=1))
        image = Image.fromarray((strip * 255 + 0.5).astype(np.uint8))
        image.save(Path(FIGURES, "godot-shadows.png"), optimize=True)
    for renderer, taken in shown.items():
        _check(taken, bake.eroded(CAMERA), renderer)


def _check(taken: list[Picture], head: Mask, renderer: str) -> None:
    shaded, lit, floating = taken
    seen = head & (lit.min(axis=2) > 0.05) & (lit.max(axis=2) < 0.99)
    ratio = shaded[seen].mean(axis=1) / lit[seen].mean(axis=1)
    dark, same = np.mean(ratio < 1 - 0.9 * DARKNESS), np.mean(np.abs(ratio - 1) < 0.03)
    beneath = shaded[UNDER].mean() / floating[UNDER].mean()
    print(f"{renderer}: {dark:.1%} of the head in shadow, {same:.1%} as before; below it {beneath:.2f}")
    assert beneath < 0.93
    if renderer == "Compatibility":
        assert dark < 0.005
    else:
        assert 0.01 < dark < 0.3
        assert np.median(ratio[ratio < 0.5]) > 1 - DARKNESS - 0.05
    assert same > 0.7
