# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Exported textures of a layered bake: their formats and ranges, and that lookups are what they were."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.formats.containers.texture import PixelFormat, Texture, decode_texture
from radtex_addon.formats.json_reader import Facts
from radtex_addon.formats.sidecar_file import SidecarFile
from radtex_addon.forms import form_in
from radtex_addon.forms.layered.blocks import FORMATS, Coded, coded
from radtex_addon.forms.layered.files.arrangement import (
    CHANNELS,
    EXIT_DIRECTION,
    EXIT_PLACE,
    FIELD,
    IRRADIANCE,
    OWN,
    PICTURES,
    REST,
    packed,
)
from radtex_addon.forms.layered.files.layered_files import atlas_of, read_layered, write_layered
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas, sample_layered
from radtex_addon.forms.layered.shader_values import exported_facts
from radtex_addon.textures.entry import Container, TextureEntry
from radtex_addon.textures.export_spec import ExportSpec, Target, TextureFormat
from tests.layered.made_up import made_up_atlas, made_up_fragments
from tests.layered_lookups import CASES, FACTS, off
from tests.reference.textures import read_dds, read_ktx2

HALF = PixelFormat.RGBA16F


TEXELS = 64  # several blocks along the side of a cell's tile


@cache
def atlas_called(name: str) -> LayeredAtlas:
    return CASES[name](made_up_atlas(TEXELS, 64))


@cache
def textures_of(name: str, folder: Path, spec: ExportSpec) -> tuple[Path, dict[str, TextureEntry]]:
    """A made-up bake, written and exported: its sidecar and the entries."""
    sidecar, out = folder / "Vase.radiance.json", folder / f"{spec.target}-{spec.format}"
    write_layered(sidecar, atlas_called(name), replace(FACTS, width=TEXELS, height=TEXELS))
    out.mkdir()
    file = SidecarFile.read(sidecar)
    return sidecar, form_in(file.facts).write_textures(file, spec, out)


def texture_of(folder: Path, entry: TextureEntry) -> Texture:
    path = folder / entry.file
    texture = read_ktx2(path) if entry.container is Container.KTX2 else read_dds(path)
    assert (texture.format, (texture.width, texture.height)) == (entry.format, entry.size)
    assert (len(texture.levels), entry.layers) == (entry.levels, 1)
    return texture


@pytest.mark.parametrize("target", [Target.WEB, Target.GLTF, Target.UNITY])
def test_by_itself_all_but_rays_are_in_blocks(tmp_path: Path, target: Target) -> None:
    sidecar, entries = textures_of("everything", tmp_path, ExportSpec(target))
    container = Container.DDS if target is Target.UNITY else Container.KTX2
    assert list(entries) == [layer for layer in CHANNELS if layer != FIELD]
    for layer, entry in entries.items():
        assert (entry.format, entry.container) == (FORMATS.get(layer, HALF), container), layer
        assert (entry.levels > 1) == (layer in (*PICTURES, IRRADIANCE))
        texture_of(tmp_path / f"{target}-auto", entry)
    whole = sum((tmp_path / f"{target}-auto" / entry.file).stat().st_size for entry in entries.values())
    assert "RADTEX_SRGB" not in exported_facts(SidecarFile.read(sidecar).facts.values, entries)["defines"]
    print(f"{target}: {whole} bytes")


def test_rays_of_cells_are_not_exported_where_rays_are_followed(tmp_path: Path) -> None:
    _, entries = textures_of("glass ball", tmp_path, ExportSpec(Target.WEB))
    assert list(entries) == [layer for layer in CHANNELS if layer not in (EXIT_DIRECTION, EXIT_PLACE)]
    assert entries[FIELD].format == HALF
    assert (entries[FIELD].scale, entries[FIELD].offset) == (1, 0)
    texture_of(tmp_path / "web-auto", entries[FIELD])


