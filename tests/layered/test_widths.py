# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How wide lobes are where roughness was evaluated, and whether it is believed."""

from __future__ import annotations

import numpy as np

from radtex_addon.bake.light_samples import mirrored
from radtex_addon.bake.pooling import Neighbours
from radtex_addon.core.arrays import Bools, Floats, Ints
from radtex_addon.forms.layered.fit.lobes import Paths
from radtex_addon.forms.layered.fit.widths import Lobes, fit_lobes
from radtex_addon.forms.layered.lookup.lobes import shown_at
from tests.layered.test_layered import SIDE, flat_samples, spread_by_lobe

_RAYS = flat_samples(16)
_TEXELS = SIDE * SIDE
_CHECKER = (np.arange(_TEXELS) % SIDE + np.arange(_TEXELS) // SIDE) % 2 == 0  # no two neighbours alike
_SHARP, _ROUGH = 0.004, 0.25
_ONE = np.zeros(_TEXELS, dtype=np.int32)


def _paths(width: Floats, material: Ints = _ONE, seed: int = 4) -> Paths:
    """Paths about normals that turn from texel to texel, spread by lobes of `width` (K,)."""
    rng = np.random.default_rng(seed)
    each = _RAYS.used.shape[1]
    texel = np.arange(_TEXELS).repeat(each)
    normal = np.broadcast_to(np.array([0, 0, 1.0]), (len(texel), 3))
    axis = mirrored(_RAYS.plan, _RAYS.square).reshape(-1, 3)
    end = spread_by_lobe(rng, axis, normal, width[texel] ** 2)
    return Paths(texel, np.ones((len(texel), 3)), end, axis, normal, axis[:, 2], material[texel])


def _fitted(width: Floats, evaluated: Floats, material: Ints = _ONE) -> Lobes:
    neighbours = Neighbours(_RAYS.plan)
    return fit_lobes(_paths(width, material), material, neighbours, vary=False, evaluated=evaluated)


def _middles(lobes: Lobes, number: int = 0) -> Floats:
    """The width of a material's lobes, by their weight, at N.V = 0.8, in each texel."""
    weight, variance, _ = lobes.materials[number].at(np.array([0.8]))
    share = weight[:, 0] / weight[:, 0].sum()
    middle: Floats = np.exp((share * np.log(variance)).sum() / 2) * np.sqrt(lobes.width)
    return middle


def _as_log2(width: Floats) -> Floats:
    return np.log2(width**2).astype(np.float32)


def test_texels_have_the_lobes_that_two_materials_would_have() -> None:
    wide = np.where(_CHECKER, _SHARP, _ROUGH)
    lobes = _fitted(wide, _as_log2(wide))
    assert lobes.evaluated.all()
    apart = _fitted(wide, np.full(_TEXELS, np.nan, np.float32), _CHECKER.astype(np.int32))
    assert not apart.evaluated.any()
    for number, own in ((1, _CHECKER), (0, ~_CHECKER)):
        np.testing.assert_allclose(_middles(lobes)[own], _middles(apart, number)[own], rtol=0.03)


def test_what_paths_do_not_show_is_not_believed() -> None:
    """A roughness that says nothing of most of the light, such as that of what lies under a sharp coat."""
    wide = np.where(_CHECKER, _SHARP, _ROUGH)
    for true, told in (
        (np.full(_TEXELS, 0.05), wide),
        (wide, np.where(_CHECKER, _ROUGH, _SHARP)),
        (wide, np.full(_TEXELS, 0.05)),
    ):
        lobes = _fitted(true, _as_log2(told))
        assert not lobes.evaluated.any()
        assert (lobes.width == 1).all()
        assert lobes.image(_RAYS.plan, {}) is None


def test_what_is_fitted_is_kept_where_it_tells_more() -> None:
    """Of a roughness that is unsure of every second texel, where the paths of neighbours tell as well."""
    left = np.arange(_TEXELS) % SIDE < SIDE // 2
    wide = np.where(left, 0.03, 0.2)
    told = _as_log2(np.where(_CHECKER, 0.08, wide))
    neighbours, paths = Neighbours(_RAYS.plan), _paths(wide)
    only = fit_lobes(paths, _ONE, neighbours, vary=False, evaluated=told)
    assert only.evaluated.all()
    both = fit_lobes(paths, _ONE, neighbours, vary=True, evaluated=told)
    assert not both.evaluated.any()
    assert (both.width[~left] > 10 * both.width[left].mean()).mean() > 0.8  # but at the border


def _fine(values: Floats | Ints) -> Floats:
    """An image of texels' values (K,), four times as fine."""
    image: Floats = values.reshape(SIDE, SIDE, 1).repeat(4, axis=0).repeat(4, axis=1).astype(np.float32)
    return image


def test_the_map_is_fine_where_roughness_was_evaluated_and_flat_where_it_is_unknown() -> None:
    left: Bools = np.arange(_TEXELS) % SIDE < SIDE // 2
    material = (~left).astype(np.int32)
    wide = np.where(left & _CHECKER, _SHARP, _ROUGH)
    told = np.where(left, _as_log2(wide), np.nan).astype(np.float32)
    lobes = _fitted(wide, told, material)
    assert lobes.evaluated.tolist() == [True, False]
    finer = _fine(told)
    finer[0, 0] -= 3  # a detail that no coarse texel has
    image = lobes.image(_RAYS.plan, {"width": finer, "material": _fine(material)})
    assert image is not None
    assert image.shape == (4 * SIDE, 4 * SIDE, 1)
    np.testing.assert_allclose(image[0, 0] - image[0, 1], -3, atol=1e-5)
    np.testing.assert_allclose(image[1::4, 1::4].ravel()[left], np.log2(lobes.width)[left], atol=1e-5)
    assert (image[:, 4 * (SIDE // 2) + 4 :] == 0).all()


def test_texels_that_mirror_nothing_are_as_usual() -> None:
    wide = np.where(_CHECKER, _SHARP, _ROUGH)
    told = _as_log2(wide)
    told[:8] = np.nan
    lobes = _fitted(wide, told)
    assert lobes.evaluated.all()
    assert (lobes.width[:8] == 1).all()


def _reflected(
    rng: np.random.Generator, cosine: Floats, rough: Floats, facets: Floats
) -> tuple[Floats, Floats]:
    """Where a GGX surface sends paths from N.V (P,), (P, 3) about +z, and their weights (P,).

    `facets` (P,): the reflectance of facets along their normals, by Schlick's curve. Visible normals are
    sampled (Heitz, "Sampling the GGX Distribution of Visible Normals", 2018).
    """
    alpha, none = rough**2, np.zeros_like(cosine)
    viewer = np.stack([np.sqrt(1 - cosine**2), none, cosine], axis=1)
    stretched = viewer * np.stack([alpha, alpha, none + 1], axis=1)
    stretched /= np.linalg.norm(stretched, axis=1, keepdims=True)
    across = np.stack([none, none + 1, none], axis=1)
    up = np.cross(stretched, across)
    radius, angle = np.sqrt(rng.random(len(cosine))), rng.uniform(0, 2 * np.pi, len(cosine))
    x, y, part = radius * np.cos(angle), radius * np.sin(angle), (1 + stretched[:, 2]) / 2
    y = (1 - part) * np.sqrt(1 - x**2) + part * y
    left = np.sqrt(np.maximum(1 - x**2 - y**2, 0))
    facet = x[:, None] * across + y[:, None] * up + left[:, None] * stretched
    facet *= np.stack([alpha, alpha, none + 1], axis=1)
    facet /= np.linalg.norm(facet, axis=1, keepdims=True)
    along = (viewer * facet).sum(axis=1)
    end = 2 * along[:, None] * facet - viewer
    hidden = [
        (np.sqrt(1 + alpha**2 * (1 / np.maximum(way, 1e-4) ** 2 - 1)) - 1) / 2 for way in (cosine, end[:, 2])
    ]
    weight = (facets + (1 - facets) * (1 - along) ** 5) * (1 + hidden[0]) / (1 + hidden[0] + hidden[1])
    return end, np.where(end[:, 2] > 0, weight, 0)


def test_metal_and_paint_of_one_material_both_reflect_as_they_should_at_their_rims() -> None:
    rng, each = np.random.default_rng(6), 200
    rough, facets = np.where(_CHECKER, 0.25, 0.6), np.where(_CHECKER, 0.9, 0.04)
    texel = np.arange(_TEXELS).repeat(each)
    cosine = rng.uniform(0.05, 1, len(texel))
    end, weight = _reflected(rng, cosine, rough[texel], facets[texel])
    axis = np.stack([-np.sqrt(1 - cosine**2), 0 * cosine, cosine], axis=1)
    normal = np.broadcast_to(np.array([0, 0, 1.0]), axis.shape)
    light = np.repeat(weight[:, None], 3, axis=1)
    paths = Paths(texel, light, end, axis, normal, cosine, _ONE[texel])
    straight = np.ones(20_000)
    glossy = np.array(
        [
            _reflected(rng, straight * 0.9999, straight * r, straight * f)[1].mean()
            for r, f in ((0.25, 0.9), (0.6, 0.04))
        ]
    )
    mean = np.full((1, 3), glossy.mean())
    tint = np.where(_CHECKER, glossy[0], glossy[1])[:, None] / mean
    evaluated = np.log2(2 * rough**4 / (1 + 5 * rough**4)).astype(np.float32)
    lobes = fit_lobes(paths, _ONE, Neighbours(_RAYS.plan), False, evaluated, tint.astype(np.float32), mean)
    (material,) = lobes.materials
    assert material.gloss is not None
    by_tint = fit_lobes(paths, _ONE, Neighbours(_RAYS.plan), False, evaluated, tint.astype(np.float32))
    assert by_tint.materials[0].gloss is None
    for facing in (0.15, 0.3, 0.6, 0.95):
        at, one = np.full(2, facing), [int(np.flatnonzero(kind)[0]) for kind in (_CHECKER, ~_CHECKER)]
        exact = [
            _reflected(rng, straight * facing, straight * rough[i], straight * facets[i])[1].mean()
            for i in one
        ]
        shown = [
            found.materials[0].at(at)[0].sum(axis=0)[0]
            * shown_at(found.materials, _ONE[:2], at, tint[one], found.width[one])[:, 0]
            for found in (lobes, by_tint)
        ]
        np.testing.assert_allclose(shown[0], exact, rtol=0.25)
        if facing < 0.5:  # the paint's rim, which the tint alone makes as dark as the paint itself
            assert shown[1][1] < 0.6 * exact[1]
