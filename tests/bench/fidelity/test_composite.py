# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces one behind another, blended as an engine does."""

from __future__ import annotations

from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.report.gbuffer import Array, BakedSurface, CameraRays, GBuffer
from radtex_addon.scene.mesh.copy import NORMAL, SIGN, TANGENT
from tests.bench.fidelity.composite import LAYERS, seen_light
from tests.bench.fidelity.method import Baked

_PIXELS = 4
_BEHIND = np.linspace([0.1, 0.2, 0.3], [0.9, 0.8, 0.7], _PIXELS**2).reshape(_PIXELS, _PIXELS, 3)


def _stack(count: int) -> bpy.types.Mesh:
    """Triangles at the heights 0, -1, -2, ..., far wider than the view; u tells their number over `count`."""
    mesh = bpy.data.meshes.new("Stack")
    corners = [(x, y, -float(k)) for k in range(count) for x, y in ((-99.0, -99.0), (99, -99), (0, 198))]
    mesh.from_pydata(corners, [], [(3 * k, 3 * k + 1, 3 * k + 2) for k in range(count)])
    attributes = cast(Any, mesh).attributes
    for name, values in ((NORMAL, (0.0, 0, 1)), (TANGENT, (1.0, 0, 0))):
        attributes.new(name, "FLOAT_VECTOR", "CORNER").data.foreach_set("vector", values * 3 * count)
    attributes.new(SIGN, "FLOAT", "CORNER").data.foreach_set("value", (1.0,) * 3 * count)
    uv = np.repeat((np.arange(count) + 0.5) / count, 6)
    attributes.new("Bake", "FLOAT2", "CORNER").data.foreach_set("vector", uv)
    return mesh


def _seen(alphas: list[float], colours: Array, blocked: float = 1e9, behind: Any = _BEHIND) -> Array:
    """The picture of a stack of layers of these alphas and colours (count, 3), not premultiplied."""
    count = len(alphas)

    def number(buffer: GBuffer) -> Any:
        return np.minimum((buffer.uv[:, 0] * count).astype(int), count - 1)

    alpha = np.array(alphas)
    mesh = _stack(count)
    baked = Baked(
        paths=0, seconds=0, bytes=0, mesh=mesh, matrix_world=np.eye(4), uv_layer="Bake",
        radiance=lambda buffer: (alpha[:, None] * colours)[number(buffer)],
        alpha=lambda buffer: alpha[number(buffer)],
    )  # fmt: skip
    rays = CameraRays.of_camera((0, 0, 3), np.eye(3), 0.4, _PIXELS, 2)
    surface = BakedSurface(mesh, np.eye(4), "Bake")
    depth = -rays.away[:, 2]
    ends = blocked / depth
    first = surface.gbuffer(rays, ends)
    assert first.hit.all()
    return first.resolve(seen_light(baked, surface, rays, ends, first, behind))


_COLOURS = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]])


def test_layers_are_blended_from_the_front_over_what_lies_behind() -> None:
    found = _seen([0.5, 0.25, 0.5], _COLOURS)
    expected = [0.5, 0.5 * 0.25, 0.5 * 0.75 * 0.5] + 0.5 * 0.75 * 0.5 * _BEHIND
    assert found == pytest.approx(expected, abs=1e-6)


def test_an_opaque_layer_hides_the_rest() -> None:
    found = _seen([0.5, 1, 0.5], _COLOURS)
    assert found == pytest.approx(np.broadcast_to([0.5, 0.5, 0], found.shape), abs=1e-6)


def test_layers_behind_something_else_are_not_seen() -> None:
    found = _seen([0.5, 0.5, 0.5], _COLOURS, blocked=3.5)
    assert found == pytest.approx([0.5, 0, 0] + 0.5 * _BEHIND, abs=1e-6)


def test_there_is_an_end_to_layers_and_nothing_behind_is_black() -> None:
    found = _seen([0.1] * (LAYERS + 3), np.ones((LAYERS + 3, 3)), behind=None)
    assert found == pytest.approx(np.full(found.shape, 1 - 0.9**LAYERS), abs=1e-6)
