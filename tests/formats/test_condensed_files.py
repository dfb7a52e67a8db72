# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Condensed bakes come back as near as their textures are, whole, and bad files are refused by name."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.condensed import CondensedAtlas, CondensedLobe
from radtex_addon.core.errors import BakeError, FormatError, ShapeError
from radtex_addon.core.shared import Axis
from radtex_addon.formats.codecs.bc5 import decode_bc5
from radtex_addon.formats.codecs.bc6h import decode_bc6h
from radtex_addon.formats.codecs.bc7 import decode_bc7
from radtex_addon.formats.containers.dds import DdsFormat, read_dds, write_dds
from radtex_addon.formats.shared_files import (
    read_condensed,
    read_shared,
    read_shared_sidecar,
    texture_path,
    write_condensed,
    write_shared,
)
from radtex_addon.formats.shared_sidecar import SharedSidecar
from radtex_addon.formats.sidecar import file_name
from tests.shared_atlases import SHARPEST, facts_about, random_condensed_atlas, random_shared_atlas

LAYERS = ["colour", "irradiance", "surroundings"] + [
    f"{axis}_{texture}"
    for axis in ("mirror", "through")
    for texture in ("weights", "ends_xy", "ends_zs", "gain", "rest")
]
STEP = 1 / 255


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / file_name("Vase", "radiance", "json")


def flat_condensed_atlas(*sizes: int, **options: Any) -> CondensedAtlas:
    """A random atlas that blocks of 4 x 4 pixels hold well: of one colour, every tile one value."""
    atlas = random_condensed_atlas(*sizes, **options)

    def lobe(source: CondensedLobe) -> CondensedLobe:
        parts: dict[str, Any] = {part: getattr(source, part) for part in ("ends", "gain", "rest")}
        for part, tiles in parts.items():
            parts[part] = np.broadcast_to(tiles[:, :, :1, :1], tiles.shape)
        return replace(source, **parts)

    return replace(
        atlas,
        colour=np.full_like(atlas.colour, 0.5),
        irradiance=np.full_like(atlas.irradiance, 2),
        surroundings=tuple(np.full_like(level, 3) for level in atlas.surroundings),
        lobes=tuple(map(lobe, atlas.lobes)),
    )


def written(path: Path) -> tuple[CondensedAtlas, SharedSidecar]:
    atlas = flat_condensed_atlas()
    return atlas, write_condensed(path, atlas, facts_about(atlas))


def spans(tiles: Floats) -> Floats:
    """How far a part's values range, of a cluster's tiles, (1 + r, 1, 1, channels)."""
    others = np.ptp(tiles[:, 1:], axis=(0, 1, 2, 3))
    base = np.ptp(tiles[:, 0], axis=(0, 1, 2))
    return np.stack([base] + [others] * (tiles.shape[1] - 1))[:, None, None]


@pytest.mark.parametrize(("rank", "bucket"), [(2, 14), (2, 2), (6, 6)])
@pytest.mark.parametrize("lobes", [(), (Axis.MIRROR,), (Axis.THROUGH, Axis.MIRROR)])
def test_an_atlas_comes_back(path: Path, rank: int, bucket: int, lobes: tuple[Axis, ...]) -> None:
    """Tiles are off by half a 255th of their range; by one and a half where alpha's 1 forbids a 0.

    Ends have no alpha beside them, and levels between 255ths.
    """
    atlas = flat_condensed_atlas(6, 5, 4, rank, bucket, lobes=lobes)
    sidecar = write_condensed(path, atlas, facts_about(atlas))
    read, told = read_condensed(path)
    assert told == sidecar
    assert (sidecar.bake.clamped, read.sharpest, [lobe.axis for lobe in read.lobes]) == (
        0,
        SHARPEST,
        [*lobes],
    )
    for name in ("irradiance", "falloff"):
        np.testing.assert_array_equal(getattr(read, name), getattr(atlas, name))
    for blurred, level in zip(read.surroundings, atlas.surroundings, strict=True):
        np.testing.assert_allclose(blurred, level, rtol=0.01)  # some blocks reach beyond a level
    for found, lobe in zip(read.lobes, atlas.lobes, strict=True):
        np.testing.assert_array_equal(found.cluster, lobe.cluster)
        np.testing.assert_array_equal(found.weights, lobe.weights)
        for part in ("ends", "gain", "rest"):
            near, tiles = getattr(found, part), getattr(lobe, part)
            assert near.dtype == np.float32
            error = np.abs(near - tiles) / spans(tiles)
            assert error.max() <= 1.51 * STEP
            assert np.median(error) <= 0.51 * STEP
        assert (np.abs(found.ends - lobe.ends) / spans(lobe.ends)).max() <= STEP / 13


