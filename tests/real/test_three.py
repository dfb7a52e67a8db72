# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The npm package radtex-three: packed, installed, and used by the page of docs/three.md in Chromium."""

from __future__ import annotations

import functools
import http.server
import io
import json
import re
import shutil
import struct
import subprocess
import threading
import tomllib
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from PIL import Image

from radtex_addon.export.gltf import EXTENSION, UNLIT
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.report.metrics import Picture
from radtex_addon.settings.spec import Kind
from tests.real.browser import Shown, decoded
from tests.real.exhibit import CAMERAS, Bake, Camera, Exhibit, decibels
from tests.real.kinds import KindBake
from tests.real.mirror_scene import SKY
from tests.real.root import REPOSITORY
from tests.real.test_web_bytes import WHOLE
from tests.real.web import NO_BLOCKS, SOURCES, Site, aces, encoded, exported, node

INSIDE = REPOSITORY / "tests/real/inside"
GUIDE = REPOSITORY / "docs/three.md"
FRONT = CAMERAS[0]
FAR = Camera("far", (12.0, -40.0, 12.0), target=(12.0, 0.0, 0.0))
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

    def ask(self, check: str, camera: Camera, *further: Any) -> Any:
        """What a check gives that takes a camera."""
        return self.shown.page.evaluate(
            "([check, view, further]) => checks[check](view, ...further)",
            [check, Shown.view(camera), list(further)],
        )

    def failing(self, address: str, settings: dict[str, Any], ending: str | None = None) -> dict[str, Any]:
        """What a load says that cannot succeed."""
        said: dict[str, Any] = self.shown.page.evaluate(
            "([address, settings, ending]) => checks.failing(address, settings, ending)",
            [address, settings, ending],
        )
        return said

    def light(self, check: str, camera: Camera, *further: Any, wide: int = 1) -> Picture:
        """A picture's linear light (H, W, 3), rows from the top."""
        return picture(self.ask(check, camera, *further), camera, wide)


def picture(made: str, camera: Camera, wide: int = 1) -> Picture:
    """Linear light (H, W, 3) of what a check gives, rows from the top."""
    return decoded(made).reshape(camera.pixels, wide * camera.pixels, 4)[::-1, :, :3].astype(np.float64)


