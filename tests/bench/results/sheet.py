# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A sheet of pictures: the worst view of each scene, path traced and by each method, of the first seed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from PIL import Image

from radtex_addon.report.metrics import display

from ..fidelity.cache import picture_path
from ..fidelity.rendering import Rendering
from ..fidelity.report import tile
from .cells import Cell
from .kept_pictures import kept
from .matrix import MAIN, SEEDS
from .scenes import REFERENCE_SAMPLES

SHOWN = ("layered", "probe", "sg", "sh", "lightmap", "buckets", "eevee")
_REFERENCE_SEED = 11
_QUALITY = 72  # of the picture's file: a sheet stays below 300 kB


def save_sheet(path: Path, cells: Iterable[Cell]) -> bool:
    """Save a row for each scene, the worst first; false if pictures are missing."""
    layered = [
        cell
        for cell in cells
        if cell.key.method == "layered"
        and (cell.key.texels, cell.key.samples, cell.key.seed) == (MAIN.texels, MAIN.samples, SEEDS[0])
    ]
    rows = []
    for cell in sorted(layered, key=Cell.worst):
        row = _row(cell)
        if row is None:
            return False
        rows.append(row)
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.concatenate(rows, axis=0)).save(path, quality=_QUALITY, method=6)
    return bool(rows)


def _row(cell: Cell) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]] | None:
    """The view of a scene that the default shows worst; None if a picture of it is missing."""
    scene, views = cell.key.scene, list(cell.views)
    worst = min(views, key=lambda name: cell.views[name]["psnr"])
    path = picture_path(scene, worst, Rendering(REFERENCE_SAMPLES, _REFERENCE_SEED, alone=True))
    found = [kept(scene, method) for method in SHOWN]
    if not path.exists() or any(pictures is None for pictures in found):
        return None
    tiles = [tile(display(np.load(path)[..., :3]), f"{scene.rpartition('-')[2]}: path traced")]
    for method, pictures in zip(SHOWN, found, strict=True):
        assert pictures is not None
        tiles.append(tile(display(pictures[views.index(worst)]), method))
    return np.concatenate(tiles, axis=1)
