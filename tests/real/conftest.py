# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests of shaders and of exported folders share."""

from __future__ import annotations

import faulthandler
import os
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import moderngl
import pytest
from playwright.sync_api import BrowserType, sync_playwright

from radtex_addon.settings.spec import Kind, View
from tests.blender import surroundings
from tests.blender.furnished_room import bake_room
from tests.blender.image_stage import bake_crate
from tests.finished_bakes import finished_bake
from tests.real.browser import HARD_EDGES, SOFTWARE_GL, chromium, served
from tests.real.engines import Compilers
from tests.real.exhibit import Bake, Exhibit, Form
from tests.real.installable import build_zip, with_wheels
from tests.real.kinds import SPECS, KindBake, baked
from tests.real.mirror_scene import Stage
from tests.real.panel import radtex_window
from tests.real.root import BLENDER, COMPILERS, PROGRAMS, Recipe, Root, RootUnavailableError, ready_root
from tests.real.web import FIGURES, Site, build_page
from tests.real.window import Window


@pytest.fixture(scope="module", autouse=True)
def small_surroundings() -> Iterator[None]:
    """Let layered bakes in this process take small pictures of the surroundings."""
    with pytest.MonkeyPatch.context() as patch:
        surroundings.make_small(patch)
        yield


@pytest.fixture(scope="module")
def context() -> Iterator[moderngl.Context]:
    """OpenGL over EGL, without a window."""
    with moderngl.create_context(standalone=True, backend="egl") as context:  # type: ignore[arg-type]  # wrong stub
        yield context


@pytest.fixture(scope="session")
def exhibit(tmp_path_factory: pytest.TempPathFactory) -> Exhibit:
    """A small bake to show in real programs, and what they must show."""
    return Exhibit(tmp_path_factory.mktemp("exhibit"))


@pytest.fixture(scope="session")
def kind_bake(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., KindBake]:
    """Bakes by kind, cells and view, made when they are first asked for."""
    folder = tmp_path_factory.mktemp("kinds")

    def made(kind: Kind, cells: int | None = None, view: View = View.NORMAL) -> KindBake:
        return once(kind, cells or SPECS[kind].bucket, view)

    @cache
    def once(kind: Kind, cells: int, view: View) -> KindBake:
        return baked(kind, folder / f"{kind}-{cells}-{view}", cells, view)

    return made


@pytest.fixture(scope="module", params=[False, True], ids=["whole", "mixed"])
def crate(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Bake:
    """A crate that is all of images, or with a side of another material."""
    folder = tmp_path_factory.mktemp("crate")
    return Bake(finished_bake(folder, bake_crate, mixed=request.param))


@pytest.fixture(scope="session")
def room(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Bakes of a room; its last three are trees, which stand beside what the cameras see."""
    with pytest.MonkeyPatch.context() as patch:
        surroundings.make_small(patch)
        return bake_room(tmp_path_factory.mktemp("room"))


@pytest.fixture(scope="session")
def stages(tmp_path_factory: pytest.TempPathFactory) -> dict[Form, Stage]:
    """What a mirror ball moves through, and how Cycles sees it there."""
    folder = tmp_path_factory.mktemp("stages")
    return {form: Stage.made(form, folder / form) for form in Form}


@pytest.fixture(scope="session")
def root(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Root]:
    """Godot, Chromium and the others in a Debian of their own, which the first use builds."""
    root = _root(PROGRAMS, request.config, tmp_path_factory)
    yield root
    root.end_servers()


@pytest.fixture(scope="session")
def compilers(
    root: Root, request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Compilers]:
    """What game engines compile with, in a Debian of its own, which the first use builds."""
    tools = _root(COMPILERS, request.config, tmp_path_factory)
    yield Compilers(tools, root)
    tools.end_servers()


@pytest.fixture(scope="session")
def blender_root(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Root:
    """A Debian with Blender's window, which the first use builds; for those who ask for it."""
    if not os.environ.get("RADTEX_WINDOW"):
        pytest.skip("RADTEX_WINDOW=1 tests RadTex in Blender's window, in a Debian that this builds")
    return _root(BLENDER, request.config, tmp_path_factory)


@pytest.fixture(scope="session")
def window_zip(blender_root: Root, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The extension for the Blender in that root."""
    wheels = sorted((blender_root.path / "wheels").glob("*.whl"))
    return with_wheels(build_zip(), wheels, tmp_path_factory.mktemp("dist"))


@pytest.fixture(scope="module")
def window(blender_root: Root, window_zip: Path) -> Iterator[Window]:
    """Blender's window with RadTex in it and a scene to bake, which the tests of a file share."""
    with radtex_window(blender_root, window_zip) as window:
        yield window


def _root(recipe: Recipe, config: pytest.Config, folders: pytest.TempPathFactory) -> Root:
    """A root made by `recipe`, or a skip.

    What runs there depends on our own Blender in the exported mesh alone, which tests/blender checks on both:
    the newer Blender's run is enough, unless RADTEX_EVERY_BLENDER is set.
    """
    if sys.version_info < (3, 13) and not os.environ.get("RADTEX_EVERY_BLENDER"):
        pytest.skip("real programs run with Blender 5.2's tests; RADTEX_EVERY_BLENDER=1 runs them here, too")
    faulthandler.cancel_dump_traceback_later()  # building, or waiting for who builds, may take longer
    try:
        path, seconds = ready_root(recipe)
    except RootUnavailableError as error:
        pytest.skip(str(error))
    reporter = config.pluginmanager.get_plugin("terminalreporter")
    if seconds and reporter is not None:
        reporter.write_line(f"\n{path}: built in {seconds:.0f} s")
    return Root(path, folders.mktemp("shared"))


@pytest.fixture(scope="session")
def driver() -> Iterator[BrowserType]:
    """What drives Chromium; there may be one in a process."""
    with sync_playwright() as playwright:
        yield playwright.chromium


@pytest.fixture(scope="session")
def web(root: Root, driver: BrowserType, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    """A browser, and a server for web exports."""
    build_page()
    folder = tmp_path_factory.mktemp("site")
    flags = SOFTWARE_GL if FIGURES else (*SOFTWARE_GL, HARD_EDGES)
    with chromium(root, driver, *flags) as browser, served(folder) as address:
        yield Site(folder, address, browser)
