# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Atlases and renders come back as they were written, the right way up; bad files are refused by name."""

from __future__ import annotations

import os
import struct
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.colour_spaces import KNOWN, converted, matrix_to_rec709
from radtex_addon.core.errors import BakeError, FormatError, ShapeError
from radtex_addon.formats.containers.exr import Compression, read_atlas, read_render, write_atlas
from radtex_addon.formats.disk.memory import physical_memory, readable_size
from radtex_addon.formats.render_space import render_matrix
from radtex_addon.formats.sidecar import Sidecar

SIDECAR = Sidecar("Cube", "radiance", 24, 10, 8, "RadTex", 16, 0, "portal", "RadTex 0.1.0", "5.2.3")


def light(channels: int = 4) -> Floats:
    """An atlas image whose values span what a half float holds, in whole halves."""
    exponent = np.random.default_rng(1).uniform(-8, 8, (80, 192, channels))
    return (np.exp2(exponent)).astype(np.float16).astype(np.float32)


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("half", [True, False])
@pytest.mark.parametrize("compression", [Compression.ZIP, Compression.PIZ])
def test_pixels_and_sidecar_come_back_exactly(
    tmp_path: Path, channels: int, half: bool, compression: Compression
) -> None:
    path, pixels = tmp_path / "a.exr", light(channels)
    pixels = pixels if half else pixels * np.float32(1 / 3)  # which need all their bits
    written = write_atlas(path, pixels, SIDECAR, half, compression)
    read, sidecar = read_atlas(path)
    np.testing.assert_array_equal(read, pixels)
    assert read.dtype == (np.float16 if half else np.float32)
    assert sidecar == written == SIDECAR
    assert list(tmp_path.iterdir()) == [path]


def test_dwaa_is_close(tmp_path: Path) -> None:
    x = np.linspace(0, 3, 192)
    pixels = np.broadcast_to((1.5 + np.sin(x))[None, :, None], (80, 192, 4)).astype(np.float32)
    write_atlas(tmp_path / "a.exr", pixels, SIDECAR, compression=Compression.DWAA)
    np.testing.assert_allclose(read_atlas(tmp_path / "a.exr")[0], pixels, rtol=0.02)


def test_the_files_first_row_is_our_last(tmp_path: Path) -> None:
    pixels = light()
    write_atlas(tmp_path / "a.exr", pixels, SIDECAR)
    first = OpenEXR.File(str(tmp_path / "a.exr")).channels()["RGBA"].pixels[0]
    np.testing.assert_array_equal(first, pixels[-1])


def test_the_header_holds_the_sidecar_and_the_primaries(tmp_path: Path) -> None:
    written = write_atlas(tmp_path / "a.exr", light(), SIDECAR)
    header = OpenEXR.File(str(tmp_path / "a.exr"), header_only=True).header()
    assert header["radtex"] == written.to_json()
    assert header["compression"] == OpenEXR.ZIP_COMPRESSION
    red, green, blue, white = np.reshape(header["chromaticities"], (4, 2))
    np.testing.assert_allclose([red, green], [[0.64, 0.33], [0.30, 0.60]], atol=1e-6)
    np.testing.assert_allclose([blue, white], [[0.15, 0.06], [0.3127, 0.3290]], atol=1e-6)


def test_values_beyond_a_half_are_clamped_and_counted(tmp_path: Path) -> None:
    pixels = light()
    pixels[3, 4] = (1e6, -1e6, np.inf, -np.inf)
    pixels[5, 6, 0] = 65504
    sidecar = write_atlas(tmp_path / "a.exr", pixels, SIDECAR)
    read, header = read_atlas(tmp_path / "a.exr")
    assert sidecar.clamped == header.clamped == 4
    np.testing.assert_array_equal(read[3, 4], [65504, -65504, 65504, -65504])
    assert write_atlas(tmp_path / "b.exr", pixels, SIDECAR, half=False).clamped == 2
    assert np.isfinite(read_atlas(tmp_path / "b.exr")[0]).all()


def test_values_that_are_no_numbers_and_pixels_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    pixels = light()
    pixels[70:72, 5, 1] = np.nan
    with pytest.raises(BakeError, match=r"a\.exr was not written: 2 of its values are not numbers"):
        write_atlas(tmp_path / "a.exr", pixels, SIDECAR)
    for other in (light()[:-1], light()[..., :2], light()[..., 0]):
        with pytest.raises(ShapeError, match=r"\(80, 192"):
            write_atlas(tmp_path / "a.exr", other, SIDECAR)
    assert list(tmp_path.iterdir()) == []


