# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surroundings and distance fields as named arrays, in which a bake's store keeps what is finished."""

from __future__ import annotations

import numpy as np

from ....bake.piece_store import Arrays
from ....core.arrays import Floats
from ..lookup.distance_field import DistanceField, FieldFacts
from ..lookup.environment import Around, Impostor, Lamp, Pictures, Plane, Shell, SurroundingLayer
from ..lookup.lamp_shapes import LampShape, ShapeKind


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
    found["lamp_shapes"] = np.array(
        [_shape_row(lamp.shape) for lamp in around.lamps], dtype=np.float64
    ).reshape(-1, 8)
    return found


def _shape_row(shape: LampShape | None) -> list[float]:
    """The number of its kind, -1 for none, its vectors, and how large it is."""
    if shape is None:
        return [-1.0] + [0.0] * 7
    return [float(list(ShapeKind).index(shape.kind)), *shape.across, *shape.up, shape.solid]


def _shape_of(row: Floats) -> LampShape | None:
    if row[0] < 0:
        return None
    return LampShape(list(ShapeKind)[int(row[0])], _single(row[1:4]), _single(row[4:7]), float(row[7]))


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
    older = np.full((len(arrays["lamps"]), 8), -1.0)  # what was begun before lamps had shapes
    shapes = [_shape_of(row) for row in arrays.get("lamp_shapes", older)]
    lamps = tuple(
        Lamp(_single(row[:3]), _single(row[3:6]), float(row[6]), bool(row[7]), shape)
        for row, shape in zip(arrays["lamps"], shapes, strict=True)
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


def arrays_of_field(field: DistanceField) -> Arrays:
    """All of a distance field, by names that `field_of` reads."""
    facts = field.facts
    numbers = [*facts.low, facts.step, facts.ior, facts.slopes, facts.reflections, facts.all_around]
    numbers += [*facts.tint, facts.tints_reflections]
    return {"field": field.values, "field_facts": np.array(numbers, dtype=np.float64)}


def field_of(arrays: Arrays) -> DistanceField | None:
    """The inverse of `arrays_of_field`; None if there is no field among the arrays."""
    if "field" not in arrays:
        return None
    values, numbers = arrays["field"], arrays["field_facts"]
    depth, height, width = values.shape[:3]
    step, ior, slopes, reflections, all_around, red, green, blue, tints_reflections = numbers[3:].tolist()
    facts = FieldFacts(
        (width, height, depth),
        _single(numbers[:3]),
        step,
        ior,
        slopes,
        int(reflections),
        all_around,
        (red, green, blue),
        bool(tints_reflections),
    )
    return DistanceField(values, facts)
