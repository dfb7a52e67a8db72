# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group "RadTex Layered" in Cycles and in Eevee against the reference sampler."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.core.fragments import Fragments
from radtex_addon.core.frame import normalised
from radtex_addon.formats.sidecar import Sidecar
from radtex_addon.forms.layered.files.layered_files import read_layered, write_layered
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas, alpha_at, sample_layered
from radtex_addon.forms.layered.lookup.ways import Through
from radtex_addon.forms.layered.preview.group import SHOWS_THROUGH, build_layered_group
from radtex_addon.forms.layered.preview.material import check_layered_previewable, load_images
from radtex_addon.scene.nodes import NodeBuilder, Socket
from tests.blender.lookup_stage import ENGINES, Inputs, LookupStage, data_image
from tests.layered.made_up import made_up_atlas, made_up_fragments
from tests.lookups import COUNT, Lookups

_BAKE = Sidecar("Vase", "radiance", 16, 16, 14, "RadTex", 16, 0, "portal", "RadTex 0", "5.2")
_RNG = np.random.default_rng(7)


@pytest.fixture(scope="module")
def plain() -> LayeredAtlas:
    return made_up_atlas(16, 64)


def _values(*shape: int) -> Floats:
    return cast(Floats, _RNG.uniform(0.2, 1, shape).astype(np.float32))


def with_maps(atlas: LayeredAtlas) -> LayeredAtlas:
    fine = atlas.colour.shape[:2]
    normal = normalised(_values(*fine, 3) - np.array([0.6, 0.6, 0], np.float32)).astype(np.float32)
    width = 4 * _values(*atlas.irradiance.shape[:2], 1) - 2
    return replace(atlas, tint=_values(*fine, 3), normal=normal, width=width, alpha=_values(*fine, 1))


def bare(atlas: LayeredAtlas) -> LayeredAtlas:
    return replace(
        atlas,
        around=replace(atlas.around, layers=(), lamps=()),
        materials=atlas.materials[:1],
        falloff=atlas.falloff[:1],
    )


def clear(atlas: LayeredAtlas) -> LayeredAtlas:
    """Light comes through it: along rays that change slowly, and all of a sudden."""
    coarse = atlas.own.shape[:2]
    towards = normalised(_RNG.normal(size=(*coarse, 1, 1, 3)) + 4 * _RNG.normal(size=(1, 1, 16, 16, 3)))
    weight = _RNG.uniform(0.2, 1, (*coarse, 16, 16, 1))
    place = _RNG.normal(size=(*coarse, 16, 16, 3)) * 0.1
    parts = [towards * weight, weight, place * weight, 0.01 * weight]
    ways = np.concatenate(parts, axis=-1).astype(np.float32)
    return replace(atlas, through=Through(ways, _values(*coarse, 3), _values(*coarse, 8, 8, 3)))


CASES: dict[str, Callable[[LayeredAtlas], LayeredAtlas]] = {
    "plain": lambda atlas: atlas,
    "bare": bare,
    "all": lambda atlas: clear(with_maps(atlas)) if SHOWS_THROUGH else with_maps(atlas),
}


def fragments_of(atlas: LayeredAtlas) -> Fragments:
    at = made_up_fragments(atlas, COUNT)
    tangent = normalised(np.cross(at.normal, [0.1, 0.2, 0.97])).astype(np.float32)
    return replace(at, tangent=tangent, bitangent=np.cross(at.normal, tangent).astype(np.float32))


def rendered(engine: str, path: Path, at: Fragments) -> Floats:
    """What the group answers for a bake at fragments, (K, 4)."""
    assert at.tangent is not None
    group = build_layered_group(*load_images(path, half=False))
    lookups = Lookups(at.uv, at.normal, at.tangent, np.ones(COUNT, np.float32), at.viewer)

    def shader(build: NodeBuilder, inputs: Inputs) -> tuple[Socket, ...]:
        place = build.vector("FRACTION", build.uv_map("places"))
        position = build.image(data_image("position", at.position), place)[0]
        material = build.image(data_image("material", at.material[:, None].astype(np.float32)), place)[0]
        number = build.separate(material)[0]
        return build.group(group, *inputs, position, number)

    stage = LookupStage(cast(bpy.types.Scene, bpy.context.scene), engine)
    stage.add(lookups, shader)
    return stage.render(path.parent / "answers.exr")[0]


@pytest.mark.parametrize(("engine", "case"), [*(("Cycles", case) for case in CASES), ("Eevee", "all")])
def test_the_group_agrees_with_the_reference(
    engine: str, case: str, plain: LayeredAtlas, tmp_path: Path
) -> None:
    path = tmp_path / "Vase.radiance.json"
    write_layered(path, CASES[case](plain), _BAKE, half=False)
    atlas, _ = read_layered(path)
    at = fragments_of(atlas)
    found, expected = rendered(ENGINES[engine], path, at), sample_layered(atlas, at)
    off = np.abs(found[:, :3] - expected) / (np.abs(expected) + 0.05)
    print(f"{engine}, {case}: worst {off.max():.1e}, mean {off.mean():.1e}")
    assert off.mean() < 1e-3
    assert off.max() < 5e-3  # Eevee renders half floats
    assert found[:, 3] == pytest.approx(alpha_at(atlas, at.uv), abs=2e-3)


@pytest.mark.one_blender
def test_an_image_of_another_bake_is_refused(plain: LayeredAtlas, tmp_path: Path) -> None:
    path = tmp_path / "Vase.radiance.json"
    write_layered(path, plain, _BAKE)
    images, facts = load_images(path)
    with pytest.raises(InputError, match="112 x 112 pixels, but this bake's 'own' has 96 x 96"):
        build_layered_group(images, replace(facts, own_cells=12))


@pytest.mark.one_blender
def test_a_bake_beyond_the_gpu_is_refused(plain: LayeredAtlas, tmp_path: Path) -> None:
    path = tmp_path / "Vase.radiance.json"
    shapes = write_layered(path, plain, _BAKE).shapes
    check_layered_previewable(shapes, max_pixels=128)
    with pytest.raises(InputError, match="'distances' has 128 x 128 pixels and cannot be previewed"):
        check_layered_previewable(shapes, max_pixels=127)


def test_the_curves_are_in_the_blend(plain: LayeredAtlas, tmp_path: Path) -> None:
    path = tmp_path / "Vase.radiance.json"
    write_layered(path, plain, _BAKE)
    image: Any = load_images(path)[0]["curves"]
    assert image.packed_file is not None
    assert tuple(image.size) == (16, 8)
