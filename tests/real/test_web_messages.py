# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the web page says where it cannot show the object, and how it stands on a small screen."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Route

from tests.real.browser import Shown, tab_of
from tests.real.exhibit import Exhibit
from tests.real.root import Root
from tests.real.web import Site, save

# What a smaller device says, where this machine's own is asked.
SMALL_TEXTURES = """
    const asked = WebGL2RenderingContext.prototype.getParameter;
    WebGL2RenderingContext.prototype.getParameter = function (name) {
        return name === this.MAX_TEXTURE_SIZE ? 256 : asked.call(this, name);
    };
"""
# As Chromium answers with --disable-3d-apis.
NO_WEBGL = "HTMLCanvasElement.prototype.getContext = () => null;"


Spoil = Callable[[Path], None]


def says(shown: Shown, *words: str) -> None:
    """The message is there, with these words, and nothing else is in its way."""
    shown.page.locator("#message").wait_for(state="visible", timeout=20_000)
    message = shown.page.locator("#message").inner_text()
    for word in words:
        assert word in message
    assert shown.page.locator("#cards").is_hidden()


@pytest.fixture
def copied(web: Site, exhibit: Exhibit) -> Iterator[Path]:
    """A copy of the plain export, to be spoilt."""
    folder = web.folder / "spoilt"
    shutil.copytree(web.add("plain", exhibit.plain), folder)
    yield folder
    shutil.rmtree(folder)


def changed(folder: Path, change: Callable[[dict[str, Any]], None]) -> None:
    """The manifest with a change."""
    (path,) = folder.glob("*.export.json")
    facts = json.loads(path.read_text())
    change(facts)
    path.write_text(json.dumps(facts))


def lost(ending: str) -> Spoil:
    return lambda folder: next(folder.glob(f"*{ending}")).unlink()


def cut(ending: str) -> Spoil:
    def spoil(folder: Path) -> None:
        (path,) = folder.glob(f"*{ending}")
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])

    return spoil


def noise(folder: Path) -> None:
    (path,) = folder.glob("*.ktx2")
    data = bytearray(path.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 999] = bytes(999)
    path.write_bytes(data)


def another(**facts: Any) -> Spoil:
    return lambda folder: changed(folder, lambda manifest: manifest.update(facts))


SPOILT: dict[str, tuple[Spoil, tuple[str, ...]]] = {
    "no manifest": (lost(".export.json"), (".export.json is missing", "one folder")),
    "no texture": (lost(".radiance.ktx2"), (".radiance.ktx2 is missing", "one folder")),
    "no mesh": (lost(".glb"), (".glb is missing", "one folder")),
    "half a texture": (cut(".radiance.ktx2"), (".radiance.ktx2", "export", "damaged")),
    "half a mesh": (cut(".glb"), (".glb", "export", "damaged")),
    "half a manifest": (cut(".export.json"), (".export.json", "export", "no manifest")),
    "noise in a texture": (noise, (".ktx2 is damaged", "does not unpack")),
    "a texture that is not the manifest's": (
        lambda folder: changed(folder, lambda facts: facts["textures"]["radiance"].update(size=[64, 64])),
        (".ktx2 is damaged", "pixels"),
    ),
    "a newer manifest": (
        another(version=2, tool="RadTex 9.0"),
        ("is of version 2, this page reads version 1", "RadTex 9.0"),
    ),
    "a kind that the page does not show": (
        lambda folder: changed(folder, lambda facts: facts["bake"].update(kind="smell")),
        ("of kind “smell”, which this page does not show", "take the page"),
    ),
}


@pytest.mark.parametrize("what", SPOILT)
def test_what_is_wrong_with_the_files_is_said(web: Site, copied: Path, what: str) -> None:
    spoil, words = SPOILT[what]
    name = next(copied.glob("*.export.json")).name.removesuffix(".export.json")
    spoil(copied)
    with web.opened("spoilt/") as shown:
        says(shown, *words, name)


def test_a_page_without_a_bake_says_how_to_name_one(web: Site, copied: Path) -> None:
    page = copied / "index.html"
    (manifest,) = copied.glob("*.export.json")
    page.write_text(page.read_text().replace(f'content="{manifest.name}"', 'content=""'))
    with web.opened("spoilt/") as shown:
        says(shown, "which bake", "?bake=")
    with web.opened(f"spoilt/?bake={manifest.name}") as shown:
        shown.wait()


def test_a_device_that_cannot_take_a_texture_shows_the_flat_lightmap_and_says_why(
    web: Site, copied: Path
) -> None:
    with web.opened("spoilt/", before=SMALL_TEXTURES) as shown:
        shown.wait()
        notice = shown.text("notice")
        assert "takes 256 a side at most" in notice
        assert "--limit 256" in notice
        assert np.array_equal(shown.pixels(), shown.pixels(flat=True))
        assert shown.page.evaluate("radtex.inspect(innerWidth / 2, innerHeight / 2)") is None
        assert shown.pixels().max() > 0.1


def test_the_flat_lightmap_is_seen_before_the_textures_come(web: Site, copied: Path) -> None:
    """The texture's answer is held back until the page was looked at."""
    with web.opened("plain/") as shown:
        shown.wait()
        whole = shown.screen()
    with web.opened("spoilt/index.html?bake=none.export.json") as shown:
        held: list[Route] = []

        def hold(route: Route) -> None:
            held.append(route)

        shown.page.route("**/*.ktx2", hold)
        shown.page.goto(f"{web.address}/spoilt/")
        shown.page.locator("body.refining").wait_for()
        first = shown.screen()
        for route in held:
            route.continue_()
        shown.page.unroute("**/*.ktx2", hold)  # which lets those go that came meanwhile
        shown.wait()
        assert np.abs(first - whole).mean() < np.abs(whole - whole[0, 0]).mean(), "it shows the object"
        assert np.abs(first - whole).mean() > 0.002, "as its flat lightmap"
        assert np.abs(shown.screen() - whole).mean() < 0.001