def blocks_of(guide: str, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", guide, re.DOTALL)


def examples_of(guide: str) -> str:
    """A script with the guide's examples after its page, each a function of the page's object and scene."""
    examples = blocks_of(guide, "js")[1:]
    used = {line for example in examples for line in example.splitlines() if line.startswith("import ")}
    names: dict[str, set[str]] = {}
    for line in used:
        listed, module = re.fullmatch(r'import \{ (.*) \} from "(.*)";', line).groups()  # type: ignore[union-attr]
        names.setdefault(module, set()).update(listed.split(", "))
    imports = [f'import {{ {", ".join(sorted(found))} }} from "{module}";' for module, found in names.items()]
    bodies = [re.sub(r"^import .*\n", "", example, flags=re.MULTILINE) for example in examples]
    functions = [f"async (object, scene) => {{\n{body}}}" for body in bodies]
    return "\n".join([*imports, f"window.examples = [{', '.join(functions)}];"])


@pytest.fixture(scope="module")
def packed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the packed package and three.js installed, and the guide's page."""
    folder = tmp_path_factory.mktemp("three")
    npm = ("npm", "--loglevel=error")
    told = json.loads(node(*npm, "pack", "--json", f"--pack-destination={folder}"))
    facts = next(iter(told.values())) if isinstance(told, dict) else told[0]
    names = {file["path"] for file in facts["files"]}
    assert {"package.json", "README.md", "LICENSE", "dist/radtex-three.js", "dist/types/index.d.ts"} <= names
    assert {"dist/gltf-transform.js", "dist/types/gltf_transform.d.ts"} <= names
    assert {"dist/webgpu.js", "dist/webgpu.bundle.js", "dist/types/webgpu.d.ts"} <= names
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
    (folder / "examples.js").write_text(examples_of(guide))
    (folder / "both.js").write_text(
        'import "./app.js";\nimport "./three_checks.js";\nimport "./examples.js";\n'
    )
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
    with opened_in(web, web.add(form, getattr(exhibit, form)), script, before, **context) as page:
        yield page


@contextmanager
def opened_in(web: Site, folder: Path, script: Path, before: str = "", **context: Any) -> Iterator[App]:
    """The page with an export in a folder of the site."""
    (manifest,) = folder.glob("*.export.json")
    shutil.copyfile(script, folder / script.name)
    (folder / "app.html").write_text(
        f'<!doctype html><body></body><script type="module" src="{script.name}"></script>'
    )
    with web.opened(f"{folder.name}/app.html?bake={manifest.name}", before=before, **context) as shown:
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
    for name in ("app.js", "both.js", "examples.js", "three_checks.js"):
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
    """The same bake as a lamp: with its own light at 1/2 and the lamp's at 2 there is 2.5 times as much.

    A clone has its own lamps: of 3 there, 3.5 times.
    """
    with opened(web, exhibit, form, bundled) as page:
        mask = getattr(exhibit, form).eroded(FRONT)
        one = page.light("one", FRONT)
        page.shown.page.evaluate("checks.addLamp()")
        found = decibels(page.light("one", FRONT) / 2.5, one, mask)
        cloned = decibels(page.light("cloneOfMixed", FRONT) / 3.5, one, mask)
        print(f"{form}, lamps: {found:.1f} dB, cloned {cloned:.1f} dB")
        assert min(found, cloned) >= SAME
        before, after = page.ask("instancesOfMixed", FRONT)
        assert decibels(picture(before, FRONT) / 2.5, one, mask) >= SAME
        assert after == before, "instances keep the lamps' light when the device was lost"


@FORMS
def test_a_clone_shows_the_same_in_another_place(
    app: Callable[[str], App], exhibit: Exhibit, form: str
) -> None:
    """Also of a group that holds the object, and one that was made while textures were loading."""
    page, mask = app(form), getattr(exhibit, form).eroded(FRONT)
    one = page.light("one", FRONT)
    assert decibels(page.light("cloned", FRONT, np.array(CHANGE).ravel().tolist()), one, mask) >= SAME
    assert np.array_equal(page.light("cloneOfLoading", FRONT), one)
    facts = page.shown.page.evaluate("checks.shares()")
    assert facts == {
        "geometry": True,
        "textures": True,
        "own": [1, 1, 1, 0],
        "transparent": [False] * len(facts["transparent"]),
        "kept": "kept",
        "again": 3,
    }


def test_the_last_clone_frees_what_all_share(app: Callable[[str], App]) -> None:
    """By three.js's own counts, which the textures of a bake are among."""
    facts = app("layered").ask("counted", FRONT)
    without, both, alone, freed = facts["counts"]
    print(facts["counts"], len(facts["own"]))
    assert both[0] - without[0] >= len(facts["own"])
    assert both[1] > without[1]
    assert (alone, freed) == (both, without)


@FORMS
def test_tint_exposure_and_opacity_do_what_they_say(
    app: Callable[[str], App], exhibit: Exhibit, form: str
) -> None:
    page, mask = app(form), getattr(exhibit, form).eroded(FRONT)
    one = page.light("one", FRONT)
    tint = np.array([0.5, 0.25, 2.0])
    for settings, factor in (
        ({"tint": tint.tolist()}, tint),
        ({"exposure": 3}, 3.0),
        ({"own": [0.5, 0.5, 0.5]}, 0.5),
        ({"own": [0.5, 0.5, 0.5], "tint": tint.tolist(), "exposure": 4}, 2 * tint),
    ):
        assert np.allclose(page.light("looking", FRONT, settings), factor * one, rtol=1e-5, atol=1e-6)
    assert page.light("looking", FRONT, {"opacity": 0}).max() == 0
    faded = page.light("looking", FRONT, {"opacity": 0.25, "tint": tint.tolist()}, 0.8)
    wanted = 0.25 * tint * one + 0.75 * 0.8
    found = decibels(faded, wanted, mask)
    by_material = {"opacity": 0.25, "tint": tint.tolist(), "exposure": 1}
    again = decibels(page.light("lookingByMaterial", FRONT, by_material, 0.8), wanted, mask)
    print(f"{form}, opacity: {found:.1f}, by the material {again:.1f} dB")
    assert min(found, again) >= SAME


@FORMS
def test_instances_have_colours_and_opacities(app: Callable[[str], App], exhibit: Exhibit, form: str) -> None:
    page, mask = app(form), getattr(exhibit, form).eroded(FRONT)
    one = page.light("one", FRONT)
    colour = np.array([0.5, 0.25, 2.0])
    assert decibels(page.light("tinted", FRONT, colour.tolist()), colour * one, mask) >= SAME
    solid, none = [*colour.tolist(), 1], [1, 1, 1, 0]
    seen = page.light("batched", FRONT, solid, none, True, 0)
    assert decibels(seen, colour * one, mask) >= SAME
    half, far = [*colour.tolist(), 0.5], [2, 0, 0, 1]
    faded = page.light("batched", FRONT, half, none, True, 0.8)
    found = decibels(faded, 0.5 * colour * one + 0.5 * 0.8, mask)
    print(f"{form}, faded instance: {found:.1f} dB")
    assert found >= 25
    pictures = [page.light("batched", FRONT, half, far, first, 0.8) for first in (True, False)]
    assert np.array_equal(pictures[0], pictures[1]), "drawn in the order that they were made in"
    assert decibels(pictures[0], faded, mask) < 25, "the far one is seen through the near one"


def test_it_is_small_as_json(app: Callable[[str], App]) -> None:
    facts = app("layered").shown.page.evaluate("checks.written()")
    print(facts)
    assert facts.pop("bytes") < 4000
    assert facts.pop("address").endswith(".export.json")
    assert facts == {
        "place": 3,
        "name": facts["name"],
        "children": 1,
        "own": [1, 1, 1],
        "tint": [0.5, 1, 1],
        "exposure": 1,
        "opacity": 1,
    }


@FORMS
def test_it_comes_back_by_itself_after_the_device_was_lost(
    web: Site, exhibit: Exhibit, bundled: Path, form: str
) -> None:
    with opened(web, exhibit, form, bundled) as page:
        one = page.light("one", FRONT)
        facts = page.ask("lost", FRONT)
        assert np.array_equal(picture(facts["again"], FRONT), one)
        assert np.array_equal(picture(facts["instances"], FRONT), one)
        assert (facts["flat"], facts["both"], facts["problem"]) == (0, True, None)
        assert facts["textures"] > 0
        assert not [line for line in facts["told"] if "RadTex" in line]


def test_a_mirror_ball_is_cloned_with_its_object_and_comes_back_with_it(
    web: Site, exhibit: Exhibit, bundled: Path
) -> None:
    folder = web.add("with-mirror", exhibit.plain, mirror=True, sky=SKY)
    with opened_in(web, folder, bundled) as page:
        facts = page.ask("ball", FRONT)
    assert "await complete" in facts["early"]
    without, before, cloned, after = (
        picture(facts[name], FRONT) for name in ("bare", "one", "cloned", "after")
    )
    assert np.abs(before - without).max() > 0.05
    assert np.array_equal(cloned, before)
    assert np.array_equal(after, before)


ODD = {
    "page.export.json": (
        "<!doctype html><title>My app</title>",
        "is missing",
        "web page in its place",
        "public",
    ),
    "large.export.json": (
        "version https://git-lfs.github.com/spec/v1\noid sha256:0\n",
        "Git LFS",
        "git lfs pull",
    ),
    "nothing.export.json": ("", "is empty", "export again"),
    "100%.export.json": ("{", "100%.export.json is no manifest", "no JSON"),
    "Head.radiance.json": ('{"version": 1, "kind": "radiance", "layout": "buckets"}', "is a bake", "Export"),
    "Head.gltf": ('{"asset": {"version": "2.0"}}', "is a glTF", "plugin radtex"),
}


@pytest.mark.parametrize("name", ODD)
def test_what_is_taken_for_an_export_is_named(app: Callable[[str], App], web: Site, name: str) -> None:
    page = app("plain")
    content, *words = ODD[name]
    folder = web.folder / "odd"
    folder.mkdir(exist_ok=True)
    (folder / name).write_text(content)
    said = page.failing(f"../odd/{name.replace('%', '%25') if name.startswith('1') else name}", {})
    print(said)
    assert said["name"] == "Problem"
    for word in (name, *words):
        assert word in f"{said['message']} {said['remedy']}"


def test_a_wrong_number_is_named_with_its_place(app: Callable[[str], App], web: Site) -> None:
    page = app("plain")
    facts = json.loads(next((web.folder / "plain").glob("*.export.json")).read_text())
    facts["textures"]["radiance"]["size"] = [0, 4]
    folder = web.folder / "odd"
    folder.mkdir(exist_ok=True)
    (folder / "Number.export.json").write_text(json.dumps(facts))
    said = page.failing("../odd/Number.export.json", {})
    print(said)
    for word in ("Number.export.json", '"size" is [0,4]', "two whole numbers", "in the texture “radiance”"):
        assert word in said["message"]
    assert "is no address" in page.failing("http://", {})["message"]


def test_a_second_renderer_is_refused_without_an_end_of_frames(
    web: Site, exhibit: Exhibit, bundled: Path
) -> None:
    with opened(web, exhibit, "plain", bundled) as page:
        facts = page.ask("twoRenderers", FRONT)
    print(facts["told"], facts["problem"])
    assert facts["before"] == facts["after"]
    (said,) = facts["told"]
    assert "Suzanne.radiance.ktx2" in said
    assert "Load the bake once for each renderer" in said
    assert "another renderer" in facts["problem"]
    assert facts["thrown"]["name"] == "Problem"
    assert facts["errors"] == [0, 0]


@FORMS
def test_webgpu_renderer_shows_the_flat_lightmap_and_says_why(
    web: Site, exhibit: Exhibit, bundled: Path, form: str
) -> None:
    with opened(web, exhibit, form, bundled) as page:
        flat = page.light("flatly", FRONT)
        facts = page.ask("webgpu", FRONT)
    said = [line for line in facts["told"] if "WebGPURenderer" in line]
    print(facts["told"])
    assert len(said) == 1
    assert "Load it with `nodes` of radtex-three/webgpu" in said[0]
    assert "WebGPURenderer" in facts["problem"]
    found = decibels(picture(facts["light"], FRONT), flat, getattr(exhibit, form).eroded(FRONT))
    print(f"{form}, WebGPURenderer: {found:.1f} dB")
    assert found >= 35


TINT = [0.5, 0.25, 2.0]
LOOK = {"own": [0.5, 0.5, 0.5], "tint": TINT, "exposure": 4}
AS_MOVED = np.array(CHANGE).ravel().tolist()


@FORMS
@pytest.mark.parametrize("gpu", [True, False], ids=["WebGPU", "WebGL 2"])
def test_webgpu_renderer_draws_it_by_nodes(
    web: Site, exhibit: Exhibit, bundled: Path, form: str, gpu: bool
) -> None:
    """As WebGLRenderer does: moved, multiplied, faded, of instances and batches, in fog, by any camera."""
    ways: list[dict[str, Any]] = [
        {},
        {"change": AS_MOVED},
        {"look": LOOK},
        {"kind": "material", "look": LOOK},
        {"kind": "instances", "colour": TINT, "change": AS_MOVED},
        {"kind": "batch", "colour": TINT, "change": AS_MOVED},
        {"fog": [0.0, 20.0]},
        {"side": 1.5},
        {"look": {"opacity": 0}},
        {"look": {"opacity": 0.5}, "backdrop": 0.8},
    ]
    with opened(web, exhibit, form, bundled) as page:
        one = page.light("one", FRONT)
        wanted = [one, one, 2 * np.array(TINT) * one, 2 * np.array(TINT) * one, *[np.array(TINT) * one] * 2]
        wanted += [page.light("fog", FRONT, 0.0, 20.0), page.light("orthographic", FRONT, 1.5), 0 * one]
        wanted.append(0.5 * one + 0.5 * 0.8)
        facts = page.ask("byNodes", FRONT, gpu, ways)
    print(facts["told"], facts["counts"], facts["textures"])
    assert facts["gpu"] == gpu
    assert not facts["told"]
    assert facts["counts"][0] - facts["counts"][1] >= facts["textures"]
    mask = getattr(exhibit, form).eroded(FRONT)
    for way, made, reference in zip(ways, facts["pictures"], wanted, strict=True):
        found = decibels(picture(made, FRONT), reference, mask | ("side" in way))
        print(f"{form}, WebGPU {gpu}, {way}: {found:.1f} dB")
        assert found >= 45


@pytest.mark.parametrize("gpu", [True, False], ids=["WebGPU", "WebGL 2"])
def test_nodes_show_materials_by_their_images(web: Site, crate: Bake, bundled: Path, gpu: bool) -> None:
    with opened_in(web, web.add("crate", crate), bundled) as page:
        one = page.light("one", FRONT)
        facts = page.ask("byNodes", FRONT, gpu, [{}])
    assert not facts["told"]
    found = decibels(picture(facts["pictures"][0], FRONT), one, crate.eroded(FRONT))
    print(f"crate, WebGPU {gpu}: {found:.1f} dB")
    assert found >= 45


@FORMS
@pytest.mark.parametrize("gpu", [True, False], ids=["WebGPU", "WebGL 2"])
def test_nodes_show_textures_that_were_loaded_once_more(
    web: Site, exhibit: Exhibit, bundled: Path, form: str, gpu: bool
) -> None:
    """Also of instances and copies of the material; and the whole light, after a layer that WGSL lacks."""
    with opened(web, exhibit, form, bundled) as page:
        one = page.light("one", FRONT)
        facts = page.ask("nodesLater", FRONT, gpu)
    print(facts["layer"], facts["problem"], facts["told"])
    mask = getattr(exhibit, form).eroded(FRONT)
    for name, made in facts["pictures"].items():
        found = decibels(picture(made, FRONT), one, mask)
        print(f"{form}, WebGPU {gpu}, {name}: {found:.1f} dB")
        assert found >= 45
    refused = gpu and facts["layer"] != "whole"
    assert bool(facts["problem"]) == refused
    assert len(facts["told"]) == refused
    assert facts["after"] is None


@pytest.mark.parametrize("gpu", [True, False], ids=["WebGPU", "WebGL 2"])
def test_nodes_say_what_wgsl_cannot_show(web: Site, exhibit: Exhibit, bundled: Path, gpu: bool) -> None:
    """Lamps: by WebGPU the flat lightmap stays, with a reason; by WebGL 2 they are shown."""
    with opened(web, exhibit, "layered", bundled) as page:
        wanted = page.light("flatly", FRONT) if gpu else 2 * page.light("one", FRONT)
        facts = page.ask("byNodes", FRONT, gpu, [{"lamp": True}])
    found = decibels(picture(facts["pictures"][0], FRONT), wanted, exhibit.layered.eroded(FRONT))
    print(facts["told"], f"{found:.1f} dB")
    assert found >= 45
    assert len(facts["told"]) == gpu
    for line in facts["told"]:
        assert "no WGSL for lamps" in line
        assert "forceWebGL" in line


@pytest.mark.parametrize("kind", [Kind.SHADOW, Kind.TRANSFER, Kind.AO])
@pytest.mark.parametrize("gpu", [True, False], ids=["WebGPU", "WebGL 2"])
def test_nodes_show_other_kinds(
    web: Site, kind_bake: Callable[..., KindBake], bundled: Path, kind: Kind, gpu: bool
) -> None:
    """WGSL has none of those that a sun lights: the flat lightmap stays, with a reason."""
    made = kind_bake(kind)
    refused = gpu and kind is not Kind.AO
    with opened_in(web, web.add(f"nodes-{kind}", made), bundled) as page:
        wanted = page.light("flatly" if refused else "one", FRONT)
        facts = page.ask("byNodes", FRONT, gpu, [{}])
    found = decibels(picture(facts["pictures"][0], FRONT), wanted, made.eroded(FRONT))
    print(kind, facts["told"], f"{found:.1f} dB")
    assert found >= 45
    assert len(facts["told"]) == refused
    assert all(f"no WGSL for bakes of kind {kind}" in line for line in facts["told"])


@FORMS
def test_nodes_are_refused_by_the_other_renderer(
    web: Site, exhibit: Exhibit, bundled: Path, form: str
) -> None:
    with opened(web, exhibit, form, bundled) as page:
        flat = page.light("flatly", FRONT)
        facts = page.ask("nodesElsewhere", FRONT)
    print(facts["told"], facts["problem"])
    assert "loaded with nodes" in facts["problem"]
    assert "Load it without `nodes`" in " ".join(facts["told"])
    assert decibels(picture(facts["light"], FRONT), flat, getattr(exhibit, form).eroded(FRONT)) >= 35


class Guarded(http.server.SimpleHTTPRequestHandler):
    """Serves files to pages of other servers that send a key; below slow/ textures stop in the middle.

    Below until/COUNT/ meshes stop after so many bytes, below broken/COUNT/ the connection breaks there, once.
    """

    broken: ClassVar[set[str]] = set()

    ended = threading.Event()
    key: str | None = "open"

    def log_message(self, *message: Any) -> None:
        pass

    def end_headers(self) -> None:
        self.send_header("Access-Control-Allow-Origin", "*")
        self.send_header("Access-Control-Allow-Headers", "X-Key")
        super().end_headers()

    def do_OPTIONS(self) -> None:
        self.send_response(204)
        self.end_headers()

    def do_GET(self) -> None:
        if self.headers["X-Key"] != self.key:
            self.send_error(403)
        elif self.path.startswith("/slow/") and self.path.endswith(".ktx2"):
            self.send_response(200)
            self.send_header("Content-Length", "1000")
            self.end_headers()
            self.wfile.write(bytes(500))
            self.wfile.flush()
            self.ended.wait(60)
        elif re.match("/(until|broken)/.*[.]glb$", self.path) and self.path not in self.broken:
            self.send_part()
        else:
            self.path = re.sub("^/(slow|(until|broken)/[0-9]+)/", "/", self.path)
            super().do_GET()

    def send_part(self) -> None:
        _, way, count, rest = self.path.split("/", 3)
        data = Path(self.translate_path(f"/{rest}")).read_bytes()
        self.send_response(200)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data[: int(count)])
        self.wfile.flush()
        if way == "until":
            self.ended.wait(60)
        else:
            self.ended.wait(
                4
            )  # for the browser forgets what the page has not read when the connection breaks
            self.broken.add(self.path)
            self.close_connection = True


