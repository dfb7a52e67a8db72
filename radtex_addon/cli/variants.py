# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of one object that differ in their light: how they are asked for, and what they are called."""

from __future__ import annotations

import csv
from dataclasses import replace

import bpy

from ..bake.spec import BakeSpec
from ..core.errors import InputError
from ..job.variants import variant_of
from ..scene.lamps import ALL, EACH, each_light
from ..scene.scratch import find_view_layer


def parse_lights(words: str) -> tuple[str, ...]:
    """Names that commas part; one with a comma stands in double quotes. Raises InputError for none."""
    try:
        names = tuple(name.strip() for name in next(csv.reader([words], skipinitialspace=True), []))
    except csv.Error:  # a line's end in it, or a name without one
        names = ()
    if not names or not all(names):
        raise InputError(f"--lights {words}: give names of lamps or of collections, such as Key,Fill")
    if len(names) > 1 and {ALL, EACH}.intersection(names):
        raise InputError(f"--lights {words}: {ALL} and {EACH} stand alone; give --lights again for others")
    return names


def lit(spec: BakeSpec, lights: tuple[tuple[str, ...], ...]) -> BakeSpec:
    """The bake with the first of `lights`, if there are some. Raises InputError where one does not fit."""
    found = [spec if names == (ALL,) else replace(spec, lights=names) for names in lights]
    return found[0] if found else spec


def variants(
    specs: tuple[BakeSpec, ...], lights: tuple[tuple[str, ...], ...], scene: bpy.types.Scene
) -> tuple[BakeSpec, ...]:
    """Each of `specs` with each of the `lights` that are asked for, none twice.

    Raises InputError where each lamp is meant, and there is none.
    """
    meant: dict[tuple[str, ...], None] = {}
    for names in lights:
        found = each_light(find_view_layer(scene, None)) if names == (EACH,) else (names,)
        meant |= dict.fromkeys(() if one == (ALL,) else one for one in found)
    return tuple(replace(spec, lights=one) for spec in specs for one in meant) if meant else specs


def titled(name: str, spec: BakeSpec, number: int, count: int) -> str:
    """What a run of `count` bakes calls the one with that number, from 0 on."""
    words = [f"{spec.split} {spec.part}"] if spec.part is not None else []
    if variant := variant_of(spec):
        words.append(variant)
    return ", ".join([name, *words]) + (f" ({number + 1} of {count})" if words else "")