def test_both_ways_of_reading_agree(path: Path) -> None:
    _, sidecar = written(path)
    condensed, _ = read_condensed(path)
    expanded, told = read_shared(path)
    assert told == sidecar == read_shared_sidecar(path)
    for found, lobe in zip(expanded.lobes, condensed.expanded().lobes, strict=True):
        np.testing.assert_array_equal(found.ends, lobe.ends)
        np.testing.assert_array_equal(found.gain, lobe.gain)
        np.testing.assert_array_equal(found.rest, lobe.rest)
    np.testing.assert_array_equal(expanded.irradiance, condensed.irradiance)


def test_the_files_bear_the_contracts_names_and_formats(path: Path) -> None:
    _, sidecar = written(path)
    names = [file_name("Vase", "radiance", "dds", layer) for layer in LAYERS]
    assert sorted(file.name for file in path.parent.iterdir()) == sorted(["Vase.radiance.json", *names])
    assert list(sidecar.bake.layers) == list(sidecar.shapes) == LAYERS
    sizes = {
        layer: (kind.name, *size)
        for layer in LAYERS
        for kind, _, *size in [read_dds(texture_path(path, layer))]
    }
    size = (64, 48)  # twelve tiles of 16 pixels, four in a row
    assert sizes == {
        "colour": ("BC6H_UF16", 4, 4),
        "irradiance": ("BC6H_UF16", 8, 8),
        "surroundings": ("BC6H_UF16", 76, 60),
        "mirror_weights": ("R8G8B8A8_UNORM", 7, 5),
        "through_weights": ("R8G8B8A8_UNORM", 7, 5),
    } | {
        f"{axis}_{texture}": (kind, *size)
        for axis in Axis
        for kind, textures in {"BC5_UNORM": ("ends_xy", "ends_zs"), "BC7_UNORM": ("gain", "rest")}.items()
        for texture in textures
    }


def test_version_1_says_exactly_this(path: Path) -> None:
    atlas, _ = written(path)

    def stored(lobe: CondensedLobe) -> dict[str, Any]:
        values = {
            "ends": lobe.ends / np.array([1, 1, 1, SHARPEST], np.float32),
            "gain": lobe.gain,
            "rest": lobe.rest,
        }
        ranges = {
            part: [
                extreme(tiles[:, some], axis=(0, 1, 2, 3))
                for some in (slice(0, 1), slice(1, None))
                for extreme in (np.min, np.max)
            ]
            for part, tiles in values.items()
        }
        numbers = {part: [[float(str(n)) for n in row] for row in rows] for part, rows in ranges.items()}
        return {"clusters": 4} | numbers

    assert json.loads(path.read_text(encoding="utf-8")) == {
        **json.loads(facts_about(atlas).to_json()),
        "layout": "shared",
        "layers": LAYERS,
        "shared": {
            "colour": [4, 4],
            "surroundings": 48,
            "levels": 5,
            "sharpest": 2.5e-5,
            "falloff": [[float(str(value)) for value in point] for point in atlas.falloff],
            "lobes": ["mirror", "through"],
            "condensed": {
                "rank": 2,
                "columns": 4,
                "lobes": {lobe.axis.value: stored(lobe) for lobe in atlas.lobes},
                "digests": {
                    layer: hashlib.sha256(texture_path(path, layer).read_bytes()).hexdigest()
                    for layer in LAYERS
                },
            },
        },
    }


