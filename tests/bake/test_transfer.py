# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Buckets fitted to suns that stand still, on surfaces that face any way."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.progress import finished
from radtex_addon.bake.transfer_buckets import fit_buckets, lookup_solid_angles_sr, sun_directions, sun_radius
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.frame import orthonormal_frame, to_frame
from tests.reference.relighting import sample_transfer

CELLS, TEXELS = 9, 40
ONE = AtlasLayout(1, 1, CELLS)


def turned_plan() -> CapturePlan:
    """Texels at the origin that face, and are turned, every which way; some frames are left-handed."""
    random = np.random.default_rng(1)
    sign = np.where(np.arange(TEXELS) % 3, 1.0, -1.0)
    t, b, n = orthonormal_frame(random.normal(size=(TEXELS, 3)), random.normal(size=(TEXELS, 3)), sign)
    fields = [f.astype(np.float32).reshape(1, TEXELS, 3) for f in (np.zeros_like(n), t, b, n, n)]
    return CapturePlan(AtlasLayout(TEXELS, 1, 1), np.arange(TEXELS), *fields)


def captured(plan: CapturePlan, response: Callable[[Floats], Floats], suns: int) -> Floats:
    """What texels that answer to directions (..., 3) in the frame show under the suns: (S, K, 3)."""
    random = np.random.default_rng(2)
    middle, radius = sun_directions(suns), sun_radius(suns)
    shift = random.normal(size=(400, suns, 3))
    shift -= (shift * middle).sum(axis=-1, keepdims=True) * middle
    shift /= np.linalg.norm(shift, axis=-1, keepdims=True)
    away = np.tan(radius) * np.sqrt((np.arange(400) + 0.5) / 400)
    disc = middle + away[:, None, None] * shift
    disc /= np.linalg.norm(disc, axis=-1, keepdims=True)
    facing = (disc * middle).sum(axis=-1).mean()  # a sun of any size gives a plane that faces it 1
    t, b, n = (field.reshape(-1, 3).astype(float) for field in (plan.tangent, plan.bitangent, plan.normal))
    shown = [
        response(to_frame(disc, *(np.broadcast_to(axis[k], disc.shape) for axis in (t, b, n)))).mean(axis=0)
        for k in range(TEXELS)
    ]
    return np.repeat((np.stack(shown, axis=1) / facing)[..., None], 3, axis=2)


def cosine(light: Floats) -> Floats:
    return np.maximum(light[..., 2], 0)


def wax(light: Floats) -> Floats:
    """Light wraps around the edge, from one side more than from the other, and a little comes through."""
    wrapped = np.maximum((light[..., 2] + 0.2 * light[..., 0] + 0.4) / 1.4, 0) ** 1.5
    return np.asarray(wrapped + 0.1 * np.maximum(-light[..., 2], 0))


@pytest.mark.parametrize(("response", "worst"), [(cosine, 0.022), (wax, 0.012)])
def test_lookups_show_what_the_surface_would(response: Callable[[Floats], Floats], worst: float) -> None:
    plan = turned_plan()
    buckets = finished(fit_buckets(plan, captured(plan, response, CELLS**2), CELLS))
    light = np.random.default_rng(3).normal(size=(1000, 3))
    light /= np.linalg.norm(light, axis=1, keepdims=True)
    uv = np.full((1000, 2), 0.5)
    found = [sample_transfer(bucket.reshape(CELLS, CELLS, 3), ONE, uv, light)[:, 0] for bucket in buckets]
    error = float(np.sqrt(np.mean((np.stack(found) - response(light)) ** 2)))
    energy = buckets[..., 0] @ lookup_solid_angles_sr(CELLS) / (4 * np.pi)
    expected = response(light_everywhere()).mean()
    gain = energy / expected - 1
    print(f"{response.__name__}: off by {error:.4f} RMS, energy {gain.mean():+.2%} ± {gain.std():.2%}")
    assert error < worst
    assert np.abs(gain).max() < 0.02
    assert buckets.min() >= 0


def light_everywhere(count: int = 200_000) -> Floats:
    return sun_directions(count)


def test_what_is_the_same_from_everywhere_stays_so() -> None:
    plan = turned_plan()
    buckets = finished(fit_buckets(plan, np.full((CELLS**2, TEXELS, 3), 0.25), CELLS))
    facing = 0.25 * np.cos(sun_radius(CELLS**2)) ** 0.5  # between a disc's middle and its rim
    np.testing.assert_allclose(buckets, facing, rtol=2e-2)
    assert buckets.std() < 1e-3


def test_suns_share_the_sphere() -> None:
    suns = sun_directions(64)
    np.testing.assert_allclose(np.linalg.norm(suns, axis=1), 1)
    assert np.linalg.norm(suns.mean(axis=0)) < 0.01
    nearest = np.arccos(np.clip((suns @ suns.T - 2 * np.eye(64)).max(axis=1), -1, 1))
    assert nearest.min() > 1.3 * sun_radius(64)  # neighbours' discs hardly overlap
    assert 64 * np.pi * sun_radius(64) ** 2 == pytest.approx(4 * np.pi)
