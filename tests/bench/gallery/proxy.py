# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fur and leaves inside a simple hull, which alone is drawn: python -m tests.bench.gallery proxy

A hull's colour and alpha are laid over a grey ground, path traced and ours; measured where either is seen.
Hulls are wrapped around what they show. Each is baked with four points to a texel and looked up in their
mean, the atlas's mip level 1: hairs and leaves are narrower than a texel, and one point of it would not tell.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from math import pi
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.report.gbuffer import Array, GBuffer
from radtex_addon.report.metrics import Picture
from radtex_addon.settings.spec import BakeSpec, Kind
from tests.reference.levels import level_chain

from .hull import UV_LAYER, wrap_hull
from .looking import (
    FILM_PIXELS,
    SUBJECT,
    Camera,
    added,
    baked,
    empty_scene,
    filmed,
    lamp,
    principled,
    rendered,
    resolved,
)
from .row import Row, Use

SPEC = BakeSpec(kind=Kind.PROXY, texels=256, bucket=8, samples=4, uv_layer=UV_LAYER)
GROUND = 0.18
_SOLID = 0.5  # of alpha: what counts as silhouette
_HAIRS, _LEAVES = 90000, 260
CAMERAS = {
    "left": Camera((-3.4, -4.6, 1.1), lens=85),
    "above": Camera((0.8, -3.2, 4.8), lens=85),
}


def fur() -> None:
    """A ball of fur, two colours of it, in a hull of 2,048 triangles."""
    _lit_scene()
    added("uv_sphere", "Skin", principled("Skin", (0.4, 0.2, 0.1)), radius=0.82, segments=48, ring_count=24)
    rng = np.random.default_rng(3)
    root = _spread_over_ball(_HAIRS)
    tip = root * rng.uniform(0.92, 0.99, (_HAIRS, 1)) + rng.normal(0, 0.05, (_HAIRS, 3)) - [0, 0, 0.05]
    tip *= np.minimum(1, 0.99 / np.linalg.norm(tip, axis=1))[:, None]
    steps = np.linspace(0, 1, 4)[None, :, None]
    points = root[:, None] * 0.8 * (1 - steps) + tip[:, None] * steps
    points[:, 1:3] *= 1.03
    dark = np.sin(7 * root[:, 2] + 2 * np.sin(3 * root[:, 0])) > 0.2
    for name, chosen, colour in (("Dark", dark, (0.3, 0.13, 0.05)), ("Fair", ~dark, (0.75, 0.5, 0.25))):
        _hair(name, points[chosen], principled(name, colour, Roughness=0.5))
    wrap_hull(SUBJECT, tip, cells=32)


def leaves() -> None:
    """A clipped bush of leaves in a hull of 4,608 triangles."""
    _lit_scene()
    rng = np.random.default_rng(5)
    out = _spread_over_ball(_LEAVES)
    middle = out * rng.uniform(0.89, 0.95, (_LEAVES, 1))
    way = np.cross(out, rng.normal(size=(_LEAVES, 3)))
    way = way / np.linalg.norm(way, axis=1, keepdims=True) + out * rng.uniform(0.02, 0.18, (_LEAVES, 1))
    across = np.cross(way, out + rng.normal(0, 0.2, (_LEAVES, 3)))
    way, across = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (way, across))
    outline = np.array(
        [(0, 0), (0.4, 0.3), (1.0, 0.34), (1.6, 0.2), (2, 0), (1.6, -0.2), (1, -0.34), (0.4, -0.3)]
    )
    outline = (outline - [1, 0]) * 0.22
    corner = middle[:, None] + outline[:, :1] * way[:, None] + outline[:, 1:] * across[:, None]
    green = principled("Leaf", (0.12, 0.32, 0.05), Roughness=0.45)
    mesh: Any = bpy.data.meshes.new("Bush")
    count = len(outline)
    faces = [tuple(range(k * count, (k + 1) * count)) for k in range(_LEAVES)]
    mesh.from_pydata(corner.reshape(-1, 3).tolist(), [], faces)
    mesh.materials.append(green)
    _link(bpy.data.objects.new("Bush", mesh))
    added("uv_sphere", "Shade", principled("Shade", (0.1, 0.27, 0.04)), radius=0.91)
    inwards = middle[:, None] - corner
    filled = [corner + share * inwards for share in np.linspace(0, 1, 6)]
    between = [
        (1 - share) * place + share * np.roll(place, -1, axis=1)
        for place in filled
        for share in (0, 0.3, 0.6)
    ]
    wrap_hull(SUBJECT, np.concatenate(between).reshape(-1, 3), cells=48)


