# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A curtain, partly clear, over a ground that no bake knew: python -m tests.bench.gallery alpha"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from radtex_addon.bake.spec import BakeSpec
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.report.gbuffer import Array
from radtex_addon.report.metrics import Picture

from .looking import PIXELS, SUBJECT, Camera, added, baked, empty_scene, lamp, principled, rendered, resolved
from .row import Row

SPEC = BakeSpec(texels=128, bucket=8, samples=8, denoise=True)
CAMERAS = {
    "left": Camera((-2.2, -4.0, 0.6)),
    "above": Camera((0.9, -3.6, 2.2)),
}


def scene() -> None:
    """A curtain that waves of alpha run over, in a world that its picture leaves out."""
    made = empty_scene((0.5, 0.5, 0.55))
    made.render.film_transparent = True
    lamp((-3.0, -3.0, 4.0), watts=300, size=2)
    material: Any = principled("Stained", (0.8, 0.25, 0.1), Roughness=0.4)
    tree = material.node_tree
    wave = tree.nodes.new("ShaderNodeTexWave")
    wave.bands_direction = "Z"
    wave.inputs["Scale"].default_value, wave.inputs["Distortion"].default_value = 0.7, 2.0
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Object"], wave.inputs["Vector"])
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    tree.links.new(wave.outputs["Fac"], shader.inputs["Alpha"])
    curtain = added("grid", SUBJECT, material, x_subdivisions=96, y_subdivisions=8, size=2)
    curtain.rotation_euler = (np.pi / 2, 0, 0)
    for vertex in curtain.data.vertices:
        vertex.co.z = 0.12 * np.sin(7 * vertex.co.x)


def rows(spec: BakeSpec = SPEC) -> Iterator[Row]:
    """The gallery's rows: the curtain from two sides, over a ground of stripes."""
    scene()
    with tempfile.TemporaryDirectory() as folder:
        bake = baked(spec, Path(folder))
        pixels, facts = read_buckets(bake.sidecar)
    layout = AtlasLayout(facts.width, facts.height, facts.bucket)
    for name, camera in CAMERAS.items():
        seen = bake.seen(camera)
        uv, incidence = seen.uv[seen.hit], seen.incidence[seen.hit]
        looked = sample(pixels.astype(np.float32), layout, uv, incidence, Filter.QUADRILINEAR)
        ours, truth = resolved(seen.spread(looked), seen), rendered(camera)
        gap = np.abs(ours - truth)[..., 3][seen.eroded].mean()
        note = f"alpha is {gap:.3f} off in the mean; {bake.words}"
        yield Row(f"Alpha, {name}", _over(truth), _over(ours), seen.eroded, note)


def _over(picture: Array) -> Picture:
    """A premultiplied picture (H, W, 4) over slanting stripes of blue and white."""
    y, x = np.indices((PIXELS, PIXELS))
    stripe = ((x + y) // 24 % 2)[..., None]
    ground = np.where(stripe, (0.05, 0.12, 0.4), (0.7, 0.7, 0.7))
    laid: Picture = picture[..., :3] + (1 - picture[..., 3:]) * ground
    return laid
