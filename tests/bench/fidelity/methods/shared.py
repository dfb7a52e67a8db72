# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The shared layout as `bake.py --layout shared` bakes it: every texel keeps buckets of its own."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path
from time import perf_counter
from typing import TypeVar, cast

import bpy
import numpy as np

from radtex_addon.bake.progress import Progress, Stage, finished, relayed
from radtex_addon.bake.spec import BakeSpec, Layout
from radtex_addon.core.shared import SharedAtlas, sample_shared
from radtex_addon.formats.condensed_sizes import texture_bytes
from radtex_addon.formats.packing import pack
from radtex_addon.formats.shared_files import read_shared
from radtex_addon.formats.shared_sidecar import SharedSidecar
from radtex_addon.forms import form_for
from radtex_addon.forms.bake_job import BakeJob
from radtex_addon.prepare.prepared import prepare
from radtex_addon.report.gbuffer import Array, GBuffer
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene

from ..method import Baked
from ..scenes import Stage as Scene

_PIXEL = 8  # bytes, as a GPU holds it: four half floats, for no GPU has three

_Result = TypeVar("_Result")


def look(atlas: SharedAtlas, buffer: GBuffer) -> Array:
    """What a G-buffer's rays see of the atlas, (N, 3), linear; 0 where they miss."""
    fragment = (buffer.uv, buffer.normal, buffer.incoming)
    part = (field[buffer.hit].astype(np.float32) for field in fragment)
    return buffer.spread(sample_shared(atlas, *part))


class Shared:
    """Bakes, writes and reads back; paths, seconds and bytes count all of it."""

    def __init__(self, name: str, spec: BakeSpec) -> None:
        self.name = name
        self.spec = spec

    def bake(self, stage: Scene, folder: Path) -> Baked:
        scene = cast(bpy.types.Scene, bpy.context.scene)
        kept: list[bpy.types.ID] = []
        sidecar_path = folder / f"{stage.subject.name}.radiance.json"
        started = perf_counter()
        reached: dict[Stage, float] = {}
        with scratch_scene(scene, None, kept) as scratch:
            item = find_object(scratch, stage.subject.name)
            prepared = _finish(prepare(scratch, [item], self.spec, kept), reached)
            job = BakeJob(scratch, self.spec, sidecar_path, prepared, folder)
            made = _finish(form_for(self.spec).bake(job), reached)
        ended = perf_counter()
        fitted = min(at for at in (*reached.values(), ended) if at > reached[Stage.FIT])
        atlas, sidecar = read_shared(sidecar_path)
        print(
            f"{stage.name}: captured in {reached[Stage.FIT] - reached[Stage.PROBE]:.1f} s, "
            f"fitted in {fitted - reached[Stage.FIT]:.1f} s, "
            f"{100 * (made.fireflies or 0):.2f} % of the light lost as fireflies",
            flush=True,
        )

        return Baked(
            paths=made.paths,
            seconds=ended - started,
            bytes=_bytes(atlas, sidecar),
            radiance=lambda buffer: look(atlas, buffer),
            mesh=prepared.mesh,
            matrix_world=np.array(stage.subject.matrix_world),
            uv_layer=sidecar.bake.uv_map,
        )


def _bytes(atlas: SharedAtlas, sidecar: SharedSidecar) -> int:
    """What a GPU holds: the textures of a condensed atlas, or images of half floats."""
    if sidecar.condensed is not None:
        return texture_bytes(sidecar.shapes)
    pixels = [image.shape[0] * image.shape[1] for image in pack(atlas).values()]
    return _PIXEL * int(sum(pixels))


def _finish(steps: Generator[Progress, None, _Result], reached: dict[Stage, float]) -> _Result:
    """Run to the end; note when each stage was first reached."""
    return finished(relayed(steps, lambda step: reached.setdefault(step.stage, perf_counter())))


def make(texels: int, samples: int) -> Shared:
    """The shared layout with about as many paths as the plain one spends with 8 x 8 cells."""
    return Shared("shared", BakeSpec(layout=Layout.SHARED, texels=texels, samples=samples))
