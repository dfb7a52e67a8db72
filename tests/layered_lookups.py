# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes in the layered layout as textures, and ten thousand lookups of each, for shaders to be held to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations, product

import numpy as np

from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.core.fragments import Fragments
from radtex_addon.core.frame import normalised
from radtex_addon.core.hemisphere import cell_centres, square_to_direction
from radtex_addon.core.sampler import bilinear
from radtex_addon.formats.sidecar import Sidecar
from radtex_addon.forms.layered.cells import Cells
from radtex_addon.forms.layered.files.arrangement import (
    DISTANCES,
    OF_MATERIAL,
    PICTURES,
    arranged,
    packed,
    unpacked,
)
from radtex_addon.forms.layered.files.layered_files import atlas_of
from radtex_addon.forms.layered.files.sidecar import LayeredSidecar
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas, alpha_at, sample_layered
from radtex_addon.forms.layered.lookup.environment import Around, Impostor, Lamp, Shell
from radtex_addon.forms.layered.lookup.images import Colour, ImageLook, look_of_images
from radtex_addon.forms.layered.lookup.lamp_shapes import LampShape, ShapeKind
from radtex_addon.forms.layered.lookup.lobes import Gloss
from radtex_addon.forms.layered.lookup.ways import Through
from radtex_addon.forms.layered.shader_values import CLEAR_ALPHA, Stored
from tests.layered.made_up import (
    _buckets,
    _image,
    _waves,
    field_of_ball,
    made_up_atlas,
    made_up_fragments,
)
from tests.lookups import COUNT

TEXELS, SIZE, EXITS, THROUGH = 16, 64, 8, 6
FACTS = Sidecar("Vase", "radiance", TEXELS, TEXELS, 14, "RadTex", 16, 0, "portal", "RadTex 0", "5.2")
MEAN, MOST = 3e-3, 0.05  # as far off as a shader may be


@dataclass(frozen=True, eq=False)
class Case:
    """A bake and lookups: `textures` are mip levels (H, W, C) float16 by layer, `stored` says how.

    `atlas` is what the textures hold.
    """

    atlas: LayeredAtlas
    sidecar: LayeredSidecar
    textures: dict[str, list[Floats]]
    stored: dict[str, Stored]
    at: Fragments

    @property
    def through(self) -> bool:
        return self.sidecar.through is not None

    @property
    def fields(self) -> dict[str, Floats]:
        """What a lookup takes, by name: (N, C) float32."""
        at, unused = self.at, np.zeros_like(self.at.normal)
        tangent, bitangent = (unused if part is None else part for part in (at.tangent, at.bitangent))
        found = {"uvs": at.uv, "positions": at.position, "normals": at.normal, "viewers": at.viewer}
        return found | {"tangents": tangent, "bitangents": bitangent}

    def answers(self) -> Floats:
        """What the reference sampler sees, (N, 3)."""
        return sample_layered(self.atlas, self.at)

    def by_material(self, drawn: Callable[[int], Floats]) -> Floats:
        """Each fragment's answer (N, 3), of those of a picture that is drawn with each material."""
        found = np.zeros((COUNT, 3), dtype=np.float32)
        for number in range(len(self.sidecar.materials)):
            some = self.at.material == number
            found[some] = drawn(number)[some, :3]
        return found


@dataclass(frozen=True, eq=False)
class ImageCase:
    """A case whose materials are shown by images, the same for all: base colour, metal, normal map.

    `images` are (H, W, 3) float32 by the shader's names; `place` (N, 2) are their coordinates, 0 to 1. What
    comes through is left out. Where the normal map is `packed`, its z is not read, but follows from x and y.
    """

    case: Case
    looks: tuple[ImageLook, ...]
    images: dict[str, Floats]
    place: Floats
    packed: bool = False

    def answers(self) -> Floats:
        """What the reference sampler sees, (N, 3)."""
        at, atlas = self.case.at, replace(self.case.atlas, through=None)
        assert at.tangent is not None
        assert at.bitangent is not None
        found = np.zeros((COUNT, 3), dtype=np.float32)
        base, metal, bump = (bilinear(image, self.place) for image in self.images.values())
        if self.packed:
            across = ((2 * bump[:, :2] - 1) ** 2).sum(axis=1)
            bump[:, 2] = 0.5 + 0.5 * np.sqrt(np.maximum(1 - across, 0))
        for number, look in enumerate(self.looks):
            some = np.flatnonzero(at.material == number)
            frame = (at.tangent[some], at.bitangent[some], at.normal[some])
            alpha = alpha_at(atlas, at.uv[some])
            seen = look_of_images(look, base[some], metal[some, 2], metal[some, 1], bump[some], frame, alpha)
            found[some] = sample_layered(atlas, _some(at, some), seen)
        return found


