# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The web page's pictures in a real Chromium, against the reference sampler's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from radtex_addon.core.arrangements import fitting_levels
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.report.metrics import Mask, Picture
from radtex_addon.textures.export_spec import Arrangement, TextureFormat
from tests.real.browser import Shown
from tests.real.exhibit import CAMERAS, Camera, Exhibit, decibels
from tests.real.web import NO_BLOCKS, Site, save_light
from tests.reference.levels import level_chain, sample_level

LEAST = 38.0  # dB
LEAST_EXACT = 40.0  # of a layered bake that lost nothing when it was packed
ALIKE = 45.0  # dB between pictures of blocks that the device unpacks, and that the page does: to eight bits
LEAST_ABRUPT = 33.0  # where texels or cells end at an edge, and rasterisers know places to a part of a pixel
WORDS = {Filter.NEAREST: "Nearest", Filter.LINEAR: "Linear", Filter.QUADRILINEAR: "Quadrilinear"}
SETTINGS: dict[str, dict[str, Any]] = {"slices": {"arrangement": Arrangement.SLICES}, "pages": {"limit": 192}}


def seen(shown: Shown) -> Picture:
    """The page's linear light, as the reference's pictures have it."""
    return shown.pixels()[..., :3].astype(np.float64)


def agreement(shown: Shown, exhibit: Exhibit, form: str, camera: Camera, kind: Filter) -> float:
    """Decibels between the page's picture and the reference sampler's."""
    bake = getattr(exhibit, form)
    return decibels(seen(shown), bake.picture(camera, kind), bake.eroded(camera))


def test_filters_show_what_the_reference_says(web: Site, exhibit: Exhibit) -> None:
    web.add("plain", exhibit.plain)
    with web.opened("plain/") as shown:
        shown.wait()
        for camera in CAMERAS:
            shown.set_camera(camera)
            for kind, word in WORDS.items():
                shown.page.get_by_role("button", name=word, exact=True).click()
                found = {other: agreement(shown, exhibit, "plain", camera, other) for other in WORDS}
                print(f"{camera.name}, {kind}: {found[kind]:.1f} dB")
                assert found[kind] >= (LEAST if kind is Filter.QUADRILINEAR else LEAST_ABRUPT)
                assert max(found, key=lambda other: found[other]) is kind
            if camera is CAMERAS[0]:
                save_light(seen(shown), "plain")  # the last filter's: quadrilinear
        check_levels(shown, exhibit, "plain")


@pytest.mark.parametrize("form", ["slices", "pages"])
def test_other_layouts_show_what_the_reference_says(web: Site, exhibit: Exhibit, form: str) -> None:
    web.add(form, exhibit.plain, **SETTINGS[form])
    with web.opened(f"{form}/") as shown:
        shown.wait().page.get_by_role("button", name="Quadrilinear").click()
        for camera in CAMERAS:
            shown.set_camera(camera)
            found = agreement(shown, exhibit, "plain", camera, Filter.QUADRILINEAR)
            print(f"{form}, {camera.name}: {found:.1f} dB")
            assert found >= LEAST
        if form == "slices":
            check_levels(shown, exhibit, form)


def layered(web: Site, exhibit: Exhibit, name: str, before: str = "", **settings: Any) -> list[Picture]:
    """What the page shows of the layered bake from each camera."""
    web.add(name, exhibit.layered, **settings)
    found = []
    with web.opened(f"{name}/", before=before) as shown:
        shown.wait()
        for camera in CAMERAS:
            shown.set_camera(camera)
            found.append(seen(shown))
    return found


def test_blocks_lose_little_and_a_device_without_them_shows_the_same(web: Site, exhibit: Exhibit) -> None:
    """Of the layered bake: half floats, blocks that the device unpacks, and blocks that the page does."""
    exact = layered(web, exhibit, "halves", format=TextureFormat.KTX2_RGBA16F)
    blocks, unpacked = (layered(web, exhibit, "layered", before) for before in ("", NO_BLOCKS))
    save_light(blocks[0], "layered")
    for number, camera in enumerate(CAMERAS):
        wanted, mask = exhibit.layered.picture(camera), exhibit.layered.eroded(camera)
        found, lost = (decibels(each[number], wanted, mask) for each in (exact, blocks))
        alike = decibels(unpacked[number], blocks[number], mask)
        print(f"{camera.name}: half floats {found:.1f} dB, blocks {lost:.1f} dB, unpacked {alike:.1f} dB")
        assert found >= LEAST_EXACT
        assert lost >= LEAST
        assert alike >= ALIKE


def check_levels(shown: Shown, exhibit: Exhibit, form: str) -> None:
    """Levels change what is far and leave what is near."""
    far = Camera("far", (9.7, -20.3, 5.1), pixels=128)
    reference, mask = far_picture(exhibit, far)
    near, found = [], []
    for word in ("Quadrilinear", "Levels"):
        shown.page.get_by_role("button", name=word).click()
        shown.set_camera(Camera("close", (0.4, -1.3, 0.3), pixels=128))
        near.append(shown.pixels())
        shown.set_camera(far)
        found.append(decibels(seen(shown), reference, mask))
    print(f"{form}, far away: {found[0]:.1f} dB without levels, {found[1]:.1f} dB with")
    assert found[1] > found[0] + 2  # slices are filtered anisotropically, which the reference is not
    assert np.quantile(np.abs(near[1] - near[0]), 0.9) < 1e-3


def far_picture(exhibit: Exhibit, camera: Camera) -> tuple[Picture, Mask]:
    """The reference's picture with levels, and where it holds: quads of pixels within one island."""
    buffer, size = exhibit.plain.buffer(camera), camera.pixels
    pixels, facts = read_atlas(exhibit.plain.finished.images[0])
    layout = AtlasLayout(facts.width, facts.height, facts.bucket)
    uv = buffer.uv.reshape(size // 2, 2, size // 2, 2, 2) * [facts.width, facts.height]
    across = np.repeat(np.abs(uv[:, :, :, 1] - uv[:, :, :, 0])[:, :, :, None], 2, axis=3)
    up = np.repeat(np.abs(uv[:, 1] - uv[:, 0])[:, None], 2, axis=1)
    longer = np.maximum(np.linalg.norm(across, axis=-1), np.linalg.norm(up, axis=-1)).reshape(size, size)
    chain = level_chain(pixels, layout, fitting_levels(layout))
    level = np.log2(np.maximum(longer, 1)).ravel()
    light = np.zeros((size * size, 3))
    hit = buffer.hit
    light[hit] = sample_level(chain, layout, buffer.uv[hit], buffer.incidence[hit], level[hit])[:, :3]
    whole = exhibit.plain.eroded(camera).reshape(size // 2, 2, size // 2, 2).all(axis=(1, 3))
    mask = np.repeat(np.repeat(whole, 2, 0), 2, 1) & (longer < 8)
    return light.reshape(size, size, 3), mask
