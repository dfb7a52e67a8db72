# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small real bakes of the kinds that are not looked up as radiance is, and what each must show.

    python -m tests.real.kinds shadow FOLDER VIEW [CELLS]

They are of the exhibit's head and cameras; the proxy is a ball around it.
"""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.bake.layers import Layer
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.frame import to_frame
from radtex_addon.core.hemisphere import direction_to_square
from radtex_addon.core.octahedron import direction_to_octahedron
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.core.shadow import unpack_bits
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.formats.shadow_files import read_shadow_of
from radtex_addon.formats.sidecar import preview_path
from radtex_addon.formats.sidecar_file import read_facts
from radtex_addon.formats.transfer_files import read_transfer
from radtex_addon.job import bake_object
from radtex_addon.report.finished_bake import find_bake
from radtex_addon.report.gbuffer import BakedSurface, GBuffer
from radtex_addon.report.metrics import Picture
from radtex_addon.scene.demo import OBJECT
from radtex_addon.scene.preview_file import baked_copy
from radtex_addon.settings.spec import BakeSpec, Kind, View
from tests.real.exhibit import FIGURES, PLACE, ROOT, Bake, Camera, head_stage
from tests.reference.relighting import sample_transfer
from tests.reference.shadows import cell_visibility, soft_visibility, sun_directions, sun_weight, visibility

TEXELS = 64 if FIGURES else 40
HULL = "Hull"
LAYERS = (Layer.BASE, Layer.REST, Layer.GLOSSY)  # of the proxy; they change nothing of the whole
POINTS = 32  # of the sun's disc, as the page takes
MOST_BLENDED = 8  # cells on a side that soft shadows blend; whole ones of more
SPECS = {
    Kind.SHADOW: BakeSpec(kind=Kind.SHADOW, texels=TEXELS),
    Kind.AO: BakeSpec(kind=Kind.AO, texels=TEXELS, samples=1),
    Kind.PROXY: BakeSpec(kind=Kind.PROXY, texels=TEXELS, samples=4, content="Inside", layers=LAYERS),
    Kind.TRANSFER: BakeSpec(kind=Kind.TRANSFER, texels=TEXELS, samples=1),
}


@dataclass(frozen=True)
class Sun:
    """The page's sun; angles in degrees, `colour` in sRGB as CSS writes it."""

    azimuth: float
    height: float
    size: float = 0.0
    strength: float = 1.0
    colour: str = "#ffffff"

    @property
    def towards(self) -> Floats:
        """To the sun, in glTF's axes."""
        turn, up = np.radians(self.azimuth), np.radians(self.height)
        return np.array([np.cos(up) * np.sin(turn), np.sin(up), np.cos(up) * np.cos(turn)])

    @property
    def irradiance(self) -> Floats:
        """On a plane that faces it: (3,), linear."""
        parts = np.array([int(self.colour[place : place + 2], 16) / 255 for place in (1, 3, 5)])
        linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
        lit: Floats = linear * self.strength
        return lit


