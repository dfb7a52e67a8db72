# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that a stranger made, given to readers that are not in Python: three.js, the page, and the schema.

tests/export/test_manifest.py is for RadTex's own, test_godot_strangers.py for Godot.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from radtex_addon.export.gltf import extension_in
from radtex_addon.export.targets.web import BUILT
from radtex_addon.formats.containers.glb import Glb
from tests.gltf_schema import EXTENSION_FOLDER, problems
from tests.real.web import SOURCES, Site, build_page, node
from tests.strangers.attacks import BASES, attacks

CHECK = """
import { readFileSync, writeFileSync } from "node:fs";
import { problemOf } from "./checks.mjs";
const made = JSON.parse(readFileSync(new URL("made.json", import.meta.url), "utf8"));
process.stdout.write(JSON.stringify(made.map(problemOf)));
"""
ELSEWHERE = "https://example.invalid/evil.png"


def test_three_js_refuses_what_strangers_make(tmp_path: Path) -> None:
    """By the check that comes before any file is fetched; what RadTex wrote passes."""
    build_page()  # for npm's packages
    bundle = ("--bundle", "--format=esm", "--log-level=warning", f"--outfile={tmp_path / 'checks.mjs'}")
    node("npx", "esbuild", str(SOURCES / "src/checks.ts"), *bundle)
    (tmp_path / "check.mjs").write_text(CHECK, encoding="utf-8")
    made: list[Any] = [*BASES.values(), *(facts for _, facts in attacks("gltf"))]
    (tmp_path / "made.json").write_text(json.dumps(made), encoding="utf-8")
    found = json.loads(node("node", str(tmp_path / "check.mjs")))
    assert found[: len(BASES)] == [None] * len(BASES)
    told = dict(zip((what for what, _ in attacks("gltf")), found[len(BASES) :], strict=True))
    assert [what for what, problem in told.items() if not problem] == []


def test_the_schema_refuses_them_too() -> None:
    """But for sizes that do not agree with each other, which no schema tells."""
    assert [problems(facts) for facts in BASES.values()] == [[]] * len(BASES)
    passed = {what for what, facts in attacks("gltf") if not problems(facts)}
    assert passed == AGREEMENTS


AGREEMENTS = {
    "a uri of another file than the name's",
    "a layer without texture",
    "a number for a material that there is not",
    "a kind without texture",
    "more texels than are stored",
    "more pages than layers",
}


def _manifest_of(facts: dict[str, Any], folder: Path) -> None:
    (folder / "Ball.export.json").write_text(json.dumps(facts), encoding="utf-8")


def _texture_elsewhere(folder: Path) -> None:
    """A manifest that names the folder above."""
    facts = json.loads((folder / "Ball.export.json").read_text(encoding="utf-8"))
    facts["textures"]["radiance"]["file"] = ".."
    _manifest_of(facts, folder)


def _code(folder: Path) -> None:
    """A manifest whose number is code."""
    facts = json.loads((folder / "Ball.export.json").read_text(encoding="utf-8"))
    facts["textures"]["radiance"]["levels"] = "4\n#error all is lost"
    _manifest_of(facts, folder)


def _picture_elsewhere(folder: Path) -> None:
    """A .glb whose flat lightmap lies on a server."""
    glb = Glb.read(folder / "Ball.glb")
    assert extension_in(glb.document["materials"][0])
    glb.document["images"] = [{"uri": ELSEWHERE}]
    glb.write(folder / "Ball.glb")


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (_texture_elsewhere, "expected the name of a .ktx2 beside it"),
        (_code, "expected a whole number from 1 to 7"),
        (_picture_elsewhere, "lacks its flat lightmap"),
    ],
    ids=["a texture elsewhere", "code", "a picture elsewhere"],
)
def test_the_page_asks_for_no_file_elsewhere(spoil: Callable[[Path], None], says: str, web: Site) -> None:
    folder = web.folder / spoil.__name__
    shutil.copytree(BUILT, folder)
    shutil.copytree(EXTENSION_FOLDER / "example", folder, dirs_exist_ok=True)
    spoil(folder)
    before = "window.asked = []; const real = window.fetch; window.fetch = (...all) => "
    before += "{ window.asked.push(new URL(all[0].url ?? all[0], location.href).href); "
    before += "return real(...all); };"
    with web.opened(f"{folder.name}/?bake=Ball.export.json", before=before) as shown:
        shown.page.locator("#message").wait_for(state="visible", timeout=20_000)
        assert says in shown.page.locator("#message").inner_text()
        asked = {url for url in shown.page.evaluate("window.asked") if not url.startswith(("blob:", "data:"))}
        here = f"{web.address}/{folder.name}"
        assert asked <= {f"{here}/{file.name}" for file in folder.iterdir()}
