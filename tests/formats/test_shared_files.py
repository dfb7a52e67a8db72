# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes in the shared layout come back as they were written, whole, and bad files are refused by name."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import BakeError, FormatError, ShapeError
from radtex_addon.core.shared import Axis, Lobe, SharedAtlas, level_sizes
from radtex_addon.formats.containers.exr import Compression, read_atlas, write_rows
from radtex_addon.formats.image_files import layer_path
from radtex_addon.formats.shared_files import read_shared, read_shared_sidecar, write_shared
from radtex_addon.formats.shared_sidecar import SharedSidecar
from radtex_addon.formats.sidecar import file_name, read_sidecar
from tests.shared_atlases import SHARPEST, facts_about, random_shared_atlas

LAYERS = ["colour", "irradiance", "surroundings"] + [
    f"{axis}_{part}" for axis in ("mirror", "through") for part in ("ends", "gain", "rest")
]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / file_name("Vase", "radiance", "json")


def written(path: Path, **options: Any) -> tuple[SharedAtlas, SharedSidecar]:
    atlas = random_shared_atlas()
    return atlas, write_shared(path, atlas, facts_about(atlas), **options)


def parts(atlas: SharedAtlas) -> dict[str, Floats]:
    """All arrays of an atlas by name; spreads in units of the sharpest."""
    lobes = {f"{lobe.axis} {name}": getattr(lobe, name) for lobe in atlas.lobes for name in ("gain", "rest")}
    shifts = {f"{lobe.axis} shift": lobe.ends[..., :3] for lobe in atlas.lobes}
    spreads = {f"{lobe.axis} spread": lobe.ends[..., 3] / atlas.sharpest for lobe in atlas.lobes}
    levels = {f"level {number}": level for number, level in enumerate(atlas.surroundings)}
    names = ("colour", "irradiance", "falloff")
    return {name: getattr(atlas, name) for name in names} | levels | lobes | shifts | spreads


@pytest.mark.parametrize("compression", [Compression.ZIP, Compression.PIZ])
@pytest.mark.parametrize(("bucket", "size", "levels"), [(6, 48, 5), (1, 8, 1), (2, 21, 9)])
@pytest.mark.parametrize("lobes", [(), (Axis.MIRROR,), (Axis.THROUGH, Axis.MIRROR)])
def test_an_atlas_comes_back(
    path: Path, bucket: int, size: int, levels: int, lobes: tuple[Axis, ...], compression: Compression
) -> None:
    atlas = random_shared_atlas(5, 3, bucket, size, levels, lobes)
    for half, precision in ((False, 2e-7), (True, 2**-11)):
        sidecar = write_shared(path, atlas, facts_about(atlas), half, compression)
        read, told = read_shared(path)
        assert told == sidecar
        assert (read.sharpest, [lobe.axis for lobe in read.lobes]) == (SHARPEST, list(lobes))
        np.testing.assert_array_equal(read.falloff, atlas.falloff)
        for name, part in parts(atlas).items():
            assert parts(read)[name].dtype == np.float32
            least = 0.0 if name.endswith("spread") else 1e-7  # a shift may be as good as 0
            np.testing.assert_allclose(parts(read)[name], part, rtol=precision, atol=least, err_msg=name)
        assert sidecar.bake.clamped == 0


def test_the_files_bear_the_contracts_names(path: Path) -> None:
    _, sidecar = written(path)
    names = [file_name("Vase", "radiance", "exr", layer) for layer in LAYERS]
    assert sorted(file.name for file in path.parent.iterdir()) == sorted(["Vase.radiance.json", *names])
    assert list(sidecar.bake.layers) == list(sidecar.shapes) == LAYERS
    for layer in LAYERS:
        header = OpenEXR.File(str(layer_path(path, layer)), header_only=True).header()
        assert header["radtex"] == path.read_text(encoding="utf-8") == sidecar.to_json()
        assert {channel.name for channel in header["channels"]} == set("RGBA" if "ends" in layer else "RGB")


def test_version_1_says_exactly_this(path: Path) -> None:
    atlas, _ = written(path)
    assert json.loads(path.read_text(encoding="utf-8")) == {
        **json.loads(facts_about(atlas).to_json()),
        "layout": "shared",
        "layers": LAYERS,
        "shared": {
            "colour": [21, 11],
            "surroundings": 48,
            "levels": 5,
            "sharpest": 2.5e-5,
            "falloff": [[float(str(value)) for value in point] for point in atlas.falloff],
            "lobes": ["mirror", "through"],
        },
    }


def test_the_files_first_row_is_our_last(path: Path) -> None:
    atlas, _ = written(path, half=False)
    image = OpenEXR.File(str(layer_path(path, "colour"))).channels()["RGB"].pixels
    np.testing.assert_array_equal(image[0], atlas.colour[-1])


