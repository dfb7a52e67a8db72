# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The specification of our glTF extension: schema, text, example and exports of every kind say the same."""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from radtex_addon.bake.progress import finished
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.gltf import EXTENSION, extension_in
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.formats.containers.texture import PixelFormat
from radtex_addon.settings.forms import FORMS
from radtex_addon.settings.kinds import Kind
from radtex_addon.textures.entry import Arranged, Container
from tests.blender.every_kind import EXPORTS, every_kind
from tests.gltf_schema import BAKE, EXTENSION_FOLDER, TEXTURE, extensions_of, problems, schemas
from tests.reference.textures import read_ktx2

README = (EXTENSION_FOLDER / "README.md").read_text(encoding="utf-8")
EXAMPLE = EXTENSION_FOLDER / "example" / "Ball.glb"

pytestmark = pytest.mark.one_blender  # test_export_gltf.py exports on each


@pytest.mark.parametrize("name", schemas())
def test_a_schema_is_one_and_the_text_has_its_properties_and_links_it(name: str) -> None:
    schema = schemas()[name]
    Draft202012Validator.check_schema(schema)
    assert schema["$id"] == f"{name}.schema.json"
    assert f"](schema/{name}.schema.json)" in README
    named = {
        word for words in re.findall(r"^\| (\*\*.+?) \|", README, re.MULTILINE) for word in words.split(", ")
    }
    assert {f"**{key}**" for key in schema["properties"]} - {"**extensions**", "**extras**"} <= named


@pytest.mark.parametrize(
    ("schema", "key", "words"),
    [
        (TEXTURE, "format", PixelFormat),
        (TEXTURE, "container", Container),
        (TEXTURE, "arrangement", Arranged),
        (BAKE, "kind", Kind),
        (BAKE, "layout", [form.layout for form in FORMS]),
    ],
)
def test_the_schema_has_every_word_that_exports_write(schema: str, key: str, words: Any) -> None:
    assert set(schemas()[schema]["properties"][key]["enum"]) == {str(word) for word in words}


def test_the_texts_example_is_valid() -> None:
    document = json.loads(re.findall(r"```json\n(.+?)```", README, re.DOTALL)[0])
    (material,) = document["materials"]
    assert problems(extension_in(material)) == []
    assert set(document["extensionsUsed"]) == {*material["extensions"], EXTENSION}


def test_the_example_in_the_repository_is_valid_and_small() -> None:
    (facts,) = extensions_of(EXAMPLE)
    assert problems(facts) == []
    (entry,) = facts["textures"].values()
    texture = read_ktx2(EXAMPLE.with_name(entry["uri"]))
    assert [texture.width, texture.height] == entry["size"]
    assert str(texture.format) == entry["format"]
    assert sum(path.stat().st_size for path in EXAMPLE.parent.iterdir()) < 200_000


def _without(key: str) -> Any:
    return lambda facts: facts.pop(key)


def _of_texture(**changes: Any) -> Any:
    return lambda facts: next(iter(facts["textures"].values())).update(changes)


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (_without("bake"), "'bake' is a required property"),
        (_without("textures"), "'textures' is a required property"),
        (lambda facts: facts.update(version=2), "1 was expected"),
        (lambda facts: facts["bake"].update(layout="layered"), "'shader' is a required property"),
        (lambda facts: facts["bake"].update(kind="sound"), "'sound' is not one of"),
        (_of_texture(format="JPEG"), "'JPEG' is not one of"),
        (_of_texture(size=[96]), "is too short"),
        (_of_texture(file="../secret"), "does not match"),
        (lambda facts: facts.update(colour=1), "colour is not described"),
    ],
)
def test_what_is_wrong_is_found(spoil: Any, words: str) -> None:
    (facts,) = extensions_of(EXAMPLE)
    facts = copy.deepcopy(facts)
    spoil(facts)
    assert any(words in problem for problem in problems(facts)), problems(facts)


@pytest.fixture(scope="module")
def bakes(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Path]:
    """Sidecars by kind; not to be written to."""
    return every_kind(tmp_path_factory.mktemp("kinds"))


@pytest.mark.parametrize("name", EXPORTS)
def test_an_export_is_valid(name: str, bakes: Mapping[str, Path], tmp_path: Path) -> None:
    kind, spec = EXPORTS[name]
    made = finished(export_steps(bakes[kind], spec, tmp_path / "made"))
    glb = made.folder / f"{made.name}.glb"
    found = extensions_of(glb)
    assert len(found) == (2 if kind == "layered" else 1)
    for number, facts in enumerate(found):
        assert problems(facts) == []
        assert facts.get("material", 0) == number
        assert ("mirror" in facts) == spec.mirror
        for texture in (*facts["textures"].values(), *([facts["mirror"]] if spec.mirror else [])):
            assert (made.folder / texture["uri"]).is_file()
    materials = Glb.read(glb).document["materials"]
    assert [each.get("extras", {}) for each in materials] == (
        [{"radtex_material": 0}, {"radtex_material": 1}] if kind == "layered" else [{}]
    )
