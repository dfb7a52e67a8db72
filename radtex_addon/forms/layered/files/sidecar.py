# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidecar of a bake in the layered layout: the keys of the plain sidecar, and an object "layered"."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ....core.arrays import Floats
from ....core.errors import BakeError, FormatError, ShapeError
from ....formats.json_reader import Facts, json_text
from ....formats.sidecar import Sidecar
from ..lookup.atlas import LayeredAtlas
from ..lookup.distance_field import FieldFacts, image_size
from ..lookup.environment import (
    MOST_BOXES,
    MOST_PLANES,
    Impostor,
    Lamp,
    Pictures,
    Plane,
    Shell,
    SurroundingLayer,
)
from ..lookup.images import Colour, ImageLook
from ..lookup.lamp_shapes import LampShape, ShapeKind
from ..lookup.lobes import LOBES, STEPS, Gloss, Material
from ..lookup.ways import Through
from .arrangement import (
    ALPHA,
    CHANNELS,
    COLOUR,
    DISTANCES,
    EXIT_DIRECTION,
    EXIT_PLACE,
    FIELD,
    IRRADIANCE,
    NORMAL,
    OWN,
    PICTURES,
    PLANE,
    REST,
    TANGENT,
    THINGS,
    THROUGH_COLOUR,
    THROUGH_REST,
    TINT,
    WIDTH,
    WORLD,
    near_layers,
    packed_size,
    padded_size,
)

LAYOUT = "layered"
_LARGEST, _MOST_LEVELS = 4096, 12  # of pictures
_MOST_LAMPS = 1024
_MOST_SAMPLES = 512  # of a distance field along a side
_MOST_REFLECTIONS = 1024
_DENSEST = 100.0  # index of refraction
MOST_MATERIALS = 1024  # of one atlas: a bake of more is refused before its first ray
_COLOURS_OF_LOOK = ("diffuse", "dielectric", "metal")
_STRONGEST = 1000.0  # normal map, or factor of an image
_MAPS = (TINT, NORMAL, WIDTH, ALPHA, TANGENT)


@dataclass(frozen=True)
class OctahedralPicture:
    """The size of an octahedral picture's sharpest level, how many levels it has, and that one's width²."""

    size: int
    levels: int
    sharpest: float


@dataclass(frozen=True)
class ThroughCells:
    """The cells along the sides of buckets of light that comes through: of its exits, and of the rest.

    `field`: of the field through which rays are followed, if there is one.
    """

    exits: int
    rest: int
    field: FieldFacts | None = None

    @classmethod
    def of(cls, through: Through) -> ThroughCells:
        """Those of light that comes through."""
        field = None if through.field is None else through.field.facts
        return cls(through.ways.shape[2], through.rest.shape[2], field)


