# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A curtain, partly clear, over a ground that no bake knew: python -m tests.bench.gallery alpha"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.forms.layered.files.layered_files import read_layered
from radtex_addon.forms.layered.lookup.atlas import alpha_at, sample_layered
from radtex_addon.report.gbuffer import Array, GBuffer
from radtex_addon.report.metrics import Picture
from radtex_addon.settings.spec import BakeSpec, Layout

from .looking import (
    PIXELS,
    SUBJECT,
    Baked,
    Camera,
    added,
    baked,
    empty_scene,
    lamp,
    principled,
    rendered,
    resolved,
)
from .row import Row, Use

SPEC = BakeSpec(layout=Layout.LAYERED)
BUCKETS = BakeSpec(texels=128, bucket=8, samples=8, denoise=True)
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
    """The gallery's rows: the curtain from two sides, over a ground of stripes, and the same of buckets."""
    for which, (each, use) in enumerate(((spec, Use.PICTURE), (BUCKETS, Use.TABLE))):
        scene()
        with tempfile.TemporaryDirectory() as folder:
            bake = baked(each, Path(folder))
            look = _layered(bake) if each.layout is Layout.LAYERED else _buckets(bake)
        for name, camera in CAMERAS.items():
            seen = bake.seen(camera)
            ours, truth = resolved(seen.spread(look(seen)), seen), rendered(camera)
            gap = np.abs(ours - truth)[..., 3][seen.eroded].mean()
            note = f"alpha is {gap:.3f} off in the mean; {bake.words}"
            title = f"Alpha, {name}" + ", buckets" * which
            yield Row(title, _over(truth), _over(ours), seen.eroded, note, use=use)


def _layered(bake: Baked) -> Callable[[GBuffer], Floats]:
    """Premultiplied light and alpha (hits, 4) of a bake in the layered layout."""
    atlas, _ = read_layered(bake.sidecar)

    def look(seen: GBuffer) -> Floats:
        at = seen.fragments
        return np.concatenate([sample_layered(atlas, at), alpha_at(atlas, at.uv)[:, None]], axis=1)

    return look


def _buckets(bake: Baked) -> Callable[[GBuffer], Floats]:
    """Premultiplied light and alpha (hits, 4) of a bake in layout buckets."""
    pixels, facts = read_buckets(bake.sidecar)
    layout = AtlasLayout(facts.width, facts.height, facts.bucket)

    def look(seen: GBuffer) -> Floats:
        uv, incidence = seen.uv[seen.hit], seen.incidence[seen.hit]
        return sample(pixels.astype(np.float32), layout, uv, incidence, Filter.QUADRILINEAR)

    return look


def _over(picture: Array) -> Picture:
    """A premultiplied picture (H, W, 4) over slanting stripes of blue and white."""
    y, x = np.indices((PIXELS, PIXELS))
    stripe = ((x + y) // 24 % 2)[..., None]
    ground = np.where(stripe, (0.05, 0.12, 0.4), (0.7, 0.7, 0.7))
    laid: Picture = picture[..., :3] + (1 - picture[..., 3:]) * ground
    return laid
