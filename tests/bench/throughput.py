# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths per second, side by side in one run: `python -m tests.bench.throughput`.

The portal against a plain Cycles camera that the object fills, the whole job against the portal, and the
portal against the panoramic capture. Every figure is a median of pairs measured in turn; only ratios travel
to other machines.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import sqrt
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import cast

import bpy
import numpy as np
from mathutils import Vector

from radtex_addon.bake.plan import CapturePlan, Tile, plan_capture
from radtex_addon.bake.progress import finished
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.texel_map import rasterise
from radtex_addon.cycles.capture_settings import apply_capture_settings
from radtex_addon.cycles.panoramic import PanoramicCapture
from radtex_addon.cycles.portal import PortalCapture
from radtex_addon.job import bake_object
from radtex_addon.scene.demo import OBJECT, build_demo_scene
from radtex_addon.scene.mesh.copy import UV_LAYER, baked_mesh, surface_mesh
from radtex_addon.scene.mesh.evaluated import evaluate
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.scene.uv.unwrap import unwrap_steps
from radtex_addon.settings.spec import BakeSpec, Kind, Unwrap

BUCKET, SAMPLES = 8, 16


def main() -> None:
    """Measure and print the table."""
    keep_lines = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=keep_lines)
    parser.add_argument("--texels", type=int, default=64)
    parser.add_argument("--pairs", type=int, default=5)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        texels = options.texels
        rows = [
            *_portal_and_camera(texels, options.pairs, folder),
            *(_job_and_portal(texels, levels, options.pairs, folder) for levels in (1, 2)),
            *(_portal_and_panoramic(texels, spp, folder) for spp in (1, 4, 16)),
        ]
    print("\n| A | B | A, M paths/s | B, M paths/s | A/B: min | median | max |")
    print("|---|---|---|---|---|---|---|")
    print("\n".join(rows))


def _demo(levels: int = 2) -> bpy.types.Scene:
    """The demo's scene, its head subdivided so often."""
    scene = build_demo_scene()
    cast(bpy.types.SubsurfModifier, bpy.data.objects[OBJECT].modifiers[0]).render_levels = levels
    return scene


def _plan(scene: bpy.types.Scene, texels: int) -> CapturePlan:
    with scratch_scene(scene) as scratch:
        evaluated = evaluate(scratch, find_object(scratch, OBJECT))
        unwrapped = finished(unwrap_steps(evaluated, texels, Unwrap.XATLAS))
        surface = surface_mesh(evaluated, baked_mesh(evaluated, unwrapped.uv), UV_LAYER)
    return plan_capture(rasterise(surface, unwrapped.width, unwrapped.height), BUCKET)


