# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The script of the xatlas process, which `xatlas_process.py` runs by its path.

When an Atlas is destroyed, xatlas may wait for ever for one of its threads that was not told to end, and
holds Python's GIL meanwhile. So no Atlas is destroyed here, not even at the end of the process.

It reads pickles from standard input and answers on standard output: first the parent's sys.path, then
requests, each the name of a function below and its arguments. The process ends when its input ends.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import traceback
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, BinaryIO

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]
    Ints = NDArray[np.uint32]

_KEPT: list[object] = []


def flatten(
    points: Floats, faces: Ints, normals: Floats, chart: Mapping[str, object], pack: Mapping[str, object]
) -> tuple[object, ...]:
    """Flatten a mesh; returns the fields of `xatlas_process.Charts`, in order."""
    import xatlas

    atlas = xatlas.Atlas()
    _KEPT.append(atlas)
    atlas.add_mesh(points, faces, normals)
    atlas.generate(_set(xatlas.ChartOptions(), chart), _set(xatlas.PackOptions(), pack))
    _, index, uv = atlas.get_mesh(0)
    _, owner = atlas.get_mesh_vertex_assignment(0)
    return atlas.width, atlas.height, atlas.texels_per_unit, atlas.chart_count, index, uv, owner


def _set(options: Any, values: Mapping[str, object]) -> Any:
    for name, value in values.items():
        setattr(options, name, value)
    return options


def main() -> None:
    """Answer the parent process until it closes standard input."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles Ctrl-C, and kills this process
    _end_with_parent()
    answers = _answers()
    requests = sys.stdin.buffer
    sys.path[:] = pickle.load(requests)
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # numpy's threads are slow to start, and not needed here
    functions: dict[str, Callable[..., object]] = {"flatten": flatten}
    while requests.peek(1):
        name, arguments = pickle.load(requests)
        answers.write(pickle.dumps(functions[name](*arguments), pickle.HIGHEST_PROTOCOL))
        answers.flush()


def _end_with_parent() -> None:
    """On Linux, have this process killed when its parent dies; elsewhere it first finishes its request."""
    if sys.platform == "linux":
        import ctypes

        set_parent_death_signal = 1
        ctypes.CDLL(None).prctl(set_parent_death_signal, signal.SIGKILL)


def _answers() -> BinaryIO:
    """Reserve standard output for answers; what libraries print goes to standard error."""
    ours = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    return ours


if __name__ == "__main__":
    try:
        main()
    except BaseException:  # noqa: BLE001  # Python's normal exit would destroy the atlases
        traceback.print_exc()
        os._exit(1)
    os._exit(0)
