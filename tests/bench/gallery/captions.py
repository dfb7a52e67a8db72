# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's rows: the order of the page, what each shows, and what is wrong in its picture."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Caption:
    """What a row `shows` and what an artist has `seen` in its picture, in whole sentences."""

    title: str
    shows: str
    seen: str


FILMS = (  # rows with a film; their `rows` can leave out the `stills`
    "iridescence",
    "refraction",
    "shadow",
    "ao",
    "transfer",
    "lamps",
    "proxy",
    "interior",
    "moving_reflection",
)
CAPTIONS = {
    "studio": Caption(
        "Studio",
        "What a bake makes that chooses nothing, under a studio's hard lamps: a kettle of polished steel "
        "with a black handle, and a jug of clay under a red, clear-coated glaze, on a tiled table.",
        "Lamps, tiles and window are sharp and where they belong. The table's own gloss is not: the lamps' "
        "second images in it, which the kettle mirrors, are pale patches, since the surroundings are seen "
        "from one point, and tiles beside them are smeared. The brightest lamp is a little too wide, and the "
        "lid mirrors the handle softly.",
    ),
    "iridescence": Caption(
        "Iridescence",
        "A steel ring under a thin film: magenta where one looks straight at it, green at a slant.",
        "The turn from magenta to grey-green towards the edges is there. On the inside of the ring, where "
        "texels are small in the picture, the film's colours are in fine blotches.",
    ),
    "inter_reflection": Caption(
        "Inter-reflection",
        "A copper bowl that lights and mirrors itself, in up to twelve bounces.",
        "The sheen is soft and without blotches, and the warm glow in the ground, which only bounced light "
        "makes, is there.",
    ),
    "refraction": Caption(
        "Refraction",
        "An egg of frosted glass before an orange ball; the bubble in it mirrors what comes at a slant "
        "(total internal reflection).",
        "The ball is bent around the bubble, which keeps it out of its rim, and its second, small image in "
        "the bubble is there, all as soft as frosted glass makes them. The bubble's rim is a little too "
        "sharp; seen from above, where there is little else, buckets of 16 x 16 cells are nearer.",
    ),
    "alpha": Caption(
        "Transparency",
        "A curtain that is clear in waves, over stripes that no bake knew.",
        "Colour and alpha are both right, and no seam shows. A closed shape is harder: what is seen of its "
        "far side through its near one is blurred.",
    ),
    "subsurface": Caption(
        "Subsurface scattering",
        "A head of jade, its ears lit from behind.",
        "The default is 2 dB worse here than buckets: the dark rings around the eyes are too pale above "
        "them, and the skin has faint, soft patches. The glowing ears and the shine on the brows are right.",
    ),
    "volume": Caption(
        "Volume",
        "A ball of fog around a glowing ring, without a surface of its own.",
        "Glow and ring have the right colour and size, and are soft, for the ring is a radius below the "
        "surface. Along seams of the unwrap it has wisps that the fog has not.",
    ),
    "shadow": Caption(
        "Shadow",
        "One bit a cell, under a wide sun and an area lamp: 8 bytes a texel with 8 x 8 cells, 32 bytes with "
        "16 x 16.",
        "Shadows lie where they should, are as dark, and sharpen towards what casts them. With 8 x 8 cells "
        "their slopes are faceted, as cut by a knife, where the lamp is hardly wider than a cell; 16 x 16 "
        "cells leave little of that. Around the eyes, which are stuck into the head, a rim is too dark.",
    ),
    "ao": Caption(
        "Ambient occlusion",
        "White things in a corner, lit by the sky alone: a sky of one colour, and one that is warm on the "
        "left and blue on the right, seen along the bent normal. One value and one direction a texel.",
        "Hollows, contacts and the ring's inside are as dark as they should be, and walls take the colour of "
        "that side of the sky which they face. Along the walls' feet lie short dark stitches: texels half "
        "of which are in the wall. The left wall is a touch too red, for what is open there is no cone.",
    ),
    "transfer": Caption(
        "Transfer",
        "A thing of wax under suns that no bake knew, one of them behind it.",
        "Light shines through where it should, the rims glow under the sun behind. Where least gets through "
        "it is redder than it should be, in soft bands, and has a greyish patch and the line of a seam.",
    ),
    "lamps": Caption(
        "Lamps",
        "A vase under three lamps and a dim sky, each baked alone: the sum of the atlases, each times a "
        "colour that no bake knew.",
        "Colours meet on the flutes and over the lip where they should, without patches. The lip's shine is "
        "a texel off, and a little dull.",
    ),
    "layers": Caption(
        "Layers",
        "Parts of one bake's light, against Cycles's own passes: diffuse, glossy, and what a base of one "
        "value a texel and a view-dependent rest add up to.",
        "The picture is of gloss alone: highlights, and the red that the wall lays on the edge, are where "
        "they should be; it is softer in the folds of the ear.",
    ),
    "proxy": Caption(
        "Proxy",
        "A ball of fur, and a clipped bush of leaves: what is drawn are hulls of 2,048 and 4,608 triangles, "
        "wrapped around them.",
        "From afar it is fur and it is a bush; near, single hairs are gone and leaves have soft edges, for a "
        "texel is wider than a hair, and a third of a leaf. Along the rim leaves fade into the "
        "ground, for there a cell of 20 degrees holds both a leaf and what is beside it. Silhouettes are "
        "within 3 % of the true ones.",
    ),
    "interior": Caption(
        "Interior",
        "A window pane that shows a room with true parallax, 24 texels of 80 x 80 cells. The room is not "
        "drawn.",
        "Ball, table and picture stand where they should from all three places. Edges are as soft as a "
        "cell is wide at their depth.",
    ),
    "room": Caption(
        "Room",
        "A gallery of 12 x 8 metres, baked in one go with all that is in it, by the defaults: a skylight "
        "with sun, spots on nine pictures, a polished floor of terrazzo, sculptures, benches. All that one "
        "sees comes from the bakes.",
        "Light, shadows and the sun on the floor are where they belong, and the bronze mirrors its "
        "surroundings. Small shadows, such as the bronze's own, are soft. Faint blotches can be seen "
        "on the dark red wall, and dashes a texel long along rails and the edges of benches.",
    ),
    "high_to_low": Caption(
        "High to low",
        "A carved head's light on a head of few faces, drawn beside the carved one itself.",
        "Carving, eyes and shadows are where they should be; edges of the carving are a texel softer.",
    ),
    "moving_reflection": Caption(
        "Moving reflections",
        "A chrome ball on its way through a room that was baked without it, four atlases of 128 texels: each "
        "of its rays ends in the atlas that it hits. What is around it, which is not measured, is looked up "
        "too. The camera alone sees the ball: it casts no shadow in either picture, for no bake could know "
        "of it. Held against a ball that does darken the floor beneath it, 18 to 24 dB are left: a runtime "
        "must add that shadow.",
        "Window, tiles, ring and head stand in the ball where they should, and as sharp as in the room. "
        "Edges of tiles are a texel softer, the window's a little wide.",
    ),
    "together": Caption(
        "Shared atlas",
        "A ring of brass, a head of terracotta and a column of plaster, which light one another, all three "
        "in one atlas of 128 texels.",
        "Each shows its own light, and what the others throw on it: the column the head's red, the head the "
        "column's shade. The rims of the eyes are a texel softer, and faces of the column show faintly.",
    ),
    "udim": Caption(
        "UDIM tiles",
        "A painted ring whose UV layer lies in two tiles, with an atlas for each.",
        "Nothing tells where one tile ends and the next begins. The edges of the paint are a texel softer.",
    ),
}
