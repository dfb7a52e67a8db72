# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How many cells buckets of the layered layout have along a side, and the sizes of what surrounds them."""

CELLS = ((14, 8), (8, 14))  # of what the object shows of itself, and of the rest
EXIT_CELLS = 16  # of rays that leave the object
THROUGH_CELLS = 8  # of the rest of what comes through
PICTURE_SIZE = 512  # of pictures of what surrounds the object, at their sharpest
DISTANCES = 128  # of the map of distances to it
OWN_SIDE = 20  # rays along a side of a texel's hemisphere, that tell what it sees of the object itself …
OWN_RAYS = 1 << 24  # … and the most of all texels, if that leaves each a few
