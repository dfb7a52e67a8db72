# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A specification as JSON, for farms and background workers, and what of it tells bakes apart."""

from __future__ import annotations

import json
from dataclasses import fields
from enum import StrEnum
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from ..core.errors import FormatError, RadTexError
from ..formats.json_reader import Facts
from .option import Option
from .options import OPTIONS
from .spec import BakeSpec

# Names in keys that differ from the field's, as that is also the name of a digest of the scene.
_IN_KEYS = {"objects": "objects that share the atlas", "lights": "lamps that are lit"}
_MOST_FLOAT = 1e300  # of numbers in a specification: larger ones and NaN are refused


def facts_of(spec: BakeSpec) -> dict[str, Any]:
    """The fields of a specification as JSON's types."""
    return {field.name: as_json(getattr(spec, field.name)) for field in fields(BakeSpec)}


def as_json(value: Any) -> Any:
    """A field's value as JSON's types: enums as their text, tuples as lists."""
    if isinstance(value, StrEnum):
        return str(value)
    return [as_json(each) for each in value] if isinstance(value, tuple) else value


def key_facts(spec: BakeSpec) -> dict[str, str]:
    """What a bake must share with the unfinished one that it resumes, by its name in messages."""
    return {
        _IN_KEYS.get(name, name.replace("_", " ")): str(value)
        for name, value, option in _known(spec)
        if not option.resumes
    }


def fingerprint_texts(spec: BakeSpec) -> list[str]:
    """What the pixels of an atlas depend on, as text; numbers to six digits: the panel's are rounded."""
    return [
        f"{name} {f'{value:.6g}' if isinstance(value, float) else value}"
        for name, value, option in _known(spec)
        if option.of_atlas and not (option.added and value == option.default)
    ]


def _known(spec: BakeSpec) -> list[tuple[str, Any, Option]]:
    """Each field with its value and its row, but for the texels of a density, which are an estimate."""
    return [
        (field.name, getattr(spec, field.name), OPTIONS.get(field.name) or Option(field.name))
        for field in fields(spec)
        if spec.density is None or field.name != "texels"
    ]


def spec_in(facts: Facts) -> BakeSpec:
    """Inverse of `facts_of`. Raises FormatError for unknown, mistyped or impossible fields."""
    known = {field.name for field in fields(BakeSpec)}
    if unknown := sorted(facts.values.keys() - known):
        raise FormatError(
            f'{facts.source} has "{unknown[0]}", which this RadTex does not know: update RadTex'
        )
    values: dict[str, Any] = {
        key: tuple(value) if isinstance(value, list) else value for key, value in facts.values.items()
    }
    hints = get_type_hints(BakeSpec)
    for key, value in values.items():
        if not _fits(value, hints[key]):
            raise FormatError(f'{facts.source} has a "{key}" of another type: prepare it anew')
    try:
        return BakeSpec(**values)
    except (RadTexError, TypeError, ValueError, LookupError, AttributeError, ArithmeticError) as error:
        raise impossible(facts, error) from error


def impossible(facts: Facts, error: Exception) -> FormatError:
    """The error for facts from which no bake can be made."""
    return FormatError(
        f"{facts.source} is of a bake that cannot be ({json.dumps(str(error))}): prepare it anew"
    )


def _fits(value: Any, hint: Any) -> bool:
    """Whether a value from JSON is of a field's type; for enums any text, which BakeSpec parses."""
    if get_origin(hint) in (Union, UnionType):
        return any(_fits(value, each) for each in get_args(hint))
    if get_origin(hint) is tuple:
        return isinstance(value, tuple) and all(_fits(each, get_args(hint)[0]) for each in value)
    if issubclass(hint, StrEnum):
        return isinstance(value, str)
    if hint is float:
        return type(value) in (int, float) and abs(value) <= _MOST_FLOAT
    return type(value) is hint
