# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The npm package radtex-three: packed, installed, and used by the page of docs/three.md in Chromium."""

from __future__ import annotations

import json
import re
import shutil
import tomllib
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radtex_addon.report.metrics import Picture
from tests.real.browser import Shown, decoded
from tests.real.exhibit import CAMERAS, Camera, Exhibit, decibels
from tests.real.root import REPOSITORY
from tests.real.web import NO_BLOCKS, SOURCES, Site, aces, encoded, node

INSIDE = REPOSITORY / "tests/real/inside"
GUIDE = REPOSITORY / "docs/three.md"
FRONT = CAMERAS[0]
LEAST = 38.0  # dB against the reference
SAME = 55.0  # dB between two ways to draw the same light: rasterisers know places to a part of a pixel
PHONE = {"has_touch": True, "is_mobile": True, "device_scale_factor": 2}
# A turn about an oblique axis, a mirror-free scale, and a move.
CHANGE = [[0.0, -1.5, 0.0, 2.0], [1.5, 0.0, 0.0, -1.0], [0.0, 0.0, 1.5, 0.7], [0.0, 0.0, 0.0, 1.0]]


@dataclass(frozen=True)
class App:
    """The page of the guide, opened with a bake."""

    shown: Shown

    def ready(self) -> App:
        self.shown.page.wait_for_function("window.app && window.checks", timeout=60_000)
        self.shown.page.evaluate("async () => { await window.app }")
        return self

    def light(self, check: str, camera: Camera, *further: Any, wide: int = 1) -> Picture:
        """A picture's linear light (H, W, 3), rows from the top."""
        made = self.shown.page.evaluate(
            "([check, view, further]) => checks[check](view, ...further)",
            [check, Shown.view(camera), list(further)],
        )
        return decoded(made).reshape(camera.pixels, wide * camera.pixels, 4)[::-1, :, :3].astype(np.float64)


