# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The web page's pictures of the other kinds, in a real Chromium, against the reference samplers'."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.bake.spec import Kind, View
from radtex_addon.report.metrics import Picture
from tests.real.browser import Shown, decoded
from tests.real.exhibit import CAMERAS, Camera, decibels
from tests.real.kinds import SPECS, KindBake, Sun, baked
from tests.real.test_web_messages import within
from tests.real.web import Site, save

LEAST = 38.0  # dB
FRONT = CAMERAS[0]
LIT = (Kind.SHADOW, Kind.TRANSFER)  # by the page's sun


@pytest.fixture(scope="session")
def bake(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., KindBake]:
    """Bakes by kind and cells, made when they are first asked for."""
    folder = tmp_path_factory.mktemp("kinds")
    return lambda kind, cells=None: baked(kind, folder / f"{kind}{cells or SPECS[kind].bucket}", cells)


@contextmanager
def on_the_page(web: Site, made: KindBake) -> Iterator[Shown]:
    """The page that shows this bake."""
    name = Path(made.folder).name
    web.add(name, made)
    with web.opened(f"{name}/") as shown:
        yield shown.wait()


def agreement(shown: Shown, expected: Picture, made: KindBake, camera: Camera) -> float:
    """Decibels between the page's light and the reference's, or between their alphas if those agree less."""
    found, mask = shown.pixels().astype(np.float64), made.eroded(camera)
    light = decibels(found[..., :3], expected[..., :3], mask)
    return min(light, decibels(found[..., 3:], expected[..., 3:], mask))


def set_sun(shown: Shown, sun: Sun) -> None:
    shown.page.evaluate("sun => radtex.setSun(sun)", asdict(sun))


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.name)
def test_a_proxy_shows_what_is_in_it(web: Site, bake: Callable[..., KindBake], camera: Camera) -> None:
    made = bake(Kind.PROXY)
    with on_the_page(web, made) as shown:
        shown.page.get_by_role("button", name="Quadrilinear").click()
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


SUNS = (Sun(-40, 45), Sun(-40, 45, 30), Sun(110, 20, 8), Sun(0, 80, 90))


@pytest.mark.parametrize("cells", [5, 8, 12])
def test_shadows_fall_where_the_reference_has_them(
    web: Site, bake: Callable[..., KindBake], cells: int
) -> None:
    made = bake(Kind.SHADOW, cells)
    with on_the_page(web, made) as shown:
        if cells == 8:
            save(shown, "shadow")
        assert shown.page.locator("#filters").is_hidden()
        for sun, camera in zip(SUNS, (*CAMERAS, FRONT), strict=True):
            set_sun(shown, sun)
            shown.set_camera(camera)
            found = agreement(shown, made.seen(camera, sun), made, camera)
            print(f"{cells} x {cells} cells, sun of {sun.size} degrees, {camera.name}: {found:.1f} dB")
            assert found >= LEAST


def test_ambient_occlusion_is_grey(web: Site, bake: Callable[..., KindBake]) -> None:
    made = bake(Kind.AO)
    with on_the_page(web, made) as shown:
        shown.page.get_by_role("button", name="Quadrilinear").click()
        for camera in CAMERAS:
            shown.set_camera(camera)
            found = agreement(shown, made.seen(camera), made, camera)
            print(f"ao, {camera.name}: {found:.1f} dB")
            assert found >= LEAST
        assert 0 < made.seen(FRONT)[..., 0][made.eroded(FRONT)].min() < 0.5


LIGHTS = (Sun(-40, 45, strength=3), Sun(180, 10, strength=5, colour="#ffc080"), Sun(90, -30, strength=2))


def test_transfer_answers_to_a_sun_of_any_direction_and_colour(
    web: Site, bake: Callable[..., KindBake]
) -> None:
    made = bake(Kind.TRANSFER)
    with on_the_page(web, made) as shown:
        for sun, camera in zip(LIGHTS, CAMERAS, strict=True):
            set_sun(shown, sun)
            shown.set_camera(camera)
            found = agreement(shown, made.seen(camera, sun), made, camera)
            print(f"transfer, {camera.name}: {found:.1f} dB")
            assert found >= LEAST


