# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidecar is a contract: its keys, its refusals, its file names, its fingerprint."""

from __future__ import annotations

import json
import unicodedata
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from radtex_addon.core.errors import BakeError, FormatError, InputError
from radtex_addon.formats.bucket_files import count_text, read_counts
from radtex_addon.formats.fingerprint import KEY, Fingerprint, fingerprint_in
from radtex_addon.formats.json_reader import MOST_VALUES, Facts
from radtex_addon.formats.sidecar import (
    Content,
    Part,
    Sidecar,
    Source,
    TexelDensity,
    check_readable,
    file_name,
    read_sidecar,
    safe_name,
    write_sidecar,
)

SIDECAR = Sidecar(
    *("Größe", "radiance", 64, 32, 8, "RadTex", 16, 3, "portal", "RadTex 0.1.0", "5.2.3"),
    layers=("diffuse",),
    clamped=2,
)


# Every filesystem's traps in one alphabet.
names = st.text(
    st.one_of(st.sampled_from('./\\ :*?"<>|CONcom1é\u0301\u202e\ud800\n~-'), st.characters()), max_size=150
)


def altered(**changes: Any) -> str:
    facts = json.loads(SIDECAR.to_json())
    facts.update(changes)
    return json.dumps(facts)


def test_version_1_says_exactly_this() -> None:
    assert json.loads(SIDECAR.to_json()) == {
        "version": 1,
        "kind": "radiance",
        "layout": "buckets",
        "texels": [64, 32],
        "bucket": 8,
        "object": "Größe",
        "uv_map": "RadTex",
        "tangents": "mikktspace; Bt = sign * cross(N, T)",
        "color_space": "Linear Rec.709",
        "alpha": "premultiplied",
        "samples": 16,
        "seed": 3,
        "capture": "portal",
        "layers": ["diffuse"],
        "clamped": 2,
        "tool": "RadTex 0.1.0",
        "blender": "5.2.3",
    }


@given(names, names, st.lists(names, max_size=3), st.integers(1, 2**64 - 1), st.integers(0, 2**64 - 1))
def test_what_is_written_is_read(name: str, uv: str, layers: list[str], width: int, clamped: int) -> None:
    sidecar = replace(
        SIDECAR, object_name=name, uv_map=uv, layers=tuple(layers), width=width, clamped=clamped
    )
    assert Sidecar.from_json(sidecar.to_json()) == sidecar


def test_keys_of_later_tools_are_ignored() -> None:
    assert Sidecar.from_json(altered(license="CC0", extra={"a": [1]})) == SIDECAR


def test_a_version_it_does_not_know_is_refused() -> None:
    with pytest.raises(FormatError, match=r"a\.json is of version 2.*update RadTex"):
        Sidecar.from_json(altered(version=2, texels="in another way"), "a.json")


@pytest.mark.parametrize("key", json.loads(SIDECAR.to_json()))
def test_a_missing_key_is_named(key: str) -> None:
    facts = json.loads(SIDECAR.to_json())
    del facts[key]
    with pytest.raises(FormatError, match=f'a.json lacks "{key}"'):
        Sidecar.from_json(json.dumps(facts), "a.json")


@pytest.mark.parametrize("key", json.loads(SIDECAR.to_json()))
@pytest.mark.parametrize("value", [None, True, 1.5, -1, {}, [1, 2, 3], [0, 4], "x" * 1000])
def test_a_key_of_the_wrong_type_is_named(key: str, value: object) -> None:
    free_text = key in {"kind", "object", "uv_map", "capture", "tool", "blender"}
    if free_text and isinstance(value, str):
        return
    with pytest.raises(FormatError, match=f'"{key}" is .*, expected ') as raised:
        Sidecar.from_json(altered(**{key: value}), "a.json")
    assert len(str(raised.value)) < 200


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "1", '{"version": 1' + "0" * 9999 + "}", "[" * 100_000, "\ud800"]
)
def test_what_is_no_json_object_is_refused(text: str) -> None:
    with pytest.raises(FormatError, match="the sidecar is"):
        Sidecar.from_json(text)


def test_files_are_read_back_and_bad_ones_named(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    write_sidecar(path, SIDECAR)
    assert read_sidecar(path) == SIDECAR
    assert path.read_bytes().endswith(b"\n")
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FormatError, match=r"a\.json is not text"):
        read_sidecar(path)
    for missing in (tmp_path / "b.json", tmp_path):
        with pytest.raises(FormatError, match="cannot be read"):
            read_sidecar(missing)


@pytest.mark.parametrize("name", ["Suzanne", "Cube.001", "a b", "Größe", "茶壺", "-x", "console", "a~$%'(1)"])
def test_a_name_that_is_safe_stays(name: str) -> None:
    assert safe_name(name) == name


@pytest.mark.parametrize(
    ("name", "start"),
    [
        ("../../x", "_.._x-"),
        ("a/b\\c:d", "a_b_c_d-"),
        (".hidden", "hidden-"),
        ("end. ", "end-"),
        ("con", "_con-"),
        ("LPT1.x", "_LPT1.x-"),
        ("com¹", "_com¹-"),
        ("", "object-"),
        (" . ", "object-"),
        ("a\nb\x7f", "a_b_-"),
        ("gpj.\u202eexe", "gpj._exe-"),
        ("é" * 200, "é" * 45 + "-"),
    ],
)
def test_a_name_that_is_unsafe_is_cleaned_and_marked(name: str, start: str) -> None:
    safe = safe_name(name)
    assert safe.startswith(start)
    assert len(safe) == len(start) + 8


