# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The web page's pictures of the other kinds, in a real Chromium, against the reference samplers'."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pytest

from radtex_addon.bake.layers import Layer
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.formats.bucket_files import read_layer
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.report.metrics import Picture
from radtex_addon.settings.spec import Kind, View
from tests.real.browser import Shown, decoded
from tests.real.exhibit import CAMERAS, Camera, decibels
from tests.real.kinds import LAYERS, KindBake, Sun
from tests.real.test_web_messages import within
from tests.real.web import Site, save

LEAST = 38.0  # dB
FRONT = CAMERAS[0]
LIT = (Kind.SHADOW, Kind.TRANSFER)  # by the page's sun


Bakes = Callable[..., KindBake]


def agreement(shown: Shown, expected: Picture, made: KindBake, camera: Camera) -> float:
    """Decibels between the page's light and the reference's, or between their alphas if those agree less."""
    found, mask = shown.pixels().astype(np.float64), made.eroded(camera)
    light = decibels(found[..., :3], expected[..., :3], mask)
    return min(light, decibels(found[..., 3:], expected[..., 3:], mask))


def compare(shown: Shown, made: KindBake, suns: tuple[Sun | None, ...], name: str) -> None:
    """Hold the page's pictures to the reference's: from a camera by each sun."""
    for sun, camera in zip(suns, (*CAMERAS, FRONT), strict=False):
        shown.set_camera(camera, sun)
        found = agreement(shown, made.seen(camera, sun), made, camera)
        print(f"{name}, {camera.name}, {sun}: {found:.1f} dB")
        assert found >= LEAST


def check_inspector(shown: Shown, made: KindBake) -> None:
    """Five clicks: each tells the light, the place in the bucket, and what the texel holds."""
    kind, sun = made.kind, Sun(-40, 45, strength=2)
    buffer, expected = made.buffer(FRONT), made.seen(FRONT, sun if kind in LIT else None)
    cells = made.cells.astype(np.float32)
    n, places = cells.shape[2], np.zeros((len(buffer.hit), 2))
    places[buffer.hit] = made.looked_up(buffer, sun)
    mask = made.eroded(FRONT)
    mask[:90] = False  # there are words
    rows, columns = np.nonzero(mask)
    shown.set_camera(FRONT, sun)
    for number in np.linspace(0, len(rows) - 1, 5).astype(int):
        row, column = int(rows[number]), int(columns[number])
        shown.page.mouse.click(column + 0.5, row + 0.5)
        found = shown.page.evaluate("([x, y]) => radtex.inspect(x, y)", [column + 0.5, row + 0.5])
        assert found["light"] == pytest.approx(expected[row, column], abs=0.03, rel=0.03)
        assert found["square"] == pytest.approx(places[row * FRONT.pixels + column], abs=1e-2)
        i, j = found["texel"]
        stored = decoded(found["bucket"]).reshape(n, n, 4)
        rounded = 1e-3 + cells[j, i].max(axis=-1, keepdims=True) / 500  # RGB9E5, by the greatest of three
        assert (np.abs(stored - cells[j, i]) <= rounded).all()
        assert shown.text("at-texel") == f"({i}, {j})"
        assert shown.text("way") == ("L" if kind in LIT else "I")
    shown.page.keyboard.press("Escape")


def layer_light(made: KindBake, layer: Layer) -> Picture:
    """The light (H, W, 3) of a layer as the reference looks it up; of the base with buckets of one cell."""
    facts, buffer = read_sidecar(made.sidecar), made.buffer(FRONT)
    layout = AtlasLayout(facts.width, facts.height, 1 if layer == Layer.BASE else facts.bucket)
    uv, incidence = buffer.uv[buffer.hit], buffer.incidence[buffer.hit]
    pixels = read_layer(made.sidecar, layer).astype(np.float32)
    light = buffer.spread(sample(pixels, layout, uv, incidence, Filter.QUADRILINEAR))
    return light.reshape(FRONT.pixels, FRONT.pixels, 3)