@pytest.mark.parametrize(("view", "limit"), [(View.AROUND, None), (View.NORMAL, 256), (View.AROUND, 1024)])
def test_transfer_from_around_and_in_pages(
    web: Site, tmp_path_factory: pytest.TempPathFactory, view: View, limit: int | None
) -> None:
    made = baked(Kind.TRANSFER, tmp_path_factory.getbasetemp() / f"transfer-{view}", view=view)
    name = f"transfer-{view}-{limit}"
    web.add(name, made, **({} if limit is None else {"limit": limit}))
    with web.opened(f"{name}/") as shown:
        shown.wait()
        for sun, camera in zip(LIGHTS, CAMERAS, strict=True):
            set_sun(shown, sun)
            shown.set_camera(camera)
            found = agreement(shown, made.seen(camera, sun), made, camera)
            print(f"transfer, {view}, {limit}, {camera.name}: {found:.1f} dB")
            assert found >= LEAST


@pytest.mark.parametrize("kind", [Kind.PROXY, Kind.SHADOW, Kind.AO, Kind.TRANSFER])
def test_the_inspector_shows_what_the_texel_holds(
    web: Site, bake: Callable[..., KindBake], kind: Kind
) -> None:
    made, sun = bake(kind), Sun(-40, 45, strength=2)
    buffer, expected = made.buffer(FRONT), made.seen(FRONT, sun if kind in LIT else None)
    cells = made.cells.astype(np.float32)
    n, places = cells.shape[2], np.zeros((len(buffer.hit), 2))
    places[buffer.hit] = made.looked_up(buffer, sun)
    mask = made.eroded(FRONT)
    mask[:90] = False  # there are words
    rows, columns = np.nonzero(mask)
    with on_the_page(web, made) as shown:
        set_sun(shown, sun)
        shown.set_camera(FRONT)
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


@pytest.mark.parametrize("kind", [Kind.SHADOW, Kind.TRANSFER])
def test_the_suns_controls_move_it(web: Site, bake: Callable[..., KindBake], kind: Kind) -> None:
    made = bake(kind)
    with on_the_page(web, made) as shown:
        page = shown.page
        parts = [["size"], ["strength", "colour"]]
        own, others = parts if kind is Kind.SHADOW else parts[::-1]
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


@pytest.mark.parametrize("kind", [Kind.SHADOW, Kind.TRANSFER])
def test_dragging_with_shift_turns_the_sun(web: Site, bake: Callable[..., KindBake], kind: Kind) -> None:
    """And nothing else: the camera stays, no point is inspected, and the sliders follow."""
    web.add(f"dragged-{kind}", bake(kind))
    with web.opened(f"dragged-{kind}/", 900, 500) as shown:
        shown.wait()
        page, mouse = shown.page, shown.page.mouse
        assert page.get_by_text("Shift-drag in the picture turns the sun").is_visible()
        place = "JSON.stringify([radtex.sun().azimuth, radtex.sun().height])"
        before, sun = shown.pixels(), json.loads(page.evaluate(place))
        mouse.move(200, 220)
        page.keyboard.down("Shift")
        mouse.down()
        mouse.move(300, 170, steps=5)
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
        mouse.move(300, 170, steps=5)
        mouse.up()
        assert page.evaluate("radtex.sun().azimuth") == pytest.approx(-175)
        assert (shown.pixels()[..., 3] > 0).sum() != (after[..., 3] > 0).sum()  # without Shift it orbits


def test_a_phone_has_the_sun_among_its_settings(web: Site, bake: Callable[..., KindBake]) -> None:
    web.add("phone", bake(Kind.SHADOW))
    with web.opened("phone/", 360, 740, has_touch=True, is_mobile=True) as shown:
        shown.wait()
        shown.page.get_by_role("button", name="Settings").tap()
        within(shown)
        before = shown.pixels()
        shown.page.locator("#sun-azimuth").tap(position={"x": 250, "y": 12})
        assert np.abs(shown.pixels() - before).max() > 0.05
        shown.page.locator("#exposure").tap()  # by scrolling, if need be


def test_other_kinds_have_no_sun(web: Site, bake: Callable[..., KindBake]) -> None:
    with on_the_page(web, bake(Kind.AO)) as shown:
        assert shown.page.locator("#sun").is_hidden()
