# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kind `transfer`: the object is captured under suns all around, and each texel's bucket fitted to them."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path

import bpy
import numpy as np

from ..bake.checkpoint import KEEPS_NOTHING, Keeper
from ..bake.plan import CapturePlan, plan_capture
from ..bake.progress import Progress, Stage
from ..bake.rays import PROBE_CELLS
from ..bake.spec import BakeSpec
from ..bake.thumbnail import Thumbnail
from ..bake.transfer import fit_buckets
from ..core.arrays import Floats
from ..core.atlas import AtlasLayout
from ..cycles.hidden import find_hidden
from ..cycles.transfer import capture_under_suns
from ..formats.transfer_files import TransferSidecar, write_transfer
from ..scene.scratch import scene_copied
from .files import OutputFiles, facts_of
from .made import Made
from .prepare import Prepared


def bake_transfer(
    scratch: bpy.types.Scene,
    original: bpy.types.Object,
    spec: BakeSpec,
    files: OutputFiles,
    prepared: Prepared,
    folder: Path,
    keeper: Keeper = KEEPS_NOTHING,
    thumbnail: Thumbnail | None = None,
) -> Generator[Progress, None, Made]:
    """Bake the scratch scene's object; `folder` takes temporary files, the `keeper` every finished render."""
    plan = yield from _plan(prepared, folder, keeper)
    suns = spec.bucket**2
    with scene_copied(scratch) as scene:
        lit = yield from capture_under_suns(
            scene, plan, suns, spec.samples, spec.seed, spec.memory_mb, folder, keeper, thumbnail
        )
    light = yield from fit_buckets(plan, lit.light, spec.bucket)
    yield Progress(Stage.WRITE, 0, 1)
    layout = AtlasLayout(plan.layout.width, plan.layout.height, spec.bucket)
    facts = facts_of(original.name, spec, layout.width, layout.height, prepared.uv_layer)
    written = write_transfer(
        files.sidecar,
        _image(plan, layout, light, lit.alpha),
        TransferSidecar(facts, suns),
        spec.half,
        spec.compression,
    )
    count = len(plan.texel)
    return Made(files, layout, count, count * suns * spec.samples, written.bake.clamped)


def _plan(prepared: Prepared, folder: Path, keeper: Keeper) -> Generator[Progress, None, CapturePlan]:
    """One ray for each texel, but for those that nobody sees."""
    texels = prepared.texels()
    probe = plan_capture(texels, PROBE_CELLS)
    hidden = yield from find_hidden(prepared.mesh, prepared.matrix_world, probe, folder, keeper)
    return plan_capture(texels, 1, without=probe.texel[hidden.all(axis=(1, 2))])


def _image(plan: CapturePlan, layout: AtlasLayout, light: Floats, alpha: Floats) -> Floats:
    """The atlas (H*n, W*n, 4) float32 of buckets (K, n*n, 3) and alphas (K,), gutter filled."""
    n = layout.bucket
    rgba = np.empty((*light.shape[:2], 4), dtype=np.float32)
    rgba[..., :3], rgba[..., 3] = light, alpha[:, None]
    return layout.from_buckets(plan.placed(rgba.reshape(-1, n, n, 4), gutter=True))