class Open(Guarded):
    """The same for everybody."""

    key = None


@pytest.fixture
def guarded(web: Site) -> Iterator[str]:
    """The address of another server of the same exports."""
    with another_server(web, Guarded) as address:
        yield address


@pytest.fixture
def open_server(web: Site) -> Iterator[str]:
    """The same, which asks for no key."""
    with another_server(web, Open) as address:
        yield address


@contextmanager
def another_server(web: Site, kind: type[Guarded]) -> Iterator[str]:
    handler = functools.partial(kind, directory=str(web.folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}"
        finally:
            Guarded.ended.set()
            server.shutdown()
            thread.join()
            Guarded.ended.clear()


def test_a_loader_works_as_three_js_s_do(app: Callable[[str], App], web: Site, guarded: str) -> None:
    page = app("layered")
    one = page.light("one", FRONT)
    name = next((web.folder / "layered").glob("*.export.json")).name
    facts = page.ask("byLoader", FRONT, f"{guarded}/layered", name)
    assert np.array_equal(picture(facts["light"], FRONT), one)
    textures = json.loads((web.folder / "layered" / name).read_text())["textures"]
    files = [path for path in (web.folder / "layered").iterdir() if path.name.startswith("Suzanne.")]
    asked = 2 + len(
        textures
    )  # the manifest, the mesh, and all textures, each changed by the manager's modifier
    print(
        facts["progress"][-1],
        facts["ended"],
        facts["started"],
        facts["modified"],
        [path.name for path in files],
    )
    assert facts["parts"] == [len(textures)]
    assert facts["modified"] == asked
    assert (facts["ended"], facts["finished"]) == (asked + 1, 1)
    assert facts["started"] == [f"{guarded}/layered/moved/{name}"]
    computable, loaded, total = facts["progress"][-1]
    assert computable
    assert loaded == total > facts["files"]
    assert [loaded for _, loaded, _ in facts["progress"]] == sorted(
        loaded for _, loaded, _ in facts["progress"]
    )


@pytest.mark.parametrize("ending", ["signal", "loader", "manager"])
def test_a_load_can_be_ended(app: Callable[[str], App], web: Site, guarded: str, ending: str) -> None:
    page = app("plain")
    name = next((web.folder / "plain").glob("*.export.json")).name
    key = {"setRequestHeader": {"X-Key": "open"}}
    said = page.failing(f"{guarded}/slow/plain/{name}", key, ending)
    print(said)
    assert said["name"] == "AbortError"
    assert said["seconds"] < 10
    assert name in said["errors"]


@pytest.mark.parametrize("form", ["plain", "images"])
def test_a_load_can_be_ended_while_the_mesh_comes(
    app: Callable[[str], App], web: Site, crate: Bake, guarded: str, form: str
) -> None:
    """Also while its images come: it ends as asked for, or says that nothing comes; nothing is damaged."""
    page = app("plain")
    folder = web.folder / form if form == "plain" else web.add(f"images-{crate.folder.name}", crate)
    (manifest,), (mesh,) = folder.glob("*.export.json"), folder.glob("*.glb")
    key = {"setRequestHeader": {"X-Key": "open"}}
    places = [1500] if form == "plain" else [1500, mesh.stat().st_size - 50]
    for place in places:
        address = f"{guarded}/until/{place}/{folder.name}/{manifest.name}"
        ended = page.failing(address, key, "signal")
        late = page.failing(address, key | {"setTimeout": 700})
        print(place, ended, late)
        assert ended["name"] == "AbortError"
        assert late["name"] == "Problem"
        assert f"{mesh.name} does not come" in late["message"]
        assert ended["finished"] == late["finished"] == 1


BROKEN = {
    "a web page": b"<!doctype html>" + bytes(3 << 20),
    "no .glb": b"x" * (3 << 20),
    "a broken .glb": struct.pack("<5I", 0x46546C67, 2, 3 << 20, 100, 0x4E4F534A) + b"{" * (3 << 20),
}


@pytest.mark.parametrize("content", BROKEN)
def test_a_manager_hears_the_end_of_a_mesh_that_cannot_be_read(
    app: Callable[[str], App], web: Site, content: str
) -> None:
    """Though it is not read to its end."""
    page = app("plain")
    folder = web.folder / f"broken {content}".replace(" ", "-")
    folder.mkdir()
    (manifest,), (mesh,) = (web.folder / "plain").glob("*.export.json"), (web.folder / "plain").glob("*.glb")
    shutil.copyfile(manifest, folder / manifest.name)
    (folder / mesh.name).write_bytes(BROKEN[content])
    said = page.failing(f"../{folder.name}/{manifest.name}", {})
    print(said)
    assert said["name"] == "Problem"
    assert mesh.name in said["message"]
    assert manifest.name in said["errors"]
    assert said["finished"] == 1


def test_each_image_of_a_material_is_its_own(app: Callable[[str], App], web: Site, crate: Bake) -> None:
    """By the address of the manifest and by that of the mesh, and where two nodes have one mesh."""
    page = app("plain").shown.page
    folder = web.add(f"images-{crate.folder.name}", crate)
    (manifest,), (mesh,) = folder.glob("*.export.json"), folder.glob("*.glb")
    own: dict[str, list[int]] = {}
    for name in (manifest.name, mesh.name):
        own, stock = page.evaluate(
            "([address, file]) => checks.ownImages(address, file)",
            [f"../{folder.name}/{name}", f"../{folder.name}/{mesh.name}"],
        )
        print(own, stock)
        assert own == stock
        assert all(len(set(images)) == 3 and 0 not in images for images in own.values())
        assert own
    twice = web.folder / f"{folder.name}-twice"
    shutil.copytree(folder, twice)
    glb = Glb.read(twice / mesh.name)
    (first,) = [node for node in glb.document["nodes"] if "mesh" in node]
    glb.document["nodes"].append(first | {"name": "Other", "translation": [9.0, 0.0, 0.0]})
    glb.document["scenes"][0]["nodes"].append(len(glb.document["nodes"]) - 1)
    glb.write(twice / mesh.name)
    facts = page.evaluate("file => checks.imagesByGltf(file)", f"../{twice.name}/{mesh.name}")
    print(facts)
    (textures,) = {count for _, count, _ in facts["found"]}
    assert [(images, problem) for images, _, problem in facts["found"]] == 2 * [(own, None)]
    assert textures == len(json.loads(manifest.read_text())["textures"])
    assert list(facts["counts"].values()) == textures * [1]


def test_images_that_did_not_come_are_loaded_again(
    app: Callable[[str], App], web: Site, crate: Bake, open_server: str
) -> None:
    page = app("plain")
    folder = web.add(f"images-{crate.folder.name}", crate)
    (manifest,), (mesh,) = folder.glob("*.export.json"), folder.glob("*.glb")
    address = f"{open_server}/broken/{mesh.stat().st_size - 50}/{folder.name}/{manifest.name}"
    facts = page.ask("brokenOff", WHOLE, address, f"../{folder.name}/{manifest.name}")
    print(facts["told"], facts["found"], facts["error"])
    assert facts["told"] == f"{mesh.name} came only in part"
    assert facts["found"][0] == facts["found"][1]
    assert np.abs(picture(facts["wanted"], WHOLE)).max() > 0.1
    assert facts["again"] == facts["wanted"]
    assert facts["error"] == 0


def test_a_manager_hears_once_that_all_is_loaded(app: Callable[[str], App], web: Site, crate: Bake) -> None:
    """When it is complete, and not between two of its files."""
    page = app("plain").shown.page
    folder = web.add(f"images-{crate.folder.name}", crate)
    names = [f"../{folder.name}/{next(folder.glob(f'*.{ending}')).name}" for ending in ("export.json", "glb")]
    counts = page.evaluate("names => checks.finished(...names)", names)
    print(counts)
    assert counts == [1, 1]


def test_a_load_that_fails_says_why_and_what_to_do(
    app: Callable[[str], App], web: Site, guarded: str
) -> None:
    page = app("plain")
    name = next((web.folder / "plain").glob("*.export.json")).name
    key = {"setRequestHeader": {"X-Key": "open"}}
    late = page.failing(f"{guarded}/slow/plain/{name}", key | {"setTimeout": 700})
    refused = page.failing(f"{guarded}/plain/{name}", {})
    missing = page.failing(f"{guarded}/plain/None.export.json", key)
    unsent = page.failing(f"{guarded}/plain/{name}", {"setRequestHeader": {"X-Key": "…"}})
    gone = page.failing(f"http://127.0.0.1:9/{name}", {})
    for said, *words in (
        (late, "Suzanne.radiance.ktx2 does not come", "0.7 seconds", "timeout"),
        (refused, f"{name} was refused: 403", "header"),
        (missing, "None.export.json is missing", "one folder"),
        (unsent, "requestHeader cannot be sent", "Latin"),
        (gone, f"{name} could not be reached", "127.0.0.1:9", "Access-Control-Allow-Origin"),
    ):
        print(said)
        assert said["name"] == "Problem"
        for word in words:
            assert word in f"{said['message']} {said['remedy']}"
    assert late["errors"].count(name) == 1
    assert "Suzanne.radiance.ktx2" in late["errors"]


@FORMS
def test_three_js_s_gltf_loader_shows_the_radiance(
    app: Callable[[str], App], web: Site, exhibit: Exhibit, form: str
) -> None:
    page = app(form)
    one, mask = page.light("one", FRONT), getattr(exhibit, form).eroded(FRONT)
    folder = web.folder / form
    (mesh,) = folder.glob("*.glb")
    facts = page.ask("byGltf", FRONT, mesh.name)
    (manifest,) = folder.glob("*.export.json")
    print(facts["objects"], facts["names"], facts["told"])
    assert facts["objects"] == [["Suzanne", len(json.loads(manifest.read_text())["textures"]), None]]
    assert not facts["told"]
    for seen in ("light", "cloned"):
        found = decibels(picture(facts[seen], FRONT), one, mask)
        print(f"{form}, GLTFLoader, {seen}: {found:.1f} dB")
        assert found >= SAME


@pytest.fixture(scope="module")
def transformer(packed: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with gltf-transform and the packed package, and the guide's settings and script for it."""
    folder = tmp_path_factory.mktemp("transform")
    version = json.loads((SOURCES / "package.json").read_text())["devDependencies"]["@gltf-transform/core"]
    (folder / "package.json").write_text('{"private": true, "type": "module"}')
    (tarball,) = packed.glob("*.tgz")
    node(
        *("npm", "--loglevel=error", "install", f"--prefix={folder}", "--no-audit", "--no-fund"),
        *("--ignore-scripts", "--no-package-lock", str(tarball), f"@gltf-transform/cli@{version}"),
    )
    settings, script = blocks_of(GUIDE.read_text(encoding="utf-8"), "javascript")
    (folder / "gltf-transform.config.mjs").write_text(settings)
    (folder / "optimize.mjs").write_text(script)
    return folder


def gltf_transform(transformer: Path, *arguments: str, kept: bool = True) -> None:
    """Run gltf-transform's command, with the package's extension if bakes are to be `kept`."""
    command = transformer / "node_modules/@gltf-transform/cli/bin/cli.js"
    settings = ("--config", str(transformer / "gltf-transform.config.mjs")) if kept else ()
    node("node", str(command), *arguments, *settings)


def bakes_and_attributes(mesh: Path) -> tuple[list[Any], set[str], list[str]]:
    """Of a .glb: each material's bake and whether it is unlit, what all primitives have, its extensions."""
    document = Glb.read(mesh).document
    bakes = [
        (
            material["pbrMetallicRoughness"].get("baseColorTexture", {}).get("extensions", {}).get(EXTENSION),
            UNLIT in material.get("extensions", {}),
        )
        for material in document["materials"]
    ]
    primitives = [set(each["attributes"]) for mesh in document["meshes"] for each in mesh["primitives"]]
    return bakes, set.intersection(*primitives), document["extensionsUsed"]


def slots_of(mesh: Path) -> list[list[Any]]:
    """Of each material of a .glb: its factors, and whether it has each of the textures that lookups read."""
    found = []
    for material in Glb.read(mesh).document["materials"]:
        shading = material["pbrMetallicRoughness"]
        factors = [
            *shading.get("baseColorFactor", [1, 1, 1, 1]),
            shading.get("metallicFactor", 1),
            shading.get("roughnessFactor", 1),
            material.get("normalTexture", {}).get("scale", 1),
        ]
        textures = ["baseColorTexture" in shading, "metallicRoughnessTexture" in shading]
        found.append([[round(each, 5) for each in factors], *textures, "normalTexture" in material])
    return found


@FORMS
def test_gltf_transform_keeps_bakes(
    app: Callable[[str], App], web: Site, exhibit: Exhibit, transformer: Path, form: str
) -> None:
    """The guide's script changes no pixel, `optimize` few; without the package the bake is lost."""
    page, mask = app(form), getattr(exhibit, form).eroded(FRONT)
    one = page.light("one", FRONT)
    folder = web.folder / f"{form}-transformed"
    shutil.copytree(web.folder / form, folder)
    (mesh,) = folder.glob("*.glb")
    files = {name: folder / f"{mesh.stem}-{name}.glb" for name in ("without", "script", "medium", "default")}
    gltf_transform(transformer, "optimize", str(mesh), str(files["without"]), kept=False)
    node("node", str(transformer / "optimize.mjs"), str(mesh), str(files["script"]))
    medium = ("--meshopt-level", "medium", "--simplify", "false")
    gltf_transform(transformer, "optimize", str(mesh), str(files["medium"]), *medium)
    gltf_transform(transformer, "optimize", str(mesh), str(files["default"]))

    before, attributes, _ = bakes_and_attributes(mesh)
    lost, few, _ = bakes_and_attributes(files.pop("without"))
    assert not any(facts for facts, _ in lost)
    assert few == {"POSITION", "TEXCOORD_0"} < attributes
    for name, least in (("script", 90), ("medium", 50), ("default", 44)):
        kept, had, used = bakes_and_attributes(files[name])
        assert (kept, had) == (before, attributes), name
        assert {EXTENSION, UNLIT, "EXT_meshopt_compression"} <= set(used)
        facts = page.ask("byGltf", FRONT, f"../{folder.name}/{files[name].name}")
        found = decibels(picture(facts["light"], FRONT), one, mask)
        print(f"{form}, {name}: {files[name].stat().st_size} bytes, {found:.1f} dB")
        assert not facts["told"]
        assert found >= least, name


def test_gltf_transform_keeps_what_images_need(transformer: Path, crate: Bake, tmp_path: Path) -> None:
    """Both UV maps, and also images of one colour, which prune would make the material's factors."""
    exported(crate, tmp_path / "crate")
    mesh, small = tmp_path / "crate/Crate.glb", tmp_path / "crate/small.glb"
    glb = Glb.read(mesh)
    buffer = io.BytesIO()
    Image.new("RGB", (8, 8), (255, 128, 200)).save(buffer, "PNG")
    view = glb.add_view(buffer.getvalue())
    for image in glb.document["images"]:
        image.update(bufferView=view, mimeType="image/png")
    glb.write(mesh)
    gltf_transform(transformer, "prune", str(mesh), str(small), kept=False)
    assert slots_of(small) != slots_of(mesh)
    gltf_transform(transformer, "prune", str(mesh), str(small))
    before, attributes, _ = bakes_and_attributes(mesh)
    kept, had, _ = bakes_and_attributes(small)
    assert (kept, had) == (before, attributes)
    assert "TEXCOORD_1" in had
    assert slots_of(small) == slots_of(mesh)
    assert slots_of(mesh)[0][1:] == [True, True, True]


def test_gltf_transform_refuses_what_breaks_a_bake(
    web: Site, exhibit: Exhibit, crate: Bake, transformer: Path, tmp_path: Path
) -> None:
    """Also positions in whole numbers where there are normal maps: these scale with the node."""
    exported(crate, tmp_path / "crate")
    with pytest.raises(subprocess.CalledProcessError) as refused:
        gltf_transform(
            transformer, "quantize", str(tmp_path / "crate/Crate.glb"), str(tmp_path / "crate/small.glb")
        )
    assert "POSITION of the mesh Crate" in refused.value.stdout + refused.value.stderr
    (mesh,) = web.add("plain", exhibit.plain).glob("*.glb")
    changed = tmp_path / "changed.glb"
    with pytest.raises(subprocess.CalledProcessError) as refused:
        gltf_transform(transformer, "draco", str(mesh), str(changed))
    assert "take meshopt in its place" in refused.value.stdout + refused.value.stderr
    script = (transformer / "optimize.mjs").read_text().replace("dedup, prune, weld", "prune, unlit")
    (transformer / "spoil.mjs").write_text(script.replace("dedup(), weld(), prune()", "unlit(), prune()"))
    with pytest.raises(subprocess.CalledProcessError) as refused:
        node("node", str(transformer / "spoil.mjs"), str(mesh), str(changed))
    assert "NORMAL of the mesh Suzanne is lost" in refused.value.stderr
    assert not changed.exists()


def test_gltf_transform_can_leave_a_bake_out(
    web: Site, exhibit: Exhibit, transformer: Path, tmp_path: Path
) -> None:
    """What stays is the flat lightmap, as bright as it is: the material is still unlit."""
    (mesh,) = web.add("plain", exhibit.plain).glob("*.glb")
    script = (transformer / "optimize.mjs").read_text()
    line = "await document.transform(dedup(), weld(), prune());"
    assert line in script
    (transformer / "without.mjs").write_text(
        script.replace(line, f'document.disposeExtension("{EXTENSION}");')
    )
    node("node", str(transformer / "without.mjs"), str(mesh), str(tmp_path / "flat.glb"))
    kept, _, used = bakes_and_attributes(tmp_path / "flat.glb")
    assert kept == [(None, True)]
    assert EXTENSION not in used


def test_a_gltf_without_its_textures_keeps_the_flat_lightmap(app: Callable[[str], App], web: Site) -> None:
    page = app("plain")
    (mesh,) = (web.folder / "plain").glob("*.glb")
    alone = web.folder / "alone"
    alone.mkdir()
    shutil.copyfile(mesh, alone / mesh.name)
    facts = page.ask("byGltf", FRONT, f"../alone/{mesh.name}")
    assert np.array_equal(picture(facts["light"], FRONT), page.light("flatly", FRONT))
    ((name, textures, problem),) = facts["objects"]
    assert (name, textures) == ("Suzanne", 0)
    assert "Suzanne.radiance.ktx2 is missing" in problem
    assert "put all files of the export into one folder" in facts["told"][0]


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


def test_the_guides_examples_run(web: Site, exhibit: Exhibit, packed: Path, bundled: Path) -> None:
    """Each draws something more, or something else; what loads has another name here."""
    folder = web.add("plain", exhibit.plain)
    examples = folder.parent / "examples"
    shutil.copytree(folder, examples)
    for ending in ("glb", "export.json"):
        shutil.copyfile(examples / f"Suzanne.{ending}", examples / f"Vase.{ending}")
    script = examples / bundled.name
    shutil.copyfile(bundled, script)
    (examples / "app.html").write_text(
        f'<!doctype html><body></body><script type="module" src="{script.name}"></script>'
    )
    count = len(blocks_of(GUIDE.read_text(encoding="utf-8"), "js")) - 1
    with web.opened("examples/app.html?bake=Suzanne.export.json") as shown:
        page = App(shown).ready()
        errors: list[str] = []
        shown.page.on("pageerror", lambda error: errors.append(str(error)))
        shown.page.on("console", lambda said: errors.append(said.text) if said.type == "error" else None)
        for number in range(count):
            before = page.light("one", FAR)
            shown.page.evaluate(
                """async (number) => {
                    const { object, scene } = await window.app;
                    const { length } = scene.children;
                    await examples[number](object, scene);
                    const end = performance.now() + 20000;
                    while (number === 3 && scene.children.length === length && performance.now() < end) {
                        await new Promise((done) => setTimeout(done, 20));
                    }
                    if (number >= 3) scene.children.at(-1).position.y = 4; // else it is where others are
                }""",
                number,
            )
            assert not np.array_equal(page.light("one", FAR), before), number
        assert not errors


def test_types_are_found_by_typescript(packed: Path) -> None:
    (packed / "typed.ts").write_text(
        'import { loadRadTex, type RadTexObject, RadTexMirror } from "radtex-three";\n'
        'const { object, complete } = await loadRadTex("a.json", { lamps: { key: "b.json" } });\n'
        "await complete;\n"
        'const ours: RadTexObject = object; ours.lamps.get("key")?.set("#ffcc88");\n'
        "ours.add(new RadTexMirror(ours, ours.filter));\n"
        "ours.setSun({ azimuth: 30 }); const bytes: number = ours.memory.gpu; console.log(bytes);\n"
        "const other: RadTexObject = ours.clone(); other.opacity = other.exposure = 0.5; ours.add(other);\n"
        'import { LoadingManager } from "three";\n'
        'import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";\n'
        'import { type LoadOptions, Problem, radtex, RadTexLoader, RadTexMaterial } from "radtex-three";\n'
        "const options: LoadOptions = { signal: AbortSignal.timeout(9), restore: false };\n"
        "const loader = new RadTexLoader(new LoadingManager()).setPath('a/').setTimeout(1);\n"
        "const loaded: RadTexObject = (await loader.loadAsync('a.json', ({ loaded }) => loaded)).object;\n"
        "new GLTFLoader().register(radtex).register((parser) => radtex(parser, options)); loaded.toJSON();\n"
        "loader.load('a', ({ manifest }) => manifest.name, undefined, (error) => error instanceof Problem);\n"
        "const material = ours.meshes[0]?.material;\n"
        "if (material instanceof RadTexMaterial) material.tint.set(1);\n"
    )
    check_types(packed / "typed.ts")


def test_types_for_gltf_transform_are_found_by_typescript(transformer: Path) -> None:
    (transformer / "typed.ts").write_text(
        'import { NodeIO } from "@gltf-transform/core";\n'
        'import { type RadianceTexture, RadTexRadianceTexture } from "radtex-three/gltf-transform";\n'
        "const io = new NodeIO().registerExtensions([RadTexRadianceTexture]);\n"
        'const [material] = (await io.read("a.glb")).getRoot().listMaterials();\n'
        'const bake = material?.getExtension<RadianceTexture>("RADTEX_radiance_texture");\n'
        "const unlit: boolean | undefined = bake?.getUnlit(); console.log(unlit, bake?.getFacts()['name']);\n"
    )
    check_types(transformer / "typed.ts")


def check_types(script: Path) -> None:
    for resolution in ("bundler", "nodenext"):
        module = "esnext" if resolution == "bundler" else "nodenext"
        node(
            *("npx", "tsc", "--noEmit", "--ignoreConfig", "--strict", "--target", "es2022", "--skipLibCheck"),
            *("--module", module, "--moduleResolution", resolution, "--lib", "es2023,dom,dom.iterable"),
            str(script),
        )


def test_its_version_is_the_extensions() -> None:
    manifest = tomllib.loads((REPOSITORY / "blender_manifest.toml").read_text(encoding="utf-8"))
    assert json.loads((SOURCES / "package.json").read_text())["version"] == manifest["version"]
    assert (SOURCES / "LICENSE").read_text() == (REPOSITORY / "shaders/LICENSE").read_text()