def test_a_failing_write_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.exr"
    path.write_text("old")

    class FullDisk:
        def __init__(self, *_: object) -> None: ...

        def write(self, name: str) -> None:
            Path(name).write_text("half")
            raise RuntimeError("No space left\non device.")

    monkeypatch.setattr(OpenEXR, "File", FullDisk)
    with pytest.raises(BakeError, match=r"a\.exr could not be written: No space left on device; free"):
        write_atlas(path, light(), SIDECAR)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_was_cut_short_or_damaged_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    write_atlas(path, light(), SIDECAR)
    data = path.read_bytes()
    middle = len(data) // 2
    spoilt = data[:middle] + bytes(200) + data[middle + 200 :]
    for harmed in (spoilt, *(data[: int(len(data) * share)] for share in (0.0001, 0.05, 0.5, 0.999))):
        path.write_bytes(harmed)
        for read in (read_atlas, read_render):
            with pytest.raises(FormatError, match=r"a\.exr is (damaged|not an OpenEXR file)"):
                read(path)


def test_missing_and_foreign_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    for read in (read_atlas, read_render):
        with pytest.raises(FormatError, match=r"a\.exr cannot be read: No such file"):
            read(path)
    path.write_bytes(b"\x89PNG and so on")
    for read in (read_atlas, read_render):
        with pytest.raises(FormatError, match=r"a\.exr is not an OpenEXR file"):
            read(path)
    store(path, None, RGBA=light())
    with pytest.raises(FormatError, match=r"a\.exr .* no RadTex atlas"):
        read_atlas(path)


def store(path: Path, sidecar: str | None, **channels: Floats) -> None:
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header | ({"radtex": sidecar} if sidecar is not None else {}), channels).write(str(path))


def test_atlases_that_break_the_contract_are_refused(tmp_path: Path) -> None:
    path, pixels = tmp_path / "a.exr", light()
    store(path, SIDECAR.to_json(), X=pixels[..., 0].copy(), RGB=pixels[..., :3].copy())
    with pytest.raises(FormatError, match=r"a\.exr has the channels B, G, R, X, expected RGBA"):
        read_atlas(path)
    store(path, SIDECAR.to_json(), RGBA=pixels[1:].copy())
    with pytest.raises(FormatError, match=r"a\.exr has 192 x 79 pixels .* 192 x 80"):
        read_atlas(path)
    store(path, SIDECAR.to_json(), RGBA=pixels.astype(np.uint32))
    with pytest.raises(FormatError, match=r"a\.exr has .* uint32"):
        read_atlas(path)
    store(path, "{}", RGBA=pixels)
    with pytest.raises(FormatError, match=r'the header of .*a\.exr lacks "version"'):
        read_atlas(path)
    store(path, SIDECAR.to_json().replace('"version": 1', '"version": 2'), RGBA=pixels)
    with pytest.raises(FormatError, match="version 2"):
        read_atlas(path)


def test_a_header_that_asks_for_more_than_the_memory_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    write_atlas(path, light(), SIDECAR)
    data = path.read_bytes()
    window = struct.pack("<4i", 0, 0, 191, 79)
    path.write_bytes(data.replace(window, struct.pack("<4i", 0, 0, 999_999, 999_999)))
    for read in (read_atlas, read_render):
        with pytest.raises(FormatError, match=rf"a\.exr is damaged: {len(data)} bytes cannot hold 1000000 x"):
            read(path)
    os.truncate(path, 1 << 40)  # the disk holds no more of it than before
    for read in (read_atlas, read_render):
        with pytest.raises(FormatError, match=r"a\.exr needs 14901\.2 GiB of memory"):
            read(path)


