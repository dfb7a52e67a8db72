# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The shared layout: single paths are captured, an atlas is fitted to them, and written as several images."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

import bpy

from ..bake.fit import fit_shared
from ..bake.progress import Progress, Stage
from ..bake.spec import BakeSpec
from ..core.atlas import AtlasLayout
from ..cycles.shared_capture import capture_shared
from ..formats.shared_files import layer_path, write_shared
from .files import OutputFiles, facts_of
from .made import Made
from .prepare import Prepared

FINER = 4  # times as many texels along each side has the diffuse colour, which needs no light


def bake_shared(
    scratch: bpy.types.Scene,
    original: bpy.types.Object,
    spec: BakeSpec,
    files: OutputFiles,
    prepared: Prepared,
    folder: Path,
) -> Generator[Progress, None, Made]:
    """Bake the scratch scene's object; `folder` takes temporary files."""
    capture = yield from capture_shared(
        scratch,
        original,
        prepared.mesh,
        prepared.matrix_world,
        prepared.texels(),
        prepared.texels(FINER),
        spec.rays,
        spec.seed,
        folder,
    )
    yield Progress(Stage.FIT, 0, 1)
    fitted = fit_shared(capture.light, capture.ends, capture.surroundings, capture.colour, cells=spec.bucket)
    yield Progress(Stage.WRITE, 0, 1)
    plan = capture.plan
    width, height = plan.layout.width, plan.layout.height
    facts = facts_of(original.name, spec, width, height, prepared.uv_layer)
    sidecar = write_shared(files.sidecar, fitted.atlas, facts, spec.half, spec.compression)
    images = tuple(layer_path(files.sidecar, layer) for layer in sidecar.bake.layers)
    _remove(set(files.images) - set(images))
    return Made(
        files=replace(files, images=images),
        layout=AtlasLayout(width, height, spec.bucket),
        covered_texels=len(plan.texel),
        paths=capture.paths,
        clamped=sidecar.bake.clamped,
        fireflies=fitted.fireflies,
    )


def _remove(images: set[Path]) -> None:
    """Of an overwritten bake: they would lie beside the sidecar of another."""
    for path in images:
        path.unlink(missing_ok=True)
