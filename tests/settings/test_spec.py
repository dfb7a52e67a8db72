# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A spec that exists can be baked: everything else is refused in one line that names it and the remedy."""

from __future__ import annotations

import math
import shutil
from dataclasses import FrozenInstanceError
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from radtex_addon.bake.layers import LIGHT, Layer, captured, split_layers
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import InputError
from radtex_addon.forms import cost_of
from radtex_addon.settings import cost
from radtex_addon.settings.cost import check_disk, check_memory
from radtex_addon.settings.spec import BakeSpec, CaptureMethod, Compression, Kind, Layout, Unwrap, View
from radtex_addon.settings.texel_density import MOST_TEXELS, parse_density, side_for


def refusal(**changes: Any) -> str:
    with pytest.raises(InputError) as raised:
        check_memory(BakeSpec(**changes))
    message = str(raised.value)
    assert "\n" not in message
    assert raised.value.exit_code == 2
    return message


@pytest.mark.parametrize(
    ("name", "value", "bounds"),
    [
        ("texels", 0, "1 to 65536"),
        ("texels", -4, "1 to 65536"),
        ("bucket", 1, "2 to 256"),
        ("bucket", 257, "2 to 256"),
        ("samples", 0, "1 to 16777216"),
        ("seed", -1, "0 to 2147483647"),
        ("padding", -1, "0 to 256"),
        ("memory_mb", 0, "16 to 16777216"),
        ("texels", 64.0, "1 to 65536"),
        ("samples", True, "1 to 16777216"),
        ("bucket", "8", "2 to 256"),
    ],
)
def test_a_number_out_of_bounds_is_named_with_its_bounds(name: str, value: object, bounds: str) -> None:
    called = {"bucket": "cells", "memory_mb": "memory in MiB"}.get(name, name)
    assert refusal(**{name: value}) == f"{called} {value}: give a whole number from {bounds}"


def test_an_image_beyond_blenders_limit_is_refused_and_less_is_streamed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(cost, "physical_memory", lambda: None)
    assert "makes 65544 pixels a side, 65536 is the most" in refusal(texels=8193, bucket=8)
    assert BakeSpec(texels=8192, bucket=8).pixels_a_side == 65536
    assert BakeSpec(texels=2048, bucket=16, memory_mb=2048).streams
    assert "needs 32.0 GiB" in refusal(texels=2048, bucket=16, memory_mb=2048, accumulate=True)
    spec = BakeSpec(texels=1024, memory_mb=600)
    assert 32 <= spec.tile_mb == 600 - spec.atlas_bytes // 2**20 < 400  # what the atlas leaves
    assert BakeSpec(texels=1024, memory_mb=8000).tile_mb == BakeSpec().tile_mb == 1024


def test_an_atlas_beyond_the_memory_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cost, "physical_memory", lambda: 2**30)
    needs = "a side of 4096 texels with 8 cells needs 4.3 GiB of memory"
    expected = f"{needs}, this machine has 1.0 GiB: lower one of them"
    assert refusal(texels=4096, bucket=8) == expected
    assert "a side of 4096 texels with 14 cells needs" in refusal(layout=Layout.LAYERED, texels=4096)
    assert BakeSpec(texels=1024, bucket=8).atlas_bytes < 2**30
    assert BakeSpec().atlas_bytes < 80 * 1024**2


@pytest.mark.parametrize("other", [{}, {"layout": "layered"}, {"kind": "transfer"}, {"accumulate": True}])
def test_a_bake_beyond_the_memory_that_is_allowed_is_refused(
    other: dict[str, object], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cost, "physical_memory", lambda: None)
    said = refusal(texels=512, memory_mb=64, **other)
    assert "of memory beside the scene, 64 MiB are allowed: allow more, or lower one" in said


