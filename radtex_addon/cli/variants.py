# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Variants of a bake with different lights: parse `--lights`, make specifications and titles."""

from __future__ import annotations

import csv
from dataclasses import replace

import bpy

from ..bake.spec import BakeSpec
from ..core.errors import InputError
from ..job.variants import variant_of
from ..scene.lights.lamps import ALL, EACH, each_light
from ..scene.scratch import find_view_layer


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


def variants(
    specs: tuple[BakeSpec, ...], lights: tuple[tuple[str, ...], ...], scene: bpy.types.Scene
) -> tuple[BakeSpec, ...]:
    """Each of `specs` with each of `lights`, without duplicates.

    EACH stands for every lamp alone, and all light without lamps. Raises InputError if EACH is given and the
    scene renders no lamp.
    """
    meant: dict[tuple[str, ...], None] = {}
    for names in lights:
        found = each_light(find_view_layer(scene, None)) if names == (EACH,) else (names,)
        meant |= dict.fromkeys(() if one == (ALL,) else one for one in found)
    return tuple(replace(spec, lights=one) for spec in specs for one in meant) if meant else specs


def titled(name: str, spec: BakeSpec, number: int, count: int) -> str:
    """Title of bake `number` (from 0) in a run of `count` bakes."""
    words = [f"{spec.split} {spec.part}"] if spec.part is not None else []
    if variant := variant_of(spec):
        words.append(variant)
    return ", ".join([name, *words]) + (f" ({number + 1} of {count})" if words else "")