def _some(at: Fragments, some: Ints) -> Fragments:
    assert at.tangent is not None
    assert at.bitangent is not None
    return Fragments(
        at.uv[some],
        at.normal[some],
        at.viewer[some],
        at.position[some],
        at.material[some],
        at.tangent[some],
        at.bitangent[some],
    )


@cache
def image_case(name: str, packed: bool = False) -> ImageCase:
    """A case shown by images. A `packed` normal map is flatter, and its third channel means nothing."""
    case, rng = case_of(name), np.random.default_rng(11)

    def colour() -> Colour:
        red, green, blue = rng.uniform(0.3, 1.2, 3).tolist()
        return red, green, blue

    strengths = (1.0, 0.4)[: len(case.sidecar.materials)]
    looks = tuple(ImageLook("UVMap", colour(), colour(), colour(), 0.9, each, 0.7) for each in strengths)
    bump = normalised(_image(rng, 32, 3) - [0.5, 0.5, -0.3]) * 0.5 + 0.5
    if packed:
        bump[..., :2] = 0.25 + 0.5 * bump[..., :2]
    images = {
        "radtex_base_map": _image(rng, 32, 3),
        "radtex_metal_map": _image(rng, 32, 3),
        "radtex_bump_map": bump.astype(np.float32),
    }
    return ImageCase(case, looks, images, rng.uniform(size=(COUNT, 2)).astype(np.float32), packed)


def off(found: Floats, expected: Floats) -> Floats:
    """Differences over what was expected and a twentieth of white."""
    return np.asarray(np.abs(found - expected) / (np.abs(expected) + 0.05))


def assert_agrees(name: str, found: Floats, case: Case | ImageCase) -> None:
    wrong = off(found, case.answers())
    print(f"{name}: mean error {wrong.mean():.1e}, 99.9 % {np.quantile(wrong, 0.999):.1e}, {wrong.max():.1e}")
    assert wrong.mean() < MEAN
    assert wrong.max() < MOST


@cache
def case_of(name: str) -> Case:
    """One of CASES."""
    atlas = CASES[name](made_up_atlas(TEXELS, SIZE))
    sidecar, images = LayeredSidecar.of(atlas, FACTS), arranged(atlas)
    ranged = name.endswith("in ranges")
    textures, stored = {}, {}
    for layer, image in images.items():
        textures[layer], stored[layer] = _stored(layer, image, sidecar, ranged)
        images[layer] = _decoded(layer, textures[layer], stored[layer], image.shape)
    at = made_up_fragments(atlas, COUNT, framed=True)
    return Case(atlas_of(images, sidecar), sidecar, textures, stored, at)


def glass_ball(atlas: LayeredAtlas) -> LayeredAtlas:
    """With a ball of frosted glass, through which rays are followed."""
    whole = everything(atlas)
    assert whole.through is not None
    return replace(whole, through=replace(whole.through, field=field_of_ball((24, 25, 26), 1e-2)))


def parted(atlas: LayeredAtlas) -> LayeredAtlas:
    """With everything, and ways that part within a texel or a cell, at a third of the lookups."""
    whole = everything(atlas)
    assert whole.through is not None
    ways = whole.through.ways.copy()
    rng = np.random.default_rng(9)
    aside = rng.random(ways.shape[:4]) < 0.1
    turned = np.roll(ways[..., :3], 1, axis=-1) * [1, -1, 1]
    ways[..., :3][aside] = turned[aside]
    return replace(whole, through=replace(whole.through, ways=ways.astype(np.float32)))


