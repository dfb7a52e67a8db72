# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake's textures hold its light, each texel where its entry says; what cannot be is refused in a line."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.bake.layers import Layer
from radtex_addon.core.arrangements import Pages, padded_layout
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import FormatError, InputError, ShapeError
from radtex_addon.formats.bucket_files import write_buckets
from radtex_addon.formats.containers.exr import read_atlas, read_buckets, write_atlas
from radtex_addon.formats.containers.texture import PixelFormat, Texture, decode_texture
from radtex_addon.formats.sidecar import Sidecar, write_sidecar
from radtex_addon.formats.sidecar_file import SidecarFile
from radtex_addon.forms import form_in
from radtex_addon.forms.layered.files.arrangement import unpacked
from radtex_addon.forms.layered.files.layered_files import read_layer, read_layered_sidecar, write_layered
from radtex_addon.textures.entry import Arranged, Container, TextureEntry
from radtex_addon.textures.export_spec import Arrangement, ExportSpec, Target, TextureFormat
from tests.layered.made_up import made_up_atlas
from tests.reference.levels import level_chain
from tests.reference.pages import join_pages
from tests.reference.slices import from_slices, mip_chain
from tests.reference.textures import read_dds, read_ktx2

WEB = ExportSpec(Target.WEB)
RAW = ExportSpec(Target.RAW)