@dataclass(frozen=True, eq=False)
class LayeredSidecar:
    """Facts about one bake in the layered layout.

    `bake` holds the facts of every layout: `width` x `height` texels of the irradiance, and as `bucket` the
    most cells that buckets can have. `colour` is the size of the maps of the material, `width` that of the
    lobes' widths, which may be as coarse as the irradiance; `coarse` tells how many texels have buckets, of
    `own_cells` x `own_cells` and `rest_cells` x `rest_cells` cells, and `rest` how many have those of the
    rest. `distances` are the cells along the side of that map, `nearness` its mean, 0 without, and
    `things_eye` (3,) whence it is seen, from the middle; in a room things lie in `boxes` (n, 2, 3). Falloffs
    (STEPS, 3) are by material, as are the lobes; so are `looks`, which tell how materials are shown by their
    own images, empty if none is. Unless an object `mirrors_itself`, its buckets of own light are (0, 0, 0, 1)
    everywhere.
    """

    bake: Sidecar
    colour: tuple[int, int]
    width: tuple[int, int]
    coarse: tuple[int, int]
    rest: tuple[int, int]
    own_cells: int
    rest_cells: int
    middle: Floats
    pictures: dict[str, OctahedralPicture]
    distances: int
    nearness: float
    plane: Plane | Shell | None
    lamps: tuple[Lamp, ...]
    falloff: Floats
    materials: tuple[Material, ...]
    through: ThroughCells | None
    looks: tuple[ImageLook | None, ...] = ()
    things_eye: Floats = field(default_factory=lambda: np.zeros(3, dtype=np.float32))
    boxes: Floats = field(default_factory=lambda: np.zeros((0, 2, 3), dtype=np.float32))
    mirrors_itself: bool = True

    @classmethod
    def of(cls, atlas: LayeredAtlas, bake: Sidecar) -> LayeredSidecar:
        """The facts about `atlas`, the rest from `bake`, whose `layers` are replaced.

        Raises ShapeError if both differ in size, BakeError for numbers that are not finite.
        """
        expected = (bake.height, bake.width)
        if atlas.irradiance.shape[:2] != expected:
            raise ShapeError(f"irradiance: expected shape {(*expected, 3)}, got {atlas.irradiance.shape}")
        for found, most, what in (
            (len(atlas.materials), MOST_MATERIALS, "materials"),
            (len(atlas.around.lamps), _MOST_LAMPS, "lamps"),
        ):
            if found > most:
                raise BakeError(f'"{bake.object_name}" has {found} {what}, a sidecar holds {most}')
        plane, things = near_layers(atlas)
        pictures = {WORLD: _picture(atlas.around.world)}
        pictures |= {
            name: _picture(layer.pictures) for name, layer in ((PLANE, plane), (THINGS, things)) if layer
        }
        shape = plane.shape if plane is not None else None
        through, wide = atlas.through, atlas.width
        sidecar = cls(
            bake=bake,
            colour=(atlas.colour.shape[1], atlas.colour.shape[0]),
            width=(bake.width, bake.height) if wide is None else (wide.shape[1], wide.shape[0]),
            coarse=(atlas.own.shape[1], atlas.own.shape[0]),
            rest=(atlas.rest.shape[1], atlas.rest.shape[0]),
            own_cells=atlas.own.shape[2],
            rest_cells=atlas.rest.shape[2],
            middle=atlas.around.middle,
            pictures=pictures,
            distances=0 if things is None else len(things.shape.nearness),  # type: ignore[union-attr]
            nearness=0.0 if things is None else float(things.shape.nearness.mean()),  # type: ignore[union-attr]
            plane=None if isinstance(shape, Impostor) else shape,
            lamps=atlas.around.lamps,
            falloff=_resampled(atlas.falloff),
            materials=atlas.materials,
            through=None if through is None else ThroughCells.of(through),
            looks=atlas.looks,
            mirrors_itself=bool((atlas.own != (0, 0, 0, 1)).any()),
            **({} if things is None else {"things_eye": things.shape.eye, "boxes": _boxes(things)}),
        )
        maps = [name for name in _MAPS if getattr(atlas, name) is not None]
        sidecar = replace(sidecar, bake=replace(sidecar.bake, layers=sidecar.layers_with(maps)))
        if not sidecar.is_finite():
            raise BakeError(
                f'a material, a lamp or the surroundings of "{bake.object_name}" have a value that is no '
                "finite number: nothing was written; bake it again"
            )
        return sidecar

    @property
    def shapes(self) -> dict[str, tuple[int, int, int]]:
        """Each layer's width, height and channels."""
        bake = self.bake
        sizes = dict.fromkeys((COLOUR, TINT, NORMAL, ALPHA), self.colour)
        sizes |= dict.fromkeys((IRRADIANCE, TANGENT), (bake.width, bake.height))
        sizes[WIDTH] = self.width
        sizes |= {OWN: _tiles(self.coarse, self.own_cells), REST: _tiles(self.rest, self.rest_cells)}
        sizes |= {name: packed_size(found.size, found.levels) for name, found in self.pictures.items()}
        sizes[DISTANCES] = (self.distances, self.distances)
        if self.through is not None:
            sizes |= dict.fromkeys((EXIT_DIRECTION, EXIT_PLACE), _tiles(self.coarse, self.through.exits))
            if self.through.field is not None:
                sizes[FIELD] = image_size(self.through.field.size)
            sizes |= {THROUGH_COLOUR: self.coarse, THROUGH_REST: _tiles(self.coarse, self.through.rest)}
        return {name: (*sizes[name], CHANNELS[name]) for name in bake.layers}

    @property
    def every_look(self) -> tuple[ImageLook | None, ...]:
        """`looks`, one for each material."""
        return self.looks or (None,) * len(self.materials)

    @property
    def second_lobes(self) -> bool:
        """Whether any of the materials has a second lobe."""
        return any(material.weight[1].any() for material in self.materials)

    @property
    def brushes(self) -> bool:
        """Whether any material is brushed, and there are tangents."""
        return TANGENT in self.bake.layers and any(material.brush for material in self.materials)

    @property
    def glosses(self) -> bool:
        """Whether any material has a gloss."""
        return any(material.gloss is not None for material in self.materials)

    def larger(self, texels: int, cells: int) -> LayeredSidecar:
        """Of a bake with `texels` times as many texels along a side, and `cells` times as many cells."""
        bake = self.bake
        return replace(
            self,
            bake=replace(
                bake, width=bake.width * texels, height=bake.height * texels, bucket=bake.bucket * cells
            ),
            colour=(self.colour[0] * texels, self.colour[1] * texels),
            width=(self.width[0] * texels, self.width[1] * texels),
            coarse=(self.coarse[0] * texels, self.coarse[1] * texels),
            rest=(self.rest[0] * texels, self.rest[1] * texels),
            own_cells=self.own_cells * cells,
            rest_cells=self.rest_cells * cells,
        )

    def to_json(self) -> str:
        """The sidecar's JSON, in ASCII and with a newline at its end."""
        layered: dict[str, Any] = {
            "colour": list(self.colour),
            **({"width": list(self.width)} if WIDTH in self.bake.layers else {}),
            "coarse": list(self.coarse),
            **({} if self.rest == self.coarse else {"rest": list(self.rest)}),
            "own_cells": self.own_cells,
            "rest_cells": self.rest_cells,
            **({} if self.mirrors_itself else {"mirrors_itself": False}),
            "middle": _row(self.middle),
            "pictures": {
                name: {"size": found.size, "levels": found.levels, "sharpest": found.sharpest}
                for name, found in self.pictures.items()
            },
        }
        plane = self.plane
        if isinstance(plane, Shell):
            planes = zip(plane.normals, plane.heights, strict=True)
            layered["shell"] = {
                "planes": [{"normal": _row(normal), "height": _short(height)} for normal, height in planes],
                "eye": _row(plane.eye),
            }
        elif plane is not None:
            layered["plane"] = {
                "normal": _row(plane.normal),
                "height": _short(plane.height),
                "eye": _row(plane.eye),
            }
        if self.distances:
            layered["distances"] = {"size": self.distances, "nearness": _short(self.nearness)}
            if self.things_eye.any():
                layered["distances"]["eye"] = _row(self.things_eye)
            if len(self.boxes):
                boxes = [{"low": _row(low), "high": _row(high)} for low, high in self.boxes]
                layered["distances"]["boxes"] = boxes
        layered["lamps"] = [
            {
                "place": _row(lamp.place),
                "irradiance": _row(lamp.irradiance),
                "variance": _short(lamp.variance),
                **({"behind": True} if lamp.behind else {}),
                **({"shape": _shape_facts(lamp.shape)} if lamp.shape is not None else {}),
            }
            for lamp in self.lamps
        ]
        layered["materials"] = [
            {
                "falloff": _rows(falloff),
                "lobes": [
                    {"weight": _rows(weight), "variance": _row(variance)}
                    for weight, variance in zip(material.weight, material.variance, strict=True)
                ],
                "bend": _row(material.bend),
                **({} if material.gloss is None else {"gloss": _gloss_facts(material.gloss)}),
                **({} if material.brush is None else {"brush": [_short(width) for width in material.brush]}),
                **({} if look is None else {"images": _look_facts(look)}),
            }
            for falloff, material, look in zip(self.falloff, self.materials, self.every_look, strict=True)
        ]
        if self.through is not None:
            layered["through"] = {"exit_cells": self.through.exits, "rest_cells": self.through.rest}
            if self.through.field is not None:
                layered["through"]["field"] = _field_facts(self.through.field)
        return json_text(self.bake.facts(LAYOUT) | {"layered": layered})

    @classmethod
    def from_json(cls, text: str, source: str = "the sidecar") -> LayeredSidecar:
        """Read the text of `to_json`; `source` names it in errors. Unknown keys are ignored.

        Raises FormatError if it is no JSON object, for another version or layout, a missing or mistyped key.
        """
        return cls.from_facts(Facts.parse(text, source))

    @classmethod
    def from_facts(cls, facts: Facts) -> LayeredSidecar:
        """Read the JSON of `to_json`. Raises FormatError as `from_json` does."""
        bake, layered = Sidecar.from_facts(facts, LAYOUT), facts.inner("layered")
        pictures = layered.inner("pictures")
        found = {name: _picture_in(pictures.inner(name)) for name in PICTURES if name in pictures.values}
        through = layered.inner("through") if "through" in layered.values else None
        distances = layered.inner("distances") if THINGS in found else None
        materials = _objects(layered, "materials", MOST_MATERIALS)
        sidecar = cls(
            bake=bake,
            colour=layered.size("colour"),
            width=layered.size("width") if "width" in layered.values else (bake.width, bake.height),
            coarse=layered.size("coarse"),
            rest=layered.size("rest" if "rest" in layered.values else "coarse"),
            own_cells=layered.whole_number("own_cells", 2, 256),
            rest_cells=layered.whole_number("rest_cells", 2, 256),
            middle=_vector(layered, "middle"),
            pictures=found,
            distances=0 if distances is None else distances.whole_number("size", 2, _LARGEST),
            nearness=0.0 if distances is None else distances.positive("nearness"),
            plane=_plane_in(layered) if PLANE in found else None,
            lamps=tuple(_lamp(lamp) for lamp in _objects(layered, "lamps", _MOST_LAMPS)),
            falloff=_floats([_table(material, "falloff") for material in materials]),
            materials=tuple(map(_material, materials)),
            through=None if through is None else _through_in(through),
        )
        if "mirrors_itself" in layered.values:
            sidecar = replace(sidecar, mirrors_itself=layered.truth("mirrors_itself"))
        if distances is not None and "eye" in distances.values:
            sidecar = replace(sidecar, things_eye=_vector(distances, "eye"))
        if distances is not None and "boxes" in distances.values:
            sidecar = replace(sidecar, boxes=_boxes_in(distances, sidecar.plane))
        looks = tuple(_look(each) for each in materials)
        if any(looks):
            sidecar = replace(sidecar, looks=looks)
        maps = [name for name in _MAPS if name in bake.layers]
        expected = sidecar.layers_with(maps)
        if sidecar.rest not in (sidecar.coarse, (bake.width, bake.height)):
            raise FormatError(
                f'{facts.source} in "layered": "rest" is neither "coarse" nor the atlas\'s size'
            )
        if not sidecar.is_finite():
            raise FormatError(f'{facts.source} in "layered" has numbers beyond the range of single floats')
        if WORLD not in found or not materials:
            raise FormatError(f'{facts.source} in "layered" lacks the world\'s picture, or materials')
        facts.constant("layers", list(expected))
        return sidecar

    def layers_with(self, maps: Sequence[str]) -> tuple[str, ...]:
        """The names of a bake's images, if it has these optional maps of the surface."""
        there = {COLOUR, IRRADIANCE, OWN, REST, *maps, *self.pictures}
        if THINGS in self.pictures:
            there.add(DISTANCES)
        if self.through is not None:
            there |= {EXIT_DIRECTION, EXIT_PLACE, THROUGH_COLOUR, THROUGH_REST}
            if self.through.field is not None:
                there.add(FIELD)
        return tuple(name for name in CHANNELS if name in there)

    def is_finite(self) -> bool:
        """Whether all numbers are finite as single floats, and all widths above 0."""
        with np.errstate(all="ignore"):
            return all(np.isfinite(np.asarray(part).astype(np.float32)).all() for part in self.numbers())

    def numbers(self) -> list[Floats]:
        """All numbers that must be finite."""
        found = [self.middle, self.falloff]
        found += [np.array(look.rows) for look in self.looks if look is not None]
        for material in self.materials:
            found += [material.weight, np.log(material.variance), material.bend]
            found += [] if material.brush is None else [np.log(material.brush)]
        for lamp in self.lamps:
            found += [lamp.place, lamp.irradiance, np.log([lamp.variance])]
            if lamp.shape is not None:
                found += [lamp.shape.across, lamp.shape.up]
        if isinstance(self.plane, Shell):
            found += [self.plane.normals, self.plane.heights, self.plane.eye]
        elif self.plane is not None:
            found += [self.plane.normal, np.array([self.plane.height]), self.plane.eye]
        if self.through is not None and self.through.field is not None:
            field = self.through.field
            found += [
                field.low,
                np.array([field.step, field.ior, field.slopes, field.all_around]),
                np.log(field.tint),
            ]
        return [*found, self.things_eye, self.boxes]