def _shape(rng: np.random.Generator, number: int, place: Floats) -> LampShape | None:
    """One of each kind, and none, in turns; it turns its bright side to the middle."""
    kinds = [None, *ShapeKind]
    kind = kinds[number % len(kinds)]
    if kind is None:
        return None
    across = rng.normal(size=3).astype(np.float32)
    if kind == ShapeKind.BALL:
        return LampShape(kind, across / 3, np.zeros(3, np.float32), 0.3)
    up = np.cross(np.cross(across, place), across)
    up *= rng.uniform(0.3, 0.9) / np.linalg.norm(up)
    up = up if np.cross(across, up) @ place > 0 else -up
    return LampShape(kind, across, up.astype(np.float32), 0.2)


def everything(atlas: LayeredAtlas) -> LayeredAtlas:
    """With every optional map, more lamps, and light that comes through."""
    rng = np.random.default_rng(7)
    fine, coarse = len(atlas.colour), len(atlas.own)
    alpha = 0.2 + 0.8 * _image(rng, fine, 1)
    tangent = normalised(rng.normal(size=3) + 0.3 * rng.normal(size=(*atlas.irradiance.shape[:2], 3)))
    along = (np.arange(coarse) + 0.5) / coarse
    uv = np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2)
    rest = _buckets(rng, uv, THROUGH, 3) * 0.4 - 0.1
    place, light = (3 * normalised(rng.normal(size=(7, 3))), rng.uniform(0, 1, (7, 3)))
    lit = zip(place.astype(np.float32), light.astype(np.float32), rng.uniform(1e-3, 0.02, 7), strict=True)
    lamps = tuple(
        Lamp(place, light, float(size), shape=_shape(rng, number, place))
        for number, (place, light, size) in enumerate(lit)
    )
    return replace(
        atlas,
        colour=atlas.colour * alpha,
        tint=_image(rng, fine, 3) * alpha,
        materials=(
            replace(
                atlas.materials[0],
                gloss=Gloss(np.array([0.3, 0.25, 0.1], np.float32), -5.0),
                brush=(0.04, 0.006),
            ),
            *atlas.materials[1:],
        ),
        normal=normalised(_image(rng, fine, 3) - 0.5).astype(np.float32),
        width=_image(rng, fine, 1) * 4 - 2,
        alpha=alpha,
        tangent=tangent.astype(np.float32),
        around=replace(atlas.around, lamps=(*atlas.around.lamps, *lamps)),
        through=Through(_ways(rng, uv), 0.5 + _image(rng, coarse, 3), rest),
    )


def clear(atlas: LayeredAtlas) -> LayeredAtlas:
    """With alpha and no tint."""
    alpha = 0.2 + 0.8 * _image(np.random.default_rng(8), len(atlas.colour), 1)
    return replace(atlas, colour=atlas.colour * alpha, alpha=alpha)


def bare(atlas: LayeredAtlas) -> LayeredAtlas:
    """With nothing optional, and nothing that it mirrors of itself."""
    around = Around(atlas.around.middle, atlas.around.world, (), ())
    own = np.zeros_like(atlas.own)
    own[..., 3] = 1
    return replace(atlas, around=around, materials=atlas.materials[:1], falloff=atlas.falloff[:1], own=own)


def matt(atlas: LayeredAtlas) -> LayeredAtlas:
    """Without lobes."""
    lobes = (replace(material, weight=material.weight * 0) for material in atlas.materials)
    return replace(atlas, materials=tuple(lobes))


def with_rest_at_every_texel(atlas: LayeredAtlas) -> LayeredAtlas:
    """With buckets of own light as they were, and twice as many of the rest along a side."""
    return replace(atlas, rest=made_up_atlas(TEXELS, SIZE, Cells(2, 8, every=True)).rest)


def of_one_lobe(atlas: LayeredAtlas) -> LayeredAtlas:
    """Without second lobes."""
    lobes = (
        replace(material, weight=material.weight * np.array([1, 0], np.float32)[:, None, None])
        for material in atlas.materials
    )
    return replace(atlas, materials=tuple(lobes))


