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


CAPTIONS = {
    "iridescence": Caption(
        "Iridescence",
        "A steel ring under a thin film, 16 x 16 cells: magenta where one looks straight at it, green at "
        "a slant.",
        "The turn from magenta to grey-green towards the edges is there. A fine grain is left, of three "
        "samples a cell, worst on the inside of the ring, where texels are small in the picture.",
    ),
    "inter_reflection": Caption(
        "Inter-reflection",
        "A copper bowl that lights and mirrors itself, in up to twelve bounces.",
        "The warm glow in the ground, which only bounced light makes, is right in colour and place; it is "
        "grainy, and the lamp's sheen is a little too wide, for a cell is 20 degrees wide.",
    ),
    "refraction": Caption(
        "Refraction",
        "A glass egg, 16 x 16 cells; the bubble in it mirrors what comes at a slant (total internal "
        "reflection).",
        "The ball is bent around the bubble, which keeps it out of its rim and shows it a second time, "
        "small. All outlines are soft and grainy, that of the bubble most, where light turns faster than "
        "cells and texels can follow. In a studio's sharper light, the shared layout came to 14 dB.",
    ),
    "alpha": Caption(
        "Transparency",
        "A curtain that is clear in waves, over stripes that no bake knew.",
        "Colour and alpha are both right; a faint grain is left, of a few samples a cell. A closed shape "
        "is harder: what is seen of its far side through its near one is as blurred as a cell is wide, "
        "and a clear ball came to 22 dB.",
    ),
    "subsurface": Caption(
        "Subsurface scattering",
        "A head of jade, its ears lit from behind.",
        "The glowing ears and the dark rings around the eyes are right; the skin is mottled, for light "
        "that wanders inside is noisy and ten samples a cell are few.",
    ),
    "volume": Caption(
        "Volume",
        "A ball of fog around a glowing ring, without a surface of its own.",
        "The glow has the right colour and size, but the ring is not a ring any more: it is a radius "
        "below the surface, where a cell of 20 degrees is wider than the ring is thick. Content near the "
        "surface, or more cells, keep it.",
    ),
    "shadow": Caption(
        "Shadow",
        "One bit a cell, under a wide sun and an area lamp.",
        "The sun's shadows are smooth. The area lamp's lie where they should, but fall in steps, for the "
        "lamp is hardly wider than one of 8 x 8 cells: it wants more of them.",
    ),
    "transfer": Caption(
        "Transfer",
        "A thing of wax under suns that no bake knew, one of them behind it.",
        "Light shines through where it should, the rims glow under the sun behind. What is lit from behind "
        "is dark, and there the grain of the samples, coloured, is seen at once.",
    ),
    "proxy": Caption(
        "Proxy",
        "A ball of fur, and a clipped bush of leaves: what is drawn is a ball of 1,280 faces around them.",
        "From afar it is fur and it is a bush; near, single hairs and the edges of leaves are gone, for a "
        "texel is wider than they are. A grey veil lies along the rim: there a cell of 20 degrees holds "
        "both the leaves and what is beside them. Silhouettes are within 5 % of the true ones.",
    ),
    "interior": Caption(
        "Interior",
        "A window pane that shows a room with true parallax, 24 texels of 64 x 64 cells. The room is not "
        "drawn.",
        "Ball, table and picture stand where they should from all three places. Edges are as soft as a "
        "cell is wide at their depth, and walls are blotchy: five samples a cell are too few for light "
        "that has bounced.",
    ),
    "high_to_low": Caption(
        "High to low",
        "A carved head's light on a head of few faces, drawn beside the carved one itself.",
        "Carving, eyes and shadows are where they should be; edges of the carving are a texel softer.",
    ),
}