def test_levels_of_irradiance_are_means_of_what_is_seen(tmp_path: Path) -> None:
    """Of 36 x 38 texels: nobody sees the left ones, which are black; those on the right are in shadow."""
    light, colour = np.zeros((2, 36, 38, 3), np.float32)
    light[:, 20:32] = np.random.default_rng(3).uniform(0.5, 2, (36, 12, 3))
    colour[:, 20:] = 0.5
    sidecar, atlas = (
        tmp_path / "Vase.radiance.json",
        replace(atlas_called("bare"), irradiance=light, colour=colour),
    )
    write_layered(sidecar, atlas, replace(FACTS, width=38, height=36))
    file = SidecarFile.read(sidecar)
    for kind, size in ((TextureFormat.KTX2_RGBA16F, (38, 36)), (TextureFormat.DDS_BC6H, (40, 36))):
        folder = tmp_path / kind
        folder.mkdir()
        entry = form_in(file.facts).write_textures(file, ExportSpec(Target.RAW, format=kind), folder)[
            IRRADIANCE
        ]
        assert (entry.texels, entry.size, entry.levels) == ((38, 36), size, 6)
        levels = [level[0, ..., :3] for level in decode_texture(texture_of(folder, entry))]
        loss = 2e-3 if kind is TextureFormat.KTX2_RGBA16F else 0.1
        means = light.reshape(18, 2, 19, 2, 3).mean(axis=(1, 3))
        assert np.abs(levels[0][:, :38] - light).mean() < loss
        assert np.abs(levels[1][:, 10:19] - means[:, 10:]).mean() < loss
        assert levels[2][:, :4].min() > 0.4  # what nobody sees has the light of what lies around
        assert levels[2][:, 8].max() < 0.3  # the dark stays dark
        assert np.allclose(levels[-1], light[:, 20:].mean(axis=(0, 1)), rtol=0.2)


def test_from_afar_colour_times_irradiance_has_the_mean_that_it_has_near_by(tmp_path: Path) -> None:
    """Of a lamp on a dark wall, which is most of the light, and whose neighbours have little colour."""
    light, colour = np.ones((16, 16, 3), np.float32), np.full((32, 32, 3), 0.5, np.float32)
    light[5:8, 5:8], colour[10:16, 10:16] = 20, 0.5 / 20
    colour[12:14, 12:14] = 1
    sidecar = tmp_path / "Wall.radiance.json"
    atlas = replace(atlas_called("bare"), irradiance=light, colour=colour)
    write_layered(sidecar, atlas, replace(FACTS, width=16, height=16))
    file = SidecarFile.read(sidecar)
    spec = ExportSpec(Target.RAW, format=TextureFormat.KTX2_RGBA16F)
    entry = form_in(file.facts).write_textures(file, spec, tmp_path)[IRRADIANCE]
    *_, last = decode_texture(texture_of(tmp_path, entry))
    whole = (colour * light.repeat(2, axis=0).repeat(2, axis=1)).mean(axis=(0, 1))
    np.testing.assert_allclose(last[0, 0, 0, :3] * colour.mean(axis=(0, 1)), whole, rtol=0.01)


@pytest.mark.parametrize("name", ["everything", "clear", "bare"])
def test_lookups_are_nearly_what_they_were(tmp_path: Path, name: str) -> None:
    """By what the files say of themselves: the manifest's entries and the blocks.

    The channels of what is made up have nothing to do with each other, and blocks hold lines of colours:
    bakes lose a tenth of that.
    """
    sidecar, entries = textures_of(name, tmp_path, ExportSpec(Target.GLTF))
    atlas, facts = read_layered(sidecar)
    images: dict[str, Floats] = {}
    for layer, entry in entries.items():
        texture = texture_of(tmp_path / "gltf-auto", entry)
        if layer not in FORMATS:
            levels = tuple(level[0].view("<f2").astype(np.float32) for level in texture.levels)
        else:
            levels = Coded(texture, entry.texels, entry.scale, entry.offset).values()
        levels = tuple(level[..., : CHANNELS[layer]] for level in levels)
        picture = facts.pictures.get(layer)
        images[layer] = levels[0] if picture is None else packed(levels[: picture.levels])
    at = made_up_fragments(atlas, 4000, framed=True)
    wrong = off(sample_layered(atlas_of(images, facts), at), sample_layered(atlas, at))
    print(f"{name}: mean error {wrong.mean():.1e}, 99 % {np.quantile(wrong, 0.99):.1e}")
    assert wrong.mean() < 0.06