def _tiles(size: tuple[int, int], cells: int) -> tuple[int, int]:
    """Width and height of the image of buckets of width x height texels."""
    width, height = padded_size(size)
    return cells * width, cells * height


def _picture(pictures: Pictures) -> OctahedralPicture:
    return OctahedralPicture(len(pictures.levels[0]), len(pictures.levels), float(pictures.sharpest))


def _picture_in(facts: Facts) -> OctahedralPicture:
    found = OctahedralPicture(
        facts.whole_number("size", 2, _LARGEST),
        facts.whole_number("levels", 1, _MOST_LEVELS),
        facts.positive("sharpest"),
    )
    if found.size % (1 << (found.levels - 1)) or found.size >> (found.levels - 1) < 2:
        raise FormatError(f"{facts.source} has sizes that no picture has: {found.levels} of {found.size}")
    return found


def _through_in(facts: Facts) -> ThroughCells:
    field = _field_in(facts.inner("field")) if "field" in facts.values else None
    return ThroughCells(
        facts.whole_number("exit_cells", 2, 256), facts.whole_number("rest_cells", 2, 256), field
    )


def _field_facts(field: FieldFacts) -> dict[str, Any]:
    return {
        "size": list(field.size),
        "low": _row(field.low),
        "step": _short(field.step),
        "ior": _short(field.ior),
        "slopes": _short(field.slopes),
        "reflections": field.reflections,
        "all_around": _short(field.all_around),
        "tint": [_short(part) for part in field.tint],
        "tints_reflections": field.tints_reflections,
    }


