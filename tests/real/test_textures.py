# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""KTX2 and DDS files as a program decodes them that we did not write: Godot, by libktx and its own loader."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.formats.containers.dds import write_texture
from radtex_addon.formats.containers.ktx2 import write_ktx2
from radtex_addon.formats.containers.texture import PixelFormat, decode_texture, encode_texture
from radtex_addon.formats.containers.unit_blocks import CHANNELS, decode_units, encode_units
from tests.real.godot import RENDERERS, run_godot
from tests.real.root import Root
from tests.reference.slices import mip_chain

WIDTH, HEIGHT = 96, 64
SCRIPT = Path(__file__).parent / "inside" / "decode.gd"
FILES = [
    f"{kind}.{layers}.{container}"
    for container, kind, layers in (
        *(("ktx2", kind, 1) for kind in ("RGBA16F", "RGB9E5", "BC6H")),
        *(("zstd.ktx2", kind, 1) for kind in ("RGBA16F", "RGB9E5", "BC6H")),
        *(("dds", kind, layers) for kind in ("RGBA16F", "BC6H") for layers in (1, 3)),
        *(
            (container, kind, 1)
            for container in ("ktx2", "zstd.ktx2", "dds")
            for kind in ("BC3", "BC4", "BC7")
        ),
    )
]


def light(layers: int) -> list[Floats]:
    """Mip levels (layers, H, W, 4) of half floats from about 0.01 to 100, smooth as bakes are, and alpha."""
    rng = np.random.default_rng(layers)
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    bright = np.exp(3 * np.sin(x / 11) * np.cos(y / 9) + np.sin((x + 2 * y) / 5))
    image = np.ones((layers, HEIGHT, WIDTH, 4))
    image[..., :3] = bright[..., None] * [1, 0.7, 0.4] * rng.uniform(0.9, 1.1, (layers, HEIGHT, WIDTH, 3))
    image[..., 3] = rng.uniform(0, 1, image.shape[:3])
    return [level.astype(np.float16).astype(np.float32) for level in mip_chain(image)]


def units(kind: PixelFormat) -> list[Floats]:
    """The same in 0..1, mip levels (H, W, C) with a format's channels."""
    return [np.clip(level[0, ..., : CHANNELS[kind]] / 100, 0, 1) for level in light(1)]


@pytest.fixture(scope="module")
def decoded(root: Root) -> dict[str, list[Floats]]:
    """Each file's mip levels (layers, H, W, 4) as Godot has them."""
    folder, inside = root.shared("textures")
    shutil.copy(SCRIPT, folder)
    (folder / "project.godot").write_text("config_version=5\n", encoding="utf-8")
    for name in FILES:
        kind, layers, container = name.split(".", 2)
        texture = (
            encode_units(units(PixelFormat(kind)), PixelFormat(kind))
            if PixelFormat(kind) in CHANNELS
            else encode_texture(light(int(layers)), PixelFormat(kind), is_array=layers != "1")
        )
        if container == "dds":
            write_texture(folder / name, texture)
        else:
            write_ktx2(folder / name, texture, zstd=container.startswith("zstd"))
    run_godot(
        root,
        [*RENDERERS["Forward+"], "--path", inside, "--script", "res://decode.gd", "--"]
        + [f"res://{name}" for name in FILES],
    )
    return {name: read(folder / f"{name}.floats", int(name.split(".")[1])) for name in FILES}


def read(path: Path, layers: int) -> list[Floats]:
    """The levels in a file of all layers' levels, one layer after the other."""
    sizes = [level.shape[1:] for level in light(1)]
    data = np.fromfile(path, np.float32).reshape(layers, -1)
    parts = np.split(data, np.cumsum([np.prod(size) for size in sizes])[:-1], axis=1)
    return [part.reshape(layers, *size) for part, size in zip(parts, sizes, strict=True)]


@pytest.mark.parametrize("name", [name for name in FILES if name.startswith("RGBA16F")])
def test_half_floats_are_exact(decoded: dict[str, list[Floats]], name: str) -> None:
    source = light(int(name.split(".")[1]))
    for ours, theirs in zip(source, decoded[name], strict=True):
        np.testing.assert_array_equal(theirs, ours)


@pytest.mark.parametrize("name", [name for name in FILES if name.startswith("RGB9E5")])
def test_shared_exponents_are_within_five_thousandths_of_a_stop(
    decoded: dict[str, list[Floats]], name: str
) -> None:
    """The greatest channel of each pixel; the others are off by no more than it."""
    worst = 0.0
    for ours, theirs in zip(light(1), decoded[name], strict=True):
        greatest = ours[..., :3].max(axis=-1)
        worst = max(worst, np.abs(np.log2(theirs[..., :3].max(axis=-1) / greatest)).max())
        assert (np.abs(theirs - ours)[..., :3] <= greatest[..., None] / 511).all()
    print(f"{name}: {worst:.4f} stops at most")
    assert worst <= 0.005


@pytest.mark.parametrize("name", [name for name in FILES if name.startswith("BC6H")])
def test_blocks_are_what_we_think_they_are(decoded: dict[str, list[Floats]], name: str) -> None:
    """Godot rounds a value on a block's line as its library likes: to one half float of our own decoder's."""
    source = light(int(name.split(".")[1]))
    expected = decode_texture(encode_texture(source, PixelFormat.BC6H, is_array=True))
    stops = np.log2(decoded[name][0][..., :3] / source[0][..., :3])
    print(f"{name}: {np.sqrt(np.mean(stops**2)):.4f} stops RMSE")
    for ours, theirs in zip(expected, decoded[name], strict=True):
        np.testing.assert_allclose(theirs[..., :3], ours, rtol=2**-10)
    assert np.sqrt(np.mean(stops**2)) < 0.1


@pytest.mark.parametrize("name", [name for name in FILES if name[:3] in ("BC3", "BC4", "BC7")])
def test_blocks_of_values_in_0_to_1_are_what_we_think_they_are(
    decoded: dict[str, list[Floats]], name: str
) -> None:
    """Godot's decoders round what lies between a block's ends to eight bits."""
    kind = PixelFormat(name.split(".", maxsplit=1)[0])
    ours = decode_units(encode_units(units(kind), kind))
    for expected, theirs in zip(ours, decoded[name], strict=True):
        off = np.abs(theirs[0, ..., : CHANNELS[kind]] - expected).max()
        assert off <= 2.5 / 255
