# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A stage's subject baked and exported as by a user who names neither layout nor format."""

from __future__ import annotations

import json
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import cast

import bpy

from radtex_addon.core.sampler import Filter
from radtex_addon.export.exporting import export_steps
from radtex_addon.job import OpenLayout, OutputFiles, bake_object, choose_layout
from radtex_addon.report.finished_bake import Finished, read_bake
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.textures.export_spec import ExportSpec, Target, TextureFormat
from tests.bench.fidelity.scenes import Stage


@dataclass(frozen=True, eq=False)
class Product:
    """A finished bake and its exports: the folders `web` and `godot`; `seconds` are the bake's."""

    finished: Finished
    web: Path
    godot: Path
    seconds: float


def produce(stage: Stage, spec: BakeSpec, folder: Path, form: TextureFormat = TextureFormat.AUTO) -> Product:
    """Bake the stage, which the open file must hold, into `folder`, save its preview, and export it.

    The layout is chosen as for a user who names none, whatever that of `spec` is.
    A finished bake of the same settings in `folder` is taken as it is, with the seconds that it took.
    """
    scene, name = cast(bpy.types.Scene, bpy.context.scene), stage.subject.name
    choice = choose_layout(scene, (name, spec), OpenLayout(), folder)
    sidecar, spent = OutputFiles.of(name, choice.spec, folder, preview=True).sidecar, folder / "seconds.json"
    if not spent.is_file():
        started = perf_counter()
        bake_object(scene, name, choice.spec, folder, preview=Filter.QUADRILINEAR, overwrite=True)
        spent.write_text(json.dumps(perf_counter() - started), encoding="utf-8")
    seconds = json.loads(spent.read_text(encoding="utf-8"))
    web, godot = folder / f"web-{form}", folder / f"godot-{form}"
    for target, place in ((Target.WEB, web), (Target.GODOT, godot)):
        deque(export_steps(sidecar, ExportSpec(target, form), place, overwrite=True), maxlen=0)
    return Product(read_bake(sidecar), web, godot, seconds)


def size_of(folder: Path) -> int:
    """Bytes of all files in an exported folder."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
