# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The layered layout's files: what is written comes back, and what is damaged is refused by name."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radtex_addon.core.errors import BakeError, FormatError, ShapeError
from radtex_addon.formats.containers.exr import Compression
from radtex_addon.formats.sidecar import Sidecar
from radtex_addon.forms.layered.cells import HOLLOW
from radtex_addon.forms.layered.files.arrangement import arranged, packed, tiled, unpacked, untiled
from radtex_addon.forms.layered.files.layered_files import read_layered, write_layered
from radtex_addon.forms.layered.files.sidecar import MOST_MATERIALS, LayeredSidecar
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas, sample_layered
from radtex_addon.forms.layered.lookup.environment import Shell
from radtex_addon.forms.layered.textures import own_texels
from tests.layered.made_up import made_up_atlas, made_up_fragments
from tests.layered_lookups import everything, glass_ball, in_a_room

_BAKE = Sidecar("Vase", "radiance", 16, 16, 14, "RadTex", 16, 0, "portal", "RadTex 0", "5.2")


@pytest.fixture(scope="module")
def atlas() -> LayeredAtlas:
    return made_up_atlas(16, 64)


@pytest.mark.parametrize("half", [True, False])
def test_what_is_written_is_read_again(atlas: LayeredAtlas, tmp_path: Path, half: bool) -> None:
    path = tmp_path / "Vase.radiance.json"
    whole = everything(atlas)
    written = write_layered(path, whole, _BAKE, half)
    found, facts = read_layered(path)
    assert facts.to_json() == written.to_json()
    assert facts.bake.layers == tuple(arranged(whole))
    for name, image in arranged(whole).items():
        again = arranged(found)[name]
        np.testing.assert_allclose(again, image, rtol=1e-3 if half else 0, atol=1e-6, err_msg=name)
    at = made_up_fragments(whole, 2000, framed=True)
    once, again = sample_layered(whole, at), sample_layered(found, at)
    assert np.median(np.abs(once - again) / (once + 0.05)) < 0.01


def test_what_a_bake_lacks_has_no_file(atlas: LayeredAtlas, tmp_path: Path) -> None:
    bare = replace(atlas, around=replace(atlas.around, layers=(), lamps=()))
    written = write_layered(tmp_path / "Vase.radiance.json", bare, _BAKE)
    assert written.bake.layers == ("colour", "irradiance", "own", "rest", "world")
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"Vase.radiance.json", *(f"Vase.radiance.{layer}.exr" for layer in written.bake.layers)}
    found, _ = read_layered(tmp_path / "Vase.radiance.json")
    assert not found.around.layers
    assert not found.around.lamps
    assert found.through is None


def test_the_rest_may_be_finer_than_own_light(tmp_path: Path) -> None:
    path, atlas = tmp_path / "Vase.radiance.json", made_up_atlas(16, 64, HOLLOW)
    assert write_layered(path, atlas, _BAKE, half=False).shapes["rest"] == (128, 128, 3)
    found, facts = read_layered(path)
    assert (facts.coarse, facts.rest) == ((8, 8), (16, 16))
    np.testing.assert_array_equal(found.rest, atlas.rest)
    assert facts.larger(2, 1).shapes["rest"] == (256, 256, 3)


def test_a_map_of_widths_may_be_as_coarse_as_the_irradiance_as_earlier_ones_are(
    atlas: LayeredAtlas, tmp_path: Path
) -> None:
    path = tmp_path / "Vase.radiance.json"
    wide = np.linspace(-4, 4, 16 * 16, dtype=np.float32).reshape(16, 16, 1)
    coarse, fine = (replace(atlas, width=wide.repeat(each, axis=0).repeat(each, axis=1)) for each in (1, 4))
    assert write_layered(path, fine, _BAKE).shapes["width"] == (64, 64, 1)
    assert write_layered(path, coarse, _BAKE).shapes["width"] == (16, 16, 1)
    facts = json.loads(path.read_text(encoding="utf-8"))
    assert facts["layered"].pop("width") == [16, 16]
    path.write_text(json.dumps(facts), encoding="utf-8")
    found, _ = read_layered(path)
    assert found.width is not None
    np.testing.assert_allclose(found.width, wide, atol=2e-3)


