# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What shaders/radtex_layered.* must be told of a bake, in every language: definitions, textures, uniforms.

The uniform of a layer's texture is `radtex_<layer>_map`. All others are vectors of four numbers, or arrays of
such, so that they may lie in a uniform buffer in any order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ...core.errors import InputError
from ...formats.containers.texture import PixelFormat
from ...formats.json_reader import Facts
from ...textures.entry import TextureEntry
from .files.arrangement import (
    ALPHA,
    COLOUR,
    DISTANCES,
    EXIT_DIRECTION,
    EXIT_PLACE,
    FIELD,
    IRRADIANCE,
    NORMAL,
    OF_IMAGES,
    OWN,
    PLANE,
    REST,
    TANGENT,
    THINGS,
    THROUGH_COLOUR,
    THROUGH_REST,
    TINT,
    WIDTH,
    WORLD,
    padded_size,
)
from .files.sidecar import LayeredSidecar, ThroughCells
from .lookup.distance_field import columns_of
from .lookup.environment import MOST_BOXES, MOST_LAMPS, MOST_PLANES, Lamp, Plane, Shell
from .lookup.images import ROWS
from .lookup.lamp_shapes import LampShape, ShapeKind
from .lookup.lobes import STEPS, Material

Values = dict[str, list[float] | list[list[float]]]

_OF_MIRRORS = (TINT, WIDTH, TANGENT, OWN)  # read only where a material has lobes
_SURROUNDINGS = (WORLD, PLANE, THINGS, DISTANCES)
_COLOURS = (COLOUR, TINT, OWN, PLANE, THINGS, THROUGH_COLOUR)  # in blocks they are coded as sRGB
_UNDECODED = (PixelFormat.BC3, PixelFormat.BC7)
_OPTIONAL = (TINT, NORMAL, WIDTH, ALPHA, TANGENT, PLANE, THINGS)  # defined by their names


@dataclass(frozen=True)
class Stored:
    """How a texture holds a layer: a value is texel * `scale` + `offset`, but for the alpha of CLEAR_ALPHA.

    `part`: the share of the texture's width and height that is the layer's image, not padding beside it.
    `mean`: of the values, in the distances' texture alone.
    """

    scale: float = 1.0
    offset: float = 0.0
    part: tuple[float, float] = (1.0, 1.0)
    mean: float = 0.0


IMAGES = "radtex_images"  # of the values of a material, where its own images can show it
CLEAR_ALPHA = (OWN, PLANE, THINGS)


@dataclass(frozen=True)
class LookupCost:
    """What a lookup may cost.

    `steps`: fetches of distances, 0 to 2. `own_taps`, `rest_taps`: cells of a bucket that are blended, 3 or
    4. `second_lobe`: whether it is looked up where a material has one, or each has one in place of two.
    `exit_taps`: of the ways of light that comes through, 16 are looked at, or 4, as the textures' filter
    blends those of texels. `temporal`: of the cells of a bucket and of two levels of a picture one is read,
    drawn by chance, for an engine's temporal antialiasing.
    """

    steps: int = 1
    own_taps: int = 3
    rest_taps: int = 3
    second_lobe: bool = True
    exit_taps: int = 16
    temporal: bool = False


# The uniforms of the buffers that HLSL and WGSL declare, in order, and how many vectors each has.
BAKE_BUFFER = {
    "radtex_middle": 1,
    **{f"radtex_{layer}_range": 1 for layer in (COLOUR, IRRADIANCE, TINT, NORMAL, WIDTH, ALPHA, TANGENT)},
    **{f"radtex_{layer}_range": 1 for layer in (OWN, REST)},
    "radtex_own_tile": 1,
    "radtex_rest_tile": 1,
    **{f"radtex_{layer}_range": 1 for layer in _SURROUNDINGS},
    **{f"radtex_{layer}_levels": 1 for layer in (WORLD, PLANE, THINGS)},
    "radtex_distances_size": 1,
    "radtex_plane_place": 1,
    "radtex_plane_eye": 1,
    "radtex_things_eye": 1,
    "radtex_shell": MOST_PLANES,
    "radtex_box_low": MOST_BOXES,
    "radtex_box_high": MOST_BOXES,
    "radtex_lamp_place": MOST_LAMPS,
    "radtex_lamp_light": MOST_LAMPS,
    "radtex_lamp_across": MOST_LAMPS,
    "radtex_lamp_up": MOST_LAMPS,
}
MATERIAL_BUFFER = {"radtex_material": STEPS, "radtex_lobes": 2 * STEPS, "radtex_gloss": 1, "radtex_brush": 1}
IMAGES_BUFFER = {IMAGES: ROWS}  # of a material by its own images; in HLSL alone
THROUGH_BUFFER = {
    "radtex_exit_direction_range": 1,
    "radtex_exit_place_range": 1,
    "radtex_exit_tile": 1,
    "radtex_through_colour_range": 1,
    "radtex_through_rest_range": 1,
    "radtex_through_rest_tile": 1,
    "radtex_field_range": 1,
    "radtex_field_low": 1,
    "radtex_field_size": 1,
    "radtex_field_glass": 1,
    "radtex_field_tint": 1,
}

