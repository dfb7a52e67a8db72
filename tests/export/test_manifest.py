# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Manifests come back as they were written; what is no manifest is refused in a line that names the key."""

from __future__ import annotations

import json
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from radtex_addon.core.errors import FormatError
from radtex_addon.export.export_manifest import Manifest, read_manifest, write_manifest
from radtex_addon.formats.containers.texture import PixelFormat
from radtex_addon.formats.sidecar import Sidecar
from radtex_addon.forms.layered.files.layered_files import write_layered
from radtex_addon.textures.entry import Arranged, Container, TextureEntry
from tests.layered.made_up import made_up_atlas
from tests.strangers.attacks import BASES, attacks

BAKE = Sidecar("Vase", "radiance", 100, 60, 8, "RadTex", 4, 0, "portal", "RadTex 1", "5.2")


def entry(**changes: Any) -> TextureEntry:
    stored: tuple[Any, ...] = ((416, 512), 2, (100, 60), (104, 64), 3, (2, 1), (52, 64))
    kind = (Container.KTX2, PixelFormat.RGB9E5, True, Arranged.MATRIX)
    return replace(TextureEntry("Vase.radiance.ktx2", *kind, *stored), **changes)


def manifest(**changes: Any) -> Manifest:
    textures = {"radiance": entry()}
    whole = Manifest("RadTex 1", "Vase", "Vase.glb", "Vase.flat.png", BAKE.facts(), textures, 0.25)
    return replace(whole, **changes)


def test_a_manifest_comes_back(tmp_path: Path) -> None:
    path = tmp_path / "Vase.export.json"
    sliced = entry(arrangement=Arranged.SLICES, layers=64, pages=(1, 1), page_texels=(104, 64))
    for one in (entry(), sliced, entry(scale=2.5, offset=-1.0)):
        whole = manifest(textures={"radiance": one})
        write_manifest(path, whole)
        assert read_manifest(path) == whole
        assert path.read_text() == whole.to_json()
        told = json.loads(path.read_text())["textures"]["radiance"]
        assert told.get("range") == ([2.5, -1.0] if one.scale == 2.5 else None)


def test_the_keys_are_the_contracts() -> None:
    facts = json.loads(manifest().to_json())
    assert list(facts) == ["version", "tool", "name", "mesh", "flat", "flat_scale", "bake", "textures"]
    assert facts["version"] == 1
    assert facts["bake"] == BAKE.facts()
    assert facts["textures"]["radiance"] == {
        "file": "Vase.radiance.ktx2",
        "container": "ktx2",
        "format": "RGB9E5",
        "zstd": True,
        "arrangement": "matrix",
        "size": [416, 512],
        "layers": 2,
        "texels": [100, 60],
        "stored": [104, 64],
        "levels": 3,
        "pages": [2, 1],
        "page_texels": [52, 64],
    }


def test_a_layered_bake_has_its_layers(tmp_path: Path) -> None:
    facts, size = replace(BAKE, width=16, height=16, bucket=14), (104, 64)
    layered = write_layered(tmp_path / "Vase.radiance.json", made_up_atlas(16, 16), facts)
    one = {"layers": 1, "pages": (1, 1), "size": size, "texels": size, "page_texels": size}
    textures = dict.fromkeys(layered.bake.layers, entry(arrangement=Arranged.IMAGE, **one))
    written = manifest(bake=json.loads(layered.to_json()), textures=textures)
    assert Manifest.from_json(written.to_json()) == written
    lacking = json.loads(written.to_json())
    lacking["textures"] = {"colour": lacking["textures"]["colour"]}
    with pytest.raises(FormatError, match="has the textures colour, expected colour, irradiance, own"):
        Manifest.from_json(json.dumps(lacking))


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("version",), 2, "is of version 2, this RadTex reads 1: update RadTex"),
        (("version",), None, '"version" is null, expected a whole number'),
        (("tool",), 5, '"tool" is 5, expected text'),
        (("mesh",), "../../etc/passwd", '"mesh" is "../../etc/passwd", expected a file of the same folder'),
        (("flat",), "", "expected a file of the same folder"),
        (("flat_scale",), 0, "expected a number above 0"),
        (("bake",), [], '"bake" is \\[\\], expected an object'),
        (("bake", "version"), 9, 'in "bake" is of version 9'),
        (("bake", "texels"), [0, 4], 'in "bake": "texels" is \\[0, 4\\]'),
        (("textures",), {}, "has the textures none, expected radiance"),
        (("textures", "radiance", "file"), "a\\b", "expected a file of the same folder"),
        (("textures", "radiance", "container"), "png", '"container" is "png", expected exr or ktx2 or dds'),
        (("textures", "radiance", "format"), "BC1", '"format" is "BC1", expected RGBA16F or'),
        (("textures", "radiance", "zstd"), 1, '"zstd" is 1, expected true or false'),
        (("textures", "radiance", "size"), [416, 99999], "expected two whole numbers from 1 to 16384"),
        (("textures", "radiance", "layers"), 4096, "expected a whole number from 1 to 2048"),
        (("textures", "radiance", "layers"), 3, "has other layers than pages"),
        (("textures", "radiance", "levels"), 11, "expected a whole number from 1 to 10"),
        (("textures", "radiance", "texels"), [105, 60], "pages that do not hold its texels"),
        (("textures", "radiance", "page_texels"), [50, 64], "pages that do not hold its texels"),
    ],
)
def test_what_is_no_manifest_is_refused_by_its_key(
    place: tuple[str, ...], value: object, message: str
) -> None:
    facts = json.loads(manifest().to_json())
    inner = facts
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    with pytest.raises(FormatError, match=message) as caught:
        Manifest.from_json(json.dumps(facts), "Vase.export.json")
    assert "Vase.export.json" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_key_and_no_json_are_refused(tmp_path: Path) -> None:
    facts = json.loads(manifest().to_json())
    del facts["textures"]["radiance"]["pages"]
    with pytest.raises(FormatError, match='lacks "pages": it is no RadTex export'):
        Manifest.from_json(json.dumps(facts))
    with pytest.raises(FormatError, match="is not JSON"):
        Manifest.from_json("{")
    with pytest.raises(FormatError, match="no RadTex export"):
        Manifest.from_json("[]")
    with pytest.raises(FormatError, match=r"none\.json cannot be read"):
        read_manifest(tmp_path / "none.json")


@pytest.mark.parametrize("base", BASES)
def test_what_we_wrote_is_read(base: str) -> None:
    assert Manifest.from_json(json.dumps(BASES[base])).facts().items() <= _without_uris(BASES[base]).items()


@pytest.mark.parametrize(("what", "facts"), attacks("python"))
def test_what_a_stranger_made_is_refused(what: str, facts: dict[str, Any]) -> None:
    with pytest.raises(FormatError) as caught:
        Manifest.from_json(json.dumps(facts), "Vase.export.json")
    assert str(caught.value).isprintable()


def _without_uris(facts: dict[str, Any]) -> dict[str, Any]:
    """The manifest's JSON of an extension's."""
    found = deepcopy(facts)
    for entry in (*found["textures"].values(), *[found.get("mirror", {})]):
        entry.pop("uri", None)
    return found
