# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""`lookup.atlas.sample_layered` as native shader nodes, alike in Eevee and Cycles: group "RadTex Layered".

Each step is a group of its own, so that the tree reads like the maths. What a bake lacks is not built.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import bpy

from ....core.errors import InputError
from ....preview.taps import in_working_space, octahedron_group, readable_size
from ....scene.nodes import NodeBuilder, Operand, Socket, close_group, open_group
from ..files.arrangement import (
    ALPHA,
    COLOUR,
    IRRADIANCE,
    NORMAL,
    OF_IMAGES,
    OWN,
    REST,
    TANGENT,
    TINT,
    WIDTH,
)
from ..files.sidecar import LayeredSidecar
from ..lookup.lobes import LEAST_TANGENT, LOWEST
from .images import (
    brush_at,
    buckets_group,
    constant,
    curve_group,
    curves_at,
    map_group,
    ordered,
    reflected_at,
    reflected_group,
)
from .surroundings import around_group, brushes, more_inputs, most_of, shaded_lamps
from .through import through_group

CURVES = "curves"  # the image of `curves_of`
SHOWS_THROUGH = bpy.app.version >= (5, 0)  # else the nodes overflow the stack of 4.5's Cycles
_STEEP, _LEAST_COSINE, _LEAST_LEFT = 0.3, 1e-3, 0.5  # as in lookup.atlas
_KEPT, _EDGE = 5.0, 0.04  # as in lookup.lobes

_Images = Mapping[str, bpy.types.Image]


def build_layered_group(
    images: _Images, facts: LayeredSidecar, of_images: bool = False
) -> bpy.types.ShaderNodeTree:
    """A node group that looks up the sidecar's `images`, by layer and CURVES, as `sample_layered` does.

    Inputs: UV (0..1, v up); Normal and Tangent (world space, of any length) and the bitangent's Sign; unit
    Incoming, towards the viewer, and Position, in world space; the Material's number. Outputs: Color, in the
    file's working space and premultiplied by Alpha, without what comes through unless SHOWS_THROUGH. If it is
    `of_images`, there are inputs for what the material's own images say: the diffuse Colour, the lobes' Tint,
    and the Shading normal, of any length. Raises InputError if an image has another size than in the sidecar.
    """
    _check_sizes(images, facts)
    octahedron = octahedron_group()
    around = around_group(images, facts, octahedron)
    mirrored = _mirrored_group(images, facts, octahedron, around, more_inputs(facts))
    through = None
    if facts.through is not None and SHOWS_THROUGH:
        through = through_group(images, facts, octahedron, around)
    curves = curve_group(images[CURVES], len(facts.materials))
    more = dict.fromkeys(("Colour", "Tint", "Shading"), "Vector") if of_images else {}
    build, (uv, normal, tangent, sign, viewer, position, material, *given) = open_group(
        "RadTex Layered",
        UV="Vector",
        Normal="Vector",
        Tangent="Vector",
        Sign="Float",
        Incoming="Vector",
        Position="Vector",
        Material="Float",
        **more,
    )
    outward = build.vector("NORMALIZE", normal)
    offset = build.vector("SUBTRACT", position, constant(facts.middle), label="from the middle")
    shading = outward
    look = _Look(build, images, uv, given)
    shading = look.shading(outward)
    facing = build.vector("DOT_PRODUCT", shading, viewer, label="N.V")
    axis = _mirror_direction(build, shading, facing, viewer, outward)
    cosine = build.math("MAXIMUM", facing, _LEAST_COSINE)
    falloff, first, second, bend, widths = curves_at(build, curves, cosine, material)
    colour = look.colour((falloff, first, second))
    (irradiance,) = build.group(map_group("Irradiance", images[IRRADIANCE]), _later(build, uv, (colour,)))
    light = build.vector("MULTIPLY", build.vector("MULTIPLY", colour, irradiance), falloff, label="diffuse")
    alpha = None
    if ALPHA in images:
        there = _later(build, uv, (light,))
        alpha = build.separate(build.group(map_group("Alpha", images[ALPHA]), there)[0])[0]
        light = build.vector("SCALE", light, alpha) if of_images else light
    factor: Operand = 1.0
    if WIDTH in images:
        there = _later(build, uv, (light,))
        wider = build.separate(build.group(map_group("Width", images[WIDTH]), there)[0])[0]
        factor = build.math("POWER", 2.0, wider)
        widths = (build.math("MULTIPLY", widths[0], factor), build.math("MULTIPLY", widths[1], factor))
    seen = [
        *(most_of(build, lamp, offset, outward, irradiance, colour) for lamp in shaded_lamps(facts).values()),
        *(
            _how_brushed(
                build,
                images,
                _later(build, uv, (light,)),
                shading,
                axis,
                brush_at(build, curves, material, factor),
            )
            if brushes(facts)
            else ()
        ),
    ]
    reflected = reflected_at(build, curves, cosine, material, factor) if facts.glosses else None
    shown, rest = build.group(
        mirrored, _later(build, uv, (light, *widths, *seen)), offset, shading, axis, first, second, bend,
        *widths, *seen,
    )  # fmt: skip
    shown = look.tinted(shown, rest, alpha, reflected)
    if alpha is not None:
        rest = build.vector("SCALE", rest, alpha)
    light = build.vector("ADD", light, shown)
    light = build.vector(
        "MAXIMUM", build.vector("ADD", light, rest), build.vector("SCALE", light, _LEAST_LEFT)
    )
    if through is not None:
        (behind,) = build.group(through, _later(build, uv, (light,)), offset, outward, tangent, sign, viewer)
        if alpha is not None:
            behind = build.vector("SCALE", behind, alpha)
        light = build.vector("ADD", light, behind)
    shown = build.mix(1.0, light, (0.0, 0.0, 0.0, 1.0), "RGBA", "LIGHTEN")
    opacity = build.value(1.0) if alpha is None else alpha
    return close_group(build, Color=in_working_space(build, shown), Alpha=opacity)


