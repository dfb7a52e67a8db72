# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Make a .blend with a sculpt of so many triangles, a sun and a camera: FILE TRIANGLES."""

from __future__ import annotations

import math
import sys
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from radtex_addon.core.arrays import Floats, Ints

_DEEP, _FINE = 0.5, 0.01  # of the radius: bumps and hollows, and what lies on them


def main(path: str, triangles: int) -> None:
    """Make the scene, and save it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    place, faces = _ball(math.ceil(math.sqrt(triangles / 12)))
    place *= (1 + _DEEP * _bumps(place, 1.0))[:, None]
    place *= (1 + _FINE * _bumps(place, 6.0))[:, None]
    mesh: Any = bpy.data.meshes.new("Sculpt")
    mesh.vertices.add(len(place))
    mesh.loops.add(faces.size)
    mesh.polygons.add(len(faces))
    mesh.vertices.foreach_set("co", place.astype(np.float32).ravel())
    mesh.loops.foreach_set("vertex_index", faces.astype(np.int32).ravel())
    mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 4, dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh.shade_smooth()
    mesh.materials.append(bpy.data.materials.new("Clay"))
    scene: Any = bpy.context.scene
    scene.collection.objects.link(bpy.data.objects.new("Sculpt", mesh))
    bpy.ops.object.light_add(type="SUN")
    bpy.ops.object.camera_add(location=(0, 0, 6))
    scene.camera, scene.render.engine, scene.cycles.samples = bpy.context.object, "CYCLES", 1
    scene.render.resolution_x = scene.render.resolution_y = 64
    bpy.ops.wm.save_as_mainfile(filepath=path, compress=False)
    print(f"{2 * len(faces):,} triangles")


def _ball(side: int) -> tuple[Floats, Ints]:
    """A unit ball of six grids of `side` x `side` quads: positions (V, 3), quads (F, 4)."""
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), axis=-1).reshape(-1, 1, 2)
    quads = grid + np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    faces = []
    for axis in range(3):
        for end in (0, side):
            face = np.insert(quads, axis, end, axis=-1)
            faces.append(face if (axis != 1) == (end == side) else face[:, ::-1])
    steps = side + 1
    number = np.concatenate(faces) @ [1, steps, steps**2]
    used, corner = np.unique(number, return_inverse=True)
    lattice: npt.NDArray[np.float64] = np.stack(
        [used % steps, used // steps % steps, used // steps**2], axis=1
    )
    place = lattice * (2 / side) - 1
    return place / np.linalg.norm(place, axis=1, keepdims=True), corner.reshape(-1, 4)


def _bumps(place: Floats, scale: float) -> Floats:
    """A sum of waves in random directions at positions (V, 3): (V,), about -1 to 1."""
    chance = np.random.default_rng(5)
    total = np.zeros(len(place))
    for octave in range(5):
        for _ in range(4):
            wave = chance.normal(size=3) * 1.4 * scale * 2**octave
            total += np.sin(place @ wave + chance.uniform(0, 2 * math.pi)) / (4 * 1.7**octave)
    return total


if __name__ == "__main__":
    main(sys.argv[-2], int(sys.argv[-1]))
