# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The layered layout's textures and shader, against the sampler in numpy and against cases that are known."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import moderngl
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.octahedron import cell_directions, octahedron_to_direction, sample_octahedron
from radtex_addon.formats.codecs.bc3 import decode_bc3, encode_bc3
from radtex_addon.formats.codecs.srgb import from_srgb, to_srgb
from radtex_addon.forms.layered.cells import CELLS
from radtex_addon.forms.layered.lookup.atlas import look_at, sample_layered, shading_normal
from radtex_addon.forms.layered.lookup.edge_grid import EdgePictures, on_edges
from radtex_addon.forms.layered.lookup.environment import Impostor, Shell
from radtex_addon.forms.layered.shader_values import FULL
from tests.bench.fidelity.layered.compressed import compressed
from tests.bench.fidelity.layered.drawn_fragments import radiance
from tests.bench.fidelity.layered.lookup import lookup_of
from tests.layered.made_up import made_up_atlas, made_up_fragments
from tests.lookups import squared_steps

_RNG = np.random.default_rng(3)


@pytest.fixture(scope="module")
def context() -> Iterator[moderngl.Context]:
    with moderngl.create_context(standalone=True, backend="egl") as context:  # type: ignore[arg-type]  # wrong stub
        yield context


def _off(found: Floats, expected: Floats) -> Floats:
    return np.asarray(np.abs(found - expected) / (np.abs(expected) + 0.05))


def test_the_shader_knows_how_many_cells_buckets_have(context: moderngl.Context) -> None:
    atlas, textures = compressed(made_up_atlas(16, 64, CELLS[1]), near_sizes=(32, 32))
    at = made_up_fragments(atlas, 4000)
    off = _off(radiance(context, atlas, lookup_of(atlas, textures, FULL), at), sample_layered(atlas, at))
    assert off.mean() < 3e-3
    assert off.max() < 0.05


def test_lobes_widen_where_normals_differ_within_a_pixel(context: moderngl.Context) -> None:
    atlas, textures = compressed(made_up_atlas(16, 64, CELLS[1]), near_sizes=(32, 32))
    side, steady = 64, 0.002
    at, lookup = made_up_fragments(atlas, side**2), lookup_of(atlas, textures, FULL)
    normal = shading_normal(look_at(atlas, at), at)
    spread = steady * squared_steps(normal, np.ones(side**2, dtype=bool), side)
    assert np.median(spread) > 1e-3
    found = radiance(context, atlas, lookup, at, f"#define RADTEX_STEADY {steady}\n")
    off = _off(found, sample_layered(atlas, replace(at, spread=spread)))
    assert off.mean() < 3e-3
    assert off.max() < 0.05
    assert _off(found, sample_layered(atlas, at)).mean() > 0.01, "without, they are not the same"


def test_colours_and_alpha_come_back_from_bc3() -> None:
    ends = _RNG.uniform(size=(4, 4, 2, 4))
    share = _RNG.permuted(np.arange(16).reshape(1, 16).repeat(16, axis=0) % 4, axis=1) / 3
    share = share.reshape(4, 4, 4, 4).swapaxes(1, 2).reshape(16, 16, 1)
    first, last = (ends[:, :, end].repeat(4, axis=0).repeat(4, axis=1) for end in range(2))
    image = (first + (last - first) * share).astype(np.float32)
    image[..., 3] = np.linspace(0, 1, 16)
    found = decode_bc3(encode_bc3(image, np.ones((16, 16), np.float32)))
    assert np.abs(found[..., :3] - image[..., :3]).max() < 1.5 / 31
    assert np.abs(found[..., 3] - image[..., 3]).max() < 0.2 / 14 + 1 / 255  # half a step between the ends


def test_pixels_of_no_weight_do_not_disturb_others() -> None:
    image = np.full((4, 4, 4), 0.4, np.float32)
    image[0, :, :3] = _RNG.uniform(size=(4, 3))
    weight = np.ones((4, 4), np.float32)
    weight[0] = 1e-6
    assert np.abs(decode_bc3(encode_bc3(image, weight)) - image)[1:].max() < 1 / 31


def test_srgb_and_back() -> None:
    values = np.linspace(0, 1, 100, dtype=np.float32)
    np.testing.assert_allclose(from_srgb(to_srgb(values)), values, atol=1e-6)


def test_a_picture_on_edges_has_no_seam_and_is_as_sharp() -> None:
    size = 32
    directions = cell_directions(size).astype(np.float32)
    wave = np.sin(5 * directions[:, :1]) + np.cos(4 * directions[:, 1:2] * directions[:, 2:])
    image = wave.reshape(size, size, 1).astype(np.float32)
    along = np.linspace(0, 1, size, dtype=np.float32)
    interpolated = sample_octahedron(image, np.stack(np.meshgrid(along, along), axis=-1)).astype(np.float32)
    pictures, plain = EdgePictures((on_edges(image),), 1.0), EdgePictures((interpolated,), 1.0)
    sharp = np.full(size * size, 1e-6, np.float32)
    wrong = [np.abs(one.look(directions, sharp)[0] - image.ravel()).mean() for one in (pictures, plain)]
    assert wrong[0] < 0.4 * wrong[1]
    along = np.linspace(0.01, 0.49, 50, dtype=np.float32)
    edge = np.full_like(along, 1e-5)
    left, mirrored = np.stack([edge, along], axis=1), np.stack([edge, 1 - along], axis=1)
    both = [octahedron_to_direction(place).astype(np.float32) for place in (left, mirrored)]
    seen = [pictures.look(direction, sharp[:50])[0] for direction in both]
    np.testing.assert_allclose(seen[0], seen[1], atol=1e-3)


def test_a_ray_past_a_thing_does_not_show_it_where_it_hides_the_wall_from_its_eye() -> None:
    """A block lies before the middle of a wall, which a ray from aside meets beside the block."""
    direction = cell_directions(64)
    thing = direction[:, 0] > 0.97
    room = Shell(np.concatenate([np.eye(3), -np.eye(3)]).astype(np.float32), np.full(6, -2.0), np.zeros(3))
    block = np.array([[[0.8, -0.2, -0.2], [1.2, 0.2, 0.2]]], np.float32)
    found = Impostor.of(direction[thing], np.full(thing.sum(), 0.8), np.zeros(3, np.float32))
    found = replace(found, boxes=block, shell=room)
    offset = np.tile(np.array([0, 1.5, 0], np.float32), (3, 1))
    axis = np.array([[2, -1.5, 0], [2, -1.5, 0], [0.8, -1.4, 0]])
    axis = (axis / np.linalg.norm(axis, axis=1, keepdims=True)).astype(np.float32)
    met, _, cover = found.meet(offset, axis, np.array([1e-3, 0.06, 1e-3], np.float32))
    assert cover.tolist() == [0, 1, 1], "past it; as wide as sees it; and at it"
    np.testing.assert_allclose(met[:2], [[1, 0, 0]] * 2, atol=1e-3)
