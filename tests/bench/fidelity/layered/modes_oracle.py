# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a clear object would show if each camera ray knew its one, two or three chief ways through exactly.

    python -m tests.bench.fidelity.layered.modes_oracle --scenes glass,thick_glass
    python -m tests.bench.fidelity.layered.modes_oracle --scenes glass --paths 64 --quick

Cycles traces many paths of each ray through the object; those that leave it alike are one way. Ways are
followed into the layers of surroundings that a bake keeps; what the front mirrors is the bake's own. Nothing
is stored in cells, so that the figures say what the number of ways limits, and nothing else.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import bpy
import numpy as np

from radtex_addon.bake.plan import CapturePlan, plan_of_picked
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.cycles.path_ends import Body
from radtex_addon.forms.layered.capture.capturing import reach_of
from radtex_addon.forms.layered.capture.exits import capture_exits
from radtex_addon.forms.layered.capture.surface_alone import surface_alone
from radtex_addon.forms.layered.fit.fitting import fit_layered
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas
from radtex_addon.forms.layered.samples import ExitSamples
from radtex_addon.prepare.prepared import prepare
from radtex_addon.report.gbuffer import Array, BakedSurface, GBuffer
from radtex_addon.scene.mesh.render_contents import matrices_in_renders
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, Layout

from ..choice import add_scene_options, chosen_scenes
from ..methods.layered import look
from ..metrics import compare
from ..references import View, views
from ..scenes import Stage
from .staged import Staged, capture_staged

_AGREE = 0.995  # cosine between the directions of paths that go one way
_PRINTED = (1, 2, 3, 8)  # of so many ways


@dataclass(frozen=True, eq=False)
class _Ways:
    """Of K rays, M ways each, the brightest first: `weight` (M, K), `direction`, `place` (M, K, 3), local."""

    weight: Floats
    direction: Floats
    place: Floats
    variance: Floats


def main() -> None:
    """Capture, trace, look, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add_scene_options(parser)
    parser.add_argument("--texels", type=int, default=128)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--paths", type=int, default=32)
    options = parser.parse_args()
    for name, build in chosen_scenes(options).items():
        stage = build()
        seen = views(stage, options.quick, options.tuning)
        spec = BakeSpec(layout=Layout.LAYERED, texels=options.texels, samples=options.samples)
        with tempfile.TemporaryDirectory() as folder:
            staged = capture_staged(stage, spec, Path(folder))
            atlas = finished(fit_layered(staged.captured.capture))
            for view in seen:
                _measure(name, stage, staged, atlas, view, options.paths, Path(folder))


def _measure(
    name: str, stage: Stage, staged: Staged, atlas: LayeredAtlas, view: View, paths: int, folder: Path
) -> None:
    prepared = staged.prepared
    surface = BakedSurface(prepared.mesh, staged.matrix_world, prepared.uv_layer)
    buffer = surface.gbuffer(view.rays, view.blocked)
    front = replace(atlas, through=None)
    faces = staged.captured.faces

    def psnr(light: Array) -> float:
        return compare(buffer.resolve(light), view.reference, buffer.inside, buffer.eroded).psnr

    whole = look(atlas, faces, buffer)
    print(f"{name}, {view.name}: as baked {psnr(whole):.2f} dB", flush=True)
    mirrored = look(front, faces, buffer)
    exits = _exits(stage, buffer, paths, folder)
    ways = _grouped(exits)
    shares = ways.weight.sum(axis=1) / max(float(exits.weight.sum() / paths), 1e-9)
    print(f"  shares of the light by ways: {' '.join(f'{share:.3f}' for share in shares)}")
    hit = buffer.hit
    shown = np.zeros((int(hit.sum()), 3))
    for number in range(len(ways.weight)):
        shown += _shown(atlas, exits, ways, number, buffer)
        if number + 1 in _PRINTED:
            print(f"  {number + 1} ways: {psnr(mirrored + buffer.spread(shown)):.2f} dB", flush=True)


def _exits(stage: Stage, buffer: GBuffer, paths: int, folder: Path) -> ExitSamples:
    """Paths of the rays that hit, each ray the middle of a texel's only cell."""
    hit = buffer.hit
    count = int(hit.sum())
    normal = buffer.incoming[hit].astype(np.float32)
    helper = np.where(np.abs(normal[:, 2:]) < 0.9, [[0.0, 0, 1]], [[1.0, 0, 0]])
    tangent = np.cross(helper, normal)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    bitangent = np.cross(normal, tangent)

    def packed(values: Array) -> Floats:
        return values.astype(np.float32)[None]

    flat = CapturePlan(
        AtlasLayout(count, 1, 1),
        np.arange(count),
        *map(packed, (buffer.position[hit], tangent, bitangent, normal, buffer.normal[hit])),
    )
    plan = plan_of_picked(flat, np.arange(count))
    scene = cast(bpy.types.Scene, bpy.context.scene)
    kept: list[bpy.types.ID] = []
    with scratch_scene(scene, None, kept) as scratch:
        item = find_object(scratch, stage.subject.name)
        prepared = finished(
            prepare(scratch, [item], BakeSpec(layout=Layout.LAYERED, texels=128), kept, backs=True)
        )
        originals = [one for one, _ in prepared.rendered]
        meshes = [mesh for _, mesh in prepared.rendered]
        bodies = tuple(map(Body, originals, meshes, matrices_in_renders(scratch, originals)))
        with surface_alone(originals, meshes, prepared.panes):
            middle, radius = reach_of(plan)
            return capture_exits(scratch, bodies, middle, radius, plan, paths, 5, folder)


def _grouped(exits: ExitSamples, most: int = 8) -> _Ways:
    """Paths that leave alike as one way each."""
    left = exits.weight[:, :, 0].copy()
    direction, place = exits.direction[:, :, 0], exits.place[:, :, 0]
    times, count = left.shape
    weight, mean, where, spread = [], [], [], []
    for _ in range(most):
        best, keep = np.zeros(count), np.zeros_like(left)
        for one, own in zip(direction, left, strict=True):
            agree = ((direction * one).sum(axis=-1) > _AGREE) * left
            score = agree.sum(axis=0) * (own > 0)
            better = score > best
            best = np.where(better, score, best)
            keep = np.where(better, agree, keep)
        total = np.maximum(keep.sum(axis=0), 1e-9)
        towards = (keep[..., None] * direction).sum(axis=0) / total[:, None]
        length = np.maximum(np.linalg.norm(towards, axis=1), 1e-9)
        weight.append(keep.sum(axis=0) / times)
        mean.append(towards / length[:, None])
        where.append((keep[..., None] * place).sum(axis=0) / total[:, None])
        spread.append(np.maximum(1 - length, 0))
        left = np.where(keep > 0, 0, left)
    return _Ways(*(np.stack(part).astype(np.float32) for part in (weight, mean, where, spread)))


def _shown(atlas: LayeredAtlas, exits: ExitSamples, ways: _Ways, number: int, buffer: GBuffer) -> Array:
    plan, hit = exits.plan, buffer.hit
    count = len(plan.texel)
    axes = np.stack([a.reshape(-1, 3)[:count] for a in (plan.tangent, plan.bitangent, plan.normal)], axis=1)
    direction, moved = (
        np.einsum("na,nac->nc", local[number], axes) for local in (ways.direction, ways.place)
    )
    offset = (buffer.position[hit] - atlas.around.middle).astype(np.float32)
    light = atlas.around.look(offset + moved, direction.astype(np.float32), ways.variance[number])
    shown: Array = (light * ways.weight[number]).T.astype(np.float64) * exits.colour
    return shown


if __name__ == "__main__":
    main()
