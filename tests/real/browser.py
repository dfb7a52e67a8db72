# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A real Chromium in the root of real programs, driven from here, and a static server for what it opens."""

from __future__ import annotations

import base64
import functools
import http.server
import io
import subprocess
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, BrowserType, Error, Page

from radtex_addon.core.arrays import Floats
from tests.real.exhibit import Camera
from tests.real.kinds import Sun
from tests.real.root import Root

_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--no-first-run",
    "--hide-scrollbars",
    "--remote-debugging-port=0",
)
SOFTWARE_GL = (  # and a WebGPU that is software, too
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"),
    "--enable-unsafe-webgpu",
)
HARD_EDGES = "--webgl-antialiasing-mode=none"  # a picture is drawn in half the time
# Tells which callbacks wait for the next frame: a page of ours draws in those alone.
_COUNT_FRAMES = """{
    const request = window.requestAnimationFrame.bind(window);
    const cancel = window.cancelAnimationFrame.bind(window);
    window.awaitedFrames = new Set();
    window.requestAnimationFrame = (drawn) => {
        const number = request((now) => {
            awaitedFrames.delete(number);
            drawn(now);
        });
        awaitedFrames.add(number);
        return number;
    };
    window.cancelAnimationFrame = (number) => {
        awaitedFrames.delete(number);
        cancel(number);
    };
}
"""
_START = 60.0  # seconds that Chromium may take
PATIENCE = 120_000  # milliseconds: without a GPU, and beside other tests, a frame may take seconds
TO_GLTF = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], dtype=np.float64)


@contextmanager
def chromium(root: Root, driver: BrowserType, *flags: str) -> Iterator[Browser]:
    """Chromium of the root, with `flags` beside those that every test needs; `driver` is Playwright's."""
    profile, inside = root.shared("chromium")
    argv = ["chromium", *_FLAGS, f"--user-data-dir={inside}", *flags, "about:blank"]
    log = profile.with_suffix(".log")
    with root.start(argv, log=log) as started:
        port = profile / "DevToolsActivePort"
        end = time.monotonic() + _START
        while not (port.is_file() and port.read_text().strip()):
            assert time.monotonic() < end, f"Chromium does not start: {log.read_text()[-2000:]}"
            time.sleep(0.1)
        browser = driver.connect_over_cdp(f"http://127.0.0.1:{port.read_text().split()[0]}")
        try:
            yield browser
        finally:
            with suppress(
                Error, subprocess.TimeoutExpired
            ):  # it ends by itself, so that what it cost is known
                browser.new_browser_cdp_session().send("Browser.close")
                started.wait(10)


def tab_of(browser: Browser, before: str = "", **context: Any) -> Page:
    """A new tab, which may be `Shown`, in a context of its own; `before` runs before its pages' scripts."""
    tab = browser.new_context(**context)
    tab.set_default_timeout(PATIENCE)
    page = tab.new_page()
    page.add_init_script(_COUNT_FRAMES + before)
    return page


class _Quiet(http.server.SimpleHTTPRequestHandler):
    """Serves a folder, with further headers, without a word."""

    def __init__(self, *args: Any, headers: Mapping[str, str], **kwargs: Any) -> None:
        self._headers = headers
        super().__init__(*args, **kwargs)

    def end_headers(self) -> None:
        for name, value in self._headers.items():
            self.send_header(name, value)
        super().end_headers()

    def log_message(self, *message: Any) -> None:
        pass


@contextmanager
def served(folder: Path, headers: Mapping[str, str] | None = None) -> Iterator[str]:
    """The address at which `folder` is served, each file with these headers."""
    handler = functools.partial(_Quiet, directory=str(folder), headers=headers or {})
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}"
        finally:
            server.shutdown()
            thread.join()


@dataclass(frozen=True)
class Shown:
    """An opened page of the web export, in a tab of `tab_of`."""

    page: Page

    def wait(self) -> Shown:
        """Until the object is on the screen and the picture stands still."""
        self.page.evaluate("radtex.ready")
        self.still()
        return self

    def still(self) -> None:
        """Until nothing waits for another frame."""
        self.page.wait_for_function("awaitedFrames.size === 0")

    def screen(self) -> Floats:
        """What the screen shows, (H, W, 3) in [0, 1], a pixel for each CSS pixel, without the frame rate."""
        hidden = "#status { visibility: hidden }"
        with Image.open(
            io.BytesIO(self.page.screenshot(style=hidden, scale="css", animations="disabled"))
        ) as image:
            return np.asarray(image.convert("RGB"), dtype=np.float32) / 255

    @staticmethod
    def view(camera: Camera) -> list[Any]:
        """An exhibit's camera as window.radtex takes it."""
        matrix = (TO_GLTF @ np.array(camera.matrix)).ravel().tolist()
        return [matrix, float(np.radians(camera.fovy)), camera.pixels, camera.pixels]

    def set_camera(self, camera: Camera, sun: Sun | None = None) -> None:
        """Take the place of an exhibit's camera, and draw it, once, by that sun."""
        both = "([camera, sun]) => { if (sun) radtex.setSun(sun); radtex.setCamera(...camera); }"
        self.page.evaluate(both, [self.view(camera), sun and asdict(sun)])

    def pixels(self, flat: bool = False) -> Floats:
        """Linear light of the picture, (H, W, 4), rows from the top."""
        made = self.page.evaluate("flat => radtex.pixels(flat)", flat)
        return decoded(made["values"]).reshape(made["height"], made["width"], 4)

    def text(self, element: str) -> str:
        """What an element of the page says."""
        return self.page.text_content(f"#{element}") or ""


def decoded(text: str) -> Floats:
    """Floats from base64, as window.radtex gives them."""
    return np.frombuffer(base64.b64decode(text), np.float32)