@dataclass(frozen=True, eq=False)
class _Look:
    """The material at UV, as `lookup.atlas.look_at` has it: by maps, or as `given` by its own images.

    `given`: colour, tint and shading normal, or nothing.
    """

    build: NodeBuilder
    images: _Images
    uv: Socket
    given: Sequence[Socket]

    def shading(self, outward: Socket) -> Socket:
        """The shading normal; `outward` is the mesh's."""
        if self.given:
            return _shading_normal(self.build, self.given[2], outward)
        if NORMAL not in self.images:
            return outward
        (found,) = self.build.group(map_group("Normal", self.images[NORMAL]), self.uv)
        return _shading_normal(self.build, found, outward)

    def colour(self, known: Iterable[Socket]) -> Socket:
        """The diffuse colour, looked up after what is `known`."""
        if self.given:
            return self.given[0]
        there = _later(self.build, self.uv, known)
        return self.build.group(map_group("Colour", self.images[COLOUR]), there)[0]

    def tinted(
        self, shown: Socket, rest: Socket, alpha: Socket | None, reflected: tuple[Socket, ...] | None
    ) -> Socket:
        """What lobes have `shown` times their tint, looked up after both, and alpha.

        `reflected`: what `images.reflected_at` returns, if any material has a gloss.
        """
        build, white = self.build, 1.0 if alpha is None or self.given else alpha
        tint: Operand = (1.0, 1.0, 1.0)
        if self.given:
            tint = self.given[1]
        elif TINT in self.images:
            there = _later(build, self.uv, (shown, rest))
            (tint,) = build.group(map_group("Tint", self.images[TINT]), there)
        elif alpha is not None:
            tint = build.combine(alpha, alpha, alpha)
        if reflected is not None:
            (tint,) = build.group(reflected_group(), tint, white, *reflected)
        shown = build.vector("MULTIPLY", shown, tint)
        return build.vector("SCALE", shown, alpha) if alpha is not None and self.given else shown


def _later(build: NodeBuilder, uv: Socket, known: Iterable[Socket]) -> Socket:
    """The same coordinates, evaluated only after all the sockets in `known`: see `images.ordered`."""
    u, v, _ = build.separate(uv)
    return build.combine(ordered(build, u, known), v)


def _check_sizes(images: _Images, facts: LayeredSidecar) -> None:
    for layer, (width, height, _) in facts.shapes.items():
        if layer in OF_IMAGES and layer not in images:
            continue
        actual = readable_size(images[layer])
        if actual != (width, height):
            raise InputError(
                f"{images[layer].name}: {actual[0]} x {actual[1]} pixels, but this bake's '{layer}' has "
                f"{width} x {height}; use the sidecar that belongs to this image"
            )


def _shading_normal(build: NodeBuilder, found: Socket, outward: Socket) -> Socket:
    """The map's normal, or the mesh's own where the two disagree."""
    shading = build.vector("NORMALIZE", found)
    agrees = build.math("GREATER_THAN", build.vector("DOT_PRODUCT", shading, outward), _STEEP)
    return build.vector("NORMALIZE", build.mix(agrees, outward, shading))


def _mirror_direction(
    build: NodeBuilder, shading: Socket, facing: Socket, viewer: Socket, outward: Socket
) -> Socket:
    """No lower than the surface, as `lookup.lobes.lifted`."""
    twice = build.vector("SCALE", shading, build.math("MULTIPLY", facing, 2.0))
    axis = build.vector("SUBTRACT", twice, viewer, label="mirror direction")
    lower = build.math("SUBTRACT", LOWEST, build.vector("DOT_PRODUCT", axis, outward))
    up = build.vector("SCALE", outward, build.math("MAXIMUM", lower, 0.0))
    return build.vector("NORMALIZE", build.vector("ADD", axis, up))