def test_dwaa_loses_light_but_no_directions(path: Path) -> None:
    atlas = random_shared_atlas()
    atlas = replace(atlas, colour=np.full_like(atlas.colour, 0.5))
    write_shared(path, atlas, facts_about(atlas), half=False, compression=Compression.DWAA)
    read, _ = read_shared(path)
    np.testing.assert_allclose(read.colour, atlas.colour, rtol=0.02)
    for lobe, wanted in zip(read.lobes, atlas.lobes, strict=True):
        np.testing.assert_allclose(lobe.ends, wanted.ends, rtol=2e-7)
        assert not np.array_equal(lobe.gain, wanted.gain)


def altered(atlas: SharedAtlas, **values: float) -> SharedAtlas:
    """With one value in the parts named."""
    for name, value in values.items():
        part = getattr(atlas, name).copy()
        part.flat[4] = value
        atlas = replace(atlas, **{name: part})
    return atlas


def test_values_beyond_a_half_are_clamped_and_counted(path: Path) -> None:
    atlas = altered(random_shared_atlas(), colour=np.inf, irradiance=-1e6)
    assert write_shared(path, atlas, facts_about(atlas)).bake.clamped == 2
    read, sidecar = read_shared(path)
    assert [*read.colour.flat[4:5], *read.irradiance.flat[4:5]] == [65504, -65504]
    assert sidecar.bake.clamped == 2
    assert write_shared(path, atlas, facts_about(atlas), half=False).bake.clamped == 1


def test_values_that_are_no_numbers_are_refused(path: Path) -> None:
    atlas = random_shared_atlas()
    for name, message in [
        ("irradiance", r"Vase\.radiance\.irradiance\.exr was not written: 1 of its values"),
        ("falloff", 'the falloff .* of "Vase" is no finite number'),
    ]:
        with pytest.raises(BakeError, match=message):
            write_shared(path, altered(atlas, **{name: np.nan}), facts_about(atlas))
    for sharpest in (0.0, np.nan, np.inf):
        with pytest.raises(BakeError, match=r'sharpest .* of "Vase" is no finite'):
            write_shared(path, replace(atlas, sharpest=sharpest), facts_about(atlas))
    assert list(path.parent.iterdir()) == []


def test_what_does_not_fit_is_refused(path: Path) -> None:
    atlas = random_shared_atlas()
    facts = facts_about(atlas)
    doubled = replace(atlas, lobes=(atlas.lobes[0], atlas.lobes[0]))
    deep = replace(atlas, surroundings=tuple(np.zeros((s, s, 3), np.float32) for s in level_sizes(8, 33)))
    for wrong, bake, message in [
        (atlas, replace(facts, width=8), r"irradiance: expected shape \(5, 8, 3\)"),
        (atlas, replace(facts, bucket=8), "expected 8 cells a side, got 6"),
        (doubled, facts, "each axis once, got mirror, mirror"),
        (deep, facts, "at most 32 levels, got 33"),
    ]:
        with pytest.raises(ShapeError, match=message):
            write_shared(path, wrong, bake)
    assert list(path.parent.iterdir()) == []


@pytest.mark.parametrize("failing", [1, 4, 9])
def test_a_failing_write_leaves_the_old_files(
    path: Path, monkeypatch: pytest.MonkeyPatch, failing: int
) -> None:
    """The disk is full at the first image, in the middle, at the last one."""
    written(path)
    old = {file.name: file.read_bytes() for file in path.parent.iterdir()}
    calls = []

    def full_disk(beside: Path, *arguments: Any) -> None:
        write_rows(beside, *arguments)
        calls.append(beside)
        if len(calls) == failing:
            raise OSError(f"no space for {beside}")

    monkeypatch.setattr("radtex_addon.formats.image_files.write_rows", full_disk)
    image = layer_path(path, LAYERS[failing - 1])
    other = random_shared_atlas(seed=2)
    with pytest.raises(BakeError) as raised:
        write_shared(path, other, facts_about(other))
    assert str(raised.value).startswith(f"{image} could not be written: no space for {image};")
    assert {file.name: file.read_bytes() for file in path.parent.iterdir()} == old


