# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""<RadTex> of radtex-three/r3f in react-three-fiber, from the packed package, in Chromium."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radtex_addon.report.metrics import Picture
from tests.real.browser import Shown
from tests.real.exhibit import Exhibit, decibels
from tests.real.test_three import (
    FORMS,
    FRONT,
    GUIDE,
    INSIDE,
    SAME,
    blocks_of,
    bundled,
    check_types,
    opened,
    packed,
    picture,
)
from tests.real.web import SOURCES, Site, node

__all__ = ["bundled", "packed"]  # fixtures
ADDRESS = "Suzanne.export.json"


@dataclass(frozen=True)
class Canvases:
    """A page that shows what it is told to."""

    shown: Shown
    asked: list[str]  # all files

    def ask(self, check: str, *further: Any) -> Any:
        return self.shown.page.evaluate(
            "([check, further]) => checks[check](...further)", [check, list(further)]
        )

    def show(self, *bakes: dict[str, Any], strict: bool = False, **others: list[dict[str, Any]]) -> None:
        """Show these bakes in the canvas `one`, and what others have, and wait until all are there."""
        canvases = {"one": list(bakes), **others}
        self.ask("show", canvases, strict)
        for name, shown in canvases.items():
            ids = [bake["id"] for bake in shown if "stock" not in bake]
            self.shown.page.wait_for_function(
                "([name, ids]) => checks.ready(name, ids)", arg=[name, ids], timeout=60_000
            )

    def light(self, name: str = "one") -> Picture:
        return picture(self.ask("draw", Shown.view(FRONT), name), FRONT)

    def wait_for_clones(self, count: int) -> None:
        """Until so many are in use: what React made and gave up is freed after 10 seconds."""
        self.shown.page.wait_for_function("count => checks.clones()[1] === count", arg=count, timeout=20_000)
        assert self.ask("clones")[2] == 0, "freed twice"


@pytest.fixture(scope="module")
def reactive(packed: Path) -> Path:
    """The folder with react-three-fiber beside the package, and the page's script, as in development."""
    versions = json.loads((SOURCES / "package.json").read_text())["devDependencies"]
    names = ("react", "@react-three/fiber", "@types/react")
    wanted = [f"{name}@{versions[name]}" for name in names] + [f"react-dom@{versions['react']}"]
    options = ("--no-audit", "--no-fund", "--ignore-scripts", "--no-package-lock")
    node("npm", "--loglevel=error", "install", f"--prefix={packed}", *options, *wanted)
    (guide,) = blocks_of(GUIDE.read_text(encoding="utf-8"), "jsx")
    (packed / "guide.jsx").write_text(guide)
    shutil.copyfile(INSIDE / "react_checks.jsx", packed / "react_checks.jsx")
    for name in ("guide", "react_checks"):
        node(
            *("npx", "esbuild", str(packed / f"{name}.jsx"), "--bundle", "--format=esm", "--jsx=automatic"),
            *(f"--outfile={packed / name}.js", "--log-level=error"),
        )
    return packed


@contextmanager
def page_of(web: Site, folder: Path, script: Path, query: str = "") -> Iterator[tuple[Shown, list[str]]]:
    """A page with a script in a folder of the site, and the files that it asks for."""
    shutil.copyfile(script, folder / script.name)
    (folder / "react.html").write_text(
        f'<!doctype html><body style="margin: 0"><div id="root" style="height: 400px"></div></body>'
        f'<script type="module" src="{script.name}"></script>'
    )
    with web.opened("", device_scale_factor=1) as shown:
        asked: list[str] = []
        shown.page.on("request", lambda request: asked.append(request.url.rsplit("/", 1)[-1]))
        shown.page.goto(f"{web.address}/{folder.name}/react.html{query}")
        yield shown, asked


@contextmanager
def canvases(web: Site, exhibit: Exhibit, reactive: Path, form: str = "plain") -> Iterator[Canvases]:
    folder = web.add(form, getattr(exhibit, form))
    with page_of(web, folder, reactive / "react_checks.js") as (shown, asked):
        shown.page.wait_for_function("window.checks", timeout=60_000)
        yield Canvases(shown, asked)


