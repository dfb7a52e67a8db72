# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A window pane that shows a room: python -m tests.bench.gallery interior

The room is not drawn: the pane alone is, from three places, and held against the room itself.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.report.gbuffer import GBuffer
from radtex_addon.report.metrics import Picture
from radtex_addon.settings.spec import BakeSpec, Kind

from .looking import (
    FILM_PIXELS,
    SUBJECT,
    Camera,
    added,
    baked,
    empty_scene,
    filmed,
    lamp,
    principled,
    rendered,
    resolved,
)
from .row import Row, Use

# A texel is 0.08 wide; one of 80 cells sees 0.06 of what is 1.7 behind the pane, the depth of the room.
SPEC = BakeSpec(
    denoise=True, kind=Kind.PROXY, content="*", texels=24, bucket=80, samples=14, uv_layer="UVMap"
)
CAMERAS = {
    "from the front": Camera((0.0, -4.6, 0.1), lens=70),
    "from the left": Camera((-2.4, -3.8, 0.5), lens=70),
    "from below right": Camera((2.0, -4.2, -0.9), lens=70),
}
_DEPTH = 1.7


def scene() -> None:
    """A room of 3 by 1.7 behind a pane of 2 by 2, under a lamp in its ceiling."""
    empty_scene((0.35, 0.45, 0.6)).cycles.max_bounces = 4
    pane = added("plane", SUBJECT, None, size=2, rotation=(np.pi / 2, 0, 0))
    pane.visible_shadow = pane.visible_diffuse = pane.visible_glossy = False  # or no daylight would come in
    shell: dict[str, tuple[Any, Any, tuple[float, float, float]]] = {
        "Floor": ((3.2, _DEPTH, 0.1), (0, _DEPTH / 2, -1.3), (0.32, 0.16, 0.07)),
        "Ceiling": ((3.2, _DEPTH, 0.1), (0, _DEPTH / 2, 1.3), (0.75, 0.74, 0.7)),
        "Left": ((0.1, _DEPTH, 2.6), (-1.55, _DEPTH / 2, 0), (0.55, 0.16, 0.1)),
        "Right": ((0.1, _DEPTH, 2.6), (1.55, _DEPTH / 2, 0), (0.12, 0.3, 0.5)),
        "Back": ((3.2, 0.1, 2.6), (0, _DEPTH + 0.05, 0), (0.7, 0.62, 0.45)),
        "Table": ((1.1, 0.6, 0.08), (-0.3, 0.9, -0.6), (0.5, 0.33, 0.18)),
        "Foot": ((0.16, 0.16, 0.6), (-0.3, 0.9, -0.93), (0.3, 0.2, 0.1)),
        "Cupboard": ((0.7, 0.5, 1.6), (1.1, 1.4, -0.45), (0.25, 0.4, 0.25)),
        "Picture": ((0.9, 0.06, 0.65), (-0.5, _DEPTH - 0.03, 0.35), (0.06, 0.1, 0.3)),
    }
    for name, (size, place, colour) in shell.items():
        item = added("cube", name, principled(name, colour, Roughness=0.8), size=1, location=place)
        item.scale = size
    ball = principled("Ball", (0.85, 0.35, 0.05), Roughness=0.5)
    added("uv_sphere", "Ball", ball, radius=0.24, location=(-0.3, 0.85, -0.32))
    lamp((0.0, 0.8, 1.2), watts=30, size=1.4, towards=(0.0, 0.8, 0.0))
    lamp((0.4, 0.05, -0.9), watts=14, size=0.5, towards=(0.1, 1.4, 0.6))


def rows(spec: BakeSpec = SPEC, stills: bool = True) -> Iterator[Row]:
    """The gallery's rows: the room from three places."""
    scene()
    with tempfile.TemporaryDirectory() as folder:
        bake = baked(spec, Path(folder))
        pixels, facts = read_buckets(bake.sidecar)
    layout = AtlasLayout(facts.width, facts.height, facts.bucket)
    cast(Any, bpy.data.objects[SUBJECT]).hide_render = True
    note = f"{pixels.size * 2:,} bytes on a GPU; {bake.words}"

    def shown(seen: GBuffer) -> Picture:
        uv, incidence = seen.uv[seen.hit], seen.incidence[seen.hit]
        looked = sample(pixels.astype(np.float32), layout, uv, incidence, Filter.QUADRILINEAR)
        return resolved(seen.spread(looked[:, :3]), seen)

    for name, camera in CAMERAS.items() if stills else ():
        seen = bake.seen(camera)
        yield Row(f"Interior, {name}", rendered(camera)[..., :3], shown(seen), seen.eroded, note)
    for camera in CAMERAS["from the front"].swung(32):
        seen = bake.seen(camera, FILM_PIXELS)
        yield Row("Interior, film", filmed(camera)[..., :3], shown(seen), seen.eroded, use=Use.FILM)
