# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The npm package radtex-babylon: packed, installed, and used by Babylon.js in Chromium."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radtex_addon.export.gltf import EXTENSION
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.report.metrics import Picture
from tests.real.browser import Shown
from tests.real.exhibit import CAMERAS, Bake, Camera, Exhibit, decibels
from tests.real.root import REPOSITORY
from tests.real.test_three import (
    FORMS,
    FRONT,
    INSIDE,
    LEAST,
    SAME,
    blocks_of,
    bundled,
    check_types,
    opened,
    packed,
    picture,
)
from tests.real.web import Site, aces, node

__all__ = ["bundled", "packed"]  # fixtures, of the page of three.js
NPM = ("npm", "--loglevel=error")
QUIET = ("--no-audit", "--no-fund", "--ignore-scripts")


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page's script. The package is checked and packed in a copy of its sources, and installed beside."""
    folder = tmp_path_factory.mktemp("babylon")
    made = shutil.ignore_patterns("node_modules", "dist", "godot", "unity", "unreal", ".built-*")
    shutil.copytree(REPOSITORY / "shaders", folder / "shaders", ignore=made)
    sources = folder / "shaders/babylon"
    node(*NPM, "ci", f"--prefix={sources}", *QUIET)
    node(*NPM, "run", "--silent", "check", f"--prefix={sources}")
    told = json.loads(node(*NPM, "pack", "--json", f"--pack-destination={folder}", str(sources)))
    (facts,) = told.values() if isinstance(told, dict) else told
    names = {file["path"] for file in facts["files"]}
    assert {"package.json", "README.md", "LICENSE", "dist/radtex-babylon.js"} <= names
    assert {"dist/types/babylon/src/index.d.ts", "dist/types/three/src/problem.d.ts"} <= names
    assert not {name for name in names if name.startswith(("src/", "node_modules/"))}
    print(f"npm pack: {facts['size']} bytes, {len(names)} files")
    app = folder / "app"
    app.mkdir()
    (app / "package.json").write_text('{"private": true, "type": "module"}')
    tarball = folder / Path(facts["filename"]).name
    versions = json.loads((sources / "package.json").read_text())["devDependencies"]
    peers = ("@babylonjs/core", "@babylonjs/loaders", "babylonjs-gltf2interface")
    wanted = [f"{name}@{versions[name]}" for name in peers]
    node(*NPM, "install", f"--prefix={app}", *QUIET, "--no-package-lock", str(tarball), *wanted)
    shutil.copyfile(INSIDE / "babylon_checks.js", app / "checks.js")
    guide = (REPOSITORY / "docs/babylon.md").read_text(encoding="utf-8")
    (app / "guide.js").write_text(blocks_of(guide, "js")[0])
    for name, bundle in (("checks", "bundled"), ("guide", "guide_bundled")):
        node(
            *("npx", "esbuild", str(app / f"{name}.js"), "--bundle", "--format=esm"),
            *(f"--outfile={app / bundle}.js", "--log-level=error"),
        )
    return app / "bundled.js"


class Page:
    """A page of Babylon.js."""

    def __init__(self, shown: Shown) -> None:
        self.shown = shown

    def ask(self, check: str, *further: Any) -> Any:
        return self.shown.page.evaluate(
            "([check, further]) => checks[check](...further)", [check, list(further)]
        )

    def light(self, camera: Camera) -> Picture:
        return picture(self.ask("draw", Shown.view(camera)), camera)


@contextmanager
def babylon(web: Site, folder: Path, script: Path) -> Iterator[Page]:
    """The page, in a folder with an export."""
    shutil.copyfile(script, folder / "babylon.js")
    decoder = script.parent / "node_modules/@babylonjs/core/assets/meshopt/meshopt_decoder.js"
    shutil.copyfile(decoder, folder / "meshopt_decoder.js")
    (folder / "babylon.html").write_text(
        '<!doctype html><body><canvas id="canvas"></canvas></body>'
        '<script type="module" src="babylon.js"></script>'
    )
    with web.opened(f"{folder.name}/babylon.html", device_scale_factor=1) as shown:
        shown.page.on("console", lambda said: print(said.text[:2000]) if said.type == "error" else None)
        shown.page.wait_for_function("window.checks", timeout=60_000)
        yield Page(shown)