@FORMS
def test_it_shows_what_plain_three_js_does(
    web: Site, exhibit: Exhibit, reactive: Path, bundled: Path, form: str
) -> None:
    """Also in StrictMode, which mounts it twice; and two of one file are loaded once."""
    mask = getattr(exhibit, form).eroded(FRONT)
    with opened(web, exhibit, form, bundled) as plain:
        wanted = plain.light("one", FRONT)
    with canvases(web, exhibit, reactive, form) as page:
        page.show({"id": "a", "url": ADDRESS}, {"id": "b", "src": ADDRESS, "position": [0, 50, 0]})
        found = decibels(page.light(), wanted, mask)
        print(f"{form}, react-three-fiber: {found:.1f} dB")
        assert found >= SAME
        facts = page.ask("told")
        assert facts["fallbacks"] == 1
        assert facts["refs"] == [[True, True]], "their parent's effects find both"
        assert page.ask("shared", "a", "b") == [True, True, True]
        files = [name for name in page.asked if name.startswith("Suzanne.")]
        assert len(files) == len(set(files)) > 2
        page.wait_for_clones(2)

        page.show(strict=True)
        page.wait_for_clones(0)
        page.show({"id": "a", "url": ADDRESS}, strict=True)
        found = decibels(page.light(), wanted, mask)
        print(f"{form}, in StrictMode: {found:.1f} dB")
        assert found >= SAME
        page.wait_for_clones(1)
        page.shown.page.wait_for_timeout(500)
        assert decibels(page.light(), wanted, mask) >= SAME, "its clone is still there"


def test_its_props_are_a_groups_and_its_look(web: Site, exhibit: Exhibit, reactive: Path) -> None:
    """What is left out again is as it was, and never 0."""
    with canvases(web, exhibit, reactive) as page:
        page.show({"id": "a", "url": ADDRESS})
        one, first = page.light(), page.ask("object", "a")
        tint = [0.5, 0.25, 2.0]
        page.show({"id": "a", "url": ADDRESS, "tint": tint, "exposure": 2})
        assert np.allclose(page.light(), 2 * np.array(tint) * one, rtol=1e-5, atol=1e-6)
        page.show({"id": "a", "url": ADDRESS, "tint": "#ff0000", "own": "#0000ff"})
        assert page.light().max() == 0, "both at once"
        page.show({"id": "a", "url": ADDRESS, "opacity": 0})
        assert page.light().max() == 0
        place = {"position": [1, 2, 3], "rotation": [0, 1, 0], "scale": 2}
        further = {"visible": False, "castShadow": True, "userData": {"note": "kept"}}
        page.show({"id": "a", "url": ADDRESS, **place, **further})
        facts = page.ask("object", "a")
        assert facts == {
            "position": [1, 2, 3],
            "turn": [0, 1, 0],
            "scale": [2, 2, 2],
            "visible": False,
            "shadows": [True] * len(facts["shadows"]),
            "look": [1, 1, 1, 1, 1],
            "note": "kept",
            "children": 0,
        }
        page.show({"id": "a", "url": ADDRESS, "position-y": 5})
        assert page.ask("object", "a")["position"] == [0, 5, 0]
        page.show({"id": "a", "url": ADDRESS})
        assert page.ask("object", "a") == first
        assert first["scale"] == [1, 1, 1]
        assert not any(first["shadows"])
        assert np.array_equal(page.light(), one)
        page.shown.page.mouse.click(100, 100)
        page.shown.page.wait_for_function("checks.told().clicks.length > 0")
        assert page.ask("told")["clicks"][0] == ["a", True]


def test_what_is_unmounted_is_freed_and_nothing_that_others_show(
    web: Site, exhibit: Exhibit, reactive: Path
) -> None:
    with canvases(web, exhibit, reactive) as page:
        page.show()
        page.ask("draw", Shown.view(FRONT))
        empty = page.ask("memory")
        page.show({"id": "a", "url": ADDRESS}, {"id": "b", "url": ADDRESS, "position": [0, 50, 0]})
        one, both = page.light(), page.ask("memory")
        assert both["textures"] > empty["textures"]
        page.show({"id": "a", "url": ADDRESS})
        page.wait_for_clones(1)
        assert np.array_equal(page.light(), one)
        page.show()
        page.wait_for_clones(0)
        page.show({"id": "a", "url": ADDRESS})
        assert np.array_equal(page.light(), one), "it is kept"
        page.ask("clear", ADDRESS)
        assert np.array_equal(page.light(), one), "what shows it keeps showing it"
        page.show()
        page.wait_for_clones(0)
        page.ask("draw", Shown.view(FRONT))
        assert page.ask("memory") == empty
        files = [name for name in page.asked if name == ADDRESS]
        page.ask("preload", ADDRESS)
        page.shown.page.wait_for_load_state("networkidle")
        page.shown.page.wait_for_timeout(500)
        before = page.ask("told")["fallbacks"]
        page.show({"id": "a", "url": ADDRESS})
        assert page.ask("told")["fallbacks"] == before, "it was loaded ahead"
        assert np.array_equal(page.light(), one)
        assert len([name for name in page.asked if name == ADDRESS]) == len(files) + 1