def test_a_damaged_image_is_told_of_once(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.exr"
    write_atlas(path, light(), SIDECAR)
    path.write_bytes(path.read_bytes()[:-9])
    with pytest.raises(FormatError, match="its pixels cannot be read"):
        read_atlas(path)
    assert capfd.readouterr() == ("", "")
    data = path.read_bytes()
    for before, after in ((b'"tool"', b'"\xff\xfe\xfdl"'), (b"R\0\1\0\0\0", b"\xff\0\1\0\0\0")):
        assert before in data
        path.write_bytes(data.replace(before, after))
        with pytest.raises(FormatError, match=r"a\.exr is damaged: .*(codec|not text)"):
            read_atlas(path)


@pytest.mark.parametrize("packed", [name for name in dir(OpenEXR) if name.endswith("_COMPRESSION")])
@pytest.mark.parametrize("value", [0, 1.5])
def test_what_packs_best_is_not_taken_for_damaged(tmp_path: Path, packed: str, value: float) -> None:
    """A picture of one colour comes nearest to the bounds of what a file of its size can hold."""
    path, pixels = tmp_path / "a.exr", np.full((1024, 512, 4), value, dtype=np.float32)
    for channels in (pixels, pixels.astype(np.float16)):
        header = {"compression": getattr(OpenEXR, packed), "type": OpenEXR.scanlineimage}
        OpenEXR.File(header, {"RGBA": channels}).write(str(path))
        np.testing.assert_allclose(read_render(path)[""], pixels, rtol=1e-3)


def test_a_plain_float_image_is_a_render_of_one_layer(tmp_path: Path) -> None:
    for channels in ("RGB", "RGBA"):
        pixels = np.random.default_rng(3).normal(size=(5, 7, len(channels))).astype(np.float32)
        store(tmp_path / "a.exr", None, **{channels: pixels[::-1].copy()})
        layers = read_render(tmp_path / "a.exr")
        assert list(layers) == [""]
        np.testing.assert_array_equal(layers[""], pixels)
    store(tmp_path / "a.exr", "", V=light()[..., 0].copy())
    assert read_render(tmp_path / "a.exr")[""].shape == (80, 192, 1)


@pytest.mark.parametrize("parts", [False, True])
def test_the_layers_of_a_render_are_joined(tmp_path: Path, parts: bool) -> None:
    """Blender 4.5 writes all layers into one part, 5.x each into a part of its own."""
    path, pixels = tmp_path / "a.exr", light()
    names = {"Combined": "RGBA", "Position": "XYZ", "UV": "UVA"}
    groups: list[dict[str, Floats]] = [
        {f"Layer é.x.{name}.{c}": pixels[..., k].copy() for k, c in enumerate(channels)}
        for name, channels in names.items()
    ]
    groups.append({"Layer é.x.Object Index.X": pixels[..., 3].astype(np.float16)})
    if parts:
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        made = [OpenEXR.Part({**header}, group, f"part {k}") for k, group in enumerate(groups)]
        OpenEXR.File(made).write(str(path))
    else:
        store(path, "", **{name: channel for group in groups for name, channel in group.items()})
    layers = read_render(path)
    assert {layer.dtype for layer in layers.values()} == {np.dtype(np.float32)}
    expected = {f"Layer é.x.{name}": pixels[..., : len(channels)] for name, channels in names.items()}
    expected["Layer é.x.Object Index"] = pixels[..., 3:]
    assert set(layers) == set(expected)
    for name, values in expected.items():
        np.testing.assert_array_equal(layers[name], values[::-1])


def test_sizes_are_readable() -> None:
    assert [readable_size(n) for n in (512, 2**20 - 1, 1.5 * 2**30)] == ["512 bytes", "1024 KiB", "1.5 GiB"]
    memory = physical_memory()
    assert memory is None or 2**28 < memory < 2**50


def rendered(path: Path, *spaces: str | None) -> Path:
    """A file of as many parts as there are spaces, each of which says its own."""
    parts = []
    for number, space in enumerate(spaces):
        header = {"type": OpenEXR.scanlineimage, "name": f"part {number}"}
        if space is not None:
            header["colorInteropID"] = space
        parts.append(OpenEXR.Part(header, {"RGB": np.ones((2, 2, 3), dtype=np.float32)}))
    OpenEXR.File(parts).write(str(path))
    return path


def test_matrices_are_those_that_others_publish() -> None:
    """ITU-R BT.2407 for Rec.2020; the ACES project's for AP1 with Bradford's adaptation."""
    rec2020 = [(1.6605, -0.5876, -0.0728), (-0.1246, 1.1329, -0.0083), (-0.0182, -0.1006, 1.1187)]
    acescg = [(1.70505, -0.62179, -0.08326), (-0.13026, 1.14080, -0.01055), (-0.02400, -0.12897, 1.15297)]
    np.testing.assert_allclose(matrix_to_rec709("lin_rec2020_scene"), rec2020, atol=1e-4)
    np.testing.assert_allclose(matrix_to_rec709("lin_ap1_scene"), acescg, atol=1e-5)
    for space in KNOWN:
        white = converted(np.ones((2, 3), dtype=np.float32), matrix_to_rec709(space))
        assert white.dtype == np.float32
        np.testing.assert_allclose(white, 1, atol=1e-6)


def test_the_file_says_its_space_and_data_has_none(tmp_path: Path) -> None:
    for plain in (("lin_rec709_scene", "data"), (None, None), ("data",)):
        assert render_matrix(rendered(tmp_path / "a.exr", *plain)) is None
    found = render_matrix(rendered(tmp_path / "a.exr", "data", "lin_ap1_scene", "lin_ap1_scene"))
    assert found is not None
    np.testing.assert_array_equal(found, matrix_to_rec709("lin_ap1_scene"))


def test_a_space_that_is_not_known_is_named(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"a\.exr holds colours of the space 'lin_p3d65_scene'"):
        render_matrix(rendered(tmp_path / "a.exr", "lin_p3d65_scene"))
    with pytest.raises(FormatError, match=r"a\.exr mixes colours of lin_ap1_scene and lin_rec2020_scene"):
        render_matrix(rendered(tmp_path / "a.exr", "lin_ap1_scene", "lin_rec2020_scene"))