def test_a_lost_graphics_device_comes_back(web: Site, copied: Path) -> None:
    with web.opened("spoilt/") as shown:
        before = shown.wait().pixels()
        look = "radtex.inspect(innerWidth / 3, innerHeight / 2)"
        inspected = shown.page.evaluate(look)
        shown.page.evaluate("""async () => {
            const canvas = document.getElementById("view");
            const lost = new Promise((done) => canvas.addEventListener("webglcontextlost", done));
            window.device = canvas.getContext("webgl2").getExtension("WEBGL_lose_context");
            window.device.loseContext();
            await lost;
        }""")
        shown.page.locator("body.refining").wait_for()
        shown.page.evaluate("device.restoreContext()")
        shown.page.locator("body:not(.refining)").wait_for()
        shown.still()
        assert np.allclose(shown.pixels(), before, atol=1e-3)
        assert max(inspected["light"][:3]) > 0
        assert np.allclose(shown.page.evaluate(look)["light"], inspected["light"], atol=1e-3)


def test_the_object_alone_is_shown_in_a_frame_of_another_page(web: Site, copied: Path) -> None:
    with web.opened("spoilt/?ui=0") as shown:
        shown.wait()
        assert shown.page.locator("header, aside, #divider").filter(visible=True).count() == 0
        assert shown.pixels().max() > 0.1


def test_two_lamps_of_one_name_are_refused(web: Site, copied: Path) -> None:
    with web.opened("spoilt/?lamp=a/Vase.key.export.json&lamp=b/Vase.key.export.json") as shown:
        says(shown, "Two lamps", "the name Vase.key", "?lamp=Key=Vase.key.export.json")


def test_a_browser_without_webgl_is_told(web: Site, copied: Path) -> None:
    with web.opened("spoilt/", before=NO_WEBGL) as shown:
        says(shown, "no WebGL 2", "hardware acceleration")


@pytest.mark.parametrize("alone", [False, True], ids=["in its folder", "as from a zip that was not unpacked"])
def test_a_double_click_says_what_to_do(root: Root, web: Site, copied: Path, alone: bool) -> None:
    folder, inside = root.shared("double-click")
    for path in copied.glob("index.html" if alone else "*.*"):
        shutil.copy(path, folder)
    page = tab_of(web.browser)
    page.goto(f"file://{inside}/index.html")
    says(Shown(page), "Show in Browser in Blender", "python -m http.server", "in this folder")
    assert page.locator("body > *:visible").count() == 1, "the message and nothing else"


def test_a_phone_has_all_of_it_by_taps(web: Site, exhibit: Exhibit) -> None:
    web.add("plain", exhibit.plain)
    with web.opened("plain/", 360, 740, has_touch=True, is_mobile=True, device_scale_factor=2) as shown:
        shown.wait()
        page = shown.page
        assert page.locator("#panel").is_hidden()
        page.get_by_role("button", name="Settings").tap()
        page.get_by_role("button", name="Nearest").tap()
        assert page.locator("#filters [aria-pressed=true]").inner_text() == "Nearest"
        within(shown)
        page.get_by_role("button", name="Settings").tap()
        shown.still()
        page.touchscreen.tap(170, 300)
        page.locator("#inspector").wait_for(state="visible")
        shown.still()
        within(shown)
        save(shown, "phone")
        page.get_by_role("button", name="Close the inspector").tap()
        page.get_by_role("button", name="Help").tap()
        page.locator("#help").wait_for(state="visible")
        within(shown)
        page.get_by_role("button", name="Close", exact=True).tap()
        assert page.locator("#help").is_hidden()


@pytest.mark.parametrize("form", ["plain", "layered"])
def test_the_help_is_about_what_is_shown(web: Site, exhibit: Exhibit, form: str) -> None:
    web.add(form, getattr(exhibit, form))
    with web.opened(f"{form}/") as shown:
        page = shown.wait().page
        page.keyboard.press("?")
        page.locator("#help").wait_for(state="visible")
        said, keys = page.locator("#about").inner_text(), page.locator("#filter-keys")
        filters = page.locator("#filters button").count()
        if form == "plain":
            assert "Each texel holds a bucket" in said
            assert keys.inner_text().split() == ["1", "to", str(filters), "filter"]
        else:
            assert "bucket" not in said
            assert "surroundings" in said
            assert (filters, keys.is_hidden()) == (1, True)


def within(shown: Shown) -> None:
    """No button and no card lies beyond the screen, and none is too small for a finger."""
    boxes = shown.page.evaluate("""
        [...document.querySelectorAll("button, section, nav, dialog")]
            .filter((each) => each.checkVisibility())
            .map((each) => [each.id || each.textContent, each.tagName, each.getBoundingClientRect().toJSON()])
    """)
    size = shown.page.viewport_size
    assert size is not None
    assert len(boxes) > 5
    for name, tag, box in boxes:
        assert box["left"] >= 0, name
        assert box["right"] <= size["width"], name
        assert box["bottom"] <= size["height"], name
        assert tag != "BUTTON" or box["height"] >= 36, name
