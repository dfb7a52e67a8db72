# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Costs before a bake, in figures that can be counted by hand, and times that follow what was measured."""

from __future__ import annotations

from dataclasses import replace

import pytest

from radtex_addon.bake.progress import Stage
from radtex_addon.forms import cost_of
from radtex_addon.settings.estimate import START, BakeWork, Basis, Measurement, estimate, typical_seconds
from radtex_addon.settings.rays import LayeredRays, most_panorama_paths, side_in
from radtex_addon.settings.spec import BakeSpec, Kind, Layout

LAYERED = BakeSpec(texels=128, layout=Layout.LAYERED, samples=16)
PLAIN = BakeSpec(texels=128, samples=16, denoise=True)


def work(spec: BakeSpec, covered: int | None = None) -> BakeWork:
    return BakeWork.of(spec, 16_000, covered=covered, preview=True, device="CPU")


def measured(one: BakeWork, slower: float, place: str = "here", name: str = "Head") -> Measurement:
    """A bake on a machine that is so many times slower than the typical one in every stage."""
    return Measurement(place, name, one, {s: slower * t for s, t in typical_seconds(one).items()})


@pytest.mark.parametrize("spec", [LAYERED, PLAIN, BakeSpec(kind=Kind.SHADOW), BakeSpec(kind=Kind.TRANSFER)])
def test_without_measurements_the_time_is_the_typical_one(spec: BakeSpec) -> None:
    found = estimate(work(spec), "here", "Head", ())
    assert found.basis is Basis.NOTHING
    assert found.total == pytest.approx(sum(typical_seconds(work(spec)).values()))


def test_a_larger_mesh_takes_longer_in_the_stages_that_read_it() -> None:
    for spec in (LAYERED, PLAIN):
        works = [BakeWork.of(spec, n, preview=True, device="CPU") for n in (1_000, 9_000)]
        few, many = map(typical_seconds, works)
        grown = {stage for stage in few if many[stage] > few[stage]}
        assert grown == {"evaluate", "unwrap", "preview"}
        assert all(many[stage] == few[stage] for stage in set(few) - grown)


def test_the_same_bake_again_takes_as_long_as_it_took() -> None:
    seconds = {START: 2.0, "unwrap": 40.0, "capture": 7.0, "fit": 90.0, "surroundings": 3.0, "write": 0.5}
    others = [measured(work(LAYERED), 3.0, "there", f"Other {number}") for number in range(5)]
    found = estimate(
        work(LAYERED), "here", "Head", (*others, Measurement("here", "Head", work(LAYERED), seconds))
    )
    assert found.basis is Basis.BAKED
    for stage, value in seconds.items():
        assert found.seconds[stage] == pytest.approx(value, rel=0.03)


def test_another_object_is_as_slow_as_the_last_ones_on_this_machine() -> None:
    history = [measured(work(PLAIN), 3.0, "there", f"Other {number}") for number in range(5)]
    found = estimate(work(PLAIN), "here", "Head", history)
    assert found.basis is Basis.OTHERS
    assert found.total == pytest.approx(3.0 * sum(typical_seconds(work(PLAIN)).values()), rel=0.05)
    unlike = estimate(replace(work(PLAIN), device="optix"), "here", "Head", history)
    assert unlike.basis is Basis.NOTHING
    assert unlike.seconds["capture"] == typical_seconds(work(PLAIN))["capture"]  # a GPU's pace is its own
    assert unlike.seconds[START] == pytest.approx(3.0 * 3.5, rel=0.05)  # but starting is not


def test_paths_grow_with_texels_and_samples() -> None:
    once = typical_seconds(work(PLAIN, 5000))["capture"] - 0.4
    assert typical_seconds(work(PLAIN, 20_000))["capture"] - 0.4 == pytest.approx(4 * once)
    finer = replace(PLAIN, samples=48)
    assert typical_seconds(work(finer, 5000))["capture"] - 0.4 == pytest.approx(3 * once)


def test_wrong_mirror_rays_are_looked_for_in_each_texel() -> None:
    """So the stage of the surroundings grows with texels, and the pictures alone with their width.

    A texel of a large atlas takes fewer rays.
    """
    counts = (1000, 40_000, 60_000)
    few, many, most = (typical_seconds(work(LAYERED, count))["surroundings"] for count in counts)
    assert many - few == pytest.approx(39_000 * 8.6e-4)
    assert most - few == pytest.approx((60_000 * 16**2 / 20**2 - 1000) * 8.6e-4)
    narrow = typical_seconds(replace(work(LAYERED, 1000), surroundings=0.25))["surroundings"]
    assert few - narrow == pytest.approx(9.0 * 0.955 * (1 - 0.25**2))


def test_a_probe_counts_more_than_other_objects_and_less_than_the_same_bake() -> None:
    small = replace(work(LAYERED, 500), texels=24)
    probe = replace(measured(small, 2.0), finished=False)
    others = [measured(work(LAYERED), 1.0, "there", f"Other {number}") for number in range(5)]
    found = estimate(work(LAYERED), "here", "Head", (*others, probe))
    assert found.basis is Basis.MEASURED
    assert found.seconds["capture"] == pytest.approx(
        2.0 * typical_seconds(work(LAYERED))["capture"], rel=0.05
    )
    baked = estimate(work(LAYERED), "here", "Head", (measured(work(LAYERED), 4.0), probe))
    assert baked.seconds["capture"] > 3.5 * typical_seconds(work(LAYERED))["capture"]


def test_an_object_with_a_uv_layer_of_its_own_says_nothing_of_unwraps() -> None:
    quick = Measurement("there", "Other", work(PLAIN), {str(Stage.UNWRAP): 0.01})
    assert estimate(work(PLAIN), "here", "Head", [quick]).seconds["unwrap"] == pytest.approx(3.82, abs=0.01)
    assert estimate(work(PLAIN), "there", "Other", [quick]).seconds["unwrap"] < 0.02


def test_buckets_cost_four_half_floats_a_cell() -> None:
    cost = cost_of(BakeSpec(texels=64, bucket=8, samples=4))
    assert cost.side == 512
    assert cost.disk == cost.gpu == 512 * 512 * 4 * 2
    assert cost.paths == 512 * 512 * 4
    assert cost_of(BakeSpec(texels=64, bucket=8, half=False)).disk == 2 * cost.disk


def test_finer_texels_and_hidden_ones_are_among_the_layered_layouts_paths() -> None:
    spec = BakeSpec(texels=32, layout=Layout.LAYERED, samples=16)
    of_texel = 3 * 16**2 + 2 * 10**2 + 1 + 16 + 2 * 16
    assert cost_of(spec).paths == 32**2 * of_texel + most_panorama_paths()
    for samples in (4, 16, 64, 256, 1024):
        assert 0.3 < LayeredRays.of(samples).of_texel / (64 * samples) < 1
    assert LayeredRays.of(16) == LayeredRays()
    assert min(LayeredRays.of(1).light, LayeredRays.of(1).ends) >= 4  # which still tell directions apart


def test_a_map_of_wider_texels_has_whole_ones_alone() -> None:
    """The buckets of light that comes through lay in one more column than those of the rest."""
    assert [side_in(texels, 2) for texels in (1, 63, 64, 65)] == [1, 31, 32, 32]
    assert [side_in(texels, 0.25) for texels in (1, 63)] == [4, 252]
    assert side_in(1023, 1023 / 512) == 512
