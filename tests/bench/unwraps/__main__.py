# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A race of unwraps on meshes as artists have them.

    python -m tests.bench.unwraps --out DIR                          all meshes, all ways
    python -m tests.bench.unwraps --meshes toy,case --texels 512 --out DIR

For each mesh and way: the number of islands, the share of the atlas that they cover, texels per unit of the
surface, stretch (the mean, by area, of how many times longer a texel is than wide), the length of seams in
texels, and seconds, of this machine. DIR gets table.md and a picture of each layout, MESH-WAY.png: islands in
colours, darker where texels are denser than on average.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from radtex_addon.core.errors import RadTexError
from radtex_addon.core.islands import uv_islands, weld
from radtex_addon.core.surface import stretches
from radtex_addon.core.uv_map import UvMap, draw_map
from radtex_addon.formats.containers.png import encode_png
from radtex_addon.scene.mesh.evaluated import EvaluatedMesh
from radtex_addon.scene.mesh.flatten import islands_of
from radtex_addon.scene.uv.unwrap_options import AtlasUnwrap
from tests.bench.fidelity.choice import names_of

from .meshes import MESHES
from .ways import WAYS, read


@dataclass(frozen=True)
class Score:
    """What an unwrap came to."""

    islands: int
    coverage: float
    density: float
    stretch: float
    seams: float
    seconds: float

    @classmethod
    def of(cls, mesh: EvaluatedMesh, made: AtlasUnwrap) -> Score:
        """Measure an unwrap of the mesh."""
        scaled = made.uv * [made.width, made.height] / made.density
        island = uv_islands(weld(mesh.position)[mesh.triangles], made.uv)
        flat = islands_of(mesh, scaled, island)
        corners = mesh.world_position[mesh.triangles]
        most, least = stretches(corners, scaled).T
        area = np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        ) * (flat.island >= 0)
        stretch = float(np.sum(area * np.minimum(most / np.maximum(least, 1e-9), 10)) / area.sum())
        seams = flat.border * made.density
        return cls(made.islands, made.utilisation, made.density, stretch, seams, made.seconds)


def main() -> None:
    """Unwrap, measure, print."""
    options = _options()
    options.out.mkdir(parents=True, exist_ok=True)
    lines = [
        "| mesh, triangles | way | islands | covered | texels a unit | stretch | seams, texels | s |",
        "|---|---|---|---|---|---|---|---|",
    ]
    print("\n".join(lines), flush=True)
    for name in options.meshes:
        for way in options.ways:
            line = _line(name, way, options.texels, options.out)
            lines.append(line)
            print(line, flush=True)
    (options.out / "table.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _line(name: str, way: str, texels: int, out: Path) -> str:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    item = MESHES[name]()
    mesh = read(item)
    head = f"| {name}, {len(mesh.triangles):,} | {way} | "
    try:
        made = WAYS[way](item, mesh, texels)
    except (RadTexError, ValueError) as error:
        return f"{head}{str(error).partition(':')[0]} | | | | | |"
    score = Score.of(mesh, made)
    uv_map = UvMap(mesh.world_position[mesh.triangles], made.uv, made.width, made.height)
    picture = out / f"{name}-{way.replace(', ', '-').replace(' ', '_')}.png"
    picture.write_bytes(encode_png(draw_map(uv_map)))
    return (
        f"{head}{score.islands} | {score.coverage:.0%} | {score.density:.1f} | {score.stretch:.2f} | "
        f"{score.seams:.0f} | {score.seconds:.1f} |"
    )


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.unwraps",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    meshes = list(MESHES)
    parser.add_argument("--meshes", type=names_of(meshes), default=meshes, help="of " + ", ".join(meshes))
    parser.add_argument("--ways", nargs="+", choices=list(WAYS), default=list(WAYS), metavar="WAY")
    parser.add_argument("--texels", type=int, default=256, help="along the atlas's longer side (256)")
    parser.add_argument("--out", type=Path, required=True, help="folder for what it makes")
    return parser.parse_args()


if __name__ == "__main__":
    main()
