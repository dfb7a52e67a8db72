# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What shaders are told of a layered bake: as JSON, in buffers, and what is refused."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.forms.layered.shader_values import (
    BAKE_BUFFER,
    MATERIAL_BUFFER,
    THROUGH_BUFFER,
    LookupCost,
    Stored,
    bake_values,
    buffer_of,
    definitions,
    layers_read,
    material_values,
    shader_facts,
)
from tests.layered_lookups import case_of

SHADERS = Path(__file__).parents[2] / "shaders"
BUFFERS = {"RadtexBake": BAKE_BUFFER, "RadtexMaterial": MATERIAL_BUFFER, "RadtexThrough": THROUGH_BUFFER}


@pytest.mark.parametrize("name", ["everything, in ranges", "bare", "matt"])
def test_facts_survive_json(name: str) -> None:
    case = case_of(name)
    facts = shader_facts(case.sidecar, case.stored)
    assert json.loads(json.dumps(facts)) == facts


def test_every_uniform_of_everything_is_in_a_buffer() -> None:
    case, room = case_of("everything"), case_of("room")
    values = bake_values(room.sidecar, room.stored) | bake_values(case.sidecar, case.stored)
    glass = case_of("glass ball")
    values |= bake_values(glass.sidecar, glass.stored) | material_values(case.sidecar, 0)
    assert set(values) == set(BAKE_BUFFER) | set(MATERIAL_BUFFER) | set(THROUGH_BUFFER)
    numbers = np.reshape(buffer_of(values, BAKE_BUFFER), (-1, 4))
    assert len(numbers) == sum(BAKE_BUFFER.values())
    np.testing.assert_allclose(numbers[0, :3], case.sidecar.middle, rtol=1e-6)
    np.testing.assert_allclose(numbers[-17, :3], case.sidecar.lamps[-1].irradiance, rtol=1e-6)
    shape = case.sidecar.lamps[-1].shape
    assert shape is not None
    np.testing.assert_allclose(numbers[-1, :3], shape.up, rtol=1e-6)


def test_what_is_not_looked_up_is_not_read() -> None:
    sidecar = case_of("matt").sidecar  # without lobes
    assert layers_read(sidecar) == ("colour", "irradiance", "rest")
    assert definitions(sidecar)["RADTEX_LAMPS"] == 0
    assert "RADTEX_PLANE" not in definitions(sidecar)
    sidecar = case_of("bare").sidecar  # mirrors nothing of itself
    assert layers_read(sidecar) == ("colour", "irradiance", "rest", "world")
    assert definitions(sidecar)["RADTEX_OWN_TAPS"] == 0
    sidecar = case_of("made up").sidecar
    assert "distances" in layers_read(sidecar)
    assert "distances" not in layers_read(sidecar, LookupCost(steps=0))
    sidecar = case_of("brushed").sidecar
    assert "tangent" in layers_read(sidecar)
    assert definitions(sidecar)["RADTEX_TANGENT"] == 1
    round_one = tuple(replace(material, brush=None) for material in sidecar.materials)
    for less in (replace(sidecar, materials=round_one), replace(sidecar, lamps=())):
        assert "tangent" not in layers_read(less)
        assert "RADTEX_TANGENT" not in definitions(less)
        assert "radtex_brush" not in material_values(less, 0)
    sidecar = case_of("glass ball").sidecar  # through which rays are followed
    assert {"exit_direction", "exit_place", "field"} <= set(sidecar.bake.layers)
    assert not {"exit_direction", "exit_place"} & set(layers_read(sidecar))
    assert "field" in layers_read(sidecar)
    assert "RADTEX_EXIT_TAPS" not in definitions(sidecar)


def test_one_lobe_is_as_bright_as_two() -> None:
    sidecar = case_of("made up").sidecar
    one, two = (
        np.reshape(material_values(sidecar, 1, LookupCost(second_lobe=both))["radtex_lobes"], (2, 16, 4))
        for both in (False, True)
    )
    np.testing.assert_allclose(one[0, :, :3], two[..., :3].sum(axis=0), rtol=1e-5)
    assert (one[0, :, 3] > two[..., 3].min(axis=0)).all()
    assert (one[0, :, 3] < two[..., 3].max(axis=0)).all()


def test_what_shaders_cannot_do_is_refused() -> None:
    case = case_of("made up")
    many = replace(case.sidecar, lamps=case.sidecar.lamps * 9)
    with pytest.raises(InputError, match='"Vase" mirrors 9 lamps, shaders at most 8'):
        definitions(many)
    with pytest.raises(ValueError, match="world: a picture must fill its texture"):
        bake_values(case.sidecar, case.stored | {"world": Stored(part=(0.5, 1.0))})
    with pytest.raises(ValueError, match="expected the mean"):
        bake_values(case.sidecar, {})


@pytest.mark.parametrize(
    ("language", "body", "member", "prefix"),
    [
        ("hlsl", r"cbuffer {} [^{{]*{{(.*?)}}", r"float4 (\w+)(?:\[(\d+)\])?;", ""),
        ("wgsl", r"struct {} {{(.*?)}}", r"(\w+): (?:vec4f|array<vec4f, (\d+)>),", "radtex_"),
    ],
)
def test_shaders_declare_the_buffers(language: str, body: str, member: str, prefix: str) -> None:
    files = (SHADERS / f"{name}.{language}" for name in ("radtex_layered", "radtex_layered_through"))
    text = "".join(path.read_text(encoding="utf-8") for path in files)
    for name, layout in BUFFERS.items():
        (inside,) = re.findall(body.format(name), text, re.DOTALL)
        found = [(f"{prefix}{word}", int(count or 1)) for word, count in re.findall(member, inside)]
        assert [count for _, count in found] == list(layout.values())
        if language == "hlsl" or name == "RadtexBake":
            assert [word for word, _ in found] == list(layout)