def write_textures(sidecar: Path, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    file = SidecarFile.read(sidecar)
    return form_in(file.facts).write_textures(file, spec, folder)


def bake(folder: Path, width: int = 13, height: int = 6, bucket: int = 8, channels: int = 4) -> Path:
    """A plain bake of smooth light from 0.05 to 20, no two values alike, with an alpha of 1; its sidecar."""
    rng = np.random.default_rng(1)
    pixels = np.ones((height * bucket, width * bucket, channels))
    across, up = np.arange(width * bucket), np.arange(height * bucket)[:, None]
    bright = np.exp(np.sin(across / 9) * 2 + np.cos(up / 7) - 0.0001 * across * up)
    colour = np.array([1.0, 0.8, 0.5]) * rng.uniform(0.98, 1.02, (*bright.shape, 3))
    lit = min(3, channels)
    pixels[..., :lit] = bright[..., None] * colour[..., :lit]
    return written(folder, pixels, width, height, bucket)


def written(folder: Path, pixels: Floats, width: int, height: int, bucket: int) -> Path:
    sidecar = Sidecar("Vase", "radiance", width, height, bucket, "RadTex", 4, 0, "portal", "RadTex 1", "5.2")
    path = folder / "Vase.radiance.json"
    write_sidecar(path, write_atlas(path.with_suffix(".exr"), pixels, sidecar))
    return path


def exported(sidecar: Path, spec: ExportSpec, folder: Path) -> tuple[TextureEntry, Texture]:
    """The one texture of a plain bake, held to its entry."""
    (layer, entry), *_ = write_textures(sidecar, spec, folder).items()
    assert layer == "radiance"
    texture = texture_of(folder, entry)
    assert entry.file == f"Vase.radiance.{entry.container}"
    return entry, texture


@pytest.mark.parametrize("form", [TextureFormat.AUTO, TextureFormat.KTX2_RGB9E5, TextureFormat.KTX2_BC6H])
def test_layers_lie_beside_the_whole_and_add_up_to_it(tmp_path: Path, form: TextureFormat) -> None:
    """Base and rest are as exact as their formats; what is below 0 keeps its sign in any."""
    path = bake(tmp_path, 12, 8, 8)
    whole, facts = read_buckets(path)
    layout = AtlasLayout(12, 8, 8)
    base = layout.to_buckets(whole[..., :3]).mean(axis=(2, 3)).astype(np.float32)
    rest = whole[..., :3] - base.repeat(8, axis=0).repeat(8, axis=1)
    write_buckets(path, whole, {"base": base, "rest": rest, "diffuse": whole[..., :3]}, facts)
    spec = ExportSpec(Target.RAW, form, layers=(Layer.BASE, Layer.REST))
    entries = write_textures(path, spec, tmp_path)
    assert list(entries) == ["radiance", "base", "rest"]
    assert entries["base"].arrangement is Arranged.IMAGE
    assert entries["rest"].format is PixelFormat.RGBA16F
    assert entries["rest"].levels == entries["radiance"].levels
    found = {name: decode_texture(texture_of(tmp_path, entry))[0][0] for name, entry in entries.items()}
    height, width = rest.shape[:2]
    added = found["rest"][:height, :width, :3] + found["base"][:8, :12, :3].repeat(8, axis=0).repeat(
        8, axis=1
    )
    np.testing.assert_allclose(added, whole[..., :3], rtol=0.1, atol=0.1 * float(base.max()))
    assert found["rest"].min() < -0.1


def texture_of(folder: Path, entry: TextureEntry) -> Texture:
    """What the file of an entry holds, which must be what the entry says."""
    path = folder / entry.file
    texture = read_ktx2(path) if entry.container is Container.KTX2 else read_dds(path)
    assert (texture.format, (texture.width, texture.height)) == (entry.format, entry.size)
    assert (texture.layers, len(texture.levels)) == (entry.layers, entry.levels)
    return texture


def source_of(sidecar: Path) -> tuple[Floats, AtlasLayout]:
    pixels, facts = read_atlas(sidecar.with_suffix(".exr"))
    return pixels.astype(np.float32), AtlasLayout(facts.width, facts.height, facts.bucket)


def stops(ours: Floats, source: Floats) -> float:
    """By how much the greatest channel of a pixel is off at most."""
    return float(np.abs(np.log2(ours[..., :3].max(axis=-1) / source[..., :3].max(axis=-1))).max())


def test_the_matrix_is_the_atlas_from_the_bottom_row_on_and_an_exr_the_bakes(tmp_path: Path) -> None:
    sidecar = bake(tmp_path)
    pixels, _ = source_of(sidecar)
    for spec in (TextureFormat.KTX2_RGBA16F, TextureFormat.DDS_RGBA16F):
        entry, texture = exported(sidecar, replace(RAW, format=spec, levels=1), tmp_path / "out")
        np.testing.assert_array_equal(decode_texture(texture)[0][0], pixels)
        assert (entry.texels, entry.stored, entry.arrangement) == ((13, 6), (13, 6), Arranged.MATRIX)
    entry = write_textures(sidecar, replace(RAW, format=TextureFormat.EXR), tmp_path / "out")["radiance"]
    assert (entry.container, entry.size, entry.levels) == (Container.EXR, (104, 48), 1)
    assert (tmp_path / "out" / entry.file).read_bytes() == sidecar.with_suffix(".exr").read_bytes()


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_by_itself_opaque_light_is_rgb9e5_and_packed(tmp_path: Path, channels: int) -> None:
    sidecar = bake(tmp_path, channels=channels)
    entry, texture = exported(sidecar, replace(WEB, levels=1), tmp_path / "out")
    assert (entry.container, entry.format, entry.zstd) == (Container.KTX2, PixelFormat.RGB9E5, True)
    assert stops(decode_texture(texture)[0][0], source_of(sidecar)[0]) <= 0.005
    entry, _ = exported(bake(tmp_path, 32, 16, 4), WEB, tmp_path / "out")
    assert (entry.levels, entry.stored) == (5, (32, 16))  # as many as padding affords


@pytest.mark.parametrize(("channel", "value"), [(3, 0.5), (1, -0.01)])
def test_by_itself_other_light_is_exact(tmp_path: Path, channel: int, value: float) -> None:
    sidecar = bake(tmp_path)
    pixels, layout = source_of(sidecar)
    pixels[7, 9, channel] = value
    written(tmp_path, pixels, layout.width, layout.height, layout.bucket)
    for target in (Target.WEB, Target.UNITY):
        entry, texture = exported(sidecar, ExportSpec(target, levels=1), tmp_path / "out")
        assert entry.format is PixelFormat.RGBA16F
        np.testing.assert_array_equal(decode_texture(texture)[0][0], pixels.astype(np.float16))


def test_engines_get_dds_by_themselves(tmp_path: Path) -> None:
    for target, bucket, kind in (
        (Target.UNITY, 8, PixelFormat.BC6H),
        (Target.UNREAL, 6, PixelFormat.RGBA16F),  # blocks would straddle buckets
    ):
        entry, _ = exported(bake(tmp_path, bucket=bucket), ExportSpec(target), tmp_path / "out")
        assert (entry.container, entry.format, entry.zstd) == (Container.DDS, kind, False)


@pytest.mark.parametrize("levels", [2, 3, 4])
def test_levels_are_those_of_the_reference(tmp_path: Path, levels: int) -> None:
    sidecar = bake(tmp_path)
    spec = replace(RAW, format=TextureFormat.KTX2_RGBA16F, levels=levels)
    entry, texture = exported(sidecar, spec, tmp_path / "out")
    pixels, layout = source_of(sidecar)
    stored = padded_layout(layout, levels)
    assert entry.stored == entry.page_texels == (stored.width, stored.height)
    chain = level_chain(pixels, layout, levels)
    for ours, reference in zip(decode_texture(texture), chain, strict=True):
        np.testing.assert_array_equal(ours[0], reference.astype(np.float16))


@pytest.mark.parametrize("levels", [1, 2])
def test_pages_join_to_the_atlas(tmp_path: Path, levels: int) -> None:
    sidecar = bake(tmp_path)
    spec = replace(RAW, format=TextureFormat.KTX2_RGBA16F, levels=levels, limit=33)
    entry, texture = exported(sidecar, spec, tmp_path / "out")
    assert texture.is_array
    assert entry.layers == entry.pages[0] * entry.pages[1] == 8
    assert max(entry.size) <= 33
    assert entry.size == tuple(8 * side for side in entry.page_texels)
    pixels, layout = source_of(sidecar)
    pages, chain = Pages(*entry.pages, *entry.page_texels), level_chain(pixels, layout, levels)
    for level, stack in enumerate(decode_texture(texture)):
        here = AtlasLayout(-(-layout.width >> level), -(-layout.height >> level), 8) if level else layout
        joined = join_pages(stack, here, pages.at_level(level))
        expected = chain[level][: joined.shape[0], : joined.shape[1]]
        np.testing.assert_array_equal(joined, expected.astype(np.float16))


def test_slices_have_a_layer_for_each_cell(tmp_path: Path) -> None:
    sidecar = bake(tmp_path, bucket=6)
    spec = replace(RAW, format=TextureFormat.KTX2_RGBA16F, arrangement=Arrangement.SLICES)
    entry, texture = exported(sidecar, spec, tmp_path / "out")
    assert (entry.arrangement, entry.layers, entry.size) == (Arranged.SLICES, 36, (13, 6))
    assert entry.levels == 4
    pixels, _ = source_of(sidecar)
    levels = decode_texture(texture)
    np.testing.assert_array_equal(from_slices(levels[0]), pixels)
    np.testing.assert_array_equal(levels[0][6 * 2 + 3, 4, 9], pixels[4 * 6 + 2, 9 * 6 + 3])
    for ours, reference in zip(levels, mip_chain(levels[0]), strict=True):
        np.testing.assert_array_equal(ours, reference.astype(np.float16))
    entry, _ = exported(sidecar, replace(spec, levels=2), tmp_path / "out")
    assert entry.levels == 2


def test_godot_gets_whole_mip_chains_and_arrays_as_dds(tmp_path: Path) -> None:
    """Its loaders make nothing of a chain that ends early, and refuse arrays in KTX2."""
    sidecar, godot = bake(tmp_path), ExportSpec(Target.GODOT)
    for spec, container, levels, whole in (
        (replace(godot, levels=1), Container.KTX2, 1, 1),
        (replace(godot, levels=2), Container.KTX2, 2, 7),
        (replace(godot, limit=64, levels=2), Container.DDS, 2, 7),
        (replace(godot, arrangement=Arrangement.SLICES), Container.DDS, 4, 4),
    ):
        entry = write_textures(sidecar, spec, tmp_path / "out")["radiance"]
        assert (entry.container, entry.levels) == (container, levels)
        path = tmp_path / "out" / entry.file
        texture = read_ktx2(path) if container is Container.KTX2 else read_dds(path)
        assert len(texture.levels) == whole
    with pytest.raises(InputError, match="which Godot reads from DDS only"):
        write_textures(sidecar, replace(godot, format=TextureFormat.KTX2_RGBA16F, limit=64), tmp_path / "out")


def test_bc6h_is_near_and_straddles_no_buckets(tmp_path: Path) -> None:
    """A bucket changed altogether changes no other one."""
    sidecar = bake(tmp_path)
    pixels, layout = source_of(sidecar)
    spec = replace(RAW, format=TextureFormat.DDS_BC6H, levels=1)
    before = decode_texture(exported(sidecar, spec, tmp_path / "out")[1])[0][0]
    rms = np.sqrt(np.mean(np.log2(before / pixels[..., :3]) ** 2))
    print(f"BC6H: {rms:.4f} stops RMSE")
    assert rms < 0.05
    pixels[8:16, 16:24, :3] *= 37
    written(tmp_path, pixels, layout.width, layout.height, layout.bucket)
    after = decode_texture(exported(sidecar, spec, tmp_path / "out")[1])[0][0]
    changed = layout.to_buckets(after != before).any(axis=(2, 3, 4))
    assert np.argwhere(changed).tolist() == [[1, 2]]


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        (
            replace(RAW, format=TextureFormat.KTX2_BC6H),
            "straddle buckets of 6 cells",
        ),
        (
            replace(RAW, format=TextureFormat.EXR, levels=2),
            "neither slices nor levels: choose KTX2 RGBA16F",
        ),
        (replace(RAW, levels=5), "13 x 6 texels, which make 4 levels at most"),
        (replace(RAW, format=TextureFormat.EXR, limit=64), "78 x 36 pixels, which cannot be split"),
        (
            replace(RAW, format=TextureFormat.DDS_BC6H, arrangement=Arrangement.SLICES),
            "slices of 13 x 6 are no whole blocks",
        ),
        (replace(RAW, levels=4, limit=32), "limit: 32 pixels hold no 8 texels"),
        (replace(RAW, arrangement=Arrangement.SLICES), "2116 layers, textures have 2048; export the matrix"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line(tmp_path: Path, spec: ExportSpec, message: str) -> None:
    bucket = 46 if "2116" in message else 6
    with pytest.raises((InputError, ShapeError), match=message) as caught:
        write_textures(bake(tmp_path, bucket=bucket), spec, tmp_path / "out")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_formats_without_alpha_are_refused_where_there_is_some(tmp_path: Path) -> None:
    sidecar = bake(tmp_path)
    pixels, layout = source_of(sidecar)
    pixels[0, 0, 3] = 0.9
    written(tmp_path, pixels, layout.width, layout.height, layout.bucket)
    for kind, other in (("ktx2-rgb9e5", "ktx2-rgba16f"), ("dds-bc6h", "dds-rgba16f")):
        with pytest.raises(
            InputError, match=f"alpha that is not 1, .* cannot hold: choose {TextureFormat(other).label}"
        ):
            write_textures(sidecar, replace(RAW, format=TextureFormat(kind)), tmp_path / "out")


def test_bad_files_are_refused_by_name(tmp_path: Path) -> None:
    sidecar = bake(tmp_path)
    image = sidecar.with_suffix(".exr")
    whole, text = image.read_bytes(), sidecar.read_text()

    def refused(message: str, path: Path = sidecar) -> None:
        with pytest.raises(FormatError, match=message):
            write_textures(path, WEB, tmp_path / "out")

    refused(r"nowhere\.json cannot be read", tmp_path / "nowhere.json")
    for damaged in (whole[:-200], whole[:100], b"", b"foreign" * 100):
        image.write_bytes(damaged)
        refused(r"Vase\.radiance\.exr")
    image.write_bytes(whole)
    sidecar.write_text(text.replace('"samples": 4', '"samples": 5'))
    refused(r"\.exr is of another bake than .*\.json")
    sidecar.write_text(text.replace('"version": 1', '"version": 2'))
    refused("of version 2, this RadTex reads 1: update RadTex")
    image.unlink()
    sidecar.write_text(text)
    refused(r"Vase\.radiance\.exr cannot be read")
    assert not (tmp_path / "out").exists()


def layered(folder: Path, texels: int = 16, irradiance: Floats | None = None) -> Path:
    """A bake in the layered layout, of other `irradiance` if it is given; its sidecar."""
    path = folder / "Vase.radiance.json"
    facts = Sidecar("Vase", "radiance", texels, texels, 14, "RadTex", 16, 0, "portal", "RadTex 1", "5.2")
    atlas = made_up_atlas(texels, 32)
    write_layered(path, atlas if irradiance is None else replace(atlas, irradiance=irradiance), facts)
    return path


def test_layered_light_is_packed_unless_it_is_below_zero_and_all_else_is_exact(tmp_path: Path) -> None:
    sidecar, spec = layered(tmp_path), replace(WEB, format=TextureFormat.KTX2_RGB9E5)
    entries = write_textures(sidecar, spec, tmp_path / "out")
    facts = read_layered_sidecar(sidecar)
    assert list(entries) == list(facts.bake.layers)
    for layer, entry in entries.items():
        image = read_layer(sidecar, facts, layer).astype(np.float32)
        levels = decode_texture(texture_of(tmp_path / "out", entry))
        assert entry.file == f"Vase.radiance.{layer}.ktx2"
        assert entry.arrangement is Arranged.IMAGE
        if layer in facts.pictures:
            picture = facts.pictures[layer]
            image = unpacked(image, picture.size, picture.levels)[0]
        assert entry.texels == entry.stored == (image.shape[1], image.shape[0])
        decoded = levels[0][0][..., : image.shape[2]]
        if layer in ("colour", "irradiance", "world"):
            assert entry.format is PixelFormat.RGB9E5
            lit = image.max(axis=2) > 1e-3
            assert stops(decoded[lit], image[lit]) <= 0.005
        else:
            assert entry.format is PixelFormat.RGBA16F
            np.testing.assert_array_equal(decoded, image)
    irradiance = np.ones((16, 16, 3), np.float32)
    irradiance[3, 4] = -0.5
    entries = write_textures(layered(tmp_path, irradiance=irradiance), spec, tmp_path / "out")
    assert entries["irradiance"].format is PixelFormat.RGBA16F
    assert entries["colour"].format is PixelFormat.RGB9E5


def test_blocks_are_filled_up_with_the_last_pixels(tmp_path: Path) -> None:
    irradiance = np.full((6, 6, 3), 1.5, np.float32)
    irradiance[:, 4:] = 2.5  # a block of its own
    sidecar = layered(tmp_path, 6, irradiance=irradiance)
    entries = write_textures(sidecar, replace(RAW, format=TextureFormat.DDS_BC6H), tmp_path / "out")
    assert (entries["irradiance"].texels, entries["irradiance"].stored) == ((6, 6), (8, 8))
    blocks = decode_texture(texture_of(tmp_path / "out", entries["irradiance"]))[0][0]
    np.testing.assert_array_equal(blocks, np.pad(irradiance, ((0, 2), (0, 2), (0, 0)), mode="edge"))


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        (
            replace(RAW, arrangement=Arrangement.SLICES),
            "layered layout: leave the arrangement and the levels out",
        ),
        (replace(RAW, levels=2), "layered layout: leave the arrangement and the levels out"),
        (replace(RAW, limit=48), r"colour\.exr would be a texture of .* cannot be split"),
        (replace(RAW, format=TextureFormat.EXR), "whose pictures have mip levels, which EXRs cannot hold"),
    ],
)
def test_what_layered_bakes_cannot_be_is_refused(tmp_path: Path, spec: ExportSpec, message: str) -> None:
    sidecar = layered(tmp_path)
    with pytest.raises(InputError, match=message):
        write_textures(sidecar, spec, tmp_path / "out")