def check_layers(shown: Shown, made: KindBake) -> None:
    """One by one, and base and rest together, which are the whole."""
    mask, whole, names = made.eroded(FRONT), made.seen(FRONT), ["whole", *LAYERS, "sum"]
    assert shown.page.evaluate("radtex.layers()") == names
    shown.set_camera(FRONT)
    parts: dict[str, Picture] = {layer: layer_light(made, layer) for layer in LAYERS}
    parts |= {"whole": whole[..., :3], "sum": parts["base"] + parts["rest"]}
    for name, words in zip(names, ("Whole", "Base", "Rest", "Glossy", "Base + Rest"), strict=True):
        shown.page.get_by_role("button", name=words, exact=True).click()
        seen = shown.pixels().astype(np.float64)
        found = decibels(seen[..., :3], parts[name], mask)
        print(f"{name}: {found:.1f} dB")
        assert found >= LEAST
        assert decibels(seen[..., 3:], whole[..., 3:], mask) >= LEAST, "other alpha than the whole's"
    assert decibels(parts["sum"], whole[..., :3], mask) >= 60
    flat = shown.pixels(flat=True)[mask]
    assert 0.02 < flat[:, 3].min() < flat[:, 3].max() < 0.5, "a hull's flat lightmap hides what is behind"
    refusal = shown.page.evaluate("() => { try { radtex.setLayer('haze') } catch (e) { return e.message } }")
    assert refusal == "no layer haze: there are whole, base, rest, glossy, sum"
    shown.page.get_by_role("button", name="Whole", exact=True).click()


def test_a_proxy_shows_what_is_in_it_and_its_layers(web: Site, kind_bake: Bakes) -> None:
    made = kind_bake(Kind.PROXY)
    web.add("proxy", made, layers=LAYERS)
    with web.opened("proxy/", device_scale_factor=1) as shown:
        shown.wait().page.get_by_role("button", name="Quadrilinear").click()
        for camera in CAMERAS:
            shown.set_camera(camera)
            expected = made.seen(camera)
            found = agreement(shown, expected, made, camera)
            print(f"proxy, {camera.name}: {found:.1f} dB")
            assert found >= LEAST
            shown.still()
            screen = shown.screen()[: camera.pixels, : camera.pixels]
            empty = made.eroded(camera) & (expected[..., 3] < 1e-3)
            empty[:90] = False  # there are words
            assert empty.sum() > 500, "nothing is seen through the hull"
            background = screen[empty].max(axis=1)  # a hair's light may bleed by a texel
            assert np.quantile(background, 0.99) < 0.2, "no background is seen through the hull"
            assert background.max() < 0.35, "what is in the hull bleeds into the background"
        check_layers(shown, made)
        check_inspector(shown, made)


SUNS = (Sun(-40, 45), Sun(-40, 45, 30), Sun(110, 20, 8), Sun(0, 80, 90))
LIGHTS = (Sun(-40, 45, strength=3), Sun(180, 10, strength=5, colour="#ffc080"), Sun(90, -30, strength=2))


@pytest.mark.parametrize("cells", [5, 8, 12])
def test_shadows_fall_where_the_reference_has_them(web: Site, kind_bake: Bakes, cells: int) -> None:
    made = kind_bake(Kind.SHADOW, cells)
    web.add(f"shadow-{cells}", made)
    with web.opened(f"shadow-{cells}/") as shown:
        shown.wait()
        if cells == 8:
            save(shown, "shadow")
            check_controls(shown, own=["size"], others=["strength", "colour"])
        assert shown.page.locator("#filters").is_hidden()
        compare(shown, made, SUNS, f"{cells} x {cells} cells")
        if cells == 8:
            check_inspector(shown, made)


def test_ambient_occlusion_is_grey(web: Site, kind_bake: Bakes) -> None:
    made = kind_bake(Kind.AO)
    web.add("ao", made)
    with web.opened("ao/") as shown:
        shown.wait().page.get_by_role("button", name="Quadrilinear").click()
        assert shown.page.locator("#sun").is_hidden()
        compare(shown, made, (None,) * len(CAMERAS), "ao")
        assert 0 < made.seen(FRONT)[..., 0][made.eroded(FRONT)].min() < 0.5
        check_inspector(shown, made)


