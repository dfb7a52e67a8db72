# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group "RadTex Sample" in Cycles and in Eevee against the reference sampler."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import bpy
import pytest

from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import FormatError, InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.preview.material import load_atlas
from radtex_addon.preview.node_group import build_sample_group
from radtex_addon.scene.nodes import NodeBuilder, Socket
from tests.blender.lookup_stage import ENGINES, Inputs, LookupStage, Shader, write_exr
from tests.lookups import LAYOUT, constant_buckets, random_atlas, random_lookups, worst_error


def group_shader(image: bpy.types.Image, kind: Filter) -> Shader:
    def shader(build: NodeBuilder, inputs: Inputs) -> tuple[Socket, ...]:
        return build.group(build_sample_group(image, LAYOUT, kind), *inputs)

    return shader


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)
def test_the_group_agrees_with_the_reference_and_never_bleeds(engine: str, tmp_path: Path) -> None:
    varied, constant, lookups = random_atlas(), constant_buckets(), random_lookups()
    stage = LookupStage(cast(bpy.types.Scene, bpy.context.scene), engine)
    planes = [(varied, kind) for kind in Filter]
    planes += [(constant, kind) for kind in (Filter.LINEAR, Filter.QUADRILINEAR)]
    for index, (atlas, kind) in enumerate(planes):
        image = load_atlas(write_exr(tmp_path / f"atlas {index}.exr", atlas))
        stage.add(lookups, group_shader(image, kind))
    results = stage.render(tmp_path / "answers.exr")
    for (atlas, kind), result in zip(planes, results, strict=True):
        worst, across = worst_error(result, atlas, lookups, kind)
        print(f"{engine} {kind}: worst error {worst:.1e}, across an edge {across:.2%}")
        assert worst <= 2e-3
        assert across <= 2e-3
        if atlas is constant and kind is Filter.LINEAR:
            assert worst <= 1e-6  # whatever lies in the bucket beside it


def test_an_image_that_is_not_this_atlas_is_refused(tmp_path: Path) -> None:
    image = load_atlas(write_exr(tmp_path / "random.exr", random_atlas()))
    with pytest.raises(InputError, match="78 x 42 pixels, but 13 x 6 texels of 6 cells have 78 x 36"):
        build_sample_group(image, AtlasLayout(13, 6, 6), Filter.NEAREST)
    assert not bpy.data.node_groups


def test_an_atlas_beyond_the_gpu_is_refused_with_the_size_that_fits(tmp_path: Path) -> None:
    image = load_atlas(write_exr(tmp_path / "random.exr", random_atlas()))
    with pytest.raises(InputError, match=r"78 x 42 pixels cannot be previewed.*at most 11 texels of 6 cells"):
        build_sample_group(image, LAYOUT, Filter.NEAREST, max_pixels=70)


def test_a_preview_is_made_without_reading_the_atlas(tmp_path: Path) -> None:
    """Blender would take 16 bytes for each pixel: 4 GiB where the side has 16384."""
    image = load_atlas(write_exr(tmp_path / "random.exr", random_atlas()))
    build_sample_group(image, LAYOUT, Filter.QUADRILINEAR)
    assert not image.has_data
    assert tuple(cast(Any, image).size) == (LAYOUT.pixel_width, LAYOUT.pixel_height)
    assert image.has_data


def test_a_missing_or_broken_atlas_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.exr: no atlas"):
        load_atlas(tmp_path / "none.exr")
    (tmp_path / "broken.exr").write_text("no image")
    with pytest.raises(FormatError, match=r"broken\.exr: Blender reads no image"):
        load_atlas(tmp_path / "broken.exr")
    assert not bpy.data.images


def test_an_atlas_baked_again_is_read_again(tmp_path: Path) -> None:
    def corner(image: bpy.types.Image) -> list[float]:
        return list(cast(Any, image.pixels)[:4])

    first = load_atlas(write_exr(tmp_path / "a.exr", random_atlas(1)))
    before = corner(first)
    again = load_atlas(write_exr(tmp_path / "a.exr", random_atlas(2)))
    assert again == first
    assert corner(again) != before
