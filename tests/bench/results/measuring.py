# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes a scene by every method of a group, looks at it from its views, and compares."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any

import bpy
import numpy as np

from radtex_addon.bake.progress import finished
from radtex_addon.core.sampler import Filter
from radtex_addon.forms.layered.fit.fitting import fit_layered
from radtex_addon.prepare.unwrapping import Unwraps
from radtex_addon.report.gbuffer import BakedSurface, GBuffer
from radtex_addon.report.metrics import Picture, compare
from radtex_addon.settings.spec import BakeSpec, Layout

from ..fidelity.captured import capture_stage
from ..fidelity.composite import seen_light
from ..fidelity.layered.sizes import material_bytes
from ..fidelity.layered.staged import capture_staged
from ..fidelity.method import Baked
from ..fidelity.methods import lightmap, probe, sg, sh
from ..fidelity.methods.eevee import Eevee
from ..fidelity.methods.layered import baked_of
from ..fidelity.methods.plain import bake_buckets
from ..fidelity.pictures import picture_inside
from ..fidelity.references import View
from .cells import Cell, Key
from .kept_pictures import keep
from .matrix import MAIN, NOTHING, SEEDS, Group, Setting
from .scenes import REFERENCE_SAMPLES, SCENES, cameras_of, looked_from

_OTHER_SEED = 22  # of the reference that tells the reference's noise


class OpenScene:
    """A scene in the open file, its views, and what they see of each mesh: unwraps do not depend on seeds."""

    def __init__(self, name: str) -> None:
        self.stage = SCENES[name]()
        self.views = looked_from(self.stage)
        self._buffers: dict[str, tuple[BakedSurface, list[GBuffer]]] = {}
        self._unwraps: Unwraps = {}

    def measure(self, setting: Setting, seed: int, group: Group) -> Iterator[Cell]:
        """Measure a group of methods."""
        with tempfile.TemporaryDirectory() as folder:
            started = perf_counter()
            for method, baked in self._bakes(setting, seed, group, Path(folder)):
                pictures, views = self._compared(baked)
                ended = perf_counter()
                key = Key(setting.texels, setting.samples, self.stage.name, method, seed)
                yield Cell(key, baked.bytes, baked.paths, baked.seconds, ended - started, views)
                if seed in {SEEDS[0], 0} and setting in {MAIN, NOTHING}:
                    keep(self.stage.name, method, pictures)
                started = ended
        if group is Group.UNBAKED:
            yield self._noise()

    def _bakes(self, setting: Setting, seed: int, group: Group, folder: Path) -> Iterator[tuple[str, Baked]]:
        texels, samples = setting.texels or MAIN.texels, setting.samples or MAIN.samples
        if group is Group.UNBAKED:
            yield "eevee", Eevee(BakeSpec(texels=texels, seed=seed)).bake(self.stage, folder)
        elif group is Group.LAYERED:
            spec = BakeSpec(layout=Layout.LAYERED, texels=texels, samples=samples, seed=seed)
            started = perf_counter()
            staged = capture_staged(self.stage, spec, folder, self._unwraps)
            atlas = finished(fit_layered(staged.captured.capture))
            baked = baked_of(atlas, staged, perf_counter() - started)
            yield "layered", replace(baked, bytes=baked.bytes + material_bytes(atlas))
        elif group is Group.CAPTURE:
            spec = BakeSpec(texels=texels, samples=samples, seed=seed)
            captured = capture_stage(self.stage, spec, folder, inputs=True, unwraps=self._unwraps)
            yield "probe", probe.of_capture(captured)
            yield "sg", sg.of_capture(captured)
            yield "sh3", sh.of_capture(captured, bands=3)
            yield "sh", sh.of_capture(captured, bands=2)
            yield "lightmap", lightmap.of_capture(captured)
        else:
            denoise = group is Group.DENOISED
            spec = BakeSpec(texels=texels, bucket=8, samples=samples, seed=seed, denoise=denoise)
            made = bake_buckets(self.stage, spec, folder)
            if denoise:
                yield "buckets denoised", made.looked_up(Filter.QUADRILINEAR)
            else:
                yield "buckets", made.looked_up(Filter.QUADRILINEAR)
                yield "buckets nearest", made.looked_up(Filter.NEAREST)

    def _compared(self, baked: Baked) -> tuple[list[Picture], dict[str, dict[str, float]]]:
        surface, buffers = self._seen(baked)
        pictures, figures = [], {}
        for view, buffer in zip(self.views, buffers, strict=True):
            light = seen_light(baked, surface, view.rays, view.blocked, buffer, view.behind)
            picture = buffer.resolve(light)
            pictures.append(np.where(buffer.inside[..., None], picture, 0))
            figures[view.name] = _figures(picture, view, buffer)
        return pictures, figures

    def _seen(self, baked: Baked) -> tuple[BakedSurface, list[GBuffer]]:
        """Where the views' rays meet a bake's mesh; kept by the mesh's places and texture coordinates."""
        key = _digest(baked)
        if key not in self._buffers:
            surface = BakedSurface(baked.mesh, baked.matrix_world, baked.uv_layer)
            buffers = [surface.gbuffer(view.rays, view.blocked) for view in self.views]
            self._buffers[key] = surface, buffers
        return self._buffers[key]

    def _noise(self) -> Cell:
        """The first view's reference of another seed, against the reference; inside any mesh's mask."""
        started = perf_counter()
        _, buffers = next(iter(self._buffers.values()))
        again = picture_inside(self.stage, cameras_of(self.stage)[0], REFERENCE_SAMPLES, _OTHER_SEED)
        view = self.views[0]
        key = Key(NOTHING.texels, NOTHING.samples, self.stage.name, "reference again", 0)
        figures = {view.name: _figures(again, view, buffers[0])}
        return Cell(key, 0, 0, 0.0, perf_counter() - started, figures)


def _figures(picture: Picture, view: View, buffer: GBuffer) -> dict[str, float]:
    found = compare(picture, view.reference, buffer.inside, buffer.eroded)
    named = {"psnr": found.psnr, "flip": found.flip, "energy": found.energy}
    return {name: round(value, 5) for name, value in named.items() if value is not None}


def _digest(baked: Baked) -> str:
    mesh: Any = baked.mesh
    facts = hashlib.sha256(baked.uv_layer.encode())
    for items, field, width in (
        (mesh.vertices, "co", 3),
        (mesh.attributes[baked.uv_layer].data, "vector", 2),
    ):
        values = np.empty(len(items) * width, dtype=np.float32)
        items.foreach_get(field, values)
        facts.update(values.tobytes())
    return facts.hexdigest()


def open_scene(name: str) -> OpenScene:
    """Build a scene of a name in the open file, which is emptied."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return OpenScene(name)