def in_a_room(atlas: LayeredAtlas) -> LayeredAtlas:
    """With every plane that a room may have, and things that are seen from elsewhere than the middle."""
    rng = np.random.default_rng(12)
    plane, things = atlas.around.layers
    assert isinstance(things.shape, Impostor)
    sides = np.concatenate([np.eye(3), -np.eye(3), [[1, 1, 0.3], [-1, 0.5, -0.2]]])
    normals = normalised(sides + 0.1 * rng.normal(size=sides.shape)).astype(np.float32)
    eye = np.array([0.3, -0.2, 0.4], dtype=np.float32)
    shell = Shell(normals, rng.uniform(-2.5, -1.4, len(normals)).astype(np.float32), eye)
    low = rng.uniform(-1.6, 0.8, (8, 3))
    boxes = np.stack([low, low + rng.uniform(0.3, 1.2, (8, 3))], axis=1).astype(np.float32)
    furniture = replace(things.shape, eye=-eye, boxes=boxes, shell=shell)
    layers = replace(plane, shape=shell), replace(things, shape=furniture)
    sun = replace(atlas.around.lamps[0], behind=True, irradiance=4 * atlas.around.lamps[0].irradiance)
    lamps = (sun, *atlas.around.lamps)
    return replace(atlas, around=replace(atlas.around, layers=layers, lamps=lamps))


def brushed(atlas: LayeredAtlas) -> LayeredAtlas:
    """Of brushed metal, before lamps of which a plane and things hide every second one.

    In some texels the tangents are not known.
    """
    whole = everything(atlas)
    assert whole.tangent is not None
    known = np.arange(whole.tangent.shape[1]) % 8 < 6
    lamps = tuple(
        replace(lamp, behind=number % 2 == 0, irradiance=lamp.irradiance / 4)
        for number, lamp in enumerate(whole.around.lamps)
    )
    around, tangent = replace(whole.around, lamps=lamps), whole.tangent * known[:, None]
    return replace(whole, through=None, around=around, tangent=tangent.astype(np.float32))


CASES: dict[str, Callable[[LayeredAtlas], LayeredAtlas]] = {
    "everything": everything,
    "everything, in ranges": everything,
    "opaque, in ranges": lambda atlas: replace(everything(atlas), alpha=None),
    "parted ways": parted,
    "glass ball": glass_ball,
    "made up": lambda atlas: atlas,
    "things alone": lambda atlas: replace(
        atlas, around=replace(atlas.around, layers=atlas.around.layers[1:])
    ),
    "clear": clear,
    "bare": bare,
    "matt": matt,
    "one lobe": of_one_lobe,
    "room": in_a_room,
    "a rest at every texel": with_rest_at_every_texel,
    "brushed": brushed,
}
# One of each sort, for languages that take long to compile a case.
USUAL = tuple(name for name in CASES if name not in ("opaque, in ranges", "parted ways"))


def _ways(rng: np.random.Generator, uv: Floats) -> Floats:
    """Ways that bend by the cell and the texel."""
    side = round(len(uv) ** 0.5)
    out = -square_to_direction(cell_centres(EXITS).reshape(1, -1, 2)) * [0.6, 0.6, 1]
    turn = _waves(rng, uv, 3)[:, None] - 0.5
    direction = normalised(out + 0.5 * turn)
    shape = direction.shape[:2]
    weight = 0.3 + 0.6 * _waves(rng, uv, 1)[:, None] * _waves(rng, out[0], 1)
    place = 0.3 * (_waves(rng, uv, 3)[:, None] - 0.5 + 0.3 * direction)
    variance = np.broadcast_to(0.002 + 0.02 * _waves(rng, uv, 1)[:, None], (*shape, 1))
    ways = weight * np.concatenate([direction, np.ones((*shape, 1)), place, variance], axis=2)
    return np.ascontiguousarray(ways.reshape(side, side, EXITS, EXITS, 8), dtype=np.float32)


def _stored(layer: str, image: Floats, sidecar: LayeredSidecar, ranged: bool) -> tuple[list[Floats], Stored]:
    """A layer's texture, in a range and padded on the right and at the top or as it is."""
    part, scale, offset = (1.0, 1.0), 1.0, 0.0
    levels = [image]
    if layer in PICTURES:
        picture = sidecar.pictures[layer]
        levels = list(unpacked(image, picture.size, picture.levels))
    mean = float(image.mean()) if layer == DISTANCES else 0.0
    if ranged:
        spared = layer in CLEAR_ALPHA
        light = image[..., :3] if spared else image
        offset, scale = float(light.min()), float(np.ptp(light))
        coded = [(level - offset) / scale for level in levels]
        if spared:
            coded = [np.dstack([new[..., :3], old[..., 3]]) for new, old in zip(coded, levels, strict=True)]
        levels = coded
        if layer in (*OF_MATERIAL, "irradiance"):
            height, width = image.shape[:2]
            levels = [np.pad(levels[0], ((0, 4), (0, 12), (0, 0)), mode="edge")]
            part = (width / (width + 12), height / (height + 4))
    return [level.astype(np.float16) for level in levels], Stored(scale, offset, part, mean)