def _field_in(facts: Facts) -> FieldFacts:
    sides = facts.numbers("size", 3)
    if not all(side == round(side) and 2 <= side <= _MOST_SAMPLES for side in sides):
        raise FormatError(f'{facts.source}: "size" is not of 2 to {_MOST_SAMPLES} samples along each side')
    width, height, depth = map(round, sides)
    slopes, all_around = facts.number("slopes"), facts.number("all_around")
    ior, step = facts.positive("ior"), facts.positive("step")
    if not 1 < ior <= _DENSEST:
        raise FormatError(f'{facts.source}: "ior" is not above 1 and up to {_DENSEST}')
    if slopes < 0:
        raise FormatError(f'{facts.source}: "slopes" is below 0')
    if not 0 <= all_around <= 1:
        raise FormatError(f'{facts.source}: "all_around" is {all_around}, which is not between 0 and 1')
    if step < np.finfo(np.float32).tiny:
        raise FormatError(f'{facts.source}: "step" is {step}, which no field has')
    reflections = facts.whole_number("reflections", 0, _MOST_REFLECTIONS)
    tint = facts.numbers("tint", 3)
    if not all(0 < part <= 1 for part in tint):
        raise FormatError(f'{facts.source}: "tint" has parts that are not above 0 and up to 1')
    return FieldFacts(
        (width, height, depth),
        _vector(facts, "low"),
        step,
        ior,
        slopes,
        reflections,
        all_around,
        (tint[0], tint[1], tint[2]),
        facts.truth("tints_reflections"),
    )