def test_the_files_first_row_is_our_first(path: Path) -> None:
    """Each texture as a GPU would have it: light, weights and a tile where the format says."""
    atlas = flat_condensed_atlas()
    rows = (1 + np.arange(11, dtype=np.float32) // 4)[:, None, None]
    atlas = replace(atlas, colour=np.broadcast_to(rows, (11, 21, 3)))
    sidecar = write_condensed(path, atlas, facts_about(atlas))
    _, blocks, *size = read_dds(texture_path(path, "colour"))
    assert size == [24, 12]
    assert decode_bc6h(blocks)[:, :, 0].tolist() == [[1 + y // 4] * 24 for y in range(12)]
    lobe = atlas.lobes[0]
    _, pixels, *_ = read_dds(texture_path(path, "mirror_weights"))
    assert pixels[0, 6].tolist() == [*np.rint(128 + 127 * lobe.weights[0, 6]), lobe.cluster[0, 6], 0]
    image = decode_bc7(read_dds(texture_path(path, "mirror_rest"))[1])
    assert sidecar.condensed is not None
    low, high = np.array(sidecar.condensed.lobes[Axis.MIRROR].ranges["rest"])[2:]
    tile = image[16:32, 48:64, :3]  # number 7: the second of the third cluster, k = 1
    np.testing.assert_allclose(
        low + tile * (high - low), np.broadcast_to(lobe.rest[2, 1, 0, 0], (16, 16, 3)), atol=0.1
    )
    low, high = np.array(sidecar.condensed.lobes[Axis.MIRROR].ranges["ends"])[2:]
    halves = [decode_bc5(read_dds(texture_path(path, f"mirror_ends_{two}"))[1]) for two in ("xy", "zs")]
    tile = np.concatenate(halves, axis=2)[16:32, 48:64]
    ends = lobe.ends[2, 1, 0, 0] / (1, 1, 1, SHARPEST)
    np.testing.assert_allclose(
        tile, np.broadcast_to((ends - low) / (high - low), (16, 16, 4)), atol=STEP / 13
    )


def test_beyond_an_image_its_edge_is_repeated(path: Path) -> None:
    """Columns of light in pairs: their blocks hold two values, which BC6H does exactly or nearly so."""
    atlas = flat_condensed_atlas()
    columns = np.array([1, 1, 1, 1, 4, 4, 8], np.float32)[None, :, None]
    atlas = replace(atlas, irradiance=np.broadcast_to(columns, (5, 7, 3)))
    write_condensed(path, atlas, facts_about(atlas))
    pixels = decode_bc6h(read_dds(texture_path(path, "irradiance"))[1])
    expected = np.broadcast_to(np.array([1, 1, 1, 1, 4, 4, 8, 8])[None, :, None], (8, 8, 3))
    np.testing.assert_allclose(pixels, expected, rtol=0.03)
    read, sidecar = read_condensed(path)
    assert (read.irradiance.shape, sidecar.bake.width) == ((5, 7, 3), 7)
    np.testing.assert_array_equal(read.irradiance, pixels[:5, :7])


@pytest.mark.parametrize(("difference", "size"), [(0, (4, 4)), (9e-7, (4, 4)), (2e-6, (21, 11))])
def test_a_single_colour_is_stored_once(path: Path, difference: float, size: tuple[int, int]) -> None:
    atlas = flat_condensed_atlas()
    colour = np.full((11, 21, 3), [0.25, 0.5, 0.125], dtype=np.float32)
    colour[7, 3, 1] += difference
    sidecar = write_condensed(path, replace(atlas, colour=colour), facts_about(atlas))
    assert sidecar.colour == size
    assert sidecar.shapes["irradiance"] == (7, 5, 3)
    assert read_dds(texture_path(path, "colour"))[2:] == ((4, 4) if size == (4, 4) else (24, 12))
    read, _ = read_condensed(path)
    assert read.colour.shape == (*size[::-1], 3)
    np.testing.assert_allclose(read.colour, np.broadcast_to([0.25, 0.5, 0.125], read.colour.shape), rtol=1e-3)


def altered(atlas: CondensedAtlas, part: str, value: float, lobe: bool = False) -> CondensedAtlas:
    """With one value in a map, or in a part of the first lobe."""
    owner: Any = atlas.lobes[0] if lobe else atlas
    values = getattr(owner, part).copy()
    values.flat[5] = value
    changed = replace(owner, **{part: values})
    return replace(atlas, lobes=(changed, *atlas.lobes[1:])) if lobe else changed


@pytest.mark.parametrize(
    ("part", "lobe", "value", "stored", "times"),
    [
        ("irradiance", False, np.inf, 65504, 1),
        ("irradiance", False, -0.25, 0, 1),
        ("irradiance", False, 65504, 65504, 0),
        ("weights", True, 1.25, 1, 1),
        ("weights", True, -np.inf, -1, 1),
        ("weights", True, -1, -1, 0),
        ("gain", True, np.inf, 65504, 1),
        ("rest", True, -1e6, -65504, 1),
    ],
)
def test_values_beyond_the_textures_are_clamped_and_counted(
    path: Path, part: str, lobe: bool, value: float, stored: float, times: int
) -> None:
    atlas = altered(flat_condensed_atlas(), part, value, lobe)
    assert write_condensed(path, atlas, facts_about(atlas)).bake.clamped == times
    read, sidecar = read_condensed(path)
    assert sidecar.bake.clamped == times
    found = getattr(read.lobes[0] if lobe else read, part).flat[5]
    assert found == pytest.approx(stored, rel=0.04, abs=1e-4)


def test_values_that_are_no_numbers_are_refused(path: Path) -> None:
    atlas = flat_condensed_atlas()
    for part, lobe, named in [
        ("colour", False, "colour"),
        ("weights", True, "mirror_weights"),
        ("ends", True, "mirror_ends_xy"),
    ]:
        wrong = altered(atlas, part, np.nan, lobe)
        with pytest.raises(
            BakeError, match=rf"Vase\.radiance\.{named}\.dds was not written: 1 of its values"
        ):
            write_condensed(path, wrong, facts_about(atlas))
    with pytest.raises(BakeError, match=r'the falloff .* of "Vase" is no finite number'):
        write_condensed(path, altered(atlas, "falloff", np.nan), facts_about(atlas))
    assert list(path.parent.iterdir()) == []


def test_what_does_not_fit_is_refused(path: Path) -> None:
    atlas = flat_condensed_atlas()
    facts = facts_about(atlas)
    odd, eight = random_condensed_atlas(rank=3), random_condensed_atlas(bucket=8)
    many = random_condensed_atlas(1, 1, 65537, bucket=2, lobes=[Axis.MIRROR])
    for wrong, bake, message in [
        (atlas, replace(facts, width=8), r"irradiance: expected shape \(5, 8, 3\)"),
        (atlas, replace(facts, bucket=10), "expected 10 cells a side, got 14"),
        (replace(atlas, lobes=atlas.lobes[:1] * 2), facts, "each axis once, got mirror, mirror"),
        (replace(atlas, irradiance=atlas.irradiance[:4]), facts, "do not fit the other maps"),
        (odd, facts_about(odd), 'the textures of "Vase" would have a rank of 3, expected 2, 6'),
        (eight, facts_about(eight), 'textures of "Vase" would have buckets of 8 cells a side, expected 2, 6'),
        (many, facts_about(many), 'the textures of "Vase" would have more than 65536 clusters'),
    ]:
        with pytest.raises(ShapeError, match=message):
            write_condensed(path, wrong, bake)
    assert list(path.parent.iterdir()) == []


@pytest.mark.parametrize("failing", [1, 5, 13])
def test_a_failing_write_leaves_the_old_files(
    path: Path, monkeypatch: pytest.MonkeyPatch, failing: int
) -> None:
    """The disk is full at the first texture, in the middle, at the last one."""
    written(path)
    old = {file.name: file.read_bytes() for file in path.parent.iterdir()}
    calls = []

    def full_disk(beside: Path, *arguments: Any) -> None:
        write_dds(beside, *arguments)
        calls.append(beside)
        if len(calls) == failing:
            raise BakeError(f"{beside} could not be written: no space; free its disk, or choose another")

    monkeypatch.setattr("radtex_addon.formats.shared_files.write_dds", full_disk)
    other = flat_condensed_atlas(seed=2)
    with pytest.raises(BakeError) as raised:
        write_condensed(path, other, facts_about(other))
    texture = texture_path(path, LAYERS[failing - 1])
    assert str(raised.value).startswith(f"{texture} could not be written: no space; ")
    assert {file.name: file.read_bytes() for file in path.parent.iterdir()} == old


@pytest.mark.parametrize("layer", LAYERS)
def test_the_sidecar_takes_its_place_last(path: Path, layer: str) -> None:
    """Where a texture cannot take its own there is no sidecar that speaks of it."""
    texture_path(path, layer).mkdir()
    atlas = flat_condensed_atlas()
    with pytest.raises(BakeError, match=rf"\.{layer}\.dds could not be written: "):
        write_condensed(path, atlas, facts_about(atlas))
    assert not path.exists()
    assert not [*path.parent.glob(".radtex-*")]


@pytest.mark.parametrize("layer", LAYERS)
@pytest.mark.parametrize("read", [read_shared, read_condensed])
def test_missing_damaged_and_foreign_textures_are_named(
    path: Path, tmp_path: Path, layer: str, read: Any
) -> None:
    written(path)
    elsewhere = tmp_path / "elsewhere" / path.name
    other = random_condensed_atlas(seed=2)
    write_condensed(elsewhere, other, facts_about(other))
    texture = texture_path(path, layer)
    whole = texture.read_bytes()
    flipped = bytearray(whole)
    flipped[-1] ^= 1
    for wrong in (whole[:-20], bytes(flipped), whole + b"\0", texture_path(elsewhere, layer).read_bytes()):
        texture.write_bytes(wrong)
        message = rf"\.{layer}\.dds is damaged, or of another bake than .*Vase\.radiance\.json: put one"
        with pytest.raises(FormatError, match=message) as raised:
            read(path)
        assert "\n" not in str(raised.value)
    texture.unlink()
    with pytest.raises(FormatError, match=rf"\.{layer}\.dds cannot be read: No such file"):
        read(path)


def test_a_dense_bake_has_no_mixture(path: Path) -> None:
    atlas = random_shared_atlas()
    sidecar = write_shared(path, atlas, facts_about(atlas))
    assert sidecar.condensed is None
    with pytest.raises(FormatError, match=r"Vase\.radiance\.json is of a bake that is not condensed"):
        read_condensed(path)


def facts_in(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def retold(path: Path, **condensed: Any) -> str:
    """The sidecar's text with some of "condensed" altered; None takes a key out."""
    facts = facts_in(path)
    facts["shared"]["condensed"] |= condensed
    inner = {key: value for key, value in facts["shared"]["condensed"].items() if value is not None}
    facts["shared"]["condensed"] = inner
    return json.dumps(facts)


def test_a_cluster_that_is_not_there_is_refused(path: Path) -> None:
    written(path)
    lobes = facts_in(path)["shared"]["condensed"]["lobes"]
    lobes["through"]["clusters"] = 3  # whose nine tiles take three rows too
    path.write_text(retold(path, lobes=lobes), encoding="utf-8")
    with pytest.raises(
        FormatError, match=r"through_weights\.dds names cluster 3, its sidecar says .* are 3:"
    ):
        read_condensed(path)


def test_sizes_that_differ_from_the_textures_are_refused(path: Path) -> None:
    written(path)
    text = path.read_text(encoding="utf-8")
    path.write_text(retold(path, columns=3), encoding="utf-8")
    with pytest.raises(
        FormatError, match=r"mirror_ends_xy\.dds has 64 x 48 .*, its sidecar says 48 x 64 of BC5"
    ):
        read_condensed(path)
    path.write_text(retold(path, rank=6), encoding="utf-8")
    with pytest.raises(FormatError, match=r"mirror_weights\.dds has 7 x 5 .*, its sidecar says 14 x 5 of R8"):
        read_condensed(path)
    path.write_text(text.replace('"surroundings": 48', '"surroundings": 49'), encoding="utf-8")
    with pytest.raises(
        FormatError, match=r"surroundings\.dds has 76 x 60 .*, its sidecar says 80 x 60 of BC6H"
    ):
        read_condensed(path)


def replaced(path: Path, layer: str, shape: tuple[int, ...], kind: DdsFormat) -> None:
    """Put zeros in a texture's place, and its digest into the sidecar."""
    texture = texture_path(path, layer)
    write_dds(texture, np.zeros(shape, np.uint8), kind)
    digests = facts_in(path)["shared"]["condensed"]["digests"]
    digests[layer] = hashlib.sha256(texture.read_bytes()).hexdigest()
    path.write_text(retold(path, digests=digests), encoding="utf-8")


def test_textures_of_other_formats_are_refused(path: Path) -> None:
    written(path)
    replaced(path, "mirror_gain", (12, 16, 16), DdsFormat.BC7_UNORM)
    with pytest.raises(FormatError, match=r"mirror_gain\.dds: .*mode"):
        read_condensed(path)
    replaced(path, "mirror_ends_zs", (12, 16, 16), DdsFormat.BC7_UNORM)
    with pytest.raises(
        FormatError, match=r"mirror_ends_zs\.dds has .* of BC7_UNORM, .* 64 x 48 of BC5_UNORM"
    ):
        read_condensed(path)
    replaced(path, "colour", (4, 4, 4), DdsFormat.R8G8B8A8_UNORM)
    with pytest.raises(
        FormatError, match=r"colour\.dds has 4 x 4 pixels of R8G8B8A8_UNORM, .* 4 x 4 of BC6H_"
    ):
        read_condensed(path)


def test_what_no_memory_holds_is_refused_before_it_is_read(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both lobes' cells, of ten floats, in the dense form."""
    written(path)
    for layer in LAYERS:
        texture_path(path, layer).unlink()
    for memory, message in [
        (
            7 * 5 * 14**2 * 10 * 4 * 2 - 1,
            r"Vase\.radiance\.json needs 536 KiB of memory, this machine has 536",
        ),
        (200_000, r"Vase\.radiance\.json needs"),
    ]:
        monkeypatch.setattr("radtex_addon.formats.disk.memory.physical_memory", lambda has=memory: has)
        with pytest.raises(FormatError, match=message):
            read_shared(path)
    with pytest.raises(FormatError, match=r"Vase\.radiance\.json needs .* of memory"):
        read_condensed(path)


@pytest.mark.parametrize("key", ["rank", "columns", "lobes", "digests"])
@pytest.mark.parametrize("value", [None, True, "x" * 1000, [], -1, 0, 2.5, float("nan"), 10**400])
def test_a_bad_key_is_named(path: Path, key: str, value: object) -> None:
    written(path)
    with pytest.raises(FormatError, match=f'a.json, in "shared", in "condensed".*"{key}"') as raised:
        SharedSidecar.from_json(retold(path, **{key: value}), "a.json")
    assert len(str(raised.value)) < 200


@pytest.mark.parametrize(
    ("part", "value"),
    [
        ("clusters", 0),
        ("clusters", 65537),
        ("clusters", [4]),
        ("ends", [[0, 0, 0]] * 4),
        ("gain", [[0, 0, 0]] * 3),
        ("gain", [[0, 0, 0, 0]] * 4),
        ("rest", [[0, 0, True]] * 4),
        ("rest", [[0, 0, "1"]] * 4),
        ("rest", [[0, 0, float("inf")]] * 4),
        ("rest", [[0, 0, float("nan")]] * 4),
        ("rest", [[0, 0, 10**400]] * 4),
        ("rest", [0, 0, 0, 0]),
        ("rest", None),
    ],
)
def test_a_lobes_bad_key_is_named(path: Path, part: str, value: object) -> None:
    written(path)
    lobes = facts_in(path)["shared"]["condensed"]["lobes"]
    lobes["mirror"][part] = value
    with pytest.raises(FormatError, match=f'in "lobes", in "mirror",: "{part}" is .*, expected') as raised:
        SharedSidecar.from_json(retold(path, lobes=lobes), "a.json")
    assert len(str(raised.value)) < 200


def test_a_missing_lobe_or_digest_is_named(path: Path) -> None:
    written(path)
    condensed = facts_in(path)["shared"]["condensed"]
    del condensed["lobes"]["through"], condensed["digests"]["colour"]
    with pytest.raises(FormatError, match='in "lobes", lacks "through"'):
        SharedSidecar.from_json(retold(path, lobes=condensed["lobes"]), "a.json")
    with pytest.raises(FormatError, match='in "digests", lacks "colour"'):
        SharedSidecar.from_json(retold(path, digests=condensed["digests"]), "a.json")


def test_a_sidecar_that_speaks_of_impossible_textures_is_refused(path: Path) -> None:
    written(path)
    for changes, message in [
        ({"rank": 4}, "a rank of 4, expected 2, 6"),
        ({"columns": 1025}, "more than 16384 pixels along a side of mirror_ends_xy"),
        ({"rank": 16382}, "more than 16384 pixels along a side of mirror_weights"),
    ]:
        with pytest.raises(
            FormatError, match=f'a.json, in "shared", has sizes that no textures have: {message}'
        ):
            SharedSidecar.from_json(retold(path, **changes), "a.json")
    facts = facts_in(path)
    with pytest.raises(FormatError, match="no textures have: buckets of 16 cells a side"):
        SharedSidecar.from_json(json.dumps(facts | {"bucket": 16}), "a.json")
    with pytest.raises(FormatError, match=r'"layers" is .*, expected \["colour"'):
        SharedSidecar.from_json(json.dumps(facts | {"layers": [*LAYERS[:3], *LAYERS[4:]]}), "a.json")


def test_keys_of_later_tools_are_ignored(path: Path) -> None:
    _, sidecar = written(path)
    assert SharedSidecar.from_json(retold(path, later=[1])) == sidecar