DEFAULT = LookupCost()
FULL = LookupCost(steps=2, own_taps=4, rest_taps=4)


def shader_facts(
    sidecar: LayeredSidecar, stored: Mapping[str, Stored], cost: LookupCost = DEFAULT
) -> dict[str, Any]:
    """All of it, as JSON: "defines", "layers" whose textures are read, "values", and "materials"."""
    return {
        "defines": definitions(sidecar, cost),
        "layers": list(layers_read(sidecar, cost)),
        "values": bake_values(sidecar, stored, cost),
        "materials": [material_values(sidecar, number, cost) for number in range(len(sidecar.materials))],
    }


def exported_facts(
    bake: Mapping[str, Any], textures: Mapping[str, TextureEntry], images: bool = False
) -> dict[str, Any]:
    """The `shader_facts` of an exported bake with this sidecar's JSON and these textures.

    With `images` materials are shown by their own images, where they can be, which may replace some layers.
    RADTEX_SRGB is defined where the shader has to decode colours, since the textures' formats say not that
    they are sRGB.
    """
    sidecar = LayeredSidecar.from_facts(Facts(dict(bake), "the bake"))
    there = tuple(layer for layer in sidecar.bake.layers if layer in textures or layer not in OF_IMAGES)
    if images:
        sidecar = replace(sidecar, bake=replace(sidecar.bake, layers=there))
    else:
        sidecar = replace(sidecar, looks=())
    stored = {layer: _stored(entry) for layer, entry in textures.items()}
    if DISTANCES in stored:
        stored[DISTANCES] = replace(stored[DISTANCES], mean=sidecar.nearness)
    facts = shader_facts(sidecar, stored)
    if any(textures[layer].format in _UNDECODED for layer in _COLOURS if layer in textures):
        facts["defines"]["RADTEX_SRGB"] = 1
    return facts


def layers_read(sidecar: LayeredSidecar, cost: LookupCost = DEFAULT) -> tuple[str, ...]:
    """The layers whose textures the shaders read."""
    without: tuple[str, ...] = () if _mirrors(sidecar) else _OF_MIRRORS
    if not sidecar.mirrors_itself:
        without += (OWN,)
    if not _draws_streaks(sidecar):
        without += (TANGENT,)
    if not _mirrors(sidecar) and sidecar.through is None:
        without += _SURROUNDINGS
    if not cost.steps:
        without += (DISTANCES,)
    without += of_nodes_alone(sidecar)
    return tuple(layer for layer in sidecar.bake.layers if layer not in without)


def of_nodes_alone(sidecar: LayeredSidecar) -> tuple[str, ...]:
    """The layers that only shader nodes read, which cannot follow rays through a field."""
    followed = sidecar.through is not None and sidecar.through.field is not None
    return (EXIT_DIRECTION, EXIT_PLACE) if followed else ()


def definitions(sidecar: LayeredSidecar, cost: LookupCost = DEFAULT) -> dict[str, int]:
    """What is defined before the shaders, or in WGSL overridden. Raises InputError for too many lamps."""
    layers = layers_read(sidecar, cost)
    lamps = len(sidecar.lamps) if WORLD in layers else 0
    if lamps > MOST_LAMPS:
        raise InputError(
            f'"{sidecar.bake.object_name}" mirrors {lamps} lamps, shaders at most {MOST_LAMPS}: bake it with '
            "fewer"
        )
    found = {f"RADTEX_{layer.upper()}": 1 for layer in _OPTIONAL if layer in layers}
    found |= {"RADTEX_LAMPS": lamps, "RADTEX_REST_CELLS": sidecar.rest_cells}
    if lamps and any(lamp.shape is not None for lamp in sidecar.lamps):
        found["RADTEX_SHAPES"] = 1
    room = PLANE in layers and isinstance(sidecar.plane, Shell)
    if lamps and not room and any(lamp.behind for lamp in sidecar.lamps):
        found["RADTEX_BEHIND"] = 1
    if PLANE in layers and isinstance(sidecar.plane, Shell):
        found["RADTEX_SHELL"] = len(sidecar.plane.heights)
    if THINGS in layers and len(sidecar.boxes):
        found["RADTEX_BOXES"] = len(sidecar.boxes)
    found |= {"RADTEX_STEPS": cost.steps, "RADTEX_REST_TAPS": cost.rest_taps}
    if _mirrors(sidecar):
        found |= {"RADTEX_MIRRORS": 1, "RADTEX_OWN_CELLS": sidecar.own_cells}
        second = cost.second_lobe and sidecar.second_lobes
        taps = cost.own_taps if sidecar.mirrors_itself else 0
        found |= {"RADTEX_OWN_TAPS": taps, "RADTEX_SECOND_LOBE": int(second)}
    if cost.temporal:
        found["RADTEX_TEMPORAL"] = 1
    if sidecar.glosses:
        found["RADTEX_GLOSSES"] = 1
    return found | _through_definitions(sidecar.through, cost)