def _lamp(facts: Facts) -> Lamp:
    behind = "behind" in facts.values and facts.truth("behind")
    shape = _shape(facts.inner("shape")) if "shape" in facts.values else None
    variance = facts.positive("variance")
    return Lamp(_vector(facts, "place"), _vector(facts, "irradiance"), variance, behind, shape)


def _shape_facts(shape: LampShape) -> dict[str, Any]:
    sides = {"across": _row(shape.across)} | ({"up": _row(shape.up)} if shape.up.any() else {})
    return {"kind": shape.kind.value, **sides, "solid": _short(shape.solid)}


def _shape(facts: Facts) -> LampShape:
    kind = ShapeKind(facts.choice("kind", tuple(ShapeKind)))
    up = np.zeros(3, np.float32) if kind == ShapeKind.BALL else _vector(facts, "up")
    across = _vector(facts, "across")
    if not across.any() or (kind != ShapeKind.BALL and not np.cross(across, up).any()):
        raise FormatError(f"{facts.source} has a lamp without an area")
    return LampShape(kind, across, up, facts.positive("solid"))


def _boxes(things: SurroundingLayer) -> Floats:
    assert isinstance(things.shape, Impostor)
    return things.shape.boxes


def _boxes_in(distances: Facts, plane: Plane | Shell | None) -> Floats:
    """The boxes (n, 2, 3) of things in a room."""
    boxes = _objects(distances, "boxes", MOST_BOXES)
    if not isinstance(plane, Shell):
        raise FormatError(f'{distances.source} has "boxes", but the bake has no "shell"')
    return _floats([[box.numbers(corner, 3) for corner in ("low", "high")] for box in boxes])