def _lit_scene() -> None:
    scene = empty_scene((0.6, 0.63, 0.7))
    scene.render.film_transparent = True
    lamp((-2.5, -3.5, 4.0), watts=200, size=4)


def _spread_over_ball(count: int) -> Floats:
    """Unit vectors, evenly spread: a golden spiral."""
    index = np.arange(count) + 0.5
    height, around = 1 - 2 * index / count, index * pi * (3 - 5**0.5)
    radius = np.sqrt(1 - height**2)
    return np.stack([radius * np.cos(around), radius * np.sin(around), height], axis=1)


def _hair(name: str, points: Floats, material: bpy.types.Material) -> None:
    """Tapering curves through points (K, P, 3)."""
    count, each = points.shape[:2]
    curves: Any = bpy.data.hair_curves.new(name)
    curves.add_curves([each] * count)
    curves.points.foreach_set("position", points.ravel().astype(np.float32))
    thick = np.tile(np.linspace(0.0038, 0.002, each), count).astype(np.float32)
    curves.points.foreach_set("radius", thick)
    curves.materials.append(material)
    _link(bpy.data.objects.new(name, curves))


def _link(item: bpy.types.Object) -> None:
    scene: Any = bpy.context.scene
    scene.collection.objects.link(item)


def rows(spec: BakeSpec = SPEC, stills: bool = True) -> Iterator[Row]:
    """The gallery's rows: a ball of fur and a bush, each from two sides."""
    for title, build in (("Fur", fur), ("Leaves", leaves))[0 if stills else 1 :]:
        build()
        with tempfile.TemporaryDirectory() as folder:
            bake = baked(spec, Path(folder))
            pixels, facts = read_buckets(bake.sidecar)
        pixels = level_chain(pixels, AtlasLayout(facts.width, facts.height, facts.bucket), 2)[1]
        layout = AtlasLayout(facts.width // 2, facts.height // 2, facts.bucket)
        bpy.data.objects[SUBJECT].hide_render = True
        for name, camera in CAMERAS.items() if stills else ():
            seen = bake.seen(camera)
            ours, truth = _shown(pixels, layout, seen), rendered(camera)
            mask = (ours[..., 3] > _SOLID) | (truth[..., 3] > _SOLID)
            both = (ours[..., 3] > _SOLID) & (truth[..., 3] > _SOLID)
            share = f"silhouettes' intersection over union {both.sum() / mask.sum():.3f}"
            note = f"{share}; looked up at level 1, {layout.width} texels; baked with {bake.words}"
            yield Row(f"Proxy, {title.lower()}, {name}", _over(truth), _over(ours), mask, note)
        for camera in CAMERAS["left"].swung(40) if build is leaves else ():
            ours = _shown(pixels, layout, bake.seen(camera, FILM_PIXELS))
            truth = filmed(camera)
            mask = (ours[..., 3] > _SOLID) | (truth[..., 3] > _SOLID)
            whole = np.ones_like(mask)
            yield Row("Proxy, film", _over(truth), _over(ours), mask, "", whole, Use.FILM)


def _shown(pixels: Floats, layout: AtlasLayout, seen: GBuffer) -> Array:
    """Premultiplied colour and alpha, (pixels, pixels, 4)."""
    uv, incidence = seen.uv[seen.hit], seen.incidence[seen.hit]
    looked = sample(pixels.astype(np.float32), layout, uv, incidence, Filter.QUADRILINEAR)
    return resolved(seen.spread(looked), seen)


def _over(picture: Array) -> Picture:
    """A premultiplied picture (H, W, 4) over grey."""
    laid: Picture = picture[..., :3] + (1 - picture[..., 3:]) * GROUND
    return laid