def _through_definitions(through: ThroughCells | None, cost: LookupCost) -> dict[str, int]:
    if through is None:
        return {}
    found = {"RADTEX_THROUGH": 1, "RADTEX_THROUGH_CELLS": through.rest}
    if through.field is not None:
        return found | {"RADTEX_FIELD": 1}
    return found | {"RADTEX_EXIT_TAPS": cost.exit_taps, "RADTEX_EXIT_CELLS": through.exits}


def bake_values(sidecar: LayeredSidecar, stored: Mapping[str, Stored], cost: LookupCost = DEFAULT) -> Values:
    """The uniforms that are the same for all materials; `stored` tells of textures by layer.

    A layer that it lacks is stored as it is. Raises ValueError for a picture that is padded, and for
    distances without their mean.
    """
    layers = layers_read(sidecar, cost)
    values: Values = {}
    for layer in layers:
        found = stored.get(layer, Stored())
        cells = _cells(sidecar, layer)
        if layer in (WORLD, PLANE, THINGS, DISTANCES) and found.part != (1, 1):
            raise ValueError(f"{layer}: a picture must fill its texture")
        part = [share / cells for share in found.part]
        values[f"radtex_{layer}_range"] = _row([*part, found.scale, found.offset])
        if layer == FIELD:
            values |= _field_values(sidecar)
        if cells > 1 and layer != EXIT_PLACE:
            size = sidecar.rest if layer == REST else sidecar.coarse
            values["radtex_exit_tile" if layer == EXIT_DIRECTION else f"radtex_{layer}_tile"] = _tile(size)
    if WORLD in layers:
        values["radtex_middle"] = _row([*sidecar.middle, 0])
        for layer, picture in sidecar.pictures.items():
            levels = [picture.size, picture.levels - 1, np.log2(picture.sharpest), 0]
            values[f"radtex_{layer}_levels"] = _row(levels)
        values |= _lamp_values(sidecar.lamps)
    if THINGS in layers:
        mean = stored[DISTANCES].mean if DISTANCES in stored else 0.0
        if mean <= 0:
            raise ValueError("distances: expected the mean of the texture's values")
        values |= _things_values(sidecar, mean)
    if PLANE in layers and sidecar.plane is not None:
        values |= _plane_values(sidecar.plane)
    return values


def _lamp_values(lamps: Sequence[Lamp]) -> Values:
    if not lamps:
        return {}
    return {
        "radtex_lamp_place": [_row([*lamp.place, lamp.variance]) for lamp in lamps],
        "radtex_lamp_light": [_row([*lamp.irradiance, lamp.behind]) for lamp in lamps],
        **_shape_values([lamp.shape for lamp in lamps]),
    }


def _shape_values(shapes: Sequence[LampShape | None]) -> Values:
    """The shapes of lamps, if any has one; the fourth number of `across` is 0 where a lamp has none."""
    if not any(shapes):
        return {}
    across = [[0.0] * 4 if one is None else [*one.across, 1 / one.solid] for one in shapes]
    up = [[0.0] * 4 if one is None else [*one.up, one.kind == ShapeKind.DISC] for one in shapes]
    return {
        "radtex_lamp_across": [_row(row) for row in across],
        "radtex_lamp_up": [_row(row) for row in up],
    }


def _things_values(sidecar: LayeredSidecar, mean: float) -> Values:
    values: Values = {
        "radtex_distances_size": _row([sidecar.distances, 1 / mean, 0, 0]),
        "radtex_things_eye": _row([*sidecar.things_eye, 0]),
    }
    if len(sidecar.boxes):
        low, high = np.pad(sidecar.boxes, ((0, 0), (0, 0), (0, 1))).swapaxes(0, 1).astype(np.float64)
        values |= {"radtex_box_low": _rows(low), "radtex_box_high": _rows(high)}
    return values


