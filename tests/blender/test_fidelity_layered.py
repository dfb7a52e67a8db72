# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The draft of the layered layout, baked with Cycles and looked at."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from radtex_addon.report.gbuffer import BakedSurface, Rays
from tests.bench.fidelity.layered import lamps, panoramas
from tests.bench.fidelity.methods.layered import make
from tests.bench.fidelity.rendering import Rendering, render
from tests.bench.fidelity.scenes import PIXELS, SCENES

_TEXELS, _SAMPLES, _REFERENCE = 32, 4, 48


def test_a_head_of_gold_looks_as_cycles_sees_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for module, name, size in (
        (panoramas, "WORLD_WIDTH", 768),
        (panoramas, "NEAR_WIDTH", 384),
        (panoramas, "SIZE", 256),
        (lamps, "_SIZE", 256),
    ):
        monkeypatch.setattr(module, name, size)
    stage = SCENES["metal_20"]()
    baked = make(_TEXELS, _SAMPLES).bake(stage, tmp_path)
    camera = stage.tuning[0]
    half = camera.data.sensor_width / 2 / camera.data.lens
    turn = np.array(camera.rotation_euler.to_matrix())
    rays = Rays.of_camera(np.array(camera.location), turn, half, PIXELS, 1)
    surface = BakedSurface(baked.mesh, baked.matrix_world, baked.uv_layer)
    seen = surface.gbuffer(rays, np.full(len(rays.away), 1e9))
    picture = seen.resolve(baked.radiance(seen))
    reference = render(stage, camera, Rendering(_REFERENCE, 1, alone=False))[..., :3]
    inside = seen.eroded
    shown, expected = (np.clip(image[inside], 0, 1) ** (1 / 2.2) for image in (picture, reference))
    error = -10 * np.log10(((shown - expected) ** 2).mean())
    assert error > 21
    assert abs(shown.mean() / expected.mean() - 1) < 0.03