def test_a_large_layered_bake_has_its_arrays_in_files(monkeypatch: pytest.MonkeyPatch) -> None:
    gib = 2**30
    small, middle, large, huge = (BakeSpec(layout=Layout.LAYERED, texels=n) for n in (256, 1024, 2048, 4096))
    assert small.array_bytes == small.disk_bytes == 0
    assert 5 * gib < middle.array_bytes < middle.disk_bytes < large.disk_bytes
    assert middle.atlas_bytes < 4 * gib
    assert large.atlas_bytes < 8 * gib < huge.atlas_bytes
    plenty = BakeSpec(layout=Layout.LAYERED, texels=1024, memory_mb=64 << 10)
    assert plenty.array_bytes == 0
    assert plenty.atlas_bytes > 8 * gib
    tight = BakeSpec(layout=Layout.LAYERED, texels=256, memory_mb=1000)
    assert tight.array_bytes > 0
    assert tight.atlas_bytes < small.atlas_bytes
    assert BakeSpec(texels=4096, memory_mb=6000).array_bytes == 0, "buckets stream"
    monkeypatch.setattr(cost, "physical_memory", lambda: 8 * gib)
    check_memory(large)


def test_a_disk_without_room_for_the_arrays_is_refused_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Path] = []

    def usage(folder: Path) -> Any:
        asked.append(folder)
        return SimpleNamespace(free=3 << 30)

    monkeypatch.setattr(shutil, "disk_usage", usage)
    folder = tmp_path / "not" / "there"
    with pytest.raises(InputError) as caught:
        check_disk(BakeSpec(layout=Layout.LAYERED, texels=1024), folder)
    said = str(caught.value)
    assert f"of the disk of {folder} while it is baked, 3.0 GiB are free: free its disk, or choose" in said
    assert "a side of 1024 texels with 14 cells needs" in said
    assert asked == [tmp_path]
    check_disk(BakeSpec(layout=Layout.LAYERED, texels=256), folder)
    check_disk(BakeSpec(texels=1024), folder)


def test_the_layered_layout_chooses_its_cells_itself_and_takes_few_more_paths_at_most() -> None:
    layered = BakeSpec(layout=Layout.LAYERED)
    assert layered.bucket == 14
    assert "chooses its cells itself, 14 or fewer, not 8" in refusal(layout=Layout.LAYERED, bucket=8)
    assert BakeSpec(layout="layered") == layered  # type: ignore[arg-type]
    assert BakeSpec().layout is Layout.BUCKETS
    assert 0.3 * BakeSpec().path_count < layered.path_count < 1.5 * BakeSpec().path_count
    assert "panoramic only looks outwards and cannot bake radiance" in refusal(capture="panoramic")
    assert BakeSpec(capture=CaptureMethod.PANORAMIC, kind=Kind.INCIDENT).kind is Kind.INCIDENT


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"kind": Kind.INCIDENT}, "knows kind radiance only, not incident: choose layout buckets"),
        ({"kind": Kind.REFLECTION}, "knows kind radiance only, not reflection"),
        ({"bucket": 1}, "cells 1: give a whole number from 2 to 256"),
        ({"capture": CaptureMethod.PANORAMIC}, "panoramic"),
        ({"samples": 4097}, "samples in the layered layout 4097: give a whole number from 1 to 4096"),
    ],
)
def test_what_the_layered_layout_does_not_know_is_refused(changes: dict[str, Any], words: str) -> None:
    assert words in refusal(layout=Layout.LAYERED, **changes)


def test_text_becomes_the_choice_it_names_and_costs_are_of_all_cells() -> None:
    made = BakeSpec(kind="incident", capture="panoramic", compression="dwaa", unwrap="blender")  # type: ignore[arg-type]
    assert (made.kind, made.capture) == (Kind.INCIDENT, CaptureMethod.PANORAMIC)
    assert (made.compression, made.unwrap) == (Compression.DWAA, Unwrap.BLENDER)
    assert (made.pixels_a_side, made.pixel_count, made.path_count) == (1024, 1024**2, 16 * 1024**2)
    assert BakeSpec(texels=1, bucket=2, samples=1).path_count == 4
    with pytest.raises(FrozenInstanceError):
        made.texels = 2  # type: ignore[misc]


