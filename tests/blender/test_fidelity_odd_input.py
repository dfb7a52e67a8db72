# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The layered layout of odd input: what is right, what is right if less sharp, and what is refused."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import bpy
import numpy as np
import pytest

from radtex_addon.core.errors import InputError
from tests.bench.fidelity.methods.layered import make
from tests.bench.fidelity.scenes import Stage
from tests.blender import odd_stages
from tests.blender.odd_input import Seen, looked_at

pytestmark = pytest.mark.one_blender
# of each material: the least PSNR in dB, and by how much its mean may differ from Cycles'
_OPAQUE = {
    "glossy": (25, 0.05),
    "diffuse": (29, 0.1),
    "toon": (29, 0.15),
    "toon glossy": (25, 0.15),
    "sheen": (28, 0.15),
    "hair": (24, 0.1),
    # In 64 texels, blocks of 2 x 2 texels mix islands, and the unwrap packs them differently from run to run.
    "translucent": (26, 0.2),
    "emission": (40, 0.03),
    "nothing": (20, 6.0),  # black, beside whatever the unwrap puts there
    "-": (24, 0.2),
}
_GLOWING = {
    "cells": (25, 0.05),
    "lamps": (25, 0.05),
    "rim": (31, 0.05),
    "matt": (31, 0.05),
}
_SEE_THROUGH = {
    "glass": (26, 0.08),
    "refraction": (24, 0.08),
    "transparent": (17, 0.25),  # of coloured alpha, the mean is kept
    "holdout": (23, 3.0),
    "volume": (20, 0.4),  # warned of: it looks like milky glass, and how bright depends on its islands
    "glass volume": (25, 0.15),
}
_ALPHAS = {
    "half": (27, 0.1),
    "texture": (23, 0.1),
    "none": (37, 0.03),
    "camera sees": (30, 0.12),
    "camera does not": (36, 0.03),
    "angle": (21, 0.11),  # 0.101 also where nothing else glows
    "coloured": (23, 0.3),
    "added": (15, 0.35),
}
_BY_CAMERA = {
    "is camera ray": (25, 0.1),
    "is glossy ray": (31, 0.1),
    "facing": (21, 0.15),
    "fresnel": (29, 0.1),
    "emission at the rim": (27, 0.1),
    "view distance": (27, 0.1),
}


def check(seen: Seen, expected: Mapping[str, tuple[float, float]]) -> None:
    """Compare each material of a bake to what is expected of it."""
    assert np.isfinite(seen.light).all()
    found = {}
    for slot, name in enumerate(expected):
        assert (seen.material == slot).sum() > 20, name
        found[name] = (seen.psnr(slot), seen.energy(slot))
    print(
        "\n".join(
            f"{name:24s} {error:5.1f} dB  energy {energy:.3f}" for name, (error, energy) in found.items()
        )
    )
    for name, (least, off) in expected.items():
        error, energy = found[name]
        assert error > least, name
        assert abs(energy - 1) < off, name


def test_materials_without_roughness(tmp_path: Path) -> None:
    check(looked_at(odd_stages.opaque(), tmp_path, 64), _OPAQUE)


def test_patterns_that_glow(tmp_path: Path) -> None:
    check(looked_at(odd_stages.glowing(), tmp_path, 96), _GLOWING)


def test_materials_that_camera_rays_pass(tmp_path: Path) -> None:
    check(looked_at(odd_stages.see_through(), tmp_path, 48), _SEE_THROUGH)


def test_alpha_of_every_kind(tmp_path: Path) -> None:
    check(looked_at(odd_stages.alphas(), tmp_path, 48), _ALPHAS)


def test_materials_that_ask_for_the_camera(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Those that a bake cannot know are named; what they look like then is not checked."""
    check(looked_at(odd_stages.by_camera(), tmp_path, 64), _BY_CAMERA)
    lines = [record.getMessage() for record in caplog.records if "camera of its own" in record.getMessage()]
    named = {line.split("'")[1]: line.split("'")[5] for line in lines}
    assert named == {"view distance": "View Distance", "ray length": "Ray Length", "window": "Window"}


@pytest.mark.parametrize(
    ("name", "least"),
    [("no slot", 28), ("holdout", 45)],
)
def test_objects_that_are_odd_all_over(name: str, least: float, tmp_path: Path) -> None:
    seen = looked_at(odd_stages.whole(name), tmp_path, 16)
    assert np.isfinite(seen.light).all()
    assert seen.psnr() > least
    assert abs(seen.energy() - 1) < 0.08


@pytest.mark.parametrize("name", ["transparent", "alpha 0", "unseen"])
def test_objects_that_are_clear_everywhere_are_refused(name: str, tmp_path: Path) -> None:
    stage = odd_stages.whole(name)
    words = "^object 'Subject' is clear to the camera everywhere, "
    with pytest.raises(InputError, match=words):
        make(16, 4).bake(stage, tmp_path)
    assert [slot.material.name for slot in stage.subject.material_slots] == [name]


def test_lamps_without_size_shine_in_highlights(tmp_path: Path) -> None:
    """An area lamp of no area sends no light; the others as much as they would if they were larger."""
    before = {light.name for light in bpy.data.lights}
    seen = looked_at(odd_stages.lamps(0.0), tmp_path, 32)
    check(seen, {"rough": (28, 0.1), "metal": (25, 0.1)})
    metal = seen.material == 1
    assert abs(seen.light[metal].mean() / seen.expected[metal].mean() - 1) < 0.2  # 0.33 without highlights
    assert {light.name for light in bpy.data.lights} - before == {"POINT", "SPOT", "AREA", "SUN"}


def test_a_lamp_in_the_middle_of_the_object_is_named(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    seen = looked_at(odd_stages.lamps(0.1, "SUN", inside=True), tmp_path, 32)
    assert np.isfinite(seen.light).all()
    assert "lamp 'POINT' stands in the middle of the object" in caplog.text
    assert seen.psnr() > 18


@pytest.mark.parametrize(("name", "least"), [("no world", 60), ("own glow", 17)])
def test_hardly_any_surroundings(name: str, least: float, tmp_path: Path) -> None:
    seen = looked_at(odd_stages.surroundings(name), tmp_path, 24)
    assert np.isfinite(seen.light).all()
    assert seen.psnr() > least
    assert abs(seen.energy() - 1) < 0.1


@pytest.mark.parametrize(
    ("stage", "least"),
    [(odd_stages.room, 24), (odd_stages.glass_shell, 16)],
    ids=["room", "glass shell"],
)
def test_objects_that_enclose_the_camera_or_others(
    stage: Callable[[], Stage], least: float, tmp_path: Path
) -> None:
    seen = looked_at(stage(), tmp_path, 32)
    assert np.isfinite(seen.light).all()
    assert seen.psnr() > least
    assert abs(seen.energy() - 1) < 0.1
