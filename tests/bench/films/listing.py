# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures for the listing on Blender's extension platform: an icon, a featured picture, and previews.

They are made of what `hero` rendered, and of the film that `orbit` made: both must have been run.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from radtex_addon.core.errors import InputError
from radtex_addon.report.metrics import Picture

from .encode import as_image, captioned, graded, save_jpeg, save_png
from .hero import SIZE, pictures, split

ICON = 256  # pixels of its side
_ICON_PART = (0.34, 0.11, 0.34)  # of the baked picture: its left and top edge, and its width, in widths of it
_ROUND = 40  # the radius of the icon's corners
_MOST_ICON, _MOST_FEATURED, _MOST_PREVIEW = 100_000, 1_000_000, 500_000
_BAKED = "Three pots, baked by RadTex, from a view that was not baked"
_FRAME = 5  # of the film, in a preview


def make(folder: Path) -> None:
    """Save listing-icon.png, listing-featured.png and three previews in a folder."""
    traced, baked = pictures()
    shown = graded(baked)
    save_png(folder / "listing-icon.png", _icon(shown), _MOST_ICON)
    featured = as_image(split(traced, baked, SIZE, captions=False))
    save_png(folder / "listing-featured.png", featured, _MOST_FEATURED)
    save_jpeg(folder / "listing-preview-1.jpg", as_image(captioned(shown, _BAKED, 26)), _MOST_PREVIEW)
    save_jpeg(folder / "listing-preview-2.jpg", as_image(_close(traced, baked)), _MOST_PREVIEW)
    save_jpeg(folder / "listing-preview-3.jpg", _compared(folder / "orbit.webp"), _MOST_PREVIEW)


def _icon(shown: Picture) -> Image.Image:
    """A square around the teapot, with round corners."""
    left, top, wide = (round(part * SIZE[0]) for part in _ICON_PART)
    part = as_image(shown[top : top + wide, left : left + wide])
    image = part.resize((ICON, ICON), Image.Resampling.LANCZOS)
    mask = Image.new("L", (4 * ICON, 4 * ICON), 0)
    ImageDraw.Draw(mask).rounded_rectangle((0, 0, 4 * ICON - 1, 4 * ICON - 1), 4 * _ROUND, fill=255)
    image.putalpha(mask.resize((ICON, ICON), Image.Resampling.LANCZOS))
    return image


def _close(traced: Picture, baked: Picture) -> Picture:
    """The teapot near by, path traced beside baked."""
    width, height = SIZE
    wide = height * 2 // 3 * (width // 2) // height  # so that the part fills half a preview
    part = slice(height // 5, height // 5 + height * 2 // 3), slice((width - wide) // 2, (width + wide) // 2)
    sides = []
    for picture, name in ((traced, "Path traced by Cycles"), (baked, "Baked by RadTex")):
        image = as_image(graded(picture[part])).resize((width // 2, height), Image.Resampling.LANCZOS)
        sides.append(captioned(np.asarray(image, dtype=np.float64) / 255, name, 30))
    return np.concatenate(sides, axis=1)


def _compared(film: Path) -> Image.Image:
    """One frame of the before/after film on a dark ground. Raises InputError where there is no film."""
    if not film.is_file():
        raise InputError(f"{film} is missing: run `python -m tests.bench.films orbit` first")
    with Image.open(film) as opened:
        opened.seek(_FRAME)
        frame = opened.convert("RGB")
    side = SIZE[1]
    sheet = Image.new("RGB", SIZE, (24, 24, 25))
    sheet.paste(frame.resize((side, side), Image.Resampling.LANCZOS), ((SIZE[0] - side) // 2, 0))
    return sheet