def test_a_lamp_in_an_atlas_does_not_grey_the_others(tmp_path: Path) -> None:
    """Eight bits of a rest from -1 to 100 would be steps of 0.4, seen on all that is dark."""
    atlas = made_up_atlas(TEXELS, 64)
    rest = np.array(atlas.rest)
    rest[: len(rest) // 16] += 100
    assert _rest_of(tmp_path / "plain", atlas)[1].format is PixelFormat.BC7
    file, entry = _rest_of(tmp_path / "lamp", replace(atlas, rest=rest))
    assert entry.format is HALF
    assert (entry.scale, entry.offset) == (1, 0)
    (level,) = texture_of(tmp_path / "lamp", entry).levels
    stored = level[0].view("<f2").astype(np.float32)[..., :3]
    shown = read_layered(file)[0].rest
    np.testing.assert_allclose(
        np.sort(stored.ravel())[::997], np.sort(shown.ravel())[::997], rtol=1e-3, atol=1e-3
    )


def _rest_of(folder: Path, atlas: LayeredAtlas) -> tuple[SidecarFile, TextureEntry]:
    """A bake that is written to a folder, and the entry of its exported rest."""
    folder.mkdir()
    write_layered(folder / "Vase.radiance.json", atlas, replace(FACTS, width=TEXELS, height=TEXELS))
    file = SidecarFile.read(folder / "Vase.radiance.json")
    return file, form_in(file.facts).write_textures(file, ExportSpec(Target.WEB), folder)[REST]


def test_shaders_are_told_of_ranges(tmp_path: Path) -> None:
    sidecar, entries = textures_of("everything", tmp_path, ExportSpec(Target.WEB))
    values = exported_facts(SidecarFile.read(sidecar).facts.values, entries)["values"]
    for layer, entry in entries.items():
        scale, offset = values[f"radtex_{layer}_range"][2:]
        np.testing.assert_allclose((scale, offset), (entry.scale, entry.offset), rtol=1e-6)
    assert entries[REST].offset < 0 < entries[REST].scale
    assert (entries["normal"].scale, entries["normal"].offset) == (2, -1)
    again = TextureEntry.from_facts(Facts(entries[OWN].facts(), "an entry"))
    assert again == entries[OWN]
    assert "range" not in entries["irradiance"].facts()


def test_godot_decodes_srgb_itself_and_gets_light_that_it_does_not_unpack(tmp_path: Path) -> None:
    sidecar, entries = textures_of("everything", tmp_path, ExportSpec(Target.GODOT))
    for layer, entry in entries.items():
        expected = FORMATS.get(layer, HALF)
        if expected is PixelFormat.BC6H:
            expected = PixelFormat.RGB9E5
        assert entry.format is expected.without_srgb, layer
    facts = exported_facts(SidecarFile.read(sidecar).facts.values, entries)
    assert facts["defines"]["RADTEX_SRGB"] == 1
    asked = ExportSpec(Target.GODOT, TextureFormat.KTX2_BC6H)
    assert textures_of("everything", tmp_path, asked)[1]["world"].format is PixelFormat.BC6H


@pytest.mark.parametrize(
    ("target", "form", "light"),
    [
        (Target.RAW, TextureFormat.AUTO, PixelFormat.RGB9E5),
        (Target.UNREAL, TextureFormat.AUTO, HALF),
        (Target.WEB, TextureFormat.KTX2_RGBA16F, HALF),
        (Target.GODOT, TextureFormat.KTX2_RGB9E5, PixelFormat.RGB9E5),
        (Target.RAW, TextureFormat.DDS_BC6H, PixelFormat.BC6H),
    ],
)
def test_without_blocks_what_is_no_light_is_exact(
    tmp_path: Path, target: Target, form: TextureFormat, light: PixelFormat
) -> None:
    _, entries = textures_of("made up", tmp_path, ExportSpec(target, form))
    formats = {layer: entry.format for layer, entry in entries.items()}
    if light is PixelFormat.BC6H:  # which is asked for, so that all is in blocks
        assert formats == {layer: FORMATS.get(layer, HALF) for layer in entries}
        return
    assert {formats[layer] for layer in ("colour", "irradiance", "world")} == {light}
    assert {formats[layer] for layer in ("own", "rest", "plane", "things", "distances")} == {HALF}
    assert {(entry.scale, entry.offset) for entry in entries.values()} == {(1.0, 0.0)}


def test_a_map_that_is_the_same_everywhere_is_one_block_and_padding_is_not_the_images() -> None:
    found = coded("colour", (np.full((30, 20, 3), 0.25, np.float32),))
    assert (found.texture.width, found.texture.height, found.texels) == (4, 4, (4, 4))
    np.testing.assert_allclose(found.values()[0][..., :3], 0.25, atol=2e-3)
    other = coded("own", (np.full((16, 16, 4), 0.25, np.float32),))
    assert other.texels == (16, 16)
    found = coded("irradiance", (np.random.default_rng(3).uniform(0, 2, (6, 9, 3)).astype(np.float32),))
    assert (found.texture.width, found.texture.height, found.texels) == (12, 8, (9, 6))
    assert found.values()[0].shape == (6, 9, 3)


def test_what_is_dark_beside_the_brightest_is_kept() -> None:
    """In a hundredth of the range steps are still small."""
    image = np.full((64, 64, 4), 0.01, np.float32)
    image[:32] = 1.0
    for layer in ("plane", OWN):
        (found,) = coded(layer, (image,)).values()
        np.testing.assert_allclose(found[32:, :, :3], 0.01, rtol=0.1 if layer == "plane" else 0.3)


def test_too_small_a_limit_is_refused(tmp_path: Path) -> None:
    spec = replace(ExportSpec(Target.WEB), limit=32)
    with pytest.raises(InputError, match="pixels, which cannot be split"):
        textures_of("bare", tmp_path, spec)