@pytest.mark.parametrize(
    ("view", "limit"),
    [(View.NORMAL, None), (View.AROUND, None), (View.NORMAL, 256), (View.AROUND, 1024)],
)
def test_transfer_answers_to_a_sun_of_any_direction_and_colour(
    web: Site, kind_bake: Bakes, view: View, limit: int | None
) -> None:
    """From before each texel and from around it, in one texture and in pages."""
    made, name = kind_bake(Kind.TRANSFER, view=view), f"transfer-{view}-{limit}"
    web.add(name, made, **({} if limit is None else {"limit": limit}))
    with web.opened(f"{name}/") as shown:
        shown.wait()
        plain = (view, limit) == (View.NORMAL, None)
        if plain:
            check_controls(shown, own=["strength", "colour"], others=["size"])
            shown.set_camera(FRONT, Sun(0, 45))
        compare(shown, made, LIGHTS, name)
        if plain:
            check_inspector(shown, made)


def check_controls(shown: Shown, own: list[str], others: list[str]) -> None:
    """The sliders move the sun; these are shown, the others are not."""
    page = shown.page
    shown.set_camera(FRONT)
    for setting in ["azimuth", "height", *own]:
        before, word = shown.pixels(), page.inner_text("#sun")
        if setting == "colour":
            page.locator("#sun-colour").fill("#ff0000")
            assert shown.pixels()[..., 1].max() == 0
        else:
            for _ in range(20):
                page.locator(f"#sun-{setting}").press("ArrowRight")
            assert page.inner_text("#sun") != word
        assert np.abs(shown.pixels() - before).max() > 0.05
    assert all(page.locator(f"#sun-{setting}").is_hidden() for setting in others)
    page.keyboard.press("]")
    assert shown.text("stops") == "+0.5 stops"


def test_dragging_with_shift_turns_the_sun(web: Site, kind_bake: Bakes) -> None:
    """And nothing else: the camera stays, no point is inspected, and the sliders follow."""
    web.add("shadow-8", kind_bake(Kind.SHADOW, 8))
    with web.opened("shadow-8/") as shown:
        shown.wait()
        page, mouse = shown.page, shown.page.mouse
        assert page.get_by_text("Shift-drag in the picture turns the sun").is_visible()
        place = "JSON.stringify([radtex.sun().azimuth, radtex.sun().height])"
        before, sun = shown.pixels(), json.loads(page.evaluate(place))
        mouse.move(200, 220)
        page.keyboard.down("Shift")
        mouse.down()
        mouse.move(300, 170, steps=2)
        mouse.up()
        page.keyboard.up("Shift")
        azimuth, height = json.loads(page.evaluate(place))
        assert (azimuth - sun[0], height - sun[1]) == pytest.approx((40, 20))
        assert page.locator("#sun-azimuth").input_value() == str(round(azimuth))
        assert page.locator("#sun-height").input_value() == str(round(height))
        after = shown.pixels()
        assert np.abs(after[..., :3] - before[..., :3]).max() > 0.05
        np.testing.assert_array_equal(after[..., 3] > 0, before[..., 3] > 0)  # nothing else has moved
        assert page.locator("body.inspecting").count() == 0
        page.evaluate("radtex.setSun({azimuth: 170})")
        page.keyboard.press("Shift+ArrowRight")
        page.keyboard.press("Shift+ArrowRight")
        page.keyboard.press("Shift+ArrowRight")
        assert page.evaluate("radtex.sun().azimuth") == pytest.approx(-175)  # all the way round
        mouse.move(200, 220)
        mouse.down()
        mouse.move(300, 170, steps=2)
        mouse.up()
        assert page.evaluate("radtex.sun().azimuth") == pytest.approx(-175)
        assert (shown.pixels()[..., 3] > 0).sum() != (after[..., 3] > 0).sum()  # without Shift it orbits


def test_a_phone_has_the_sun_among_its_settings(web: Site, kind_bake: Bakes) -> None:
    web.add("shadow-8", kind_bake(Kind.SHADOW, 8))
    with web.opened("shadow-8/", 360, 740, has_touch=True, is_mobile=True) as shown:
        shown.wait()
        shown.page.get_by_role("button", name="Settings").tap()
        within(shown)
        before = shown.pixels()
        shown.page.locator("#sun-azimuth").tap(position={"x": 250, "y": 12})
        assert np.abs(shown.pixels() - before).max() > 0.05
        shown.page.locator("#exposure").tap()  # by scrolling, if need be
