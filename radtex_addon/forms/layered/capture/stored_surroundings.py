# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surroundings as named arrays, in which a bake's store keeps what is finished."""

from __future__ import annotations

import numpy as np

from ....bake.piece_store import Arrays
from ....core.arrays import Floats
from ..lookup.environment import Around, Impostor, Lamp, Pictures, Plane, Shell, SurroundingLayer


def arrays_of(around: Around) -> Arrays:
    """All of it, by names that `around_of` reads."""
    found: Arrays = {"middle": around.middle} | _levels("world", around.world)
    for number, layer in enumerate(around.layers):
        found |= _levels(f"layer{number}", layer.pictures)
        shape = layer.shape
        if isinstance(shape, Plane):
            found[f"plane{number}"] = np.array([*shape.normal, shape.height])
        elif isinstance(shape, Shell):
            found[f"shell{number}"] = np.column_stack([shape.normals, shape.heights])
        else:
            found |= {f"nearness{number}": shape.nearness, f"boxes{number}": shape.boxes}
        found[f"eye{number}"] = shape.eye
    found["lamps"] = np.array(
        [[*lamp.place, *lamp.irradiance, lamp.variance, lamp.behind] for lamp in around.lamps],
        dtype=np.float64,
    ).reshape(-1, 8)
    return found


def around_of(arrays: Arrays) -> Around:
    """The inverse of `arrays_of`."""
    layers: list[SurroundingLayer] = []
    while f"layer{len(layers)}_sharpest" in arrays:
        number = len(layers)
        shape: Plane | Shell | Impostor
        eye = _single(arrays[f"eye{number}"])
        if f"plane{number}" in arrays:
            plane = arrays[f"plane{number}"]
            shape = Plane(_single(plane[:3]), float(plane[3]), eye)
        elif f"shell{number}" in arrays:
            planes = _single(arrays[f"shell{number}"])
            shape = Shell(planes[:, :3], planes[:, 3], eye)
        else:
            shell = next((each.shape for each in layers if isinstance(each.shape, Shell)), None)
            shape = Impostor(arrays[f"nearness{number}"], eye, arrays[f"boxes{number}"], shell)
        layers.append(SurroundingLayer(_pictures(f"layer{number}", arrays), shape))
    lamps = tuple(
        Lamp(_single(row[:3]), _single(row[3:6]), float(row[6]), bool(row[7])) for row in arrays["lamps"]
    )
    return Around(arrays["middle"], _pictures("world", arrays), tuple(layers), lamps)


def _levels(name: str, pictures: Pictures) -> Arrays:
    levels = {f"{name}_{number}": level for number, level in enumerate(pictures.levels)}
    return levels | {f"{name}_sharpest": np.array([pictures.sharpest], dtype=np.float64)}


def _pictures(name: str, arrays: Arrays) -> Pictures:
    levels: list[Floats] = []
    while f"{name}_{len(levels)}" in arrays:
        levels.append(arrays[f"{name}_{len(levels)}"])
    return Pictures(tuple(levels), float(arrays[f"{name}_sharpest"][0]))


def _single(values: Floats) -> Floats:
    return np.asarray(values, dtype=np.float32)
