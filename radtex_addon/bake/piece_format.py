# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The number of the format of pieces of unfinished bakes, and of frames of farms."""

from __future__ import annotations

# Raise it by one with every change after which this program would make, or expect, another piece or frame of
# the same bake: which arrays a piece has, their names, shapes, types and units; how sheets, tiles and bands
# are cut; which rays are traced, in which order and with which seeds; what a stage of a fit hands to the next
# one; what the filling of gutters and hidden cells stores. RadTex's version is compared besides: it tells
# releases apart, this number what was built between them, and farms, whose frames later releases may join.
PIECE_FORMAT = 4
