# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run uvunwrap, which flattens meshes into islands and packs them, in a thread of its own.

It works on this process's other cores without Python's lock; a job that is no longer wanted is cancelled.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...bake.progress import Progress, Stage, Steps
from ...core.arrays import Bools, Floats, Ints
from ...core.errors import BakeError, InputError
from ...core.messages import Setting, do

_PULSE = 0.01  # seconds between two looks at the job
FLATTENED, MERGED = 0.3, 0.8  # of the unwrap's progress: when islands are flat, and when they are merged
_UNITS = 1000  # of the progress of an unwrap
_STAGES = {"segmenting": (0.0, 0.4), "parameterizing": (0.4, 0.9)}  # shares of a job's time
_OWN_LAYER = do("bake on a UV layer of your own", Setting.UV)


@dataclass(frozen=True, eq=False)
class Charts:
    """Flattened triangles: `uv` (F, 3, 2) in the mesh's units, `owner` (F,) the island's number or -1."""

    uv: Floats
    owner: Ints


@dataclass(frozen=True, eq=False)
class PackedIslands:
    """Packed islands: `uv` (F, 3, 2) in texels of `width` x `height`, `density` in texels per unit.

    `owner` (F,) numbers the `islands`: those that overlapped themselves were taken apart.
    """

    uv: Floats
    owner: Ints
    islands: int
    width: int
    height: int
    density: float


def check_uvunwrap() -> None:
    """Raise InputError if there is no uvunwrap."""
    try:
        import uvunwrap  # noqa: F401, PLC0415  # loaded with the first unwrap, not with Blender
    except ImportError as error:
        raise InputError(
            "the Python module 'uvunwrap' is missing",
            do("install the RadTex extension in Blender, or with Python run it as: uv run bake.py"),
            _OWN_LAYER,
        ) from error


def flatten(points: Floats, faces: Ints, seams: Bools, begin: float = 0.0, end: float = 1.0) -> Steps[Charts]:
    """Flatten a mesh: points (V, 3), faces (F, 3), and which edges, from corner k to k + 1, are seams (F, 3).

    Yields progress, from `begin` to `end` of the time until all is flat. Raises BakeError if it fails.
    """
    import uvunwrap  # noqa: PLC0415

    mesh = uvunwrap.Mesh(
        np.ascontiguousarray(points, dtype=np.float32),
        np.ascontiguousarray(faces, dtype=np.uint32),
        seams=np.ascontiguousarray(seams, dtype=np.uint8),
    )
    job = uvunwrap.start([mesh], page_size=1024, padding=0, packing="fast")
    atlas = yield from _finished(job, FLATTENED * begin, FLATTENED * end)
    uv, owner = _of_triangles(atlas)
    return Charts(uv / max(atlas.texels_per_unit, 1e-30), owner)


def pack(points: Floats, faces: Ints, owner: Ints, padding: int, size: int) -> Steps[PackedIslands]:
    """Place flat islands: points (V, 2), faces (F, 3), and the islands (V,) of the points.

    `padding` texels around each island stay free, in the library's own count, but none along the atlas's
    edges. Islands are as large as fit into `size` x `size` texels. Yields progress. Raises InputError if
    `size` texels are too few for so many islands, BakeError if it fails.
    """
    import uvunwrap  # noqa: PLC0415

    flat = np.ascontiguousarray(points, dtype=np.float32)
    mesh = uvunwrap.Mesh(
        np.column_stack([flat, owner.astype(np.float32)]),  # it joins islands that have a place in common
        np.ascontiguousarray(faces, dtype=np.uint32),
        existing_uvs=flat,
    )
    job = uvunwrap.start([mesh], page_size=size + 2 * padding, padding=padding)
    atlas = yield from _finished(job, MERGED, 1.0)
    if atlas.page_count > 1:
        raise InputError(
            f"{size} texels are too few for the {atlas.chart_count} islands of this unwrap",
            do(f"ask for at least {_enough(atlas, size)} texels", Setting.TEXELS),
            do("less padding"),
        )
    uv, owner = _of_triangles(atlas)
    width, height = atlas.width - 2 * padding, atlas.height - 2 * padding
    placed = np.clip(uv - padding, 0, [width, height])  # it rounds to float32
    return PackedIslands(placed, owner, atlas.chart_count, width, height, atlas.texels_per_unit)


def _of_triangles(atlas: Any) -> tuple[Floats, Ints]:
    """The only mesh's uv (F, 3, 2) in texels, and its triangles' islands (F,), -1 for none."""
    (made,) = atlas.meshes
    uv = np.asarray(made.corner_uvs, dtype=np.float64).reshape(-1, 3, 2) * [atlas.width, atlas.height]
    return uv, np.asarray(made.chart, dtype=np.int64)[np.asarray(made.indices).reshape(-1, 3)[:, 0]]


def _enough(atlas: Any, size: int) -> int:
    """A power of two whose square holds all pages."""
    most = size * int(np.ceil(np.sqrt(atlas.page_count)))
    return 1 << max(most - 1, 0).bit_length()


def _finished(job: Any, begin: float, end: float) -> Steps[Any]:
    """Wait for a job; yields progress from `begin` to `end` of the whole unwrap. Closing this cancels it."""
    try:
        while not job.done:
            yield unwrap_progress(begin + (end - begin) * _share(job.progress))
            time.sleep(_PULSE)
        return job.result()
    except Exception as error:
        raise _failure(error) from error
    except BaseException as error:
        if type(error).__name__ == "PanicException":  # of Rust, which is no Exception
            raise _failure(error) from error
        raise
    finally:
        if not job.done:
            job.cancel()


def unwrap_progress(share: float) -> Progress:
    """Progress of the whole unwrap, from 0 to 1."""
    return Progress(Stage.UNWRAP, round(share * _UNITS), _UNITS)


def merge_progress(share: float) -> Progress:
    """Progress of the whole unwrap while islands are merged, from 0 to 1."""
    return unwrap_progress(FLATTENED + (MERGED - FLATTENED) * share)


def _share(progress: Any) -> float:
    """How much of a job is done, 0 to 1. How long packing takes is not known before."""
    if progress is None:
        return 0.0
    begin, end = _STAGES.get(progress.stage, (0.9, 0.9))
    return begin + (end - begin) * (progress.done / progress.total if progress.total else 0.0)


def _failure(error: BaseException) -> BakeError:
    return BakeError(
        f"the unwrap failed ({error})",
        do("let xatlas or Blender unwrap", Setting.UNWRAP, value="blender"),
        _OWN_LAYER,
    )
