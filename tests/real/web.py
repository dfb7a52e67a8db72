# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Web exports of the exhibit, built, served and opened; and Node, for what tests ask of npm's packages."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from playwright.sync_api import Browser

from radtex_addon.core.arrays import Floats
from radtex_addon.export.exporting import Exported, export_steps
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.real.browser import Shown, tab_of
from tests.real.exhibit import Bake
from tests.real.root import REPOSITORY

SOURCES = REPOSITORY / "shaders/three"
UV = os.environ.get("UV") or shutil.which("uv") or "uv"
FIGURES = os.environ.get("RADTEX_FIGURES")  # a folder for screenshots of the page, docs/figures for one


# A device that knows no blocks.
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


@dataclass(frozen=True)
class Site:
    """Exports below `folder`, which is served at `address`, in tabs of `browser`."""

    folder: Path
    address: str
    browser: Browser

    def add(self, name: str, bake: Bake, **settings: Any) -> Path:
        """The export of that name, made if it is not there."""
        folder = self.folder / name
        if not folder.is_dir():
            exported(bake, folder, **settings)
        return folder

    @contextmanager
    def opened(
        self, name: str, width: int = 760, height: int = 500, before: str = "", **context: Any
    ) -> Iterator[Shown]:
        """A tab with the export of that name; `before` is a script that runs before the page's.

        A pixel of its first picture is two CSS pixels wide, unless told otherwise (`device_scale_factor`) or
        figures are kept: what is compared is drawn by `set_camera`, a pixel for each CSS pixel.
        """
        settings = {"device_scale_factor": 1 if FIGURES else 0.5} | context
        page = tab_of(self.browser, before, viewport={"width": width, "height": height}, **settings)
        try:
            page.goto(f"{self.address}/{name}")
            yield Shown(page)
        finally:
            page.context.close()


def build_page() -> None:
    """Have the page built of its present sources."""
    subprocess.run([sys.executable, str(REPOSITORY / ".ci/build_web.py")], check=True)


def install_packages() -> None:
    """Have npm's packages at hand, three.js among them: where the page is built already they may not be."""
    code = "from build_web import alone, install\nwith alone(): install()"
    subprocess.run([sys.executable, "-c", code], cwd=REPOSITORY / ".ci", check=True)


def exported(bake: Bake, folder: Path, **settings: Any) -> Exported:
    """Export a bake for the web."""
    steps = export_steps(bake.sidecar, ExportSpec(Target.WEB, **settings), folder)
    while True:
        try:
            next(steps)
        except StopIteration as stop:
            made: Exported = stop.value
            return made


def node(*arguments: str) -> str:
    """What Node prints, with the page's packages at hand. CalledProcessError where it fails."""
    programs = _packaging_tools()
    variables = os.environ | {"PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}
    command = [str(programs / arguments[0]), *arguments[1:]]
    run = subprocess.run(command, cwd=SOURCES, env=variables, check=True, capture_output=True, text=True)
    return run.stdout


def compiled_flamenco_job(script: Path, settings: dict[str, Any]) -> Any:
    """A Flamenco script's type of job, and the tasks that it makes of settings, and of defaults."""
    stand_in = REPOSITORY / "tests/real/inside/flamenco.js"
    arguments = (str(stand_in), str(script), json.dumps(settings))
    program = shutil.which("node")
    if program is None:
        return json.loads(node("node", *arguments))
    run = subprocess.run([program, *arguments], check=True, capture_output=True, text=True)
    return json.loads(run.stdout)


@cache
def _packaging_tools() -> Path:
    """The programs of an environment for packaging, by uv.lock, which is there until this process ends."""
    tool = [UV, "run", "--quiet", "--frozen", "--isolated", "--only-group=package", f"--project={REPOSITORY}"]
    code = "import sys, sysconfig; print(sysconfig.get_path('scripts'), flush=True); sys.stdin.read()"
    held = subprocess.Popen(
        [*tool, "python", "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    _HELD.append(held)
    assert held.stdout is not None
    return Path(held.stdout.readline().strip())


_HELD: list[subprocess.Popen[str]] = []


def encoded(light: Floats) -> Floats:
    """Linear light as the screen shows it without a tone curve, in [0, 1]."""
    shown = np.clip(light, 0, 1)
    srgb: Floats = np.where(shown <= 0.0031308, shown * 12.92, 1.055 * shown ** (1 / 2.4) - 0.055)
    return srgb


def aces(light: Floats) -> Floats:
    """Stephen Hill's fit of ACES, exposed as three.js does."""
    into = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]])
    back = np.array(
        [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]]
    )
    a = light / 0.6 @ into.T
    fitted = (a * (a + 0.0245786) - 0.000090537) / (a * (0.983729 * a + 0.4329510) + 0.238081)
    toned: Floats = fitted @ back.T
    return toned


def save(shown: Shown, name: str) -> None:
    """Keep a screenshot, if somebody asked for them."""
    if FIGURES:
        shown.page.screenshot(path=Path(FIGURES, f"web-{name}.png"))


def save_light(light: Floats, name: str) -> None:
    """Keep a picture of linear light, if somebody asked for them."""
    if FIGURES:
        bytes_shown = np.round(encoded(light[..., :3]) * 255).astype(np.uint8)
        Image.fromarray(bytes_shown).save(Path(FIGURES, f"web-{name}.png"))
