# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The draft of the layered layout: what it can show, from its maps as they were fitted."""

from __future__ import annotations

import logging
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np

from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Ints
from radtex_addon.core.fragments import Fragments
from radtex_addon.forms.layered.fit.buckets import ALL_PARTS, Parts
from radtex_addon.forms.layered.fit.fitting import fit_layered
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas, alpha_at, sample_layered
from radtex_addon.report.gbuffer import Array, GBuffer
from radtex_addon.scene.checks.camera_checks import camera_materials
from radtex_addon.settings.spec import BakeSpec, Layout

from ..layered.sizes import texture_bytes
from ..layered.staged import Staged, capture_staged
from ..method import Baked
from ..scenes import Stage

log = logging.getLogger(__name__)


def look(atlas: LayeredAtlas, faces: Ints, buffer: GBuffer) -> Array:
    """What a G-buffer's rays see of the atlas, (N, 3), linear; 0 where they miss. `faces` (F,): materials."""
    hit = buffer.hit
    fields = (buffer.uv, buffer.normal, buffer.incoming, buffer.position, buffer.tangent, buffer.bitangent)
    uv, normal, viewer, position, tangent, bitangent = (field[hit].astype(np.float32) for field in fields)
    at = Fragments(uv, normal, viewer, position, faces[buffer.triangle[hit]], tangent, bitangent)
    return buffer.spread(sample_layered(atlas, at))


def look_alpha(atlas: LayeredAtlas, buffer: GBuffer) -> Array:
    """How much is hidden of what lies behind a G-buffer's hits, (N,); 0 where rays miss."""
    alpha = alpha_at(atlas, buffer.uv[buffer.hit].astype(np.float32))
    return buffer.spread(alpha[:, None])[:, 0]


def baked_of(atlas: LayeredAtlas, staged: Staged, seconds: float = 0.0) -> Baked:
    """An atlas that was fitted to a capture, ready to be looked at."""
    return Baked(
        paths=staged.captured.paths,
        seconds=seconds,
        bytes=texture_bytes(atlas),
        radiance=partial(look, atlas, staged.captured.faces),
        mesh=staged.prepared.mesh,
        matrix_world=staged.matrix_world,
        uv_layer=staged.prepared.uv_layer,
        alpha=None if atlas.alpha is None else partial(look_alpha, atlas),
    )


class Layered:
    """Bakes and looks up; `bytes` are those of BC-compressed textures."""

    name = "layered"

    def __init__(self, spec: BakeSpec, parts: Parts = ALL_PARTS) -> None:
        self.spec, self.parts = spec, parts

    def bake(self, stage: Stage, folder: Path) -> Baked:
        for line in camera_materials(stage.subject):
            log.warning(line)
        started = perf_counter()
        staged = capture_staged(stage, self.spec, folder)
        captured = staged.captured
        middle = perf_counter()
        atlas = finished(fit_layered(captured.capture, self.parts))
        ended = perf_counter()
        print(
            f"{stage.name}: captured in {middle - started:.1f} s, fitted in {ended - middle:.1f} s, "
            f"{captured.paths / 1e6:.1f} M paths, {captured.rays / 1e6:.1f} M rays to the object itself",
            flush=True,
        )
        return baked_of(atlas, staged, ended - started)


def make(texels: int, samples: int) -> Layered:
    """The layered layout with no more paths than the plain one spends with 8 x 8 cells."""
    return Layered(BakeSpec(layout=Layout.LAYERED, texels=texels, samples=samples))
