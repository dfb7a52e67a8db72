# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layered bakes in blocks in a real Chromium: what they lose, and devices that know no blocks."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from radtex_addon.report.metrics import Picture
from radtex_addon.textures.export_spec import TextureFormat
from tests.real.browser import Shown
from tests.real.exhibit import CAMERAS, Exhibit, decibels
from tests.real.web import Site

PLAIN, BLOCKS = 40.0, 38.0  # dB against the reference, uncompressed and in blocks
ALIKE = 45.0  # dB between pictures of blocks that the device unpacks, and that the page does: to eight bits
NO_BLOCKS = """
    const asked = WebGL2RenderingContext.prototype.getExtension;
    WebGL2RenderingContext.prototype.getExtension = function (name) {
        return /bptc|rgtc|s3tc/.test(name) ? null : asked.call(this, name);
    };
    const upload = WebGL2RenderingContext.prototype.compressedTexSubImage2D;
    WebGL2RenderingContext.prototype.compressedTexSubImage2D = function () {
        throw new Error("this device knows no blocks");
    };
"""


def pictures(web: Site, exhibit: Exhibit, name: str, before: str = "", **settings: Any) -> Iterator[Picture]:
    """The page's linear light from each camera."""
    web.add(name, exhibit.layered, **settings)
    with web.opened(f"{name}/", before=before) as shown:
        shown.wait()
        yield from (seen(shown, number) for number in range(len(CAMERAS)))


def seen(shown: Shown, number: int) -> Picture:
    shown.set_camera(CAMERAS[number])
    return shown.pixels()[..., :3].astype(np.float64)


@pytest.fixture(scope="module")
def packed(web: Site, exhibit: Exhibit) -> list[Picture]:
    """With blocks that the device unpacks."""
    return list(pictures(web, exhibit, "layered"))


def test_pictures_are_the_references(web: Site, exhibit: Exhibit, packed: list[Picture]) -> None:
    """Uncompressed ones nearly so; blocks lose little."""
    plain = list(pictures(web, exhibit, "halves", format=TextureFormat.KTX2_RGBA16F))
    for camera, exact, blocks in zip(CAMERAS, plain, packed, strict=True):
        wanted, mask = exhibit.layered.picture(camera), exhibit.layered.eroded(camera)
        found, lost, between = (
            decibels(exact, wanted, mask),
            decibels(blocks, wanted, mask),
            decibels(blocks, exact, mask),
        )
        print(
            f"{camera.name}: half floats {found:.1f} dB, blocks {lost:.1f} dB, between them {between:.1f} dB"
        )
        assert found >= PLAIN
        assert lost >= BLOCKS


def test_a_device_without_blocks_shows_the_same(web: Site, exhibit: Exhibit, packed: list[Picture]) -> None:
    """The page unpacks them."""
    for camera, ours, theirs in zip(
        CAMERAS, pictures(web, exhibit, "layered", NO_BLOCKS), packed, strict=True
    ):
        found = decibels(ours, theirs, exhibit.layered.eroded(camera))
        print(f"{camera.name}: {found:.1f} dB")
        assert found >= ALIKE