@FORMS
def test_it_shows_what_three_js_does(
    web: Site, exhibit: Exhibit, script: Path, bundled: Path, form: str
) -> None:
    """In a left-handed scene, as Babylon.js's are by default, and in a right-handed one."""
    bake = getattr(exhibit, form)
    with opened(web, exhibit, form, bundled) as plain:
        wanted = {camera: plain.light("one", camera) for camera in CAMERAS}
    with babylon(web, web.folder / form, script) as page:
        for right_handed in (False, True):
            facts = page.ask("load", "Suzanne.glb", right_handed)
            assert facts["shown"] > 0
            assert not facts["problems"]
            for camera in CAMERAS:
                seen, mask = page.light(camera), bake.eroded(camera)
                found = decibels(seen, wanted[camera], mask)
                print(f"{form}, {'right' if right_handed else 'left'}-handed, {camera.name}: {found:.1f} dB")
                assert found >= SAME
                assert decibels(seen, bake.picture(camera), mask) >= LEAST
        assert page.ask("errors") == 0


def test_it_moves_and_its_look_changes(web: Site, exhibit: Exhibit, script: Path) -> None:
    """Its light moves along, in scenes of either handedness; also that of instances."""
    mask, folder = exhibit.plain.eroded(FRONT), web.add("plain", exhibit.plain)
    larger, (x, y, z) = 1.5, (2.0, -1.0, 0.7)  # in Blender's axes

    def there(place: tuple[float, float, float]) -> tuple[float, float, float]:
        return larger * place[0] + x, larger * place[1] + y, larger * place[2] + z

    moved = replace(FRONT, place=there(FRONT.place), target=there(FRONT.target))
    with babylon(web, folder, script) as page:
        for right_handed in (False, True):
            page.ask("load", "Suzanne.glb", right_handed)
            one = page.light(FRONT)
            page.ask("change", {"culled": True})
            assert decibels(page.light(FRONT), one, mask) >= SAME, "its front is its front"
            page.ask("instances")
            instances = decibels(page.light(FRONT), one, mask)
            page.ask("load", "Suzanne.glb", right_handed)
            page.ask("change", {"position": [x if right_handed else -x, z, -y], "scale": larger})
            found = decibels(page.light(moved), one, mask)
            print(f"moved: {found:.1f} dB, instances: {instances:.1f} dB")
            assert min(found, instances) >= SAME
        tint = [0.5, 0.25, 2.0]
        page.ask("load", "Suzanne.glb", False)
        one = page.light(FRONT)
        page.ask("change", {"tint": tint, "exposure": 3})
        assert np.allclose(page.light(FRONT), 3 * np.array(tint) * one, rtol=1e-4, atol=1e-5)
        page.ask("cloned", [1, 1, 1])
        assert np.allclose(page.light(FRONT), 3 * one, rtol=1e-4, atol=1e-5), "a clone has a look of its own"


def test_image_processing_is_babylon_js_s(web: Site, exhibit: Exhibit, script: Path) -> None:
    """Exposure, tone mapping and the screen's gamma, which Babylon.js takes for 2.2."""
    mask, folder = exhibit.plain.eroded(FRONT), web.add("plain", exhibit.plain)
    with babylon(web, folder, script) as page:
        page.ask("load", "Suzanne.glb", False)
        light = page.light(FRONT)[mask]
        mapped = {"exposure": 2, "toneMappingEnabled": True, "toneMappingType": 1}
        for settings, wanted in (({}, light), (mapped, aces(0.6 * 2 * light))):
            seen = picture(page.ask("screen", Shown.view(FRONT), settings), FRONT)[mask]
            display = np.clip(wanted, 0, 1) ** (1 / 2.2)
            assert np.quantile(np.abs(seen - display).max(axis=-1), 0.9) < 0.02


def test_it_comes_back_after_the_device_was_lost(web: Site, exhibit: Exhibit, script: Path) -> None:
    with babylon(web, web.add("plain", exhibit.plain), script) as page:
        page.ask("load", "Suzanne.glb", False)
        one = page.light(FRONT)
        page.ask("cloned", [1, 1, 1])
        assert page.ask("lost") == 0, "the flat lightmap until the textures have come"
        page.shown.page.wait_for_function("checks.shown() > 0")
        assert decibels(page.light(FRONT), one, exhibit.plain.eroded(FRONT)) >= SAME


