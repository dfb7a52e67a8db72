# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Patterns of bakes' names: what they become, and which are refused."""

from __future__ import annotations

from typing import Any

import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.settings.bake_names import LISTED, OBJECT, as_part, fill, filled, own_name, tokens_of
from radtex_addon.settings.presets import STOCK, quality_of, stock_values
from radtex_addon.settings.spec import BakeSpec, Layout

pytestmark = pytest.mark.one_blender


@pytest.mark.parametrize(
    ("pattern", "wrong"),
    [
        ("", "is empty"),
        ("  ", "is empty"),
        ("{object}.{colour}", '"{colour}"'),
        ("{}", '"{}"'),
        ("{object:4}", '"{object:4}"'),
        ("{object", "a { without"),
        ("object}", "a } without"),
        ("{object}/{quality}", '"/"'),
        ("a\\{object}", '"\\"'),
        ("{object}?", '"?"'),
        ("{object}#1", '"#"'),
        ("100%{object}", '"%"'),
        (".{object}", "begins or ends"),
        ("{object}.", "begins or ends"),
        (" {object}", "begins or ends"),
        ("con", "Windows"),
        ("{object}\n", "invisible"),
        ("{object}" + "x" * 91, "shorter"),
    ],
)
def test_a_name_that_no_files_can_have_is_refused(pattern: str, wrong: str) -> None:
    with pytest.raises(InputError) as raised:
        BakeSpec(bake_name=pattern)
    assert wrong in str(raised.value)
    if wrong[0] != '"' or "token" in str(raised.value):
        named = "begins" not in wrong and wrong not in ("Windows", "invisible", "shorter")
        assert not named or LISTED in str(raised.value)


def test_tokens_are_filled_in() -> None:
    spec = BakeSpec(texels=48, samples=3, bake_name="{scene} {object}-{resolution}x{samples}")
    whole = fill(spec.bake_name, {"scene": "Room", **tokens_of(spec)})
    assert whole == "Room {object}-48x3"
    assert filled(whole, "Vase") == "Room Vase-48x3"
    assert tokens_of(BakeSpec(density=1500.5))["resolution"] == "1500.5-per-metre"
    with pytest.raises(InputError, match=r"\{scene\}.*not known"):
        filled(spec.bake_name, "Vase")


def test_braces_of_names_are_no_tokens() -> None:
    assert filled(fill("{scene}.{object}", {"scene": "{object}"}), "a{quality}") == "{object}.a{quality}"
    assert filled("{{{object}}}", "Vase") == "{Vase}"
    BakeSpec(bake_name=fill("{object}.{scene}", {"scene": "{x"}))


def test_other_names_become_parts_of_files_names() -> None:
    for name in ("a/b", "50% #1", ".hidden", "con"):
        BakeSpec(bake_name=fill("{scene}", {"scene": as_part(name)}))
    assert as_part("Küche") == "Küche"


def test_the_usual_pattern_is_the_objects_name() -> None:
    assert BakeSpec().bake_name == OBJECT
    assert filled(OBJECT, "a{b") == "a{b"
    assert own_name(OBJECT, "Vase") == own_name("Vase", "Vase") == ""
    assert own_name("{object}.final", "Vase") == "Vase.final"


@pytest.mark.parametrize(("name", "label"), [(name, label) for name, label, _ in STOCK])
def test_a_presets_settings_have_its_quality(name: str, label: str) -> None:
    values: Any = stock_values(name)
    automatic = values["atlas_layout"] == "auto"
    layout = Layout.BUCKETS if automatic else Layout(values["atlas_layout"])
    chosen = {"layout": layout} if automatic else {"layout": layout, "bucket": values["bucket"]}
    spec = BakeSpec(texels=values["texels"], samples=values["samples"], **chosen)
    assert quality_of(spec, automatic=automatic) == label.lower()
    other = BakeSpec(texels=values["texels"] + 1, samples=values["samples"], **chosen)
    assert quality_of(other, automatic=automatic) == "custom"
    assert quality_of(spec, automatic=not automatic) == "custom"
