# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The fingerprint in a sidecar: as JSON, compared, and of an atlas that is added to."""

from __future__ import annotations

from dataclasses import replace

import pytest

from radtex_addon.core.errors import FormatError
from radtex_addon.formats.fingerprint import KEY, Fingerprint, fingerprint_in
from radtex_addon.formats.json_reader import Facts

WHOLE = Fingerprint("of mesh", "of transform", "of materials", "of settings", "of surroundings")


def facts(value: object) -> Facts:
    return Facts({KEY: value}, "the sidecar")


def test_json_holds_all_of_it() -> None:
    assert fingerprint_in(facts(WHOLE.to_facts())) == WHOLE
    assert fingerprint_in(Facts({}, "the sidecar")) is None
    assert fingerprint_in(facts({"version": 2})) == Fingerprint(version=2)
    with pytest.raises(FormatError):
        fingerprint_in(facts({"version": 1, "mesh": 3}))


def test_what_is_not_known_differs() -> None:
    assert WHOLE.differences(WHOLE) == ()
    assert WHOLE.differences(replace(WHOLE, mesh="other", settings="other")) == ("mesh", "settings")
    assert Fingerprint().differences(Fingerprint()) == (
        "mesh",
        "transform",
        "materials",
        "settings",
        "surroundings",
    )


def test_an_atlas_that_is_added_to_keeps_its_settings_and_what_is_the_same() -> None:
    now = replace(WHOLE, materials="other", settings="other")
    assert now.folded_onto(WHOLE, everywhere=False) == replace(WHOLE, materials="")
    assert now.folded_onto(WHOLE, everywhere=True) == replace(WHOLE, materials="other")
    assert now.folded_onto(None, everywhere=True) is None