def blocks_of(guide: str, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", guide, re.DOTALL)


@pytest.fixture(scope="module")
def packed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the packed package and three.js installed, and the guide's page."""
    folder = tmp_path_factory.mktemp("three")
    npm = ("npm", "--loglevel=error")
    told = json.loads(node(*npm, "pack", "--json", f"--pack-destination={folder}"))
    facts = next(iter(told.values())) if isinstance(told, dict) else told[0]
    names = {file["path"] for file in facts["files"]}
    assert {"package.json", "README.md", "LICENSE", "dist/radtex-three.js", "dist/types/index.d.ts"} <= names
    assert "dist/LICENSES.txt" in names  # of what the bundle holds
    assert not {name for name in names if name.startswith(("src/", "page/", "node_modules/"))}
    print(f"npm pack: {facts['size']} bytes, {len(names)} files")
    version = json.loads((SOURCES / "package.json").read_text())["devDependencies"]["three"]
    (folder / "package.json").write_text('{"private": true, "type": "module"}')
    tarball = folder / Path(facts["filename"]).name
    installing = ("--no-audit", "--no-fund", "--ignore-scripts", "--no-package-lock")
    node(
        *npm,
        "install",
        f"--prefix={folder}",
        *installing,
        str(tarball),
        f"three@{version}",
        f"@types/three@{version}",
    )
    guide = GUIDE.read_text(encoding="utf-8")
    (folder / "app.js").write_text(blocks_of(guide, "js")[0])
    shutil.copyfile(INSIDE / "three_checks.js", folder / "three_checks.js")
    (folder / "both.js").write_text('import "./app.js";\nimport "./three_checks.js";\n')
    return folder


@pytest.fixture(scope="module")
def bundled(packed: Path) -> Path:
    """The page's script as a bundler makes it, with what the tests ask."""
    script = packed / "bundled.js"
    node(
        *("npx", "esbuild", str(packed / "both.js"), "--bundle", "--format=esm", "--minify"),
        *(f"--outfile={script}", "--log-level=error"),
    )
    return script


@contextmanager
def opened(
    web: Site, exhibit: Exhibit, form: str, script: Path, before: str = "", **context: Any
) -> Iterator[App]:
    folder = web.add(form, getattr(exhibit, form))
    (manifest,) = folder.glob("*.export.json")
    shutil.copyfile(script, folder / script.name)
    (folder / "app.html").write_text(
        f'<!doctype html><body></body><script type="module" src="{script.name}"></script>'
    )
    with web.opened(f"{form}/app.html?bake={manifest.name}", before=before, **context) as shown:
        yield App(shown).ready()


@pytest.fixture(scope="module")
def app(web: Site, exhibit: Exhibit, bundled: Path) -> Iterator[Callable[[str], App]]:
    """The page with a bake in each form, which stays open: who changes its scene for good opens another."""
    with ExitStack() as pages:
        yield cache(lambda form: pages.enter_context(opened(web, exhibit, form, bundled)))


FORMS = pytest.mark.parametrize("form", ["plain", "layered"])


def compare(app: App, exhibit: Exhibit, form: str, device: str) -> None:
    bake = getattr(exhibit, form)
    for camera in CAMERAS:
        found = decibels(app.light("one", camera), bake.picture(camera), bake.eroded(camera))
        print(f"{form}, {device}, {camera.name}: {found:.1f} dB")
        assert found >= LEAST


@FORMS
def test_the_guides_page_shows_the_bake(app: Callable[[str], App], exhibit: Exhibit, form: str) -> None:
    compare(app(form), exhibit, form, "desktop")


@FORMS
def test_a_phone_without_blocks_shows_it(web: Site, exhibit: Exhibit, bundled: Path, form: str) -> None:
    with opened(web, exhibit, form, bundled, NO_BLOCKS, width=360, height=740, **PHONE) as phone:
        compare(phone, exhibit, form, "phone")


def add_guide(folder: Path, packed: Path) -> None:
    """Put the guide's page without a bundler into a served folder, as modules.html."""
    (page,) = blocks_of(GUIDE.read_text(encoding="utf-8"), "html")
    (folder / "modules.html").write_text(page.replace('src="app.js"', 'src="both.js"'))
    for name in ("app.js", "both.js", "three_checks.js"):
        shutil.copyfile(packed / name, folder / name)
    if not (folder / "node_modules").exists():
        (folder / "node_modules").symlink_to(packed / "node_modules")


def test_a_missing_bake_is_said_where_one_sees_it(web: Site, packed: Path) -> None:
    folder = web.folder / "no-bake"
    folder.mkdir()
    add_guide(folder, packed)
    with web.opened("no-bake/modules.html?bake=None.export.json") as shown:
        shown.page.wait_for_function("document.body.innerText.includes('None.export.json')")
        top, bottom = shown.page.evaluate("""() => {
            const range = document.createRange();
            range.selectNodeContents(document.body);
            const words = [...range.getClientRects()].at(-1);
            return [words.top, words.bottom];
        }""")
        assert 0 <= top < bottom <= 500, "below the window's edge, on a page that does not scroll"


def test_it_runs_without_a_bundler(web: Site, exhibit: Exhibit, packed: Path) -> None:
    folder = web.add("plain", exhibit.plain)
    (manifest,) = folder.glob("*.export.json")
    add_guide(folder, packed)
    with web.opened(f"plain/modules.html?bake={manifest.name}") as shown:
        seen = App(shown).ready().light("one", FRONT)
    bake = exhibit.plain
    assert decibels(seen, bake.picture(FRONT), bake.eroded(FRONT)) >= LEAST


@FORMS
def test_three_js_moves_it_instances_it_and_gives_each_eye_its_own_light(
    app: Callable[[str], App], exhibit: Exhibit, form: str
) -> None:
    page, mask = app(form), getattr(exhibit, form).eroded(FRONT)
    one = page.light("one", FRONT)
    flat_change = np.array(CHANGE).ravel().tolist()
    for check in ("moved", "instance"):
        found = decibels(page.light(check, FRONT, flat_change), one, mask)
        print(f"{form}, {check}: {found:.1f} dB")
        assert found >= SAME
    other = CAMERAS[1]
    both = page.light("eyes", FRONT, Shown.view(other), wide=2)
    left, right = both[:, : FRONT.pixels], both[:, FRONT.pixels :]
    second = page.light("one", other)
    each = decibels(left, one, mask), decibels(right, second, getattr(exhibit, form).eroded(other))
    print(f"{form}, eyes: {each[0]:.1f} and {each[1]:.1f} dB")
    assert min(each) >= SAME


def test_an_orthographic_camera_sees_what_a_far_one_does(app: Callable[[str], App], exhibit: Exhibit) -> None:
    away, side = 95.0, 1.5
    place = (0.6 * away, -0.8 * away, 0.0)
    far = Camera("far", place, target=(0.0, 0.0, 0.0), fovy=2 * float(np.degrees(np.arctan(side / away))))
    plain = app("plain")
    found = decibels(
        plain.light("orthographic", far, side), plain.light("one", far), exhibit.plain.eroded(far)
    )
    print(f"orthographic: {found:.1f} dB")
    assert found >= 30


def test_tone_mapping_and_fog_are_three_js_s(app: Callable[[str], App], exhibit: Exhibit) -> None:
    plain, mask = app("plain"), exhibit.plain.eroded(FRONT)
    light = plain.light("one", FRONT)
    nothing = plain.light("fog", FRONT, 0.001, 0.002)
    assert nothing[mask].max() < 1e-4
    half = plain.light("fog", FRONT, 0.0, 20.0)[mask] / np.maximum(light[mask], 1e-3)
    assert 0.2 < np.median(half) < 0.999
    seen = plain.light("one", FRONT, True)[mask]
    wanted = encoded(aces(light[mask]))
    assert np.quantile(np.abs(seen - wanted).max(axis=-1), 0.9) < 0.02


def test_clipping_planes_are_three_js_s(app: Callable[[str], App]) -> None:
    """A plane above all that there is leaves nothing, one below it everything, one between the upper part."""
    plain = app("plain")
    whole = plain.light("one", FRONT)
    for local in (False, True):
        assert plain.light("clipped", FRONT, -50.0, local).max() == 0
        assert np.array_equal(plain.light("clipped", FRONT, 50.0, local), whole)
        seen = plain.light("clipped", FRONT, 0.0, local).max(axis=(1, 2)) > 0
        assert seen[: len(seen) // 3].any()
        assert not seen[-len(seen) // 4 :].any()


def test_three_js_s_own_loader_takes_the_textures(app: Callable[[str], App], web: Site) -> None:
    """All but BC6H, which its KTX2Loader does not know."""
    page = app("layered").shown.page
    (manifest,) = (web.folder / "layered").glob("*.export.json")
    entries = json.loads(manifest.read_text())["textures"].values()
    files = {entry["file"]: entry["format"] for entry in entries}
    said = page.evaluate("files => checks.stock(files)", list(files))
    print({file: (files[file], said[file]) for file in files})
    assert {files[file] for file, error in said.items() if error} <= {"BC6H"}


def test_textures_stay_while_an_object_shows_them(web: Site, exhibit: Exhibit, bundled: Path) -> None:
    """Also by a copy of the material."""
    with opened(web, exhibit, "plain", bundled) as page:
        one = page.light("one", FRONT)
        assert np.array_equal(page.light("shared", FRONT), one)


@FORMS
def test_lamps_add_their_light(web: Site, exhibit: Exhibit, bundled: Path, form: str) -> None:
    """The same bake as a lamp: with its own light at 1/2 and the lamp's at 2 there is 2.5 times as much."""
    with opened(web, exhibit, form, bundled) as page:
        mask = getattr(exhibit, form).eroded(FRONT)
        one = page.light("one", FRONT)
        page.shown.page.evaluate("checks.addLamp()")
        found = decibels(page.light("one", FRONT) / 2.5, one, mask)
        print(f"{form}, lamps: {found:.1f} dB")
        assert found >= SAME


def test_a_material_without_a_second_lobe_looks_none_up(
    app: Callable[[str], App], web: Site, exhibit: Exhibit
) -> None:
    page = app("layered").shown.page
    (manifest,) = web.add("layered", exhibit.layered).glob("*.export.json")
    facts = json.loads(manifest.read_text())["shader"]
    lobes = [np.array(each["radtex_lobes"]) for each in facts["materials"]]
    wanted = [bool(each[len(each) // 2 :, :3].any()) for each in lobes]
    print(wanted, facts["defines"])
    assert page.evaluate("checks.secondLobes()") == wanted


def test_far_triangles_are_drawn_first_and_none_is_lost(packed: Path) -> None:
    script = packed / "far_first.mjs"
    node(
        *("npx", "esbuild", str(INSIDE / "far_first_checks.js"), "--bundle", "--format=esm"),
        "--platform=node",
        *("--alias:three=./node_modules/three/build/three.module.js", "--alias:far_first=./src/far_first.ts"),
        *(f"--outfile={script}", "--log-level=error"),
    )
    assert json.loads(node("node", str(script))) == {"lost": 0, "disordered": 0}


def test_types_are_found_by_typescript(packed: Path) -> None:
    (packed / "typed.ts").write_text(
        'import { loadRadTex, type RadTexObject, RadTexMirror } from "radtex-three";\n'
        'const { object, complete } = await loadRadTex("a.json", { lamps: { key: "b.json" } });\n'
        "await complete;\n"
        'const ours: RadTexObject = object; ours.lamps.get("key")?.set("#ffcc88");\n'
        "ours.add(new RadTexMirror(ours, ours.filter));\n"
        "ours.setSun({ azimuth: 30 }); const bytes: number = ours.memory.gpu; console.log(bytes);\n"
    )
    for resolution in ("bundler", "nodenext"):
        module = "esnext" if resolution == "bundler" else "nodenext"
        node(
            *("npx", "tsc", "--noEmit", "--ignoreConfig", "--strict", "--target", "es2022", "--skipLibCheck"),
            *("--module", module, "--moduleResolution", resolution, "--lib", "es2023,dom,dom.iterable"),
            str(packed / "typed.ts"),
        )


def test_its_version_is_the_extensions() -> None:
    manifest = tomllib.loads((REPOSITORY / "blender_manifest.toml").read_text(encoding="utf-8"))
    assert json.loads((SOURCES / "package.json").read_text())["version"] == manifest["version"]
    assert (SOURCES / "LICENSE").read_text() == (REPOSITORY / "shaders/LICENSE").read_text()