@pytest.mark.parametrize("layer", LAYERS)
def test_missing_and_damaged_images_are_named(path: Path, layer: str) -> None:
    written(path)
    image = layer_path(path, layer)
    data = image.read_bytes()
    image.write_bytes(data[: len(data) * 3 // 4])
    with pytest.raises(FormatError, match=rf"\.{layer}\.exr is damaged"):
        read_shared(path)
    image.unlink()
    with pytest.raises(FormatError, match=rf"\.{layer}\.exr cannot be read: No such file"):
        read_shared(path)


def test_images_of_another_bake_are_refused(path: Path, tmp_path: Path) -> None:
    atlas, _ = written(path)
    elsewhere = tmp_path / "elsewhere" / path.name
    write_shared(elsewhere, atlas, replace(facts_about(atlas), seed=1))
    layer_path(elsewhere, "mirror_gain").replace(layer_path(path, "mirror_gain"))
    with pytest.raises(FormatError, match=r"mirror_gain\.exr is of another bake than .*Vase\.radiance\.json"):
        read_shared(path)


def test_images_that_break_the_contract_are_refused(path: Path) -> None:
    _, sidecar = written(path)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    image = layer_path(path, "irradiance")
    for channels, shape, message in [
        ("RGB", (5, 8, 3), "has 8 x 5 pixels of float32, its header says 7 x 5 floats"),
        ("RGBA", (5, 7, 4), "has the channels A, B, G, R, expected RGB"),
    ]:
        pixels = {channels: np.zeros(shape, np.float32)}
        OpenEXR.File(header | {"radtex": sidecar.to_json()}, pixels).write(str(image))
        with pytest.raises(FormatError, match=rf"irradiance\.exr {message}"):
            read_shared(path)
    OpenEXR.File(header, {"RGB": np.zeros((5, 7, 3), np.float32)}).write(str(image))
    with pytest.raises(FormatError, match=r'irradiance\.exr has no header attribute "radtex"'):
        read_shared(path)


def test_the_two_layouts_are_not_taken_for_each_other(path: Path, tmp_path: Path) -> None:
    atlas, _ = written(path)
    with pytest.raises(FormatError, match=r'Vase.radiance.json: "layout" is "shared", expected "buckets"'):
        read_sidecar(path)
    with pytest.raises(FormatError, match=r'colour\.exr: "layout" is "shared", expected "buckets"'):
        read_atlas(layer_path(path, "colour"))
    plain = tmp_path / "plain.json"
    plain.write_text(facts_about(atlas).to_json(), encoding="utf-8")
    with pytest.raises(FormatError, match=r'plain\.json: "layout" is "buckets", expected "shared"'):
        read_shared(plain)


def told(path: Path, **shared: Any) -> str:
    """The sidecar's text with some of "shared" altered; None takes a key out."""
    facts = json.loads(path.read_text(encoding="utf-8"))
    facts["shared"] |= shared
    facts["shared"] = {key: value for key, value in facts["shared"].items() if value is not None}
    return json.dumps(facts)


@pytest.mark.parametrize("key", ["colour", "surroundings", "levels", "sharpest", "falloff", "lobes"])
@pytest.mark.parametrize(
    "value",
    [None, True, "x" * 1000, {}, -1, [0, 4], [[1, 2]], [[1, 2, "3"]], ["mirror"] * 2, float("nan"), 10**400],
)
def test_a_bad_key_is_named(path: Path, key: str, value: object) -> None:
    written(path)
    if key == "surroundings" and value == 10**400:
        return
    with pytest.raises(FormatError, match=f'a.json, in "shared".*"{key}"') as raised:
        SharedSidecar.from_json(told(path, **{key: value}), "a.json")
    assert len(str(raised.value)) < 200


def test_a_sidecar_that_contradicts_itself_or_its_images_is_refused(path: Path) -> None:
    written(path)
    with pytest.raises(FormatError, match=r'a.json: "layers" is .*, expected \["colour"'):
        SharedSidecar.from_json(told(path, lobes=["mirror"]), "a.json")
    facts = json.loads(path.read_text(encoding="utf-8"))
    with pytest.raises(FormatError, match=r'a\.json: "shared" is 1, expected an object'):
        SharedSidecar.from_json(json.dumps(facts | {"shared": 1}), "a.json")
    with pytest.raises(FormatError, match=r"a\.json is of version 2.*update RadTex"):
        SharedSidecar.from_json(json.dumps(facts | {"version": 2}), "a.json")
    path.write_text(told(path, levels=4), encoding="utf-8")
    with pytest.raises(FormatError, match=r"colour\.exr is of another bake"):
        read_shared(path)


def test_keys_of_later_tools_are_ignored(path: Path) -> None:
    _, sidecar = written(path)
    assert SharedSidecar.from_json(told(path, later=[1])) == read_shared_sidecar(path) == sidecar


def test_a_small_spread_keeps_a_halfs_precision(path: Path) -> None:
    """As it is, 1e-6 has four bits in a half float."""
    atlas = random_shared_atlas()
    ends = atlas.lobes[0].ends.copy()
    ends[..., 3] = np.geomspace(1e-6, 1e-4, ends[..., 3].size).reshape(ends.shape[:-1])
    lobe = Lobe(Axis.MIRROR, ends, atlas.lobes[0].gain, atlas.lobes[0].rest)
    atlas = replace(atlas, lobes=(lobe,))
    write_shared(path, atlas, facts_about(atlas))
    read, _ = read_shared(path)
    np.testing.assert_allclose(read.lobes[0].ends[..., 3], ends[..., 3], rtol=2**-11)