def _portal_and_camera(texels: int, pairs: int, folder: Path) -> list[str]:
    """The same scene, pixels and samples: the camera's own rays through portals, and those of a bake."""
    demo = _demo()
    plan = _plan(demo, texels)
    pixels = 2 * round(sqrt(len(plan.texel)) * BUCKET / 2)
    with scratch_scene(demo) as scene:
        share = _aim_at_object(scene, pixels)
        rays = _camera_plan(scene, pixels // 2)
        apply_capture_settings(scene, SAMPLES, 0)
        scene.render.filepath = str(folder / "plain.exr")

        def plain() -> int:
            bpy.ops.render.render(write_still=True, scene=scene.name)
            return pixels * pixels * SAMPLES

        camera = f"plain camera ({share:.0%} of its rays meet the object)"
        rows = []
        for name, each in (("portal, that camera's rays", rays), ("portal, a bake's rays", plan)):
            with _portal(demo, each, Kind.RADIANCE, SAMPLES, folder) as portal:
                rows.append(_row(name, camera, portal, plain, pairs))
    return rows


def _camera_plan(scene: bpy.types.Scene, side: int) -> CapturePlan:
    """side x side texels, 2 x 2 cells each, whose cells all look along one of the camera's rays."""
    matrix = np.array(scene.camera.matrix_world)
    frame = np.array([corner.to_tuple() for corner in scene.camera.data.view_frame(scene=scene)])
    top_right, _, bottom_left, _ = frame @ matrix[:3, :3].T
    right, up = matrix[:3, 0], matrix[:3, 1]
    across = top_right - bottom_left
    x, y = np.meshgrid(*[(np.arange(side) + 0.5) / side] * 2)
    ray = bottom_left + x[..., None] * (across @ right) * right + y[..., None] * (across @ up) * up
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    position, normal = (matrix[:3, 3] + 0.2 * ray).astype(np.float32), (-ray).astype(np.float32)
    none = np.zeros_like(normal)
    return CapturePlan(AtlasLayout(side, side, 2), np.arange(side**2), position, none, none, normal, normal)


def _job_and_portal(texels: int, levels: int, pairs: int, folder: Path) -> str:
    """Unwrap to files, against its own capture alone."""
    demo = _demo(levels)
    plan = _plan(demo, texels)
    spec = BakeSpec(texels=texels, bucket=BUCKET, samples=SAMPLES)

    def job() -> int:
        return bake_object(demo, OBJECT, spec, folder, overwrite=True).paths

    with _portal(demo, plan, Kind.RADIANCE, SAMPLES, folder) as portal:
        return _row(f"whole job, {968 * 4**levels} triangles", "portal", job, portal, pairs)


def _portal_and_panoramic(texels: int, samples: int, folder: Path) -> str:
    """Incident light of the same texels; the panoramic capture takes a sixteenth of them, it is slow."""
    demo = _demo()
    plan = _plan(demo, texels)
    with scratch_scene(demo) as scene, _portal(demo, plan, Kind.INCIDENT, samples, folder) as portal:
        few = PanoramicCapture(scene, plan, Kind.INCIDENT, samples, 0, folder)
        rows = max(1, plan.rows // 16)

        def panoramic() -> int:
            return few.render(Tile(0, rows))[..., 0].size * samples

        return _row(f"portal, {samples} spp", f"panoramic, {samples} spp", portal, panoramic, 3)


@contextmanager
def _portal(
    demo: bpy.types.Scene, plan: CapturePlan, kind: Kind, samples: int, folder: Path
) -> Iterator[Callable[[], int]]:
    """A portal capture of the whole plan."""
    with scratch_scene(demo) as scratch:
        capture = PortalCapture(scratch, plan, kind, samples, 0, folder)

        def run() -> int:
            return capture.render(Tile(0, plan.rows))[..., 0].size * samples

        yield run


def _aim_at_object(scene: bpy.types.Scene, pixels: int) -> float:
    """Let the camera see as little else as can be; returns the share of its rays that meet the object."""
    camera = scene.camera
    place = Vector((0.0, -4.0, 0.1))
    camera.location = place
    camera.rotation_euler = (Vector((0, 0, 0.1)) - place).to_track_quat("-Z", "Y").to_euler()
    camera.data.lens = 130
    scene.render.resolution_x = scene.render.resolution_y = pixels
    layer = scene.view_layers[0]
    layer.update()
    graph, eye = cast(bpy.types.Depsgraph, layer.depsgraph), camera.matrix_world.translation
    corners = [camera.matrix_world @ corner for corner in camera.data.view_frame(scene=scene)]
    top_right, bottom_right, _, top_left = corners
    hits = 0
    steps = 24
    for k in range(steps * steps):
        x, y = (k % steps + 0.5) / steps, (k // steps + 0.5) / steps
        target = top_left + x * (top_right - top_left) + y * (bottom_right - top_right)
        hit = scene.ray_cast(graph, eye, target - eye)
        hits += bool(hit[0]) and hit[4].name == OBJECT
    return hits / steps**2


def _row(a_name: str, b_name: str, a: Callable[[], int], b: Callable[[], int], pairs: int) -> str:
    """Run A and B in turn, after one warm-up each, and compare their paces pair by pair."""
    a()
    b()
    paces = [(_pace(a), _pace(b)) for _ in range(pairs)]
    ratios = sorted(x / y for x, y in paces)
    middle = [median(column) / 1e6 for column in zip(*paces, strict=True)]
    figures = f"{middle[0]:.3f} | {middle[1]:.3f} | {ratios[0]:.2f} | {median(ratios):.2f} | {ratios[-1]:.2f}"
    print(f"{a_name} / {b_name}: {median(ratios):.2f}", flush=True)
    return f"| {a_name} | {b_name} | {figures} |"


def _pace(run: Callable[[], int]) -> float:
    started = perf_counter()
    paths = run()
    return paths / (perf_counter() - started)


if __name__ == "__main__":
    main()