def _how_brushed(
    build: NodeBuilder,
    images: _Images,
    uv: Socket,
    shading: Socket,
    axis: Socket,
    brush: tuple[Socket, Socket],
) -> tuple[Socket, ...]:
    """`lookup.lobes.Brushed.of` a `brush`: viewer, normal and tangent; and the width² along and across."""
    (tangent,) = build.group(map_group("Tangent", images[TANGENT]), uv)
    twice = build.math("MULTIPLY", build.vector("DOT_PRODUCT", shading, axis), 2.0)
    viewer = build.vector("SUBTRACT", build.vector("SCALE", shading, twice), axis)
    upright = build.vector("SCALE", shading, build.vector("DOT_PRODUCT", shading, tangent))
    tangent = build.vector("SUBTRACT", tangent, upright)
    known = build.math("GREATER_THAN", build.vector("LENGTH", tangent), LEAST_TANGENT)
    tangent = build.vector("SCALE", build.vector("NORMALIZE", tangent), known)
    alike = build.math("SQRT", build.math("MULTIPLY", *brush))
    wide = (build.mix(known, alike, one, "FLOAT") for one in brush)
    return viewer, shading, tangent, *wide


def _mirrored_group(
    images: _Images,
    facts: LayeredSidecar,
    octahedron: bpy.types.ShaderNodeTree,
    around: bpy.types.ShaderNodeTree,
    told: Mapping[str, str],
) -> bpy.types.ShaderNodeTree:
    """What lobes show of the surroundings and of the object itself; and the rest: Light and Rest.

    What `more_inputs` has `told` are inputs, too.
    """
    own = buckets_group("Own", images[OWN], facts.own_cells, facts.coarse)
    rest = buckets_group("Rest", images[REST], facts.rest_cells, facts.rest)
    lobe = _lobe_group(around, facts.own_cells, told)
    build, inputs = open_group(
        "RadTex Mirrored",
        UV="Vector",
        Offset="Vector",
        Normal="Vector",
        Axis="Vector",
        First="Vector",
        Second="Vector",
        Bend="Float",
        Narrow="Float",
        Wide="Float",
        **told,
    )
    uv, offset, normal, axis, first, second, bend, narrow, wide, *seen = inputs
    (place,) = build.group(octahedron, axis)
    itself, free = build.group(own, uv, place)
    along = build.vector("SCALE", axis, build.vector("DOT_PRODUCT", normal, axis))
    towards = build.vector("NORMALIZE", build.vector("SUBTRACT", normal, along))
    turned = build.vector(
        "ADD",
        build.vector("SCALE", axis, build.math("COSINE", bend)),
        build.vector("SCALE", towards, build.math("SINE", bend)),
        label="bent towards the normal",
    )
    narrow = ordered(build, narrow, (itself, free))
    (light,) = build.group(lobe, offset, turned, first, narrow, itself, free, *seen)
    if facts.second_lobes:
        wide = ordered(build, wide, (light,))
        (more,) = build.group(lobe, offset, turned, second, wide, itself, free, *seen)
        light = build.vector("ADD", light, more)
    (left, _) = build.group(rest, _later(build, uv, (light,)), _later(build, place, (light,)))
    return close_group(build, Light=light, Rest=left)


def _lobe_group(
    around: bpy.types.ShaderNodeTree, cells: int, told: Mapping[str, str]
) -> bpy.types.ShaderNodeTree:
    """One lobe's Weight times what it sees: the surroundings where they are Free, else the object Itself.

    The mask is sharpened as `lookup.lobes.seen_free` does.
    """
    build, (offset, axis, weight, spread, itself, free, *bounds) = open_group(
        "RadTex Lobe",
        Offset="Vector",
        Axis="Vector",
        Weight="Vector",
        Spread="Float",
        Itself="Vector",
        Free="Float",
        **told,
    )
    width = build.math("SQRT", build.math("ADD", spread, _EDGE**2))
    sharper = build.math("MAXIMUM", build.math("DIVIDE", _KEPT / cells, width), 1.0)
    side = build.math("MULTIPLY_ADD", free, 2.0, -1.0)
    side = build.math("MINIMUM", build.math("MAXIMUM", side, -1.0), 1.0)
    place = build.math("MULTIPLY", side, sharper)
    flat = build.math("SUBTRACT", 1.0, build.math("MULTIPLY", side, side))
    root = build.math("SQRT", build.math("MULTIPLY_ADD", place, place, flat))
    seen = build.math("MULTIPLY_ADD", build.math("DIVIDE", place, root), 0.5, 0.5, label="free")
    (light,) = build.group(around, offset, axis, spread, *bounds)
    return close_group(build, Light=build.vector("MULTIPLY", weight, build.mix(seen, itself, light)))
