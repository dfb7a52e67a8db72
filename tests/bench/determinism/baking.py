# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of every kind, small, and digests of the files that they leave: run in a process of its own.

    python -m tests.bench.determinism.baking SCENE.blend FOLDER KIND... [--uv LAYER] [--memory MB]
        [--render-threads N] [--smaller N]

Writes DIGESTS into FOLDER: for each kind its files' digests.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import bpy
import pytest

from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, CaptureMethod, Kind, Layer, Layout, Split
from tests.bench.determinism.scenes import BODY, CORE
from tests.blender import surroundings

DIGESTS = "digests.json"
Digests: TypeAlias = dict[str, dict[str, str]]  # of each kind's files, by name

TINY = BakeSpec(texels=12, bucket=4, samples=4, half=False)
KINDS: dict[str, BakeSpec] = {
    "radiance": TINY,
    "layers": replace(TINY, layers=tuple(Layer)),
    "panoramic": replace(TINY, texels=12, bucket=2, kind=Kind.INCIDENT, capture=CaptureMethod.PANORAMIC),
    "incident": replace(TINY, kind=Kind.INCIDENT),
    "reflection": replace(TINY, kind=Kind.REFLECTION),
    "proxy": replace(TINY, kind=Kind.PROXY, content="*"),
    "shadow": replace(TINY, kind=Kind.SHADOW, half=True),
    "ao": replace(TINY, kind=Kind.AO),
    "ao near": replace(TINY, kind=Kind.AO, ao_distance=1.0),
    "transfer": BakeSpec(kind=Kind.TRANSFER, texels=16, bucket=3, samples=2, half=False),
    "lights": replace(TINY, lights=("Point", "Area")),
    "together": replace(TINY, texels=24, objects=(BODY, "Z block", "B block")),
    "split": replace(TINY, split=Split.MATERIAL, part="clay"),
    "source": replace(TINY, source=CORE),
    "accumulate": TINY,
    "refresh": TINY,
    "layered": BakeSpec(layout=Layout.LAYERED, texels=12, samples=1),
}
AGAIN: dict[str, dict[str, Any]] = {
    "accumulate": {"accumulate": True, "samples": 4},
    "refresh": {"refresh": True},
}


def main() -> None:
    """Bake what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.determinism.baking", description=__doc__)
    parser.add_argument("scene", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--uv", help="the layer to bake on; without it xatlas makes one")
    parser.add_argument("--memory", type=int, default=1024)
    parser.add_argument("--render-threads", type=int, default=0)
    parser.add_argument("--smaller", type=int, default=1, help="surroundings, so many times (1)")
    parser.add_argument("kinds", nargs="+", metavar="KIND")
    options = parser.parse_args()
    bpy.ops.wm.open_mainfile(filepath=str(options.scene.resolve()), load_ui=False)
    scene: Any = bpy.context.scene
    if options.render_threads:
        scene.render.threads_mode, scene.render.threads = "FIXED", options.render_threads
    surroundings.make_small(pytest.MonkeyPatch(), options.smaller)
    found: Digests = {}
    for kind in options.kinds:
        spec = replace(KINDS[kind], uv_layer=options.uv, memory_mb=options.memory)
        found[kind] = bake(scene, kind, spec, options.folder / kind)
    (options.folder / DIGESTS).write_text(json.dumps(found), encoding="utf-8")


def bake(scene: bpy.types.Scene, kind: str, spec: BakeSpec, folder: Path) -> dict[str, str]:
    """Bake one of KINDS; the digests of the files by name."""
    shutil.rmtree(folder, ignore_errors=True)
    name = "Group" if spec.objects else BODY
    bake_object(scene, name, spec, folder)
    if kind in AGAIN:
        bake_object(scene, name, replace(spec, **AGAIN[kind]), folder)
    return {path.name: digest(path) for path in sorted(folder.iterdir())}


def digest(path: Path) -> str:
    """A file's, short."""
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


if __name__ == "__main__":
    main()
