# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The web page shows a bake's layers, one by one and base and rest together, in a real Chromium."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from radtex_addon.bake.layers import Layer
from radtex_addon.bake.spec import Kind
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.formats.bucket_files import read_layer
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.report.metrics import Picture
from tests.real.exhibit import CAMERAS, decibels
from tests.real.kinds import LAYERS, KindBake
from tests.real.web import Site

LEAST = 38.0  # dB
FRONT = CAMERAS[0]


def expected(made: KindBake, layer: Layer) -> Picture:
    """The light (H, W, 3) of a layer as the reference looks it up; of the base with buckets of one cell."""
    facts, buffer = read_sidecar(made.sidecar), made.buffer(FRONT)
    layout = AtlasLayout(facts.width, facts.height, 1 if layer == Layer.BASE else facts.bucket)
    uv, incidence = buffer.uv[buffer.hit], buffer.incidence[buffer.hit]
    pixels = read_layer(made.sidecar, layer).astype(np.float32)
    light = buffer.spread(sample(pixels, layout, uv, incidence, Filter.QUADRILINEAR))
    return light.reshape(FRONT.pixels, FRONT.pixels, 3)


def test_layers_are_shown_one_by_one_and_base_and_rest_are_the_whole(
    web: Site, kind_bake: Callable[..., KindBake]
) -> None:
    made = kind_bake(Kind.PROXY)
    web.add("layers", made, layers=LAYERS)
    mask = made.eroded(FRONT)
    whole = made.seen(FRONT)
    with web.opened("layers/") as shown:
        shown.wait()
        shown.page.get_by_role("button", name="Quadrilinear").click()
        names = ["whole", *LAYERS, "sum"]
        assert shown.page.evaluate("radtex.layers()") == names
        shown.set_camera(FRONT)
        parts: dict[str, Picture] = {layer: expected(made, layer) for layer in LAYERS}
        parts |= {"whole": whole[..., :3], "sum": parts["base"] + parts["rest"]}
        for name, words in zip(names, ("Whole", "Base", "Rest", "Glossy", "Base + Rest"), strict=True):
            shown.page.get_by_role("button", name=words, exact=True).click()
            seen = shown.pixels().astype(np.float64)
            found = decibels(seen[..., :3], parts[name], mask)
            print(f"{name}: {found:.1f} dB")
            assert found >= LEAST
            assert decibels(seen[..., 3:], whole[..., 3:], mask) >= LEAST, "other alpha than the whole's"
        assert decibels(parts["sum"], whole[..., :3], mask) >= 60
        flat = shown.pixels(flat=True)[mask]
        assert 0.02 < flat[:, 3].min() < flat[:, 3].max() < 0.5, "a hull's flat lightmap hides what is behind"
        refusal = shown.page.evaluate(
            "() => { try { radtex.setLayer('haze') } catch (e) { return e.message } }"
        )
        assert refusal == "no layer haze: there are whole, base, rest, glossy, sum"
