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
