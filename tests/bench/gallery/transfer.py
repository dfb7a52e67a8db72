# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A lump of wax under a moving sun, against Cycles: python -m tests.bench.gallery.transfer [cells …]

One bake is looked at from cameras and under suns that it has never seen, the last one behind the lump.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
from mathutils import Vector

from radtex_addon.bake.progress import finished
from radtex_addon.core.frame import to_frame
from radtex_addon.formats.containers.exr import read_render
from radtex_addon.formats.transfer_files import read_transfer
from radtex_addon.job import bake_object
from radtex_addon.prepare.prepared import prepare
from radtex_addon.report.gbuffer import BakedSurface, CameraRays
from radtex_addon.report.metrics import Mask, Picture
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, Kind
from tests.reference.relighting import relight

from .looking import FRAMES, Place
from .row import Row, Use

SUBJECT = "Subject"
SPEC = BakeSpec(kind=Kind.TRANSFER, texels=128, bucket=15, samples=8, denoise=True)
PIXELS, SUBSAMPLES = 256, 2
SAMPLES = 128  # of the reference's pixels, before they are denoised
FILM_PIXELS, FILM_SAMPLES = 224, 32
_FILMED_FROM = (0.6, -4.7, 0.6)
IRRADIANCE = (3.0, 2.8, 2.5)
_HALF = 18 / 60  # of the cameras: a sensor of 36 mm behind a lens of 60
# Of each view: the camera's place, and the direction to the sun.
VIEWS = {
    "sun from the front": ((1.2, -4.6, 0.8), (0.1, -0.9, 0.4)),
    "sun from the left": ((-1.6, -4.4, 0.4), (-0.93, -0.3, 0.2)),
    "sun from above": ((2.6, -3.8, 1.2), (0.25, 0.1, 0.96)),
    "sun from the right, low": ((0.0, -4.8, 0.2), (0.85, -0.45, -0.28)),
    "sun from behind": ((-0.9, -4.7, 0.6), (0.3, 0.93, 0.22)),
}


def scene() -> None:
    """A flat lump of wax, alone: thin enough for light to come through."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5)
    lump: Any = bpy.context.object
    lump.name = SUBJECT
    places = np.empty(3 * len(lump.data.vertices))
    lump.data.vertices.foreach_get("co", places)
    x, y, z = places.reshape(-1, 3).T
    bulge = 0.16 * np.sin(2.4 * x + 1) * np.cos(2.1 * y) + 0.14 * np.sin(3.3 * z + 1.7 * x)
    bulge += 0.06 * np.sin(5 * y + 2 * z) * np.cos(4 * x)
    places = np.stack([x, 0.55 * y, z], axis=1) * (1 + bulge)[:, None]
    lump.data.vertices.foreach_set("co", places.ravel())
    lump.data.update()
    bpy.ops.object.shade_smooth()
    wax: Any = bpy.data.materials.new("Wax")
    wax.use_nodes = True
    shader = next(node for node in wax.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    values = {
        "Base Color": (0.9, 0.62, 0.35, 1.0),
        "Subsurface Weight": 1.0,
        "Subsurface Radius": (1.0, 0.5, 0.25),
        "Subsurface Scale": 0.1,
        "Specular IOR Level": 0.0,  # gloss depends on the viewer, whom a view along the normal does not know
    }
    for name, value in values.items():
        shader.inputs[name].default_value = value
    lump.data.materials.append(wax)
    made: Any = bpy.context.scene
    made.world = bpy.data.worlds.new("Dark")
    made.world.use_nodes = True
    made.world.node_tree.nodes.clear()
    made.cycles.sample_clamp_direct = made.cycles.sample_clamp_indirect = 0


def rows(spec: BakeSpec = SPEC, stills: bool = True) -> Iterator[Row]:
    """The gallery's rows: one bake under five suns, from five cameras."""
    scene()
    made: Any = bpy.context.scene
    with tempfile.TemporaryDirectory() as folder:
        result = bake_object(made, SUBJECT, spec, Path(folder))
        stored, facts = read_transfer(result.files.sidecar)
    print(
        f"{spec.bucket} cells: {result.paths:,} paths, {sum(result.seconds.values()):.0f} s, "
        f"{stored.nbytes:,} bytes"
    )
    kept: list[bpy.types.ID] = []
    with scratch_scene(made, None, kept) as scratch:
        prepared = finished(prepare(scratch, [find_object(scratch, SUBJECT)], spec, kept))
        surface = BakedSurface(prepared.mesh, prepared.matrix_world, prepared.uv_layer)
    bpy.data.batch_remove(kept)

    def looked(place: Place, towards: Place, pixels: int) -> tuple[Picture, Mask, Picture]:
        """Ours, where the lump is, and Cycles's."""
        turn = cast(Any, Vector(place)).to_track_quat("Z", "Y")
        rays = CameraRays.of_camera(place, np.array(turn.to_matrix()), _HALF, pixels, SUBSAMPLES)
        seen = surface.gbuffer(rays, np.full(len(rays.away), np.inf))
        hit = seen.hit
        light = to_frame(
            np.broadcast_to(np.array(towards) / np.linalg.norm(towards), seen.normal[hit].shape),
            seen.tangent[hit],
            seen.bitangent[hit],
            seen.normal[hit],
        )
        shown = relight(
            stored.astype(np.float64), facts.layout, seen.uv[hit], [(light, np.array(IRRADIANCE))]
        )
        ours = seen.resolve(seen.spread(shown))
        return ours, seen.eroded, _reference(place, turn, towards, pixels)

    for name, (place, towards) in VIEWS.items() if stills else ():
        ours, mask, truth = looked(place, towards, PIXELS)
        yield Row(f"Transfer, wax, {name}", truth, ours, mask)
    for angle in 2 * np.pi * np.arange(FRAMES) / FRAMES:
        towards = float(np.sin(angle)), float(-np.cos(angle)), 0.25
        ours, mask, truth = looked(_FILMED_FROM, towards, FILM_PIXELS)
        yield Row("Transfer, film", truth, ours, mask, use=Use.FILM)


