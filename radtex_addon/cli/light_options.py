# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Variants of a bake with different lights: parse `--lights`."""

from __future__ import annotations

import csv
from dataclasses import replace

from ..core.errors import InputError
from ..scene.lights.lamps import ALL, EACH
from ..settings.spec import BakeSpec


def parse_lights(words: str) -> tuple[str, ...]:
    """Parse names separated by commas; a name with a comma needs double quotes. Raises InputError."""
    try:
        names = tuple(name.strip() for name in next(csv.reader([words], skipinitialspace=True), []))
    except csv.Error:  # malformed, such as a line break in a name
        names = ()
    if not names or not all(names):
        raise InputError(f"--lights {words}: give names of lamps or of collections, such as Key,Fill")
    if len(names) > 1 and {ALL, EACH}.intersection(names):
        raise InputError(f"--lights {words}: {ALL} and {EACH} stand alone; give --lights again for others")
    return names


def lit(spec: BakeSpec, lights: tuple[tuple[str, ...], ...]) -> BakeSpec:
    """`spec` with the first of `lights`, if any. Raises InputError if any of them does not fit `spec`."""
    found = [spec if names == (ALL,) else replace(spec, lights=names) for names in lights]
    return found[0] if found else spec
