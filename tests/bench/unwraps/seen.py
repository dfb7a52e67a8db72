# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The race's toy as its bake shows it, by each unwrap: python -m tests.bench.unwraps.seen --out DIR

The same default bake of red paint, chrome and blue rubber, but for the unwrap, from two views: PSNR against
Cycles, and DIR/seen-UNWRAP.png, path traced, ours, and the difference.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy

from radtex_addon.settings.spec import BakeSpec, Layout, Unwrap
from tests.bench.gallery.looking import (
    SUBJECT,
    Camera,
    added,
    empty_scene,
    lamp,
    opaque_rows,
    principled,
    studio,
    tiles,
)
from tests.bench.gallery.page import save_picture

from .meshes import toy

_CAMERAS = {
    "front": Camera((1.6, -5.6, 1.8), (0, 0, 0.05), lens=60),
    "side": Camera((-4.6, -3.2, 0.9), (0, 0, 0.05), lens=60),
}
_PAINTS: dict[str, Callable[[], bpy.types.Material]] = {
    "Paint": lambda: principled("Paint", (0.8, 0.05, 0.03), Roughness=0.25),
    "Chrome": lambda: principled("Chrome", (0.9, 0.9, 0.92), Metallic=1.0, Roughness=0.08),
    "Rubber": lambda: principled("Rubber", (0.05, 0.1, 0.35), Roughness=0.4),
}


def scene() -> None:
    """The toy on tiles between three balls, under a studio's light and a lamp."""
    empty_scene()
    studio(60)
    item: Any = toy()
    item.name = SUBJECT
    for slot, paint in zip(item.material_slots, _PAINTS.values(), strict=True):
        slot.material = paint()
    added("plane", "Table", tiles(1.0, 0.5), size=14, location=(0, 0, -1))
    for number, (x, y, colour) in enumerate(
        [(2.6, -1.2, (0.9, 0.5, 0.1)), (-2.6, 0.8, (0.1, 0.6, 0.2)), (0.5, 2.8, (0.2, 0.3, 0.9))]
    ):
        ball = principled(f"Ball {number}", colour, Roughness=0.4)
        added("uv_sphere", f"Ball {number}", ball, radius=0.6, location=(x, y, -0.4))
    lamp((3, -3, 4), 250, 1)


def main() -> None:
    """Bake, look, compare, print."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.unwraps.seen",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    ways = [way.value for way in Unwrap if way is not Unwrap.AUTO]
    parser.add_argument("--ways", nargs="+", choices=ways, default=ways, metavar="UNWRAP")
    parser.add_argument("--texels", type=int, default=256, help="along the atlas's longer side (256)")
    parser.add_argument("--out", type=Path, required=True, help="folder for pictures")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for way in options.ways:
        spec = BakeSpec(layout=Layout.LAYERED, texels=options.texels, unwrap=Unwrap(way))
        rows = list(opaque_rows(f"Toy, {way}", spec, _CAMERAS, scene))
        for row in rows:
            print(f"{row.name}: {row.psnr:.1f} dB. {row.note}", flush=True)
        save_picture(options.out / f"seen-{way}.png", rows)


if __name__ == "__main__":
    main()