def _field_values(sidecar: LayeredSidecar) -> Values:
    field = None if sidecar.through is None else sidecar.through.field
    if field is None:
        return {}
    return {
        "radtex_field_low": _row([*field.low, 1 / field.step]),
        "radtex_field_size": _row([*field.size, columns_of(field.size)]),
        "radtex_field_glass": _row([field.ior, field.slopes, field.reflections, field.all_around]),
        "radtex_field_tint": _row([*np.log2(field.tint), field.tints_reflections]),
    }


def _plane_values(plane: Plane | Shell) -> Values:
    if isinstance(plane, Shell):
        planes = np.column_stack([plane.normals, plane.heights]).astype(np.float64)
        return {"radtex_shell": _rows(planes), "radtex_plane_eye": _row([*plane.eye, 0])}
    return {
        "radtex_plane_place": _row([*plane.normal, plane.height]),
        "radtex_plane_eye": _row([*plane.eye, float(plane.eye @ plane.normal) - plane.height]),
    }


def material_values(sidecar: LayeredSidecar, number: int, cost: LookupCost = DEFAULT) -> Values:
    """The uniforms of one material: its curves at the steps of N.V."""
    material = sidecar.materials[number]
    falloff = sidecar.falloff[min(number, len(sidecar.falloff) - 1)]
    values: Values = {"radtex_material": _rows(np.column_stack([falloff, np.sin(material.bend)]))}
    if _mirrors(sidecar):
        spread = np.log2(material.variance)[..., None]
        lobes = np.concatenate([material.weight, spread], axis=2) if cost.second_lobe else _merged(material)
        values["radtex_lobes"] = _rows(lobes.reshape(2 * STEPS, 4))
    if sidecar.glosses:
        gloss = material.gloss
        values["radtex_gloss"] = [_row([0] * 4 if gloss is None else [*gloss.colour, gloss.width])]
    if _draws_streaks(sidecar):
        values["radtex_brush"] = [_row([*(material.brush or (0, 0)), 0, 0])]
    look = sidecar.every_look[number]
    if look is not None:
        values[IMAGES] = _rows(np.array(look.rows))
    return values


def buffer_of(values: Values, layout: Mapping[str, int]) -> list[float]:
    """One of the buffers above: four numbers a vector, 0 for those that the bake lacks."""
    numbers: list[float] = []
    for name, count in layout.items():
        rows = np.zeros((count, 4))
        if name in values:
            given = np.reshape(values[name], (-1, 4))
            rows[: len(given)] = given
        numbers += rows.ravel().tolist()
    return numbers


def _stored(entry: TextureEntry) -> Stored:
    """How a texture is stored: in a range, and maybe padded to whole blocks."""
    width, height = entry.size
    return Stored(entry.scale, entry.offset, (entry.texels[0] / width, entry.texels[1] / height))


def _draws_streaks(sidecar: LayeredSidecar) -> bool:
    """Whether there is brushed metal, and lamps that it draws out: nothing else is asked for tangents."""
    return sidecar.brushes and bool(sidecar.lamps)


def _mirrors(sidecar: LayeredSidecar) -> bool:
    return any(material.weight.any() for material in sidecar.materials)


def _cells(sidecar: LayeredSidecar, layer: str) -> int:
    """Cells along the side of a layer's buckets; 1 for an image that is no buckets."""
    cells = {OWN: sidecar.own_cells, REST: sidecar.rest_cells}
    if sidecar.through is not None:
        cells |= {EXIT_DIRECTION: sidecar.through.exits, EXIT_PLACE: sidecar.through.exits}
        cells[THROUGH_REST] = sidecar.through.rest
    return cells.get(layer, 1)


def _tile(size: tuple[int, int]) -> list[float]:
    """The size of a tile's texels without padding, and half a texel, in units of a padded tile."""
    (width, height), (columns, rows) = size, padded_size(size)
    return _row([width / columns, height / rows, 0.5 / columns, 0.5 / rows])


def _merged(material: Material) -> npt.NDArray[np.float64]:
    """One lobe for two, twice (2, STEPS, 4): their weights' sum, and their variances' geometric mean."""
    bright = material.weight.sum(axis=2)
    share = bright / np.maximum(bright.sum(axis=0), 1e-9)
    spread = (share * np.log2(material.variance)).sum(axis=0)
    one = np.concatenate([material.weight.sum(axis=0), spread[:, None]], axis=1)
    return np.stack([one, one]).astype(np.float64)


def _row(values: npt.ArrayLike) -> list[float]:
    """Numbers with the digits that tell single floats apart."""
    return [float(str(number)) for number in np.asarray(values, dtype=np.float32)]


def _rows(values: npt.NDArray[np.float64]) -> list[list[float]]:
    return [_row(row) for row in values]