@dataclass(frozen=True, eq=False)
class KindBake(Bake):
    """A finished bake of any kind in `folder`."""

    @cached_property
    def sidecar(self) -> Path:
        return find_bake(self.folder, None, "shown", tuple(Kind)).path

    @cached_property
    def kind(self) -> Kind:
        return Kind(read_facts(self.sidecar).text("kind"))

    @property
    def preview(self) -> Path:
        return preview_path(self.sidecar, self.kind)

    @cached_property
    def surface(self) -> BakedSurface:
        facts = read_facts(self.sidecar)
        name, layer = facts.text("object"), facts.text("uv_map")
        with baked_copy(self.preview, (name,), layer) as (_, copy):
            return BakedSurface(cast(bpy.types.Mesh, copy.data), np.array(PLACE), layer)

    def seen(self, camera: Camera, sun: Sun | None = None) -> Picture:
        """Premultiplied linear light (H, W, 4), rows from the top, 0 beside the object."""
        buffer = self.buffer(camera)
        lights = {Kind.SHADOW: self._shadow, Kind.TRANSFER: self._transfer}
        light = lights[self.kind](buffer, sun) if sun else self._buckets(buffer)
        if light.shape[1] < 4:
            light = np.column_stack([np.broadcast_to(light, (len(light), 3)), np.ones(len(light))])
        return cast(Picture, buffer.spread(light).reshape(camera.pixels, camera.pixels, 4))

    @cached_property
    def cells(self) -> Floats:
        """What the inspector shows of each texel's bucket, (H, W, n, n, 4)."""
        if self.kind is Kind.SHADOW:
            words, facts = read_shadow_of(self.sidecar)
            opened = (~unpack_bits(words, facts.bucket)).astype(np.float32)[..., None]
            return self._grey(opened)
        if self.kind is Kind.TRANSFER:
            pixels, sphere = read_transfer(self.sidecar)
            return sphere.layout.to_buckets(pixels)
        pixels, facts = read_buckets(self.sidecar)
        stored = AtlasLayout(facts.width, facts.height, facts.bucket).to_buckets(pixels)
        return self._grey(stored[..., 3:]) if self.kind is Kind.AO else stored

    def looked_up(self, buffer: GBuffer, sun: Sun) -> Floats:
        """Where each hit's lookup lies in the bucket, in [-1, 1]^2: (hits, 2)."""
        if self.kind is Kind.TRANSFER:
            return direction_to_octahedron(self._in_frame(buffer, sun.towards)) * 2 - 1
        if self.kind is Kind.SHADOW:
            return direction_to_square(self._in_frame(buffer, sun.towards))
        return direction_to_square(buffer.incidence[buffer.hit])

    @staticmethod
    def _grey(values: Floats) -> Floats:
        """Values (..., 1) as opaque grey (..., 4)."""
        return np.concatenate([values, values, values, np.ones_like(values)], axis=-1)

    def _buckets(self, buffer: GBuffer) -> Floats:
        pixels, facts = read_buckets(self.sidecar)
        layout = AtlasLayout(facts.width, facts.height, facts.bucket)
        uv, incidence = buffer.uv[buffer.hit], buffer.incidence[buffer.hit]
        light = sample(pixels.astype(np.float32), layout, uv, incidence, Filter.QUADRILINEAR)
        return light[:, 3:] if self.kind is Kind.AO else light

    def _shadow(self, buffer: GBuffer, sun: Sun) -> Floats:
        words, facts = read_shadow_of(self.sidecar)
        layout = AtlasLayout(facts.width, facts.height, facts.bucket)
        uv, wide = buffer.uv[buffer.hit], float(np.radians(sun.size))
        if not sun.size:
            local = self._in_frame(buffer, sun.towards)
            share = visibility(words, layout, uv, local, Filter.QUADRILINEAR)
            return (share * np.maximum(local[:, 2], 0))[:, None]
        ways = sun_directions(sun.towards, wide, POINTS)
        local = np.stack([self._in_frame(buffer, way) for way in ways], axis=1)
        weight = np.maximum(local[..., 2], 0)
        if layout.bucket <= MOST_BLENDED:
            share = soft_visibility(words, layout, uv, local, weight)
        else:
            share = cell_visibility(words, layout, uv, local, weight, Filter.QUADRILINEAR)
        return (share * weight.mean(axis=1) * sun_weight(wide))[:, None]

    def _transfer(self, buffer: GBuffer, sun: Sun) -> Floats:
        pixels, facts = read_transfer(self.sidecar)
        local = self._in_frame(buffer, sun.towards)
        stored, hit = pixels.astype(np.float32), buffer.hit
        answer = sample_transfer(
            stored, facts.layout, buffer.uv[hit], local, buffer.incidence[hit], facts.views
        )
        lit: Floats = answer * [*sun.irradiance, 1]
        return lit

    @staticmethod
    def _in_frame(buffer: GBuffer, towards: Floats) -> Floats:
        """A direction (3,) in glTF's axes in the frame of each hit: (hits, 3)."""
        x, y, z = towards
        hit = buffer.hit
        every = np.broadcast_to(np.array([x, -z, y]), (int(hit.sum()), 3))
        return to_frame(every, buffer.tangent[hit], buffer.bitangent[hit], buffer.normal[hit])


def baked(kind: Kind, folder: Path, cells: int | None = None, view: View = View.NORMAL) -> KindBake:
    """Bake in a process of its own: the file that is open here stays as it is."""
    if not folder.is_dir():
        arguments = [kind, str(folder), view, *([str(cells)] if cells else [])]
        command = [sys.executable, "-m", "tests.real.kinds", *arguments]
        ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=600)
        assert ended.returncode == 0, ended.stderr
    return KindBake(folder)


def main(kind: Kind, folder: Path, view: View, cells: int | None) -> None:
    """Bake the head, or the hull around it, with its preview."""
    scene, head = head_stage()
    name = OBJECT
    if kind is Kind.PROXY:
        inside = bpy.data.collections.new("Inside")
        inside.objects.link(head)
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=1.6)
        hull: Any = bpy.context.object
        hull.name, hull.matrix_world, name = HULL, PLACE, HULL
    spec = replace(SPECS[kind], view=view, bucket=cells or SPECS[kind].bucket)
    bake_object(scene, name, spec, folder, preview=Filter.QUADRILINEAR)


if __name__ == "__main__":
    kind, folder, view, *cells = sys.argv[1:]
    main(Kind(kind), Path(folder), View(view), int(cells[0]) if cells else None)