def test_each_canvas_has_textures_of_its_own(web: Site, exhibit: Exhibit, reactive: Path) -> None:
    """Two at once, and another one when the first is gone."""
    bake = {"id": "a", "url": ADDRESS}
    with canvases(web, exhibit, reactive) as page:
        page.show(bake)
        one = page.light()
        page.show(bake, two=[bake])
        assert np.array_equal(page.light("two"), one)
        assert np.array_equal(page.light(), one)
        page.ask("show", {})
        page.wait_for_clones(0)
        page.shown.page.wait_for_timeout(1000)
        page.show(bake)
        assert np.array_equal(page.light(), one)
        page.wait_for_clones(1)


def test_what_fails_reaches_an_error_boundary(web: Site, exhibit: Exhibit, reactive: Path) -> None:
    """As a Problem with what to do; the same address is asked for again when it was cleared."""
    with canvases(web, exhibit, reactive) as page:
        for address, words in (
            ("None.export.json", ("None.export.json is missing. ", "one folder")),
            ("", ("<RadTex> has no url", "NAME.export.json")),
        ):
            page.ask("show", {"one": [{"id": "a", "url": address}]})
            page.shown.page.wait_for_selector("#problem")
            said = page.shown.page.text_content("#problem") or ""
            print(said)
            assert all(word in said for word in words)
            page.ask("show", {})
        assert [ours for ours, *_ in page.ask("told")["problems"]] == [True, True]
        folder = web.folder / "plain"
        shutil.copyfile(folder / ADDRESS, folder / "None.export.json")
        page.ask("clear", "None.export.json")
        page.show({"id": "a", "url": "None.export.json"})
        assert page.light().max() > 0.1
        (folder / "None.export.json").unlink()


def test_three_js_s_own_loader_takes_the_same_file_beside_it(
    web: Site, exhibit: Exhibit, reactive: Path
) -> None:
    """For react-three-fiber, loaders without properties of their own are all the same."""
    with canvases(web, exhibit, reactive) as page:
        page.show({"id": "s", "stock": "Suzanne.glb"}, {"id": "a", "url": "Suzanne.glb"})
        assert page.ask("told")["stock"] == [True, True]


def test_the_guides_page_in_react_shows_two(web: Site, exhibit: Exhibit, reactive: Path) -> None:
    folder = web.add("plain", exhibit.plain)
    with page_of(web, folder, reactive / "guide.js", f"?bake={ADDRESS}") as (shown, _):
        shown.page.wait_for_function("document.querySelector('canvas') && window.performance.now() > 0")
        shown.page.wait_for_load_state("networkidle")
        shown.page.wait_for_timeout(3000)
        before = shown.screen()
        assert (before.max(axis=2) > 0.1).mean() > 0.02
        shown.page.mouse.click(380, 200)
        shown.page.wait_for_timeout(3000)
        assert np.abs(shown.screen() - before).max() > 0.1, "a click tints it"
    with page_of(web, folder, reactive / "guide.js", "?bake=None.export.json") as (shown, _):
        shown.page.wait_for_function("document.body.innerText.includes('None.export.json is missing')")


def test_its_types_are_found_by_typescript(reactive: Path) -> None:
    """Strictly; and what is no prop of it is refused."""
    right = (
        'import { createElement, createRef } from "react";\n'
        'import type { RadTexObject } from "radtex-three";\n'
        'import { RadTex, type RadTexProps, useRadTex } from "radtex-three/r3f";\n'
        "const ref = createRef<RadTexObject>();\n"
        "const props: RadTexProps = { url: 'a', position: [1, 2, 3], tint: 'red', exposure: 2, ref };\n"
        "createElement(RadTex, props); createElement(RadTex, { src: 'a', scale: 2, opacity: 0.5 });\n"
        "createElement(RadTex, { src: 'a', onClick: ({ object }) => object.name });\n"
        "RadTex.preload('a', (loader) => loader.setTimeout(9)); RadTex.clear('a');\n"
        "export const Name = (): string => useRadTex('a', { onProgress: () => 1 }).manifest.name;\n"
    )
    (reactive / "react_typed.ts").write_text(right)
    check_types(reactive / "react_typed.ts")
    for wrong in ("{}", "{ url: 'a', src: 'b' }", "{ url: 'a', exposure: 'much' }"):
        (reactive / "react_wrong.ts").write_text(
            'import type { RadTexProps } from "radtex-three/r3f";\n'
            f"export const props: RadTexProps = {wrong};\n"
        )
        with pytest.raises(subprocess.CalledProcessError) as refused:
            check_types(reactive / "react_wrong.ts")
        assert "react_wrong.ts" in refused.value.stdout