def _plane_in(layered: Facts) -> Plane | Shell:
    """The plane, or the planes of a room."""
    if "shell" not in layered.values:
        plane = layered.inner("plane")
        return Plane(_vector(plane, "normal"), plane.number("height"), _vector(plane, "eye"))
    shell = layered.inner("shell")
    planes = _objects(shell, "planes", MOST_PLANES)
    if len(planes) < 2:
        raise FormatError(f"{shell.source} has {len(planes)} planes, expected 2 to {MOST_PLANES}")
    normals = _floats([plane.numbers("normal", 3) for plane in planes])
    return Shell(normals, _floats([plane.number("height") for plane in planes]), _vector(shell, "eye"))


def _material(facts: Facts) -> Material:
    lobes = _objects(facts, "lobes", LOBES)
    if len(lobes) != LOBES:
        raise FormatError(f"{facts.source} has {len(lobes)} lobes, expected {LOBES}")
    weight = _floats([_table(lobe, "weight") for lobe in lobes])
    variance = _floats([lobe.numbers("variance", STEPS) for lobe in lobes])
    if variance.min() <= 0:
        raise FormatError(f"{facts.source} has a lobe whose variance is not above 0")
    gloss = None
    if "gloss" in facts.values:
        told = facts.inner("gloss")
        gloss = Gloss(_floats(told.numbers("colour", 3)), told.number("width"))
    return Material(weight, variance, _floats(facts.numbers("bend", STEPS)), gloss, _brush(facts))


