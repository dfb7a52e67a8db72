# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by test_wheels.py: use the wheels in a process where the symbols of Blender's libraries come first.

Usage: python -I beside_blender.py WHEELS OUT

The bpy module keeps Blender's libraries to itself, the Blender program does not: RTLD_GLOBAL makes the one do
as the other. Prints where the modules come from; what they say of their own accord goes to standard error.
"""
# ruff: noqa: PLC0415  # modules load after the flags

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path


def main(wheels: str, out: str) -> None:
    """Load Blender as its program is loaded, then unwrap, write and read, and judge a picture."""
    sys.path[:0] = [wheels, str(Path(__file__).resolve().parents[2])]
    own = sys.getdlopenflags()
    sys.setdlopenflags(own | os.RTLD_GLOBAL)
    importlib.import_module("bpy")
    sys.setdlopenflags(own)
    print(importlib.import_module("OpenEXR").__file__)
    print(importlib.import_module("xatlas").__file__)
    print(importlib.import_module("uvunwrap").__file__)
    print(importlib.import_module("flip_evaluator").__file__)
    unwrap()
    write_and_read(Path(out, "a.exr"))
    judge()


def unwrap() -> None:
    """A quad of two triangles is one island."""
    import numpy as np
    import uvunwrap
    import xatlas

    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    _vertices, triangles, uv = xatlas.parametrize(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32))
    assert triangles.shape == (2, 3)
    assert uv.shape == (4, 2)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    assert uvunwrap.generate([uvunwrap.Mesh(corners, faces)], page_size=64).chart_count == 1


def write_and_read(path: Path) -> None:
    """Half and float, one, three and four channels, each compression."""
    import numpy as np

    from radtex_addon.formats.containers.exr import Compression, read_atlas, write_atlas
    from radtex_addon.formats.sidecar import Sidecar

    sidecar = Sidecar("Cube", "radiance", 24, 10, 8, "RadTex", 16, 0, "portal", "RadTex 0.1.0", "5.2.3")
    for channels in (1, 3, 4):
        x = np.linspace(0, 3, 80 * 192 * channels).reshape(80, 192, channels)
        pixels = (1.5 + np.sin(x)).astype(np.float16).astype(np.float32)
        for half in (True, False):
            for compression in Compression:
                write_atlas(path, pixels, sidecar, half, compression)
                read, found = read_atlas(path)
                lossy = compression is Compression.DWAA
                np.testing.assert_allclose(read, pixels, rtol=0, atol=0.05 if lossy else 0)
                assert found == sidecar


def judge() -> None:
    """A picture is as itself, and black is not white."""
    import numpy as np

    from radtex_addon.report.metrics import flip_map

    white = np.ones((32, 32, 3))
    assert flip_map(white, white).max() == 0
    assert flip_map(0 * white, white).mean() > 0.9


if __name__ == "__main__":
    main(*sys.argv[1:])