def test_lossy_compression_spares_what_is_no_light(atlas: LayeredAtlas, tmp_path: Path) -> None:
    path = tmp_path / "Vase.radiance.json"
    write_layered(path, atlas, _BAKE, compression=Compression.DWAA)
    found, _ = read_layered(path)
    for name in ("own", "distances"):
        np.testing.assert_allclose(arranged(found)[name], arranged(atlas)[name], rtol=1e-3, atol=1e-6)


def test_a_room_comes_back(atlas: LayeredAtlas, tmp_path: Path) -> None:
    path, room = tmp_path / "Vase.radiance.json", in_a_room(atlas)
    write_layered(path, room, _BAKE)
    found, _ = read_layered(path)
    for one, other in zip(found.around.layers, room.around.layers, strict=True):
        np.testing.assert_array_equal(one.shape.eye, other.shape.eye)
    shell, before = (each.around.layers[0].shape for each in (found, room))
    assert isinstance(shell, Shell)
    assert isinstance(before, Shell)
    np.testing.assert_array_equal(shell.normals, before.normals)
    np.testing.assert_array_equal(shell.heights, before.heights)
    facts = json.loads(path.read_text(encoding="utf-8"))
    del facts["layered"]["shell"]["planes"][1:]
    path.write_text(json.dumps(facts), encoding="utf-8")
    with pytest.raises(FormatError, match="has 1 planes, expected 2 to 8"):
        read_layered(path)


def test_tiles_and_packed_levels_come_back() -> None:
    rng = np.random.default_rng(5)
    buckets = rng.uniform(size=(5, 7, 3, 3, 4)).astype(np.float32)
    image = tiled(buckets)
    assert image.shape == (3 * 8, 3 * 8, 4)
    np.testing.assert_array_equal(untiled(image, 3, (7, 5)), buckets)
    np.testing.assert_array_equal(image[8 : 8 + 5, 16 : 16 + 7], buckets[:, :, 1, 2])
    levels = tuple(rng.uniform(size=(16 >> level, 16 >> level, 3)).astype(np.float32) for level in range(4))
    image = packed(levels)
    assert image.shape == (16, 24, 3)
    for level, found in zip(levels, unpacked(image, 16, 4), strict=True):
        np.testing.assert_array_equal(level, found)


def test_an_image_of_another_bake_is_named(atlas: LayeredAtlas, tmp_path: Path) -> None:
    first, other = tmp_path / "Vase.radiance.json", tmp_path / "Pot.radiance.json"
    write_layered(first, atlas, _BAKE)
    write_layered(other, atlas, replace(_BAKE, seed=3))
    (tmp_path / "Pot.radiance.own.exr").replace(tmp_path / "Vase.radiance.own.exr")
    with pytest.raises(FormatError, match=r"Vase\.radiance\.own\.exr is of another bake"):
        read_layered(first)
    (tmp_path / "Vase.radiance.own.exr").unlink()
    with pytest.raises(FormatError, match=r"Vase\.radiance\.own\.exr"):
        read_layered(first)


def _without(key: str) -> Callable[[dict[str, Any]], None]:
    return lambda layered: layered.pop(key)


