# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The JSON Schema of our glTF extension: docs/gltf/RADTEX_radiance_texture/schema."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator
from referencing import Registry, Resource

from radtex_addon.export.gltf import EXTENSION, extension_in
from radtex_addon.formats.containers.glb import Glb

EXTENSION_FOLDER = Path(__file__).resolve().parents[1] / "docs" / "gltf" / EXTENSION
TOP, TEXTURE, SHADER, MIRROR, BAKE = (
    f"{EXTENSION}.{name}" for name in ("textureInfo", "texture", "shader", "mirror", "bake")
)


@cache
def schemas() -> dict[str, Any]:
    """All schemas, by their names without the ending."""
    ending = ".schema.json"
    files = sorted((EXTENSION_FOLDER / "schema").glob(f"*{ending}"))
    return {path.name.removesuffix(ending): json.loads(path.read_text(encoding="utf-8")) for path in files}


@cache
def _validator() -> Draft202012Validator:
    resources = [(each["$id"], Resource.from_contents(each)) for each in schemas().values()]
    registry: Registry[Any] = Registry().with_resources(resources)
    return Draft202012Validator(schemas()[TOP], registry=registry)


def problems(facts: dict[str, Any]) -> list[str]:
    """What the schema finds wrong with an extension, and properties that it does not describe."""
    found = [f"{error.json_path}: {error.message}" for error in _validator().iter_errors(facts)]
    if found:
        return found
    parts: list[tuple[dict[str, Any], tuple[str, ...]]] = [
        (facts, (TOP,)),
        *((each, (TEXTURE,)) for each in facts.get("textures", {}).values()),
    ]
    parts += [(facts[name], names) for name, names in _INSIDE.items() if name in facts]
    for part, names in parts:
        known = {key for name in names for key in schemas()[name]["properties"]}
        found += [f"{key} is not described in {names[0]}" for key in part if key not in known]
    return found


_INSIDE = {"shader": (SHADER,), "mirror": (MIRROR, TEXTURE)}


def extensions_of(glb: Path) -> list[dict[str, Any]]:
    """The extension of each material of a .glb."""
    return [extension_in(each) for each in Glb.read(glb).document["materials"]]
