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
SUMS = ("0.5,1", "0.5000001,1.00001")


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


def test_what_differs_by_rounding_is_the_same_and_is_compared_with_what_earlier_radtexes_wrote() -> None:
    exact = [f"sha256:{number:064x}" for number in range(2)]
    one, near = (
        replace(WHOLE, mesh=f"{digest} {'c' * 64} {sums}") for digest, sums in zip(exact, SUMS, strict=True)
    )
    told = one.to_facts()
    assert told["mesh"] == exact[0]
    assert told["near"] == {"mesh": f"{'c' * 64} {SUMS[0]}"}
    assert fingerprint_in(facts(told)) == one
    assert one.differences(near) == ()
    assert near.folded_onto(one, everywhere=False) == near
    earlier = fingerprint_in(facts({key: told[key] for key in told if key != "near"}))
    assert earlier is not None
    assert earlier.differences(one) == one.differences(earlier) == ()
    assert earlier.differences(near) == ("mesh",)
    moved = replace(near, mesh=near.mesh.replace(SUMS[1], "0.5,1.001"))
    assert one.differences(moved) == ("mesh",)
    with pytest.raises(FormatError):
        fingerprint_in(facts({**told, "near": "none"}))


def test_an_atlas_that_is_added_to_keeps_its_settings_and_what_is_the_same() -> None:
    now = replace(WHOLE, materials="other", settings="other")
    assert now.folded_onto(WHOLE, everywhere=False) == replace(WHOLE, materials="")
    assert now.folded_onto(WHOLE, everywhere=True) == replace(WHOLE, materials="other")
    assert now.folded_onto(None, everywhere=True) is None
