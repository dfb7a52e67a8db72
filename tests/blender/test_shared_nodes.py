# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group "RadTex Shared" in Cycles and in Eevee against the reference sampler."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.core.shared import Axis, SharedAtlas
from radtex_addon.formats.shared_files import read_shared, write_shared
from radtex_addon.formats.shared_sidecar import SharedSidecar
from radtex_addon.preview.material import load_layers
from radtex_addon.preview.shared_group import build_shared_group, check_shared_previewable
from tests.blender.lookup_stage import ENGINES, render_groups
from tests.lookups import relative_error
from tests.shared_atlases import facts_about, random_shared_atlas
from tests.shared_lookups import random_fragments, shared_answers

WIDTH, HEIGHT = 7, 5
LOOKUPS = random_fragments(WIDTH, HEIGHT)

Stored = tuple[SharedAtlas, SharedSidecar, dict[str, bpy.types.Image]]


def stored(path: Path, atlas: SharedAtlas) -> Stored:
    """The atlas as its files have it, and its images."""
    write_shared(path, atlas, facts_about(atlas))
    images, sidecar = load_layers(path)
    return read_shared(path)[0], sidecar, images


def rendered(engine: str, bakes: list[Stored], folder: Path, viewer: bool = True) -> list[Floats]:
    """What the group answers to LOOKUPS for each bake, (K, 3); without `viewer` Incoming stays zero."""
    groups = [build_shared_group(images, sidecar) for _, sidecar, images in bakes]
    return render_groups(engine, groups, LOOKUPS, folder, viewer)


def worst_errors(engine: str, atlases: list[SharedAtlas], folder: Path) -> list[float]:
    """Each atlas's worst error, relative to the reference, in one render."""
    bakes = [stored(folder / f"{index}.json", atlas) for index, atlas in enumerate(atlases)]
    return [
        float(relative_error(result, shared_answers(atlas, LOOKUPS)).max())
        for result, (atlas, _, _) in zip(rendered(engine, bakes, folder), bakes, strict=True)
    ]


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)
def test_the_group_agrees_with_the_reference(engine: str, tmp_path: Path) -> None:
    (worst,) = worst_errors(engine, [random_shared_atlas(WIDTH, HEIGHT)], tmp_path)
    print(f"{engine}: worst error {worst:.1e}")
    assert worst <= 2e-3  # Eevee renders half floats


def test_any_lobes_and_any_levels_will_do(tmp_path: Path) -> None:
    atlases = [
        random_shared_atlas(WIDTH, HEIGHT, lobes=()),
        random_shared_atlas(WIDTH, HEIGHT, lobes=(Axis.THROUGH,), levels=1),
        random_shared_atlas(WIDTH, HEIGHT, lobes=(Axis.MIRROR,), surroundings=33, levels=7, bucket=1),
    ]
    for worst in worst_errors(ENGINES["Cycles"], atlases, tmp_path):
        print(f"worst error {worst:.1e}")
        assert worst <= 1e-3


def test_light_below_zero_is_none(tmp_path: Path) -> None:
    atlas = random_shared_atlas(WIDTH, HEIGHT, lobes=(Axis.THROUGH,))
    (lobe,) = atlas.lobes
    dark = replace(atlas, lobes=(replace(lobe, rest=lobe.rest - 10_000),))
    (result,) = rendered(ENGINES["Cycles"], [stored(tmp_path / "a.json", dark)], tmp_path)
    assert not result.any()


def test_without_incoming_the_viewer_is_the_ray_s(tmp_path: Path) -> None:
    files = stored(tmp_path / "a.json", random_shared_atlas(WIDTH, HEIGHT))
    (result,) = rendered(ENGINES["Cycles"], [files], tmp_path, viewer=False)
    from_above = replace(LOOKUPS, viewer=np.full_like(LOOKUPS.viewer, [0, 0, 1]))
    assert relative_error(result, shared_answers(files[0], from_above)).max() <= 1e-3


def test_an_image_of_another_bake_is_refused(tmp_path: Path) -> None:
    _, sidecar, images = stored(tmp_path / "a.json", random_shared_atlas(WIDTH, HEIGHT))
    other = replace(sidecar, bake=replace(sidecar.bake, bucket=5))
    with pytest.raises(InputError, match="56 x 40 pixels, but this bake's 'mirror_ends' has 49 x 35"):
        build_shared_group(images, other)
    assert not bpy.data.node_groups


def test_a_bake_beyond_the_gpu_is_refused(tmp_path: Path) -> None:
    _, sidecar, _ = stored(tmp_path / "a.json", random_shared_atlas(WIDTH, HEIGHT))
    check_shared_previewable(sidecar, max_pixels=76)
    with pytest.raises(InputError, match="'surroundings' has 76 x 60 pixels and cannot be previewed"):
        check_shared_previewable(sidecar, max_pixels=75)
