# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The shared layout: single paths are captured, an atlas is fitted to them, and written as several images."""

from __future__ import annotations

import logging
from collections.abc import Generator
from dataclasses import dataclass, replace
from pathlib import Path

import bpy

from ..bake.fit import fit_shared
from ..bake.keeper import KEEPS_NOTHING, Keeper
from ..bake.plan import CapturePlan
from ..bake.progress import Progress, Stage
from ..bake.rays import FINER
from ..bake.spec import BakeSpec
from ..bake.thumbnail import Thumbnail
from ..core.atlas import AtlasLayout
from ..core.shared import SharedAtlas
from ..cycles.shared_capture import capture_shared
from ..formats.shared_files import layer_path, texture_path, write_shared
from .bake_output import Made
from .condensed import Condensed, check_budget, condense_steps
from .files import OutputFiles
from .prepare import Prepared

_TOLD = 0.01  # of the light: less of it lost needs no word
_LOST = (
    "%.1f %% of the light of '%s' is lost as fireflies, which single paths brought and no others: "
    "take more samples, or a larger lamp"
)

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class FittedBake:
    """What a bake in the shared layout comes to before it is written: the `atlas` of the `plan`'s texels."""

    atlas: SharedAtlas
    plan: CapturePlan
    paths: int
    fireflies: float


def bake_shared(
    scratch: bpy.types.Scene,
    spec: BakeSpec,
    files: OutputFiles,
    prepared: Prepared,
    folder: Path,
    keeper: Keeper = KEEPS_NOTHING,
    thumbnail: Thumbnail | None = None,
) -> Generator[Progress, None, Made]:
    """Bake what is prepared; `folder` takes temporary files, the `keeper` every render and the files.

    Raises InputError for a budget that is too small for its texels.
    """
    fitted = yield from fit_bake(scratch, spec, prepared, folder, keeper, thumbnail)
    width, height = fitted.plan.layout.width, fitted.plan.layout.height
    facts = replace(prepared.facts(spec), fireflies=round(fitted.fireflies, 6))
    if fitted.fireflies > _TOLD:
        _log.warning(_LOST, 100 * fitted.fireflies, facts.object_name)
    condensed: Condensed | None = None
    if spec.condensed:
        steps = condense_steps(keeper.place(files.sidecar), fitted.atlas, fitted.plan, spec, facts)
        sidecar, condensed = yield from steps
    else:
        yield Progress(Stage.WRITE, 0, 1)
        place = keeper.place(files.sidecar)
        sidecar = write_shared(place, fitted.atlas, facts, spec.half, spec.compression)
    path_of = texture_path if spec.condensed else layer_path
    images = tuple(path_of(files.sidecar, layer) for layer in sidecar.bake.layers)
    return Made(
        files=replace(files, images=images),
        layout=AtlasLayout(width, height, spec.bucket),
        covered_texels=len(fitted.plan.texel),
        paths=fitted.paths,
        clamped=sidecar.bake.clamped,
        fireflies=fitted.fireflies,
        condensed=condensed,
    )


def fit_bake(
    scratch: bpy.types.Scene,
    spec: BakeSpec,
    prepared: Prepared,
    folder: Path,
    keeper: Keeper = KEEPS_NOTHING,
    thumbnail: Thumbnail | None = None,
) -> Generator[Progress, None, FittedBake]:
    """Capture the scratch scene's object and fit an atlas to it; errors as in `bake_shared`."""
    texels = prepared.texels()
    height, width = texels.triangle.shape
    check_budget(spec, width, height)
    capture = yield from capture_shared(
        scratch,
        prepared.original,
        prepared.mesh,
        prepared.matrix_world,
        texels,
        prepared.texels(FINER),
        spec.rays,
        spec.seed,
        folder,
        keeper,
        thumbnail,
    )
    fitted = yield from fit_shared(
        capture.light, capture.ends, capture.surroundings, capture.colour, cells=spec.bucket
    )
    return FittedBake(fitted.atlas, capture.plan, capture.paths, fitted.fireflies)
