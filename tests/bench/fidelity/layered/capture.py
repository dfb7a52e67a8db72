# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All captures of the layered layout, one after another, each in a scratch scene of its own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.bake.piece_store import NO_STORE
from radtex_addon.bake.plan import CapturePlan, plan_capture
from radtex_addon.bake.progress import finished
from radtex_addon.bake.rays import FINER, PROBE_CELLS, PROBES
from radtex_addon.bake.spec import BakeSpec
from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.cycles.find_hidden import find_hidden
from radtex_addon.cycles.path_ends import path_ends
from radtex_addon.cycles.sampling import capture_ends, capture_samples
from radtex_addon.cycles.shared_capture import _reach
from radtex_addon.prepare.prepared import Prepared, prepare
from radtex_addon.scene.mesh.surrounding_shapes import Beside, read_beside
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scene_copied, scratch_scene

from ..scenes import Stage
from ..surface_alone import surface_alone
from .environment import Around
from .exits import capture_exits
from .fit import COARSER, Capture
from .lamps import find_lamps
from .maps import capture_maps, depends_on_angle
from .opacity import find_opacity
from .own_rays import capture_own_rays
from .panoramas import look_around
from .through import lets_through

EXIT_CELLS = 16  # along the sides of buckets of rays that leave the object
OWN_SIDE = 40  # rays along a side of a texel's hemisphere, that tell what it sees of the object itself


@dataclass(frozen=True)
class Rays:
    """How many paths a texel spends: `light`², `ends`² twice, and `exits` in each cell of them."""

    light: int = 16
    ends: int = 10
    exits: int = 2

    @classmethod
    def of(cls, samples: int) -> Rays:
        """As a plain bake of so many samples in each of 8 x 8 cells affords."""
        share = (samples / 16) ** 0.5
        return cls(max(4, round(cls.light * share)), max(4, round(cls.ends * share)))


@dataclass(frozen=True, eq=False)
class Captured:
    """What was captured of a stage, the baked copy that it is of, and its faces' materials (F,).

    `paths` count all that meet light or materials; `rays` those that only ask where the object itself is.
    """

    capture: Capture
    prepared: Prepared
    matrix_world: Floats
    faces: Ints
    paths: int
    rays: int


def capture_layered(stage: Stage, spec: BakeSpec, folder: Path) -> Captured:
    """Capture the stage, which the open file must hold; `folder` takes temporary files.

    Raises InputError where no texel is covered or the object is clear everywhere, BakeError where Cycles
    fails.
    """
    scene = cast(bpy.types.Scene, bpy.context.scene)
    kept: list[bpy.types.ID] = []
    rays = Rays.of(spec.samples)
    with scratch_scene(scene, None, kept) as scratch, surface_alone(stage.subject) as clear:
        item = find_object(scratch, stage.subject.name)
        prepared = finished(prepare(scratch, [item], spec, kept, backs=True))
        texels, finer = prepared.texels(), prepared.texels(FINER)
        mesh, matrix = prepared.pieces[0].rendered, prepared.matrix_world
        probe = plan_capture(texels, PROBE_CELLS)
        hidden = finished(find_hidden([(mesh, matrix)], probe, folder, NO_STORE))
        without = probe.texel[hidden.buried]
        beside = read_beside(scratch, item)
        alone = Beside(beside.matrix, ())
        fine, coarse = plan_capture(finer, 1), plan_capture(texels, 1, without=without)
        opacity = find_opacity(scratch, item, mesh, beside.matrix, clear, coarse, fine, spec.seed, folder)
        without = np.concatenate([without, opacity.cut_out])

        def plan(cells: int) -> CapturePlan:
            return plan_capture(texels, cells, without=without)

        lit = plan(rays.light)
        middle, radius = _reach(lit)
        with scene_copied(scratch) as copy, path_ends(copy, item, mesh, alone, middle) as ends:
            lone = capture_ends(ends, plan(rays.ends), spec.seed, folder)
        with scene_copied(scratch) as copy:
            unseen = hidden.of_texels(np.isin(probe.texel, lit.texel)).cells
            light = finished(capture_samples(copy, lit, unseen, spec.seed, folder))
        with scene_copied(scratch) as copy:
            fine_maps = capture_maps(copy, fine, spec.seed, folder, depends_on_angle(clear))
        with scene_copied(scratch) as copy:
            coarse_maps = capture_maps(copy, plan(1), spec.seed, folder, depends_on_angle(clear))
        with scene_copied(scratch) as copy:
            own_plan, uv_layer = plan(OWN_SIDE), prepared.uv_layer
            own = capture_own_rays(
                copy, item, mesh, beside.matrix, own_plan, spec.seed, folder, opacity.fine, uv_layer
            )
        with scene_copied(scratch) as copy:
            lamps = find_lamps(copy, middle, folder)
        with scene_copied(scratch) as copy:
            seen = look_around(copy, item.name, middle, folder, spec.seed)
        paths = len(lit.texel) * (rays.light**2 + 2 * rays.ends**2 + 1) + len(fine.texel)
        paths += len(probe.texel) * PROBES * PROBE_CELLS**2 + seen.paths
        exits = None
        if lets_through(lone, light):
            coarser = plan_capture(prepared.texels(1 / COARSER), EXIT_CELLS)
            exits = capture_exits(
                scratch, item, mesh, beside.matrix, middle, radius, coarser, rays.exits, spec.seed, folder
            )
            paths += 3 * exits.weight.size
        faces = np.empty(len(prepared.mesh.polygons), dtype=np.int32)
        cast(Any, prepared.mesh.polygons).foreach_get("material_index", faces)
        around = Around(middle, seen.world, seen.layers, lamps)
        material = faces[texels.triangle.ravel()[lit.texel]]
        fine_maps["material"] = fine.placed(
            faces[finer.triangle.ravel()[fine.texel]][:, None].astype(np.float32), gutter=True
        )
        capture = opacity.bare(Capture(light, lone, own, around, fine_maps, coarse_maps, material, exits))
        paths += opacity.rays
    return Captured(capture, prepared, np.array(stage.subject.matrix_world), faces, paths, own.hit.size)