def _brush(facts: Facts) -> tuple[float, float] | None:
    """The width² of brushed metal along the tangent and across it."""
    if "brush" not in facts.values:
        return None
    along, across = facts.numbers("brush", 2)
    if min(along, across) <= 0:
        raise FormatError(f"{facts.source} has a brush whose width is not above 0")
    return along, across


def _gloss_facts(gloss: Gloss) -> dict[str, Any]:
    return {"colour": _row(gloss.colour), "width": _short(gloss.width)}


def _look_facts(look: ImageLook) -> dict[str, Any]:
    colours = {name: [_short(value) for value in getattr(look, name)] for name in _COLOURS_OF_LOOK}
    return {
        "uv_map": look.uv_map,
        **colours,
        "metallic": _short(look.metallic),
        "normal_strength": _short(look.strength),
        "fading": _short(look.fading),
    }


def _look(facts: Facts) -> ImageLook | None:
    """How a material is shown by its own images, None if it is not."""
    if "images" not in facts.values:
        return None
    images = facts.inner("images")
    diffuse, dielectric, metal = (_colour(images, name) for name in _COLOURS_OF_LOOK)
    names = ("metallic", "normal_strength", "fading")
    metallic, strength, fading = (_bounded(images, name) for name in names)
    return ImageLook(images.text("uv_map"), diffuse, dielectric, metal, metallic, strength, fading)


def _colour(facts: Facts, key: str) -> Colour:
    red, green, blue = facts.numbers(key, 3)
    return red, green, blue


def _bounded(facts: Facts, key: str) -> float:
    found = facts.number(key)
    if not 0 <= found <= _STRONGEST:
        raise FormatError(f'{facts.source}: "{key}" is {found}, expected 0 to {_STRONGEST:g}')
    return found


def _objects(facts: Facts, key: str, most: int) -> list[Facts]:
    """The objects in a list. Raises FormatError for anything else, or more than `most`."""
    found = facts.values.get(key)
    if not isinstance(found, list) or len(found) > most or not all(isinstance(one, dict) for one in found):
        raise FormatError(f'{facts.source}: "{key}" is no list of at most {most} objects')
    source = f'{facts.source} in "{key}"'
    return [Facts(one, f"{source}, number {number},", facts.what) for number, one in enumerate(found)]


def _table(facts: Facts, key: str) -> tuple[tuple[float, float, float], ...]:
    found = facts.colours(key)
    if len(found) != STEPS:
        raise FormatError(f'{facts.source}: "{key}" has {len(found)} colours, expected {STEPS}')
    return found


def _vector(facts: Facts, key: str) -> Floats:
    return _floats(facts.numbers(key, 3))


def _floats(values: Any) -> Floats:
    """As float32; numbers beyond its range become infinite, which `from_facts` refuses."""
    with np.errstate(over="ignore"):
        return np.array(values, dtype=np.float32)


def _short(number: float) -> float:
    """The shortest decimal number that is the same single float."""
    return float(str(np.float32(number)))


def _row(values: Floats) -> list[float]:
    return [_short(value) for value in values]


def _rows(values: Floats) -> list[list[float]]:
    return [_row(row) for row in values]


def _resampled(falloff: Floats) -> Floats:
    """Falloffs (M, B, 3) at the lobes' steps of N.V, (M, STEPS, 3)."""
    count = falloff.shape[1]
    if count == STEPS:
        return falloff.astype(np.float32)
    place = np.clip((np.arange(STEPS) + 0.5) / STEPS * count - 0.5, 0, count - 1)
    low = np.minimum(place.astype(np.intp), count - 2)
    above = (place - low)[:, None]
    found: Floats = (falloff[:, low] * (1 - above) + falloff[:, low + 1] * above).astype(np.float32)
    return found