def _setting(key: str, value: Any) -> Callable[[dict[str, Any]], None]:
    return lambda layered: layered.update({key: value})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (_without("materials"), '"materials" is no list'),
        (_setting("materials", []), "lacks the world's picture, or materials"),
        (_without("plane"), 'lacks "plane"'),
        (_setting("middle", [0, 1]), '"middle" is .* expected 3 numbers'),
        (_setting("rest_cells", 1), '"rest_cells" is 1'),
        (_setting("pictures", {}), "lacks the world's picture"),
        (
            _setting("pictures", {"world": {"size": 24, "levels": 5, "sharpest": 1}}),
            "sizes that no picture has",
        ),
        (
            lambda layered: layered["lamps"][0].update(variance=0),
            '"variance" is 0, expected a number above 0',
        ),
        (lambda layered: layered["materials"][0]["bend"].pop(), '"bend" is .* expected 16 numbers'),
        (lambda layered: layered["materials"][1]["lobes"].pop(), "has 1 lobes, expected 2"),
        (lambda layered: layered["materials"][1]["falloff"].pop(), "has 15 colours, expected 16"),
        (_setting("rest", [5, 7]), '"rest" is neither "coarse" nor'),
        (_setting("middle", [0, 0, 1e39]), "beyond the range of single floats"),
    ],
)
def test_a_damaged_sidecar_is_refused(
    atlas: LayeredAtlas, tmp_path: Path, change: Callable[[dict[str, Any]], None], message: str
) -> None:
    path = tmp_path / "Vase.radiance.json"
    write_layered(path, atlas, _BAKE)
    facts = json.loads(path.read_text(encoding="utf-8"))
    change(facts["layered"])
    with pytest.raises(FormatError, match=message):
        LayeredSidecar.from_json(json.dumps(facts), str(path))


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("size", [24.5, 25, 26], '"size" is not of 2 to 512'),
        ("size", [24, 25, 600], '"size" is not of 2 to 512'),
        ("ior", 1.0, '"ior" is not above 1'),
        ("ior", 1e39, '"ior" is not above 1'),
        ("slopes", -1e-3, '"slopes" is below 0'),
        ("all_around", 1.5, '"all_around" is 1.5'),
        ("step", 1e-320, '"step" is'),
        ("reflections", -1, '"reflections" is -1'),
        ("tint", [0, 1, 1], '"tint" has parts that are not above 0'),
        ("tint", [0.5, 1.5, 1], '"tint" has parts that are not above 0'),
        ("tints_reflections", 1, '"tints_reflections" is 1, expected true or false'),
        ("low", [0, 1e39, 0], "beyond the range of single floats"),
    ],
)
def test_a_damaged_field_is_refused(
    atlas: LayeredAtlas, tmp_path: Path, key: str, value: Any, message: str
) -> None:
    path = tmp_path / "Vase.radiance.json"
    write_layered(path, glass_ball(atlas), _BAKE)
    facts = json.loads(path.read_text(encoding="utf-8"))
    facts["layered"]["through"]["field"][key] = value
    with pytest.raises(FormatError, match=message):
        LayeredSidecar.from_json(json.dumps(facts), str(path))


def test_what_does_not_fit_is_not_written(atlas: LayeredAtlas, tmp_path: Path) -> None:
    path = tmp_path / "Vase.radiance.json"
    with pytest.raises(ShapeError, match="irradiance: expected shape"):
        write_layered(path, atlas, replace(_BAKE, width=8))
    broken = replace(atlas, around=replace(atlas.around, middle=np.array([0, np.nan, 0], np.float32)))
    with pytest.raises(BakeError, match='of "Vase" have a value that is no finite number'):
        write_layered(path, broken, _BAKE)
    own = atlas.own.copy()
    own[0, 0, 0, 0, 0] = np.nan
    with pytest.raises(BakeError, match=r"own\.exr was not written"):
        write_layered(path, replace(atlas, own=own), _BAKE)
    assert not list(tmp_path.iterdir())


def test_as_many_materials_as_a_sidecar_holds_come_back_and_more_are_refused(atlas: LayeredAtlas) -> None:
    def of(count: int) -> LayeredAtlas:
        return replace(
            atlas, materials=atlas.materials[:1] * count, falloff=np.repeat(atlas.falloff[:1], count, axis=0)
        )

    made = LayeredSidecar.of(of(MOST_MATERIALS), _BAKE)
    assert len(LayeredSidecar.from_json(made.to_json()).materials) == MOST_MATERIALS
    with pytest.raises(BakeError, match=rf"{MOST_MATERIALS + 1} materials, a sidecar holds {MOST_MATERIALS}"):
        LayeredSidecar.of(of(MOST_MATERIALS + 1), _BAKE)


def test_texels_are_buckets_only_where_the_irradiance_is_even(atlas: LayeredAtlas, tmp_path: Path) -> None:
    path = tmp_path / "Vase.radiance.json"
    write_layered(path, atlas, _BAKE)
    uneven, even = atlas.irradiance.copy(), np.full_like(atlas.irradiance, np.inf)
    uneven[0, 0] = np.inf  # as a damaged file may hold
    for irradiance, expected in ((uneven, uneven), (even, atlas.own.reshape(*atlas.own.shape[:2], -1))):
        found, _ = own_texels(path, replace(atlas, irradiance=irradiance))
        np.testing.assert_array_equal(found, expected)
