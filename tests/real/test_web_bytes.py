# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a page fetches, and in which order: the packed script, the compressed mesh before all else."""

from __future__ import annotations

import http.server
import json
import struct
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Request

from radtex_addon.formats.containers.glb import Glb
from radtex_addon.report.metrics import Picture
from radtex_addon.textures.export_spec import MeshPacking
from tests.real.browser import Shown, tab_of
from tests.real.exhibit import CAMERAS, Bake, Camera, Exhibit, decibels
from tests.real.web import Site

FRONT = CAMERAS[0]
LEAST = 50.0  # dB between a compressed mesh and floats
MESHOPT = "EXT_meshopt_compression"
WHOLE = Camera("whole", (3.6, -4.4, 3.2), (0.3, -0.2, 0.5))  # of the crate


def mesh_bytes(path: Path) -> int:
    """How many bytes of a .glb are vertices and triangles."""
    document = Glb.read(path).document
    images = [image["bufferView"] for image in document["images"]]
    views = [view for number, view in enumerate(document["bufferViews"]) if number not in images]
    return sum(view.get("extensions", {}).get(MESHOPT, view)["byteLength"] for view in views)


@pytest.mark.parametrize("form", ["plain", "layered"])
def test_a_compressed_mesh_is_drawn_as_one_of_floats(web: Site, exhibit: Exhibit, form: str) -> None:
    bake: Bake = getattr(exhibit, form)
    packed, plain = web.add(form, bake), web.add(f"{form}-floats", bake, mesh=MeshPacking.PLAIN)
    (file,), (other,) = packed.glob("*.glb"), plain.glob("*.glb")
    assert MESHOPT in Glb.read(file).document["extensionsRequired"]
    assert MESHOPT not in Glb.read(other).document["extensionsRequired"]
    print(f"{form}: {mesh_bytes(file)} bytes, {mesh_bytes(other)} plain")
    assert mesh_bytes(file) < mesh_bytes(other) / 2
    pictures: list[Picture] = []
    for name in (packed.name, plain.name):
        with web.opened(f"{name}/") as shown:
            shown.wait()
            shown.set_camera(FRONT)
            pictures.append(shown.pixels()[..., :3].astype(np.float64))
    found = decibels(pictures[0], pictures[1], bake.eroded(FRONT))
    print(f"{form}: {found:.1f} dB")
    assert found > LEAST


def test_a_mesh_that_needs_another_extension_is_not_called_damaged(web: Site, exhibit: Exhibit) -> None:
    """As where somebody else has compressed it: the extension is named, and what to do."""
    folder = web.add("draco", exhibit.plain, mesh=MeshPacking.PLAIN)
    (path,) = folder.glob("*.glb")
    glb = Glb.read(path)
    glb.document["extensionsRequired"].append("KHR_draco_mesh_compression")
    glb.document["extensionsUsed"].append("KHR_draco_mesh_compression")
    glb.write(path)
    with web.opened("draco/") as shown:
        shown.page.locator("#message").wait_for(state="visible", timeout=20_000)
        message = shown.page.locator("#message").inner_text()
    assert f"{path.name} needs KHR_draco_mesh_compression" in message
    assert MESHOPT in message
    assert "damaged" not in message


@dataclass
class Slow:
    """A server of one folder that holds back the end of its .glb, and notes what it is asked for."""

    address: str = ""
    asked: list[str] = field(default_factory=list)
    further: threading.Event = field(default_factory=threading.Event)


@contextmanager
def slow_server(folder: Path, most: int) -> Iterator[Slow]:
    """It sends so many bytes of the .glb, and the others when it is told to."""
    told = Slow()

    class Files(http.server.SimpleHTTPRequestHandler):
        def __init__(self, *arguments: object) -> None:
            super().__init__(*arguments, directory=str(folder))  # type: ignore[arg-type]

        def do_GET(self) -> None:
            told.asked.append(self.path)
            if not self.path.endswith(".glb"):
                super().do_GET()
                return
            data = Path(self.translate_path(self.path)).read_bytes()
            self.send_response(200)
            self.send_header("Content-Length", str(len(data)))
            self.end_headers()
            self.wfile.write(data[:most])
            self.wfile.flush()
            told.further.wait(120)
            self.wfile.write(data[most:])

        def log_message(self, *_: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Files) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        told.address = f"http://127.0.0.1:{server.server_address[1]}"
        try:
            yield told
        finally:
            told.further.set()
            server.shutdown()
            thread.join()


