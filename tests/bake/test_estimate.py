# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An estimate is exact for a machine whose times are exact."""

from __future__ import annotations

import pytest

from radtex_addon.bake.estimate import Probe, paths_needed, probe_specs, seconds_needed
from radtex_addon.bake.progress import Stage
from radtex_addon.bake.spec import BakeSpec, Kind, Layout

COVERED = 0.75  # of every atlas


def taken(spec: BakeSpec) -> Probe:
    """A bake on a machine of 1 us a path and 1 ms a texel, which needs 2 s to begin and 3 s to unwrap."""
    covered = round(COVERED * spec.texels**2)
    paths = spec.most_paths(covered) if spec.form.by_paths else covered * spec.bucket**2 * spec.samples
    seconds = {Stage.UNWRAP: 3.0, Stage.RASTER: 1e-3 * spec.texels**2, Stage.CAPTURE: 2.0 + 1e-6 * paths}
    return Probe(spec.texels, covered, paths, seconds)


@pytest.mark.parametrize(
    "spec",
    [
        BakeSpec(texels=512, samples=64),
        BakeSpec(texels=16, samples=1),
        BakeSpec(texels=128, layout=Layout.LAYERED, samples=16),
        BakeSpec(texels=32, layout=Layout.LAYERED, samples=100),
    ],
)
def test_times_by_path_and_by_texel_are_told_apart(spec: BakeSpec) -> None:
    few, more = (taken(small) for small in probe_specs(spec))
    expected = taken(spec)
    assert paths_needed(spec, more) == expected.paths
    assert seconds_needed(spec, few, more) == pytest.approx(sum(expected.seconds.values()))


def test_the_small_bakes_are_small_and_differ_in_their_paths_alone() -> None:
    few, more = probe_specs(BakeSpec(texels=128, layout=Layout.LAYERED, samples=64))
    assert (few.texels, few.padding, few.bucket) == (96, 0, 14)
    assert few.samples < more.samples
    assert few.path_count + more.path_count < 11_000_000  # 9 of them for the surroundings
    assert probe_specs(BakeSpec(texels=40, padding=3))[0].padding == 3  # the unwrap that it will have


def test_of_a_shadow_both_are_alike_and_all_is_by_path() -> None:
    spec = BakeSpec(kind=Kind.SHADOW, texels=192)
    few, more = (Probe(96, 9000, 576_000, {Stage.CAPTURE: seconds}) for seconds in (1.0, 1.1))
    assert paths_needed(spec, more) == 4 * 576_000
    assert seconds_needed(spec, few, more) == pytest.approx(4.4)


def test_where_times_are_noise_the_estimate_is_rather_too_long() -> None:
    spec = BakeSpec(texels=96, bucket=2, samples=8)
    few, more = Probe(96, 1000, 4000, {Stage.CAPTURE: 2.5}), Probe(96, 1000, 12000, {Stage.CAPTURE: 2.4})
    assert seconds_needed(spec, few, more) == pytest.approx(2.4 * 32000 / 12000)
