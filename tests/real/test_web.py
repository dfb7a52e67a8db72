# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The web page in a real Chromium: each switch by real clicks and keys, and the inspector."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator

import numpy as np
import pytest
from PIL import Image

from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.hemisphere import direction_to_square
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.report.metrics import Mask
from tests.real.browser import Shown
from tests.real.exhibit import CAMERAS, Camera, Exhibit
from tests.real.web import Site, aces, encoded, save

FRONT = CAMERAS[0]
MOST = 0.02  # of the screen's white: 8 bits, twice rounded
HEADER = 90  # pixels at the top that words may cover
FREE = slice(0, 340), slice(0, 420)  # rows and columns of the window that no card covers


@pytest.fixture(scope="module")
def opened(web: Site, exhibit: Exhibit) -> Iterator[Shown]:
    """The plain bake, on the screen."""
    web.add("plain", exhibit.plain)
    with web.opened("plain/", device_scale_factor=1) as shown:
        yield shown.wait()


@pytest.fixture
def shown(opened: Shown) -> Shown:
    """The same page as it was at first, but that a camera that a script has set stays."""
    opened.page.keyboard.press("Escape")
    opened.page.keyboard.press("r")
    opened.page.evaluate("radtex.setExposure(0); radtex.setTone('none'); radtex.setDivider(null)")
    opened.still()
    return opened


def far_off(picture: Floats, other: Floats) -> float:
    """How far pixels are from each other, but for the tenth that lies at edges, which the screen smooths."""
    return float(np.quantile(np.abs(picture - other).max(axis=-1), 0.9))


def on_object(exhibit: Exhibit, camera: Camera) -> Mask:
    """Pixels of the head that no words cover."""
    mask = exhibit.plain.eroded(camera).copy()
    mask[:HEADER] = False
    return mask


def test_dragging_orbits_and_reset_goes_back(shown: Shown) -> None:
    first = shown.screen()
    mouse = shown.page.mouse
    mouse.move(215, 250)
    mouse.down()
    mouse.move(330, 235, steps=5)
    mouse.up()
    shown.still()
    assert np.abs(shown.screen() - first).mean() > 0.01
    assert shown.page.locator("#inspector").is_hidden()  # it was no click
    mouse.wheel(0, -400)
    shown.still()
    shown.page.get_by_role("button", name="Reset").click()
    shown.still()
    assert far_off(shown.screen(), first) < MOST


def test_keys_orbit_too(shown: Shown) -> None:
    first = shown.pixels()
    for key in ("ArrowRight", "ArrowUp", "+"):
        before = shown.pixels()
        shown.page.keyboard.press(key)
        shown.still()
        assert np.abs(shown.pixels() - before).max() > 0.05
    shown.page.keyboard.press("r")
    shown.still()
    assert np.allclose(shown.pixels(), first, atol=1e-3)


def test_turning_moves_until_it_is_switched_off(shown: Shown) -> None:
    turn = shown.page.get_by_role("button", name="Turn")
    before = shown.pixels()
    turn.click()
    shown.page.wait_for_function("document.getElementById('rate').textContent.includes('frames/s')")
    turn.click()
    shown.still()
    assert np.abs(shown.pixels() - before).max() > 0.05


def test_compare_draws_the_flat_lightmap_beside(shown: Shown) -> None:
    page, before = shown.page, shown.screen()
    page.get_by_role("button", name="Compare").click()
    shown.still()
    divider = page.locator("#divider").bounding_box()
    assert divider is not None
    middle = round(divider["x"] + divider["width"] / 2)
    beside, change = 40, np.abs(shown.screen() - before)[FREE]
    assert change[:, : middle - beside].max() < MOST
    assert change[:, middle + beside :].mean() > 0.01
    save(shown, "compare")
    page.mouse.move(middle, 220)
    page.mouse.down()
    page.mouse.move(middle - 150, 220, steps=4)
    page.mouse.up()
    moved = page.locator("#divider").bounding_box()
    assert moved is not None
    assert moved["x"] == pytest.approx(divider["x"] - 150, abs=1)
    page.locator("#divider").press("Home")
    shown.still()
    flat = encoded(shown.pixels(flat=True)[..., :3])
    covered = shown.pixels()[..., 3] == 1
    covered[:HEADER] = covered[340:] = covered[:, :beside] = covered[:, 420:] = False
    inner = covered & np.roll(covered, 2, 0) & np.roll(covered, -2, 0) & np.roll(covered, 2, 1)
    inner &= np.roll(covered, -2, 1)
    assert far_off(shown.screen()[inner], flat[inner]) < MOST


def test_a_click_opens_the_inspector_and_orbiting_moves_its_cell(shown: Shown) -> None:
    page = shown.page
    page.mouse.click(212, 250)
    shown.still()
    texel, place, direction = (shown.text(name) for name in ("at-texel", "at-uv", "at-incidence"))
    save(shown, "inspector")
    for _ in range(4):
        page.keyboard.press("ArrowLeft")
    shown.still()
    assert (shown.text("at-texel"), shown.text("at-uv")) == (texel, place)
    assert shown.text("at-incidence") != direction
    page.mouse.click(12, 250)
    assert page.locator("#inspector").is_hidden()  # nothing is there