@given(names)
def test_safe_names_are_safe_and_stay_so(name: str) -> None:
    safe = safe_name(name)
    assert safe_name(safe) == safe
    assert 0 < len(safe.encode()) <= 100
    assert unicodedata.is_normalized("NFC", safe)
    assert not set(safe) & set('<>:"/\\|?*\0\n')
    assert safe[0] not in ". "
    assert safe[-1] not in ". "
    assert safe.split(".", maxsplit=1)[0].rstrip().lower() not in {"con", "nul", "com1"}


def test_decomposed_letters_are_composed_and_different_names_stay_different() -> None:
    assert safe_name("e\u0301") == "é"
    unsafe = ["a/b", "a\\b", "a:b", "a_b", "a*b", " a_b", "a_b ", "x" * 200, "x" * 201]
    assert len({safe_name(name) for name in unsafe}) == len(unsafe)


def test_file_names_are_the_contracts() -> None:
    assert file_name("Cube.001", "radiance", "exr") == "Cube.001.radiance.exr"
    assert file_name("Cube", "radiance", "json", layer="a/b").startswith("Cube.radiance.a_b-")


def test_a_written_name_works_on_this_filesystem(tmp_path: Path) -> None:
    for name in ("../../x", "\ud800", "é" * 200, "con", "", "a\0b"):
        path = tmp_path / file_name(name, "reflection", "json", layer=name)
        write_sidecar(path, SIDECAR)
        assert path.parent == tmp_path
        assert read_sidecar(path) == SIDECAR


@pytest.mark.parametrize(
    ("known", "keys"),
    [
        ({"lights": ("Key, left", "world")}, {"lights"}),
        ({"frame": 7, "content": Content("Büsche", ("Blatt",))}, {"frame", "content"}),
        (
            {"islands": 41, "coverage": 0.08, "wasteful": "covers only 8%"},
            {"islands", "coverage", "wasteful"},
        ),
        ({"kind": "ao", "ao_distance": 0.25}, {"ao_distance"}),
        (
            {"blend": "room.blend", "mesh": "a digest", "texel_samples": "16x4"},
            {"blend", "mesh", "texel_samples"},
        ),
        ({"objects": ("Vase", "Lamp"), "part": Part("material", "Gold", 1)}, {"objects", "part"}),
        ({"denoised": True, "marks": ("alone",)}, {"denoised", "alone"}),
        ({"texel_density": TexelDensity(64.0, 60.5)}, {"texel_density"}),
        ({"texel_weights": "Mehr"}, {"texel_weights"}),
        ({"backs": "none"}, {"backs"}),
    ],
)
def test_what_is_known_comes_back_and_is_not_told_where_there_is_none(
    known: dict[str, Any], keys: set[str]
) -> None:
    told = replace(SIDECAR, **known)
    assert Sidecar.from_json(told.to_json()) == told
    assert json.loads(told.to_json()).keys() - json.loads(SIDECAR.to_json()).keys() == keys


@pytest.mark.parametrize("cage", ["Käfig", None])
def test_a_source_comes_back(cage: str | None) -> None:
    told = replace(SIDECAR, source=Source("Höhe", 0.25, 3, cage))
    assert Sidecar.from_json(told.to_json()) == told
    whole = {"object": "Höhe", "extrusion": 0.25, "missed": 3} | ({"cage": cage} if cage else {})
    assert json.loads(told.to_json())["source"] == whole


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"frame": -1}, '"frame" is -1'),
        ({"ao_distance": 0}, '"ao_distance" is 0'),
        ({"lights": "Key"}, '"lights" is "Key"'),
        ({"source": "High"}, '"source" is "High", expected an object'),
        ({"source": {"extrusion": 0.1, "missed": 0}}, 'in "source" lacks "object"'),
        ({"source": {"object": "High", "extrusion": 0, "missed": 0}}, 'in "source": "extrusion" is 0'),
        ({"source": {"object": "High", "extrusion": 0.1, "missed": -1}}, '"missed" is -1'),
    ],
)
def test_a_frame_or_a_source_that_cannot_be_is_refused(changes: dict[str, Any], complaint: str) -> None:
    with pytest.raises(FormatError, match=complaint):
        Sidecar.from_json(altered(**changes))


def test_what_no_reader_takes_is_refused_before_the_bake_and_never_written() -> None:
    many = replace(SIDECAR, objects=tuple(map(str, range(MOST_VALUES))))
    with pytest.raises(BakeError, match=f"values, {MOST_VALUES} are the most: nothing was written"):
        many.to_json()
    half = replace(SIDECAR, objects=tuple(map(str, range(MOST_VALUES // 2 + 1))))
    assert Sidecar.from_json(half.to_json()) == half
    with pytest.raises(InputError, match=r"could not be read, it has \d+ values"):
        check_readable(half)  # its layout adds others


def test_runs_go_row_after_row_from_the_bottom() -> None:
    counts = np.array([[8, 8, 8], [8, 24, 24], [8, 8, 2**24 * 1000]])
    assert count_text(counts) == "8x4 24x2 8x2 16777216000x1"
    assert not count_text(np.full((4, 5), 16))  # equal ones need no words
    for each in (counts, np.random.default_rng(1).integers(1, 4, (37, 53))):
        np.testing.assert_array_equal(
            read_counts(count_text(each), each.shape[1], each.shape[0], "here"), each
        )


@pytest.mark.parametrize("text", ["", "8x4", "8x10", "0x9", "8x4,24x5", "8x4  24x5", "-8x9", "8x0 8x9"])
def test_what_does_not_fit_is_refused(text: str) -> None:
    with pytest.raises(FormatError, match=r'a\.json has a "texel_samples" that does not tell 3 x 3 texels'):
        read_counts(text, 3, 3, "a.json")


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
