# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Extension objects that a stranger's file may have, for all readers: tests/strangers/extensions.json.

`bases` are two that RadTex wrote. An attack changes one of them: each of its `changes` is a path and what is
put there, or {"copy": PATH}. `readers` that look at what was changed must refuse it: "gltf" are those that
show a file, in Godot and in three.js; "python" is RadTex's own, which computes anew what shaders are told.
"""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

_FACTS = json.loads(Path(__file__).with_name("extensions.json").read_text(encoding="utf-8"))
OF_ANOTHER_CONTAINER = "a texture of another container"  # whose name is fine, but for its ending
BASES: dict[str, dict[str, Any]] = _FACTS["bases"]


def attacks(reader: str) -> list[tuple[str, dict[str, Any]]]:
    """What each attack on this reader is, and its extension object."""
    return [(each["what"], _changed(each)) for each in _FACTS["attacks"] if reader in each["readers"]]


def elsewhere(ending: str) -> list[str]:
    """Names that no reader may open; where they have a good ending, it is this one, such as ".dds"."""
    wanted = ["textures", "radiance", "file"]
    changes = [(each["what"], *change) for each in _FACTS["attacks"] for change in each["changes"]]
    names = [name for what, path, name in changes if path == wanted and what != OF_ANOTHER_CONTAINER]
    return [name.replace(".ktx2", ending) for name in names if isinstance(name, str)]


def _changed(attack: dict[str, Any]) -> dict[str, Any]:
    facts = deepcopy(BASES[attack["base"]])
    for path, value in attack["changes"]:
        place = _at(facts, path[:-1])
        place[path[-1]] = _value(value, BASES[attack["base"]])
    return facts


def _value(value: Any, base: dict[str, Any]) -> Any:
    """What a change puts into its place; copies may lie in an object of its own."""
    if not isinstance(value, dict):
        return value
    if "copy" in value:
        return deepcopy(_at(base, value["copy"]))
    return {key: _value(inner, base) for key, inner in value.items()}


def _at(facts: Any, path: list[Any]) -> Any:
    for key in path:
        facts = facts[key]
    return facts
