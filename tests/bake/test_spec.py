# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A spec that exists can be baked: everything else is refused in one line that names it and the remedy."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, replace
from typing import Any

import pytest

from radtex_addon.bake import memory_limits
from radtex_addon.bake.memory_limits import check_memory
from radtex_addon.bake.spec import (
    BakeSpec,
    CaptureMethod,
    Compression,
    Kind,
    Layout,
    Unwrap,
    parse_capture,
    parse_compression,
    parse_kind,
    parse_layout,
    parse_unwrap,
)
from radtex_addon.core.errors import InputError


def refusal(**changes: Any) -> str:
    with pytest.raises(InputError) as raised:
        check_memory(BakeSpec(**changes))
    message = str(raised.value)
    assert "\n" not in message
    assert raised.value.exit_code == 2
    return message


@pytest.mark.parametrize(
    ("name", "value", "bounds"),
    [
        ("texels", 0, "1 to 65536"),
        ("texels", -4, "1 to 65536"),
        ("bucket", 1, "2 to 256"),
        ("bucket", 257, "2 to 256"),
        ("samples", 0, "1 to 16777216"),
        ("seed", -1, "0 to 2147483647"),
        ("padding", -1, "0 to 256"),
        ("memory_mb", 0, "16 to 16777216"),
        ("texels", 64.0, "1 to 65536"),
        ("samples", True, "1 to 16777216"),
        ("bucket", "8", "2 to 256"),
    ],
)
def test_a_number_out_of_bounds_is_named_with_its_bounds(name: str, value: object, bounds: str) -> None:
    called = {"bucket": "cells", "memory_mb": "memory in MiB"}.get(name, name)
    assert refusal(**{name: value}) == f"{called} {value}: give a whole number from {bounds}"


def test_an_image_beyond_blenders_limit_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory_limits, "physical_memory", lambda: None)
    assert "makes 65544 pixels a side, 65536 is the most" in refusal(texels=8193, bucket=8)
    assert BakeSpec(texels=8192, bucket=8).pixels_a_side == 65536


def test_an_atlas_beyond_the_memory_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory_limits, "physical_memory", lambda: 2**30)
    needs = "a side of 4096 texels with 8 cells needs 4.3 GiB of memory"
    expected = f"{needs}, this machine has 1.0 GiB: lower one of them"
    assert refusal(texels=4096, bucket=8) == expected
    assert "a side of 4096 texels with 14 cells needs" in refusal(layout=Layout.LAYERED, texels=4096)
    assert BakeSpec(texels=1024, bucket=8).atlas_bytes < 2**30
    assert BakeSpec().atlas_bytes < 80 * 1024**2


@pytest.mark.parametrize("other", [{}, {"layout": "layered"}, {"kind": "transfer"}, {"accumulate": True}])
def test_a_bake_beyond_the_memory_that_is_allowed_is_refused(
    other: dict[str, object], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(memory_limits, "physical_memory", lambda: None)
    said = refusal(texels=512, memory_mb=64, **other)
    assert "of memory beside the scene, 64 MiB are allowed: allow more, or lower one" in said


def test_only_what_is_not_held_whole_is_large_at_little_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory_limits, "physical_memory", lambda: None)
    assert BakeSpec(texels=2048, bucket=16, memory_mb=2048).streams
    assert "needs 32.0 GiB" in refusal(texels=2048, bucket=16, memory_mb=2048, accumulate=True)


def test_tiles_take_what_the_atlas_leaves() -> None:
    assert BakeSpec().tile_mb == 1024
    spec = BakeSpec(texels=1024, memory_mb=600)
    assert 32 <= spec.tile_mb == 600 - spec.atlas_bytes // 2**20 < 400
    assert BakeSpec(texels=1024, memory_mb=8000).tile_mb == 1024


def test_a_panorama_cannot_look_inwards() -> None:
    assert "panoramic only looks outwards and cannot bake radiance" in refusal(capture="panoramic")
    assert BakeSpec(capture=CaptureMethod.PANORAMIC, kind=Kind.INCIDENT).kind is Kind.INCIDENT
    with pytest.raises(InputError, match="panoramic"):
        replace(BakeSpec(capture=CaptureMethod.PANORAMIC, kind=Kind.INCIDENT), kind=Kind.RADIANCE)


def test_the_layered_layout_chooses_its_cells_itself() -> None:
    assert BakeSpec(layout=Layout.LAYERED).bucket == 14
    assert "chooses its cells itself, 14 or fewer, not 8" in refusal(layout=Layout.LAYERED, bucket=8)
    assert BakeSpec(layout="layered") == BakeSpec(layout=Layout.LAYERED)  # type: ignore[arg-type]
    assert BakeSpec().layout is Layout.BUCKETS


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"kind": Kind.INCIDENT}, "knows kind radiance only, not incident: choose layout buckets"),
        ({"kind": Kind.REFLECTION}, "knows kind radiance only, not reflection"),
        ({"bucket": 1}, "cells 1: give a whole number from 2 to 256"),
        ({"capture": CaptureMethod.PANORAMIC}, "panoramic"),
        ({"samples": 4097}, "samples in the layered layout 4097: give a whole number from 1 to 4096"),
    ],
)
def test_what_the_layered_layout_does_not_know_is_refused(changes: dict[str, Any], words: str) -> None:
    assert words in refusal(layout=Layout.LAYERED, **changes)


def test_a_layered_bake_takes_fewer_paths_than_a_plain_one() -> None:
    assert 0.3 * BakeSpec().path_count < BakeSpec(layout=Layout.LAYERED).path_count < BakeSpec().path_count


def test_text_becomes_the_choice_it_names_and_costs_are_of_all_cells() -> None:
    made = BakeSpec(kind="incident", capture="panoramic", compression="dwaa", unwrap="blender")  # type: ignore[arg-type]
    assert (made.kind, made.capture) == (Kind.INCIDENT, CaptureMethod.PANORAMIC)
    assert (made.compression, made.unwrap) == (Compression.DWAA, Unwrap.BLENDER)
    assert (made.pixels_a_side, made.pixel_count, made.path_count) == (1024, 1024**2, 16 * 1024**2)
    assert BakeSpec(texels=1, bucket=2, samples=1).path_count == 4
    with pytest.raises(FrozenInstanceError):
        made.texels = 2  # type: ignore[misc]


def test_an_unknown_choice_is_refused_with_the_choices() -> None:
    assert refusal(kind="specular") == f"there is no kind 'specular': choose from {', '.join(Kind)}"
    assert refusal(layout="shared") == "there is no layout 'shared': choose from buckets, layered"
    assert "UV layer" in refusal(uv_layer="")
    for parse, word in (
        (parse_kind, "kind"),
        (parse_capture, "capture"),
        (parse_compression, "compression"),
        (parse_layout, "layout"),
        (parse_unwrap, "unwrap"),
    ):
        with pytest.raises(InputError, match=f"there is no {word} 'x': choose from "):
            parse("x")