def _reference(place: Place, turn: Any, towards: Place, pixels: int) -> Picture:
    """Cycles's picture, denoised, from the top row on."""
    made: Any = bpy.context.scene
    data: Any = bpy.data.lights.new("Sun", "SUN")
    data.energy, data.color = 1.0, IRRADIANCE
    data.angle = 0.009  # the real sun's
    sun: Any = bpy.data.objects.new("Sun", data)
    sun.rotation_mode = "QUATERNION"
    sun.rotation_quaternion = cast(Any, Vector(towards)).to_track_quat("Z", "Y")
    lens: Any = bpy.data.cameras.new("Camera")
    lens.lens = 60
    camera: Any = bpy.data.objects.new("Camera", lens)
    camera.location, camera.rotation_mode, camera.rotation_quaternion = place, "QUATERNION", turn
    for item in (sun, camera):
        made.collection.objects.link(item)
    made.camera, made.render.engine = camera, "CYCLES"
    made.render.resolution_x = made.render.resolution_y = pixels
    made.cycles.samples = SAMPLES if pixels == PIXELS else FILM_SAMPLES
    made.cycles.use_adaptive_sampling = False
    made.cycles.use_denoising, made.cycles.denoiser = True, "OPENIMAGEDENOISE"
    made.cycles.pixel_filter_type, made.cycles.filter_width = "BOX", 1.0
    image = made.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_depth = "OPEN_EXR", "32"
    with tempfile.TemporaryDirectory() as folder:
        made.render.filepath = str(Path(folder, "view.exr"))
        bpy.ops.render.render(write_still=True)
        (seen,) = read_render(Path(folder, "view.exr")).values()
    for item in (sun, camera):
        bpy.data.objects.remove(item)
    picture: Picture = seen[::-1, :, :3].astype(np.float64)
    return picture


def main() -> None:
    """Print what was measured."""
    for cells in [int(word) for word in sys.argv[1:]] or [9, 15]:
        for row in rows(replace(SPEC, bucket=cells)):
            print(f"{cells} cells: {row.name}: {row.psnr:.1f} dB, FLIP {row.flip:.3f}", flush=True)


if __name__ == "__main__":
    main()
