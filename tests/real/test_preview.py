# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The saved preview in Cycles and in Eevee against the reference sampler's pictures.

With RADTEX_FIGURES=docs/figures the pictures are kept: reference, Cycles, Eevee.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from radtex_addon.report.metrics import Picture, display
from tests.real.exhibit import CAMERAS, Exhibit, Form, decibels
from tests.real.preview_shot import Shots

LEAST = 38.0  # dB
FRONT = CAMERAS[:1]  # Eevee spends a minute on its shaders, wherever it looks from
FIGURES = os.environ.get("RADTEX_FIGURES")


@pytest.mark.parametrize("form", Form)
def test_cycles_shows_the_reference(form: Form, exhibit: Exhibit, tmp_path: Path) -> None:
    bake = getattr(exhibit, form)
    pictures = Shots(bake.preview, "cycles", tmp_path).pictures(CAMERAS)
    for camera, picture in zip(CAMERAS, pictures, strict=True):
        reference, inside = bake.picture(camera, steady=0), bake.inside(camera)
        assert reference[inside].mean() > 0.1, "a picture of something"
        assert decibels(picture, reference, bake.eroded(camera)) > LEAST
        assert decibels(picture, reference, np.ones_like(inside)) > LEAST, "edges and all"


@pytest.mark.parametrize("form", [Form.PLAIN, Form.LAYERED])
def test_eevee_shows_the_reference(form: Form, exhibit: Exhibit, tmp_path: Path) -> None:
    bake = getattr(exhibit, form)
    (picture,) = Shots(bake.preview, "eevee", tmp_path).pictures(FRONT)
    (camera,) = FRONT
    reference = bake.picture(camera, steady=0)
    assert decibels(picture, reference, bake.eroded(camera)) > LEAST
    if FIGURES:
        (by_cycles,) = Shots(bake.preview, "cycles", tmp_path).pictures(FRONT)
        _keep(Path(FIGURES, f"exhibit-{form}-cycles-eevee.png"), [reference, by_cycles, picture])


def _keep(path: Path, pictures: list[Picture]) -> None:
    strip = display(np.concatenate(pictures, axis=1))
    Image.fromarray((strip * 255 + 0.5).astype(np.uint8)).save(path, optimize=True)