def test_an_unknown_choice_is_refused_with_the_choices() -> None:
    assert refusal(kind="specular") == f"there is no kind 'specular': choose from {', '.join(Kind)}"
    assert refusal(layout="shared") == "there is no layout 'shared': choose from buckets, layered"
    assert "UV layer" in refusal(uv_layer="")
    for word in ("kind", "capture", "compression", "layout", "unwrap", "view"):
        assert f"there is no {word} 'x': choose from " in refusal(**{word: "x"})
    assert "there is no way to split 'x': choose from material, udim" in refusal(split="x")


@pytest.mark.parametrize(
    ("text", "per_metre"),
    [("64", 64), ("64/m", 64), (" 64 / m ", 64), ("64/cm", 6400), ("1.5/mm", 1500), ("1e2/m", 100)],
)
def test_a_density_is_texels_per_metre_whatever_its_unit(text: str, per_metre: float) -> None:
    assert parse_density(text) == per_metre


@pytest.mark.parametrize(
    "text", ["64/in", "64/", "64/m/m", "x/m", "", "0", "-3/m", "nan", "inf/m", "1e400", "1e-300/m", "1e300/m"]
)
def test_what_is_no_density_is_refused_by_its_name(text: str) -> None:
    with pytest.raises(InputError, match=r"^--density .*such as 64/m") as raised:
        parse_density(text, "--density")
    assert text in str(raised.value)


@pytest.mark.parametrize("density", [0.0, -1.0, math.nan, math.inf, 5e-324, 1e-300, 1e-10, 1e13, 1e300])
def test_a_spec_has_a_density_above_0_that_does_not_overflow(density: float) -> None:
    bounds = r"from 1e-09 to 1e\+12 texels per metre" if 0 < density < math.inf else "above 0"
    with pytest.raises(InputError, match=bounds):
        BakeSpec(density=density)


@pytest.mark.parametrize("distance", [5e-324, 1e-300, 1e-38, 1e20, 1e38, 1e300, math.inf])
@pytest.mark.parametrize(
    "given", [{"kind": Kind.AO, "ao_distance": 0.0}, {"source": "Other", "extrusion": 0.0}]
)
def test_a_distance_whose_square_is_no_float_is_refused(given: dict[str, Any], distance: float) -> None:
    beyond: dict[str, Any] = {name: distance if value == 0 else value for name, value in given.items()}
    with pytest.raises(InputError, match=r"from 1e-18 to 1e\+18, in scene units"):
        BakeSpec(**beyond)


def test_the_most_texels_are_what_an_image_can_hold() -> None:
    assert side_for(1.0, 64, 0.25) == 128  # a square metre that fills a quarter has twice its density
    assert side_for(1e300, 1e300, 1e-9) > MOST_TEXELS
    assert BakeSpec(density=1, bucket=8).most_texels == MOST_TEXELS
    assert BakeSpec(density=1, bucket=64).most_texels == 65536 // 64
    around = BakeSpec(kind=Kind.TRANSFER, view=View.AROUND, density=1, bucket=256).most_texels
    assert around * 3 * 256 <= 65536 < (around + 4) * 3 * 256


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


def test_layers_may_be_named_by_words_and_doubled_and_are_refused_where_there_are_none() -> None:
    spec = BakeSpec(layers=("glossy", "base", "glossy"))  # type: ignore[arg-type]  # as text
    assert spec.layers == (Layer.GLOSSY, Layer.BASE)
    with pytest.raises(InputError, match="there is no layer 'shine': choose from diffuse, glossy"):
        BakeSpec(layers=("shine",))  # type: ignore[arg-type]  # as text
    for kind in (Kind.INCIDENT, Kind.REFLECTION):
        with pytest.raises(InputError, match=f"{kind} has no layers"):
            BakeSpec(kind=kind, layers=LIGHT)
    with pytest.raises(InputError, match="the layered layout has no layers"):
        BakeSpec(layout=Layout.LAYERED, layers=LIGHT)
