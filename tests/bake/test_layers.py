# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers: which channels a bake needs for them, and what is made of those."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.bake.layers import LIGHT, Layer, captured, split_layers
from radtex_addon.bake.spec import BakeSpec, Kind, Layout
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import InputError
from radtex_addon.forms import cost_of


def test_base_and_rest_are_made_of_diffuse_light() -> None:
    assert captured((Layer.REST,)) == (Layer.DIFFUSE,)
    assert captured((Layer.NORMAL, Layer.GLOSSY, Layer.GLOSSY)) == (Layer.GLOSSY, Layer.NORMAL)
    assert captured(()) == ()


def test_base_and_rest_add_up_to_the_whole() -> None:
    layout = AtlasLayout(3, 2, 4)
    image = np.random.default_rng(1).uniform(0, 5, (8, 12, 10)).astype(np.float32)
    layers = split_layers(image, layout, (Layer.REST, Layer.GLOSSY, Layer.BASE))
    assert list(layers) == ["rest", "glossy", "base"]
    assert layers["base"].shape == (2, 3, 3)
    assert np.array_equal(layers["base"], layers["base"].astype(np.float16))
    spread = layers["base"].repeat(4, axis=0).repeat(4, axis=1)
    np.testing.assert_allclose(spread + layers["rest"], image[..., :3], atol=1e-6)
    assert np.array_equal(layers["glossy"], image[..., 7:10])


def test_a_base_is_the_mean_over_the_hemisphere_and_not_over_cells() -> None:
    layout = AtlasLayout(1, 1, 8)
    image = np.zeros((8, 8, 7), dtype=np.float32)
    image[..., 4:] = 3.0
    assert split_layers(image, layout, (Layer.BASE,))["base"] == pytest.approx(3.0)
    image[0, 0, 4:] = 0.0  # a corner's cell, which is smaller on the sphere than one of the middle
    corner = 3.0 - split_layers(image, layout, (Layer.BASE,))["base"].max()
    image[0, 0, 4:], image[3, 3, 4:] = 3.0, 0.0
    middle = 3.0 - split_layers(image, layout, (Layer.BASE,))["base"].max()
    assert 0 < corner < middle


def test_a_bake_with_layers_costs_more() -> None:
    plain, layered = BakeSpec(texels=8), BakeSpec(texels=8, layers=(Layer.BASE, Layer.GLOSSY))
    assert layered.channels == 10
    assert cost_of(layered).disk == cost_of(plain).disk + 2 * 3 * (64 * 64 + 8 * 8)


def test_layers_may_be_named_by_words_and_doubled() -> None:
    spec = BakeSpec(layers=("glossy", "base", "glossy"))  # type: ignore[arg-type]  # as text
    assert spec.layers == (Layer.GLOSSY, Layer.BASE)


def test_a_layer_that_is_none_is_refused_with_the_choices() -> None:
    with pytest.raises(InputError, match="there is no layer 'shine': choose from diffuse, glossy"):
        BakeSpec(layers=("shine",))  # type: ignore[arg-type]  # as text


@pytest.mark.parametrize("kind", [Kind.INCIDENT, Kind.REFLECTION])
def test_arriving_light_has_no_layers(kind: Kind) -> None:
    with pytest.raises(InputError, match=f"{kind} has no layers"):
        BakeSpec(kind=kind, layers=LIGHT)


def test_the_layered_layout_has_no_layers() -> None:
    with pytest.raises(InputError, match="the layered layout has no layers"):
        BakeSpec(layout=Layout.LAYERED, layers=LIGHT)