def test_tone_curves_and_exposure(shown: Shown, exhibit: Exhibit) -> None:
    page = shown.page
    shown.set_camera(FRONT)
    mask = on_object(exhibit, FRONT)
    light = shown.pixels()[..., :3][mask]

    def seen() -> Floats:
        shown.still()
        return shown.screen()[: FRONT.pixels, : FRONT.pixels][mask]

    assert far_off(seen(), encoded(light)) < MOST
    for _ in range(10):
        page.locator("#exposure").press("ArrowRight")
    assert shown.text("stops") == "+1.0 stops"
    assert far_off(seen(), encoded(2 * light)) < MOST
    for key in "[[":
        page.keyboard.press(key)
    assert shown.text("stops") == "0.0 stops"
    curves = {}
    for word in ("ACES", "AgX", "Neutral"):
        page.get_by_role("button", name=word).click()
        assert page.locator("#tones [aria-pressed=true]").inner_text() == word
        curves[word] = seen()
    assert far_off(curves["Neutral"], encoded(khronos_neutral(light))) < MOST
    assert far_off(curves["ACES"], encoded(aces(light))) < MOST
    assert min(far_off(curves["AgX"], curves[other]) for other in ("ACES", "Neutral")) > 2 * MOST


def khronos_neutral(light: Floats) -> Floats:
    """The PBR Neutral tone mapper, as Khronos specifies it."""
    start, desaturation = 0.8 - 0.04, 0.15
    least = light.min(axis=1, keepdims=True)
    colour = light - np.where(least < 0.08, least - 6.25 * least * least, 0.04)
    peak = colour.max(axis=1, keepdims=True)
    compressed = 1 - (1 - start) ** 2 / (peak + 1 - 2 * start)
    grey = 1 - 1 / (desaturation * (peak - compressed) + 1)
    bright: Floats = colour * compressed / np.maximum(peak, 1e-9) * (1 - grey) + compressed * grey
    return np.where(peak < start, colour, bright)


def test_the_inspector_shows_the_bucket_under_a_click(shown: Shown, exhibit: Exhibit) -> None:
    shown.set_camera(FRONT)
    shown.page.set_viewport_size({"width": 1000, "height": 700})  # where a cell is large; the canvas stays
    buffer = exhibit.plain.buffer(FRONT)
    pixels, facts = read_atlas(exhibit.plain.finished.images[0])
    layout = AtlasLayout(facts.width, facts.height, facts.bucket)
    buckets = layout.to_buckets(pixels.astype(np.float32))[..., :3]
    rows, columns = np.nonzero(on_object(exhibit, FRONT))
    for number in np.linspace(0, len(rows) - 1, 5).astype(int):
        row, column = int(rows[number]), int(columns[number])
        shown.page.mouse.click(column + 0.5, row + 0.5)
        place = row * FRONT.pixels + column
        uv = buffer.uv[place]
        square = direction_to_square(buffer.incidence[place][None])[0]
        found = shown.page.evaluate("([x, y]) => radtex.inspect(x, y)", [column + 0.5, row + 0.5])
        assert found["uv"] == pytest.approx(uv, abs=1e-3)
        assert found["square"] == pytest.approx(square, abs=5e-3)
        i, j = found["texel"]
        assert np.abs(np.array([i, j]) + 0.5 - uv * [facts.width, facts.height]).max() < 0.6
        p, q = found["cell"]
        assert np.abs(np.array([p, q]) + 0.5 - (square + 1) / 2 * facts.bucket).max() < 0.6
        assert shown.text("at-texel") == f"({i}, {j})"
        assert shown.text("at-cell").startswith(f"({p}, {q})")
        assert_pictured(shown, encoded(buckets[j, i]), (p, q))
    shown.page.keyboard.press("Escape")
    assert shown.page.locator("#inspector").is_hidden()


def assert_pictured(shown: Shown, cells: Floats, marked: tuple[int, int]) -> None:
    """The canvas shows these cells (n, n, 3), row 0 below, and frames the marked one."""
    address = shown.page.evaluate("document.getElementById('bucket').toDataURL()")
    image = Image.open(io.BytesIO(base64.b64decode(address.partition(",")[2]))).convert("RGB")
    picture = np.asarray(image, dtype=np.float32)[::-1] / 255
    n, side = len(cells), len(picture) // len(cells)
    tiles = picture.reshape(n, side, n, side, 3).swapaxes(1, 2)
    middle = tiles[:, :, side // 4 : -side // 4, side // 4 : -side // 4].reshape(n, n, -1, 3)
    assert np.abs(np.median(middle, axis=2) - cells).max() < MOST
    p, q = marked
    assert (tiles[q, p][:, :1] > 0.98).mean() > 0.7  # its left edge