def _decoded(layer: str, levels: list[Floats], stored: Stored, shape: tuple[int, ...]) -> Floats:
    """The image (H, W, C) that a texture holds."""
    image = packed(tuple(levels)) if layer in PICTURES else levels[0].astype(np.float32)
    image = image[: shape[0], : shape[1]]
    found = image * np.float32(stored.scale) + np.float32(stored.offset)
    if layer in CLEAR_ALPHA:
        found[..., 3] = image[..., 3]
    return found


# What may be defined of a bake, and what its lookup may cost: shaders/source/radtex_layered.c tells of each.
_CHOICES: dict[str, tuple[str, ...]] = {
    "tint": ("", "RADTEX_TINT"),
    "normal": ("", "RADTEX_NORMAL"),
    "alpha": ("", "RADTEX_ALPHA"),
    "lobes": ("", *(f"RADTEX_MIRRORS RADTEX_OWN_CELLS=14 RADTEX_SECOND_LOBE={second}" for second in "01")),
    "width": ("", "RADTEX_WIDTH"),
    "gloss": ("", "RADTEX_GLOSSES"),
    "brush": ("", "RADTEX_TANGENT"),
    "behind": ("", "RADTEX_BEHIND"),
    "plane": ("", "RADTEX_PLANE", "RADTEX_PLANE RADTEX_SHELL=6"),
    "things": ("", "RADTEX_THINGS", "RADTEX_THINGS RADTEX_BOXES=3"),
    "lamps": ("RADTEX_LAMPS=0", "RADTEX_LAMPS=1", "RADTEX_LAMPS=8", "RADTEX_LAMPS=8 RADTEX_SHAPES"),
    "cells": ("RADTEX_REST_CELLS=8", "RADTEX_REST_CELLS=14"),
    "through": (
        "",
        "RADTEX_THROUGH RADTEX_EXIT_CELLS=16 RADTEX_EXIT_TAPS=16 RADTEX_THROUGH_CELLS=8",
        "RADTEX_THROUGH RADTEX_FIELD RADTEX_THROUGH_CELLS=8",
    ),
    "images": ("", "RADTEX_IMAGES"),
    "steps": ("RADTEX_STEPS=0", "RADTEX_STEPS=1", "RADTEX_STEPS=2"),
    "taps": (
        "RADTEX_OWN_TAPS=0 RADTEX_REST_TAPS=3",
        "RADTEX_OWN_TAPS=3 RADTEX_REST_TAPS=3",
        "RADTEX_OWN_TAPS=4 RADTEX_REST_TAPS=4",
    ),
    "steady": ("", "RADTEX_STEADY=0.16"),
    "temporal": ("", "RADTEX_TEMPORAL"),
}


@cache
def variants() -> tuple[str, ...]:
    """Lines of definitions in which any two choices that go together are made together at least once."""
    rng, names = np.random.default_rng(1), list(_CHOICES)

    def drawn(fixed: dict[str, str]) -> dict[str, str]:
        return {name: str(rng.choice(_CHOICES[name])) for name in names} | fixed

    wanted = {
        ((one, first), (other, second))
        for one, other in combinations(names, 2)
        for first, second in product(_CHOICES[one], _CHOICES[other])
    }
    wanted = {pair for pair in wanted if _goes(dict(pair))}
    found = []
    while wanted:
        first = dict(min(wanted))
        tried = [choice for choice in (drawn(first) for _ in range(200)) if _goes(choice)]
        pairs = [set(combinations(choice.items(), 2)) for choice in tried]
        best = int(np.argmax([len(wanted & some) for some in pairs]))
        wanted -= pairs[best]
        words = " ".join(tried[best].values()).split()
        found.append("".join(f"#define {word.replace('=', ' ')}\n" for word in words))
    return tuple(found)


def _goes(choice: dict[str, str]) -> bool:
    """Whether choices go together: there are boxes in rooms alone."""
    return "BOXES" not in choice.get("things", "") or "SHELL" in choice.get("plane", "SHELL")
