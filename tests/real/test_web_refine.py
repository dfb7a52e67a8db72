# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A page that is open while its bake is refined takes in passes without a reload, and gets less noisy."""

from __future__ import annotations

import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import bpy
import numpy as np
from playwright.sync_api import Browser

from radtex_addon.report.metrics import Picture
from tests.bench.gallery.looking import added, empty_scene, lamp, principled
from tests.real.browser import Shown, served, tab_of
from tests.real.exhibit import CAMERAS, ROOT, decibels
from tests.real.web import Site

PASSES = 4
SAMPLES = 1
NAME = "Ball"
QUICK = ("--object", NAME, "--texels", "32", "--bucket", "4", "--save-preview", "--export", "web")
REFERENCE = 32  # samples
GAIN = 0.5  # decibels that each pass must be nearer to the reference, which has noise of its own
PATIENCE = 240_000  # milliseconds


def ball_under_a_lamp() -> None:
    """A ball and a floor beneath it, whose light is noisy with few samples."""
    empty_scene((0.2, 0.25, 0.3))
    added("uv_sphere", NAME, principled("Paint", (0.7, 0.3, 0.2), Roughness=0.8), segments=16, ring_count=8)
    added("plane", "Floor", principled("Floor", (0.8, 0.8, 0.8)), size=6).location.z = -1.2
    lamp((2.0, -2.0, 3.0), 300.0, 3.0)


def light(shown: Shown) -> Picture:
    shown.set_camera(CAMERAS[0])
    return shown.pixels()[..., :3].astype(np.float64)


def settled(shown: Shown) -> tuple[int, Picture]:
    """A picture of the page, and the samples that it shows: the next pass may come while it is drawn."""
    while True:
        before = shown.page.evaluate("radtex.samples()")
        picture = light(shown)
        if shown.page.evaluate("radtex.samples()") == before:
            return before, picture


def test_each_pass_is_nearer_to_the_reference_on_the_open_page(web: Site, tmp_path: Path) -> None:
    file = str(tmp_path / "scene.blend")
    ball_under_a_lamp()
    bpy.ops.wm.save_as_mainfile(filepath=file)
    bake = [sys.executable, "bake.py", file, *QUICK, "--layout", "buckets", "--samples"]
    much, refined = tmp_path / "much", tmp_path / "refined"
    subprocess.run([*bake, str(REFERENCE), "--seed", "9", "--out", str(much)], cwd=ROOT, check=True)
    options = ["--passes", str(PASSES), "--serve", "0", "--out", str(refined), "--progress", "json"]
    with subprocess.Popen(
        [*bake, str(SAMPLES), *options], cwd=ROOT, stdout=subprocess.PIPE, text=True
    ) as refining:
        try:
            assert refining.stdout is not None
            said = iter(refining.stdout)
            address = next(found.group() for line in said if (found := re.search(r"http://[^\"\s]+", line)))
            page = tab_of(web.browser, viewport={"width": 500, "height": 400})
            page.goto(f"{address}=0.3")
            page.evaluate("window.first = true; radtex.ready")
            shown, pictures, seen = Shown(page), [], 0
            while seen < PASSES:
                page.wait_for_function("seen => radtex.samples() > seen", arg=seen, timeout=PATIENCE)
                seen, picture = settled(shown)
                pictures.append((seen, picture))
            assert page.evaluate("window.first")  # the page has not been loaded again
        finally:
            refining.terminate()  # not Ctrl-C's signal, which a job of a script's in the background ignores
            try:
                refining.wait(60)
            except subprocess.TimeoutExpired:
                refining.kill()
                raise
    assert refining.returncode == 0
    truth = reference(web.browser, much)
    covered = truth.max(axis=2) > 0
    nearness = [(samples, decibels(picture, truth, covered)) for samples, picture in pictures]
    print(", ".join(f"{samples} samples: {each:.1f} dB" for samples, each in nearness))
    assert len(nearness) >= 2
    assert nearness[-1][0] == PASSES
    for (_, before), (_, after) in pairwise(nearness):
        assert after > before + GAIN


def reference(browser: Browser, folder: Path) -> Picture:
    """The page's picture of the bake with many samples."""
    with served(folder) as address:
        page = tab_of(browser, viewport={"width": 500, "height": 400})
        (export,) = folder.glob("*.web")
        page.goto(f"{address}/{export.name}/")
        page.evaluate("radtex.ready")
        return light(Shown(page))
