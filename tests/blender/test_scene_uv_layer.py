# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A UV layer of the user's own is taken as it is, or refused with what is wrong and where."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.scene.uv.uv_layer import user_uv
from tests.blender.stage import read

context: Any = bpy.context  # to the stubs, every pointer may be None


def grid() -> Any:
    """Sixteen squares over the unit square of the layer 'UVMap'."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=4, y_subdivisions=4)
    return context.object


def move(item: Any, loops: slice, scale: float = 1, shift: tuple[float, float] = (0, 0)) -> None:
    layer = item.data.uv_layers[0].uv
    flat = np.empty(2 * len(layer), dtype=np.float32)
    layer.foreach_get("vector", flat)
    uv = flat.reshape(-1, 2)
    uv[loops] = uv[loops] * scale + np.array(shift, dtype=np.float32)
    layer.foreach_set("vector", flat)


def test_a_good_layer_is_taken_as_it_is(caplog: pytest.LogCaptureFixture) -> None:
    evaluated = read(grid())
    assert np.array_equal(user_uv(evaluated, "UVMap"), evaluated.uv("UVMap"))
    assert caplog.text == ""


def test_modifiers_are_seen() -> None:
    """Mirror lays one half over the other."""
    item = grid()
    item.modifiers.new("mirror", "MIRROR").use_axis = (False, False, True)
    for vertex in item.data.vertices:
        vertex.co.z = 1
    with pytest.raises(
        InputError, match=r"UV layer 'UVMap' of object 'Grid' overlaps in 100\.00% of its area"
    ):
        user_uv(read(item), "UVMap")


def test_a_missing_layer_is_answered_with_those_there_are() -> None:
    item = grid()
    item.data.uv_layers.new(name="lightmap")
    with pytest.raises(
        InputError, match=r"object 'Grid' has no UV layer 'Lightmap' .* choose 'UVMap' or 'lightmap'"
    ):
        user_uv(read(item), "Lightmap")
    for layer in list(item.data.uv_layers):
        item.data.uv_layers.remove(layer)
    with pytest.raises(InputError, match=r"leave the UV layer out to have one made"):
        user_uv(read(item), "Lightmap")


def test_a_sliver_without_area_passes_with_a_warning(caplog: pytest.LogCaptureFixture) -> None:
    item = grid()
    corners = item.data.polygons[0].vertices
    for index in corners:
        item.data.vertices[index].co = item.data.vertices[corners[0]].co
    move(item, slice(0, 4), scale=0)
    user_uv(read(item), "UVMap")
    assert "gives no area to 2 of 32 triangles" in caplog.text


def test_rounding_beyond_the_border_is_clipped() -> None:
    item = grid()
    move(item, slice(None), shift=(2e-6, -2e-6))
    uv = user_uv(read(item), "UVMap")
    assert uv.min() == 0
    assert uv.max() == 1


def test_coordinates_that_are_not_finite() -> None:
    item = grid()
    item.data.uv_layers[0].uv[3].vector = (float("nan"), 0)
    with pytest.raises(
        InputError, match=r"UV layer 'UVMap' of object 'Grid' has coordinates that are not finite"
    ):
        user_uv(read(item), "UVMap")


@pytest.mark.parametrize(
    ("moves", "words"),
    [
        ([(slice(None), 0, (0, 0))], r"of object 'Grid' is empty \(no triangle has area\)"),
        (
            [(slice(0, 4), 0, (0, 0))],
            r"gives no area to 2 of 32 triangles, 6\.\d% of the surface: unwrap those",
        ),
        (  # the first square on top of that at (0.25, 0.25) .. (0.375, 0.375)
            [(slice(None), 0.5, (0, 0)), (slice(0, 4), 1, (0.25, 0.25))],
            r"overlaps in 6\.6\d% of its area, worst at uv \(0\.(2[5-9]|3).*\), 2 tri",
        ),
        *(
            ([(slice(None), 1, shift)], r"reaches outside 0\.\.1, from \(.*\) to \(.*\): pack its islands")
            for shift in ((0.3, 0), (0, -0.01), (1, 0))
        ),
    ],
)
def test_a_layer_that_cannot_be_used_says_why(moves: list[Any], words: str) -> None:
    item = grid()
    for loops, scale, shift in moves:
        move(item, loops, scale, shift)
    with pytest.raises(InputError, match=rf"UV layer 'UVMap' .*{words}"):
        user_uv(read(item), "UVMap")