def end_of_mesh(path: Path) -> int:
    """How many bytes of a .glb come before the images of its materials."""
    (length,) = struct.unpack_from("<I", path.read_bytes(), 12)
    document = Glb.read(path).document
    first = min(document["bufferViews"][image["bufferView"]]["byteOffset"] for image in document["images"])
    return int(20 + length + 8 + first)


def seen_first(shown: Shown) -> None:
    shown.page.wait_for_function("performance.getEntriesByName('radtex-first').length", timeout=60_000)


def test_the_mesh_is_shown_before_the_images_in_its_file_have_come(web: Site, crate: Bake) -> None:
    folder = web.add("images-late", crate)
    (path,) = folder.glob("*.glb")
    with web.opened("images-late/") as usual:
        usual.wait()
        usual.set_camera(WHOLE)
        wanted = usual.pixels()
    with slow_server(folder, end_of_mesh(path)) as server:
        page = tab_of(web.browser, viewport={"width": 760, "height": 500})
        try:
            page.goto(server.address)
            shown = Shown(page)
            seen_first(shown)
            assert page.evaluate("performance.getEntriesByName('radtex-complete').length") == 0
            assert np.abs(shown.screen() - shown.screen()[0, 0]).max() > 0.2, "the flat lightmap is there"
            server.further.set()
            shown.wait()
            shown.set_camera(WHOLE)
            np.testing.assert_allclose(shown.pixels(), wanted, atol=2e-3)
        finally:
            page.context.close()


def test_textures_wait_until_the_mesh_has_come(web: Site, exhibit: Exhibit) -> None:
    folder = web.add("plain", exhibit.plain)
    (path,) = folder.glob("*.glb")
    with slow_server(folder, path.stat().st_size - 1000) as server:
        page = tab_of(web.browser, viewport={"width": 760, "height": 500})
        try:
            page.goto(server.address)
            page.wait_for_timeout(1500)
            assert any(each.endswith(".glb") for each in server.asked)
            assert not any(each.endswith(".ktx2") for each in server.asked)
            server.further.set()
            Shown(page).wait()
            assert any(each.endswith(".ktx2") for each in server.asked)
        finally:
            page.context.close()


PAGE = "<!doctype html><title>My app</title>"  # which servers of apps send for what they lack
LACKING = {"404": {"status": 404}, "a page": {"status": 200, "content_type": "text/html", "body": PAGE}}


@pytest.mark.parametrize("missing", [None, *LACKING])
def test_the_script_comes_packed_from_any_server(web: Site, exhibit: Exhibit, missing: str | None) -> None:
    web.add("plain", exhibit.plain)
    page = tab_of(web.browser, viewport={"width": 760, "height": 500})
    asked: list[str] = []

    def note(request: Request) -> None:
        asked.append(request.url.rpartition("/")[2])

    try:
        page.on("request", note)
        if missing:
            page.route("**/viewer.js.gz", lambda route: route.fulfill(**LACKING[missing]))  # type: ignore[arg-type]
        page.goto(f"{web.address}/plain/")
        page.wait_for_function("window.radtex", timeout=60_000)
        Shown(page).wait()
        assert ("viewer.js" in asked) is (missing is not None)
        assert "viewer.js.gz" in asked
    finally:
        page.context.close()


def test_a_page_in_the_place_of_its_script_is_told(web: Site, exhibit: Exhibit) -> None:
    web.add("plain", exhibit.plain)
    page = tab_of(web.browser, viewport={"width": 760, "height": 500})
    try:
        page.route("**/viewer.js*", lambda route: route.fulfill(**LACKING["a page"]))  # type: ignore[arg-type]
        page.goto(f"{web.address}/plain/")
        page.locator("#message").wait_for(state="visible", timeout=20_000)
        message = page.locator("#message").inner_text()
        failed = page.evaluate("radtex.ready.then(() => null, ({ message }) => message)")
    finally:
        page.context.close()
    assert "viewer.js is missing" in message
    assert "all files of the export" in message
    assert failed in message


def test_the_packed_script_is_a_third_of_the_plain_one(web: Site, exhibit: Exhibit) -> None:
    folder = web.add("plain", exhibit.plain)
    assert (folder / "viewer.js.gz").stat().st_size < (folder / "viewer.js").stat().st_size / 3
    assert json.loads(next(folder.glob("*.export.json")).read_text())["mesh"]
