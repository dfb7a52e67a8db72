# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the forms of occlusion have in common: which cells' rays are blocked."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path

import bpy

from ..bake.bands import Bands
from ..bake.piece_store import PieceStore
from ..bake.plan import CapturePlan
from ..bake.progress import Progress, Stage
from ..bake.session import capture_bands
from ..bake.spec import BakeSpec
from ..bake.thumbnail import Thumbnail
from ..cycles.occlusion import OcclusionCapture
from ..prepare.prepared import Prepared


@dataclass(frozen=True, eq=False)
class Captured:
    """The open share of each cell, in `bands` of the `plan`'s texels, of which each sent so many `rays`."""

    plan: CapturePlan
    bands: Bands
    rays: int


def capture_occlusion(
    scratch: bpy.types.Scene,
    spec: BakeSpec,
    prepared: Prepared,
    folder: Path,
    store: PieceStore,
    thumbnail: Thumbnail | None,
) -> Generator[Progress, None, Captured]:
    """Capture what is prepared: arguments as in `Form.bake`."""
    plan = yield from prepared.plan_of_seen(spec.bucket, folder, store)
    capture = OcclusionCapture(scratch, plan, spec.kind, spec.samples, spec.seed, folder, spec.ao_distance)
    bands = yield from capture_bands(plan, capture, spec.tile_mb, None, store, thumbnail, spec.channels)
    yield Progress(Stage.WRITE, 0, 1)
    return Captured(plan, bands, spec.bucket**2 * capture.rays)
