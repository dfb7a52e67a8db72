# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How many cells buckets of the layered layout have along a side, and the sizes of what surrounds them."""

CELLS = ((14, 8), (8, 14))  # of what the object shows of itself, and of the rest
CLEAR = ((2, 8), (2, 14))  # the same of an object that mirrors nothing of itself
EXIT_CELLS = 16  # of rays that leave the object
FIELD_SAMPLES = 64  # along the longest side of a clear object, of the distances to it
THROUGH_CELLS = 8  # of the rest of what comes through
PICTURE_SIZE = 512  # of pictures of what surrounds the object, at their sharpest
DISTANCES = 128  # of the map of distances to it
