# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of a bake by the programs that show it: Chromium, Godot, and Blender's two engines.

All take RAYS x RAYS rays a pixel and give linear light (PIXELS, PIXELS, 3), rows from the top. Where one sees
through the object, each program blends it over the picture of what lies behind, as it blends over anything:
the page and Godot's Compatibility renderer blend display values, Blender blends light.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from radtex_addon.report.metrics import Picture
from tests.real.browser import Shown
from tests.real.godot import Shot, imported, linear
from tests.real.godot import pictures as shot_by_godot
from tests.real.preview_shot import Shots
from tests.real.root import Root
from tests.real.web import Site, encoded

from .looking import RAYS, Look, averaged

_DITHERED = 16  # samples of Eevee for each of these rays, where one sees through the object
# The canvas alone, before what lies behind.
_ALONE = """
    header, aside, footer, nav, #divider, #mark, dialog { display: none !important }
    #view { background: url(%s) 0 0 / 100%% 100%% }
"""


def by_chromium(site: Site, name: str, looked_from: Sequence[Look]) -> list[Picture]:
    """What the exported page `name` shows."""
    side = looked_from[0].camera.pixels
    found = []
    with site.opened(f"{name}/", width=side, height=side, device_scale_factor=1) as shown:
        shown.wait()
        for look in looked_from:
            shown.set_camera(look.camera)
            if look.view.behind is None:
                found.append(averaged(shown.pixels()[..., :3].astype(np.float64)))
            else:
                found.append(averaged(blended(shown, look.view.behind)))
    return found


def by_godot(root: Root, project: Path, renderer: str, looked_from: Sequence[Look]) -> list[Picture]:
    """What the exported project shows; brighter than 1 is clipped before pixels are averaged."""
    place = imported(root, project)
    shots = []
    for look in looked_from:
        behind = look.view.behind
        if behind is not None:
            _bytes_of(behind).save(place[0] / f"{look.name}.behind.png")
        shots.append(Shot(look.camera, behind=None if behind is None else f"{look.name}.behind.png"))
    return [averaged(picture) for picture in shot_by_godot(root, place, renderer, shots)]


def by_blender(
    preview: Path, name: str, engine: str, looked_from: Sequence[Look], folder: Path
) -> list[Picture]:
    """What `engine`, eevee or cycles, shows of the preview's object `name`, alone."""
    cameras = tuple(look.camera for look in looked_from)
    found = []
    clear = any(look.view.behind is not None for look in looked_from)
    shots = Shots(preview, engine, folder, name, _DITHERED if clear else 1)
    for look, picture in zip(looked_from, shots.layers(cameras), strict=True):
        mean = averaged(picture)
        behind = 0 if look.view.behind is None else look.view.behind
        found.append(mean[..., :3] + (1 - mean[..., 3:]) * behind)
    return found


def blended(shown: Shown, behind: Picture) -> Picture:
    """What the page shows over a picture (P, P, 3) on which its canvas lies, in as many pixels as it has."""
    stored = io.BytesIO()
    _bytes_of(behind).save(stored, "png")
    style = _ALONE % f"data:image/png;base64,{base64.b64encode(stored.getvalue()).decode()}"
    picture = shown.page.locator("#view").screenshot(style=style)
    with Image.open(io.BytesIO(picture)) as image:
        return linear(np.asarray(image.convert("RGB")) / 255)


def _bytes_of(light: Picture) -> Image.Image:
    """A picture of linear light as sRGB bytes, RAYS x RAYS for each of its pixels."""
    values = np.round(encoded(light) * 255).astype(np.uint8)
    return Image.fromarray(values.repeat(RAYS, axis=0).repeat(RAYS, axis=1))