def test_an_asset_container_holds_it(web: Site, exhibit: Exhibit, script: Path) -> None:
    """Nothing of it is in the scene before it is added."""
    with babylon(web, web.add("plain", exhibit.plain), script) as page:
        facts = page.ask("load", "Suzanne.glb", False, True)
        assert facts["before"][:2] == [0, 0]
        assert facts["shown"] > 0
        assert page.light(FRONT).max() > 0.1


def test_what_is_not_drawn_keeps_the_flat_lightmap_and_is_said(
    web: Site, exhibit: Exhibit, script: Path, crate: Bake
) -> None:
    """Materials that are images, clear parts, textures that are missing."""
    plain, layered = web.add("plain", exhibit.plain), web.add("layered", exhibit.layered)
    images = web.add(f"images-{crate.folder.name}", crate)
    alone, clear = web.folder / "babylon-alone", web.folder / "babylon-clear"
    alone.mkdir(exist_ok=True)
    shutil.copyfile(plain / "Suzanne.glb", alone / "Suzanne.glb")
    shutil.copytree(layered, clear, dirs_exist_ok=True)
    glb = Glb.read(clear / "Suzanne.glb")
    for material in glb.document["materials"]:
        facts = material["pbrMetallicRoughness"]["baseColorTexture"]["extensions"][EXTENSION]
        facts["textures"]["alpha"] = facts["textures"]["irradiance"]
        facts["shader"]["defines"]["RADTEX_ALPHA"] = 1
        facts["shader"]["layers"].append("alpha")
        facts["shader"]["values"]["radtex_alpha_range"] = [1, 1, 1, 0]
    glb.write(clear / "Suzanne.glb")
    with babylon(web, plain, script) as page:
        for file, words in (
            (f"../{images.name}/Crate.glb", ("Crate.glb is shown by its flat lightmap", "--image-limit 0")),
            (f"../{clear.name}/Suzanne.glb", ("Suzanne.glb", "parts of it are clear", "radtex-three")),
            (f"../{alone.name}/Suzanne.glb", ("Suzanne.radiance.ktx2 is missing", "one folder")),
        ):
            facts = page.ask("load", file, False)
            print(facts)
            assert facts["shown"] == 0
            assert facts["meshes"] > 1
            ((kind, said),) = facts["problems"]
            assert kind == "Problem"
            assert all(word in said for word in words)


def test_the_guides_page_shows_it(web: Site, exhibit: Exhibit, script: Path) -> None:
    folder = web.add("plain", exhibit.plain)
    with babylon(web, folder, script) as page:  # which puts the decoder there
        shutil.copyfile(script.parent / "guide_bundled.js", folder / "guide.js")
        (folder / "guide.html").write_text(
            '<!doctype html><body></body><script type="module" src="guide.js"></script>'
        )
        page.shown.page.goto(f"{web.address}/plain/guide.html?file=Suzanne.glb")
        page.shown.page.wait_for_function("document.querySelectorAll('canvas').length === 1")
        page.shown.page.wait_for_load_state("networkidle")
        page.shown.page.wait_for_timeout(3000)
        box = page.shown.page.locator("canvas").last.bounding_box()
        assert box is not None
        left, top, width, height = (int(box[name]) for name in ("x", "y", "width", "height"))
        seen = page.shown.screen()[top : top + height, left : left + width]
        assert seen.std() > 0.05


def test_types_are_found_by_typescript(script: Path) -> None:
    typed = script.parent / "typed.ts"
    typed.write_text(
        'import { type Problem, RadTexMaterial, registerRadTex } from "radtex-babylon";\n'
        "registerRadTex((problem: Problem) => console.log(problem.message, problem.remedy));\n"
        "export const brighten = (material: unknown): void => {\n"
        "  if (material instanceof RadTexMaterial) material.clone('b').exposure = material.tint.r;\n"
        "};\n"
    )
    check_types(typed)
