# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of options: what is told once fits together, and fingerprints of earlier bakes hold."""

from __future__ import annotations

import hashlib
from collections import Counter
from dataclasses import fields
from typing import Any

import pytest

from radtex_addon.settings.options import MARKED, OPTIONS, SECTIONS, BakeOptions
from radtex_addon.settings.spec import BakeSpec, fingerprint_texts, key_facts

FIELDS = {field.name: field.default for field in fields(BakeOptions)}


@pytest.mark.parametrize(
    ("chosen", "digest"),
    [
        ({}, "2eafbaa62b08a4dba794cd08dde5f6395e8be1695d69dda6f8dc35e897098a20"),
        ({"alone": True}, "ed7c0da1cf56bd7cffbb2388316c06c0628c78490c5f8a508eb0b3a4baaee4c2"),
        (
            {"density": 64.0, "kind": "incident", "lights": ("Key",), "denoise": True, "memory_mb": 512},
            "45e37211de50acdd6f75e7571899a1a2b552c5d2ff2707df5b1ecd6cf5c074e0",
        ),
    ],
)
def test_the_settings_of_a_fingerprint_are_those_of_radtex_0_1(chosen: dict[str, Any], digest: str) -> None:
    """Others, and every bake that was made counts as changed: a new option has to be `added`."""
    texts = fingerprint_texts(BakeSpec(**chosen))
    assert hashlib.sha256("\n".join(texts).encode()).hexdigest() == digest


def test_what_a_resumed_bake_may_change_is_no_fact_of_its_key() -> None:
    assert key_facts(BakeSpec()) == key_facts(BakeSpec(memory_mb=512, device="cpu", frame=3))
    asked = key_facts(BakeSpec(density=64.0, texels=16))
    assert asked == key_facts(BakeSpec(density=64.0, texels=32))
    assert asked.keys() < key_facts(BakeSpec()).keys()


def test_no_two_options_have_one_name() -> None:
    rows = [option for section in SECTIONS for option in section.options]
    for names in (
        [option.name for option in rows],
        [option.flag for option in rows],
        [option.setting for option in rows if option.title],
        [option.called for option in rows],
    ):
        assert [name for name, count in Counter(names).items() if name and count > 1] == []


def test_a_row_fits_its_field() -> None:
    assert {name for name, option in OPTIONS.items() if option.refusal and not option.called} == set()
    assert {name for name, option in OPTIONS.items() if option.limits or option.no_farm} <= FIELDS.keys()
    assert all(FIELDS[name] is False for name in MARKED)
    assert all(OPTIONS[name].default == value for name, value in FIELDS.items() if name in OPTIONS)
