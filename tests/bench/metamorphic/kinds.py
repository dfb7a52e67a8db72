# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of one scene that must agree: parts and the whole, a mirror and what it mirrors, two captures."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, CaptureMethod, Kind, Layer, Split
from tests.bench.metamorphic.scenes import BODY
from tests.bench.metamorphic.trial import SPEC, Outcome, Relation, Trial, nearly, same_bits, same_light
from tests.blender import stage
from tests.blender.casting import plan_of_bake


def dark(trial: Trial) -> Outcome:
    """Without light there is none."""
    lamps: Any = bpy.data.lights
    for lamp in lamps:
        lamp.energy = 0
    for material in bpy.data.materials:
        for node in material.node_tree.nodes:
            if node.type == "EMISSION":
                node.inputs["Strength"].default_value = 0
    trial.scene.world = None
    found = trial.bake()[..., :3]
    return same_bits(found, np.zeros_like(found))


def lights_add_up(trial: Trial) -> Outcome:
    """What each lamp and the world bring alone is together what they bring together."""
    noisy = trial.noisy()
    names = [item.name for item in trial.scene.objects if item.type == "LIGHT"]
    total = sum(trial.bake(seed=3, lights=(name,))[..., :3] for name in (*names, "world"))
    alone = np.concatenate([total, noisy[0][..., 3:]], axis=-1)
    return same_light(noisy, alone, rounding=2e-2)  # sums of noisy parts are tone mapped otherwise


def reflection_is_incident(trial: Trial) -> Outcome:
    """A mirror shows in a direction what comes from the mirrored one: the bucket, turned by half."""
    noisy = trial.noisy(kind=Kind.INCIDENT)
    mirrored = trial.bake(seed=3, kind=Kind.REFLECTION)[:, :, ::-1, ::-1]
    return same_light(noisy, mirrored)


def mirror(trial: Trial) -> Outcome:
    """A perfect mirror's radiance is the reflection."""
    body = trial.body
    white: dict[str, object] = {"Color": (1, 1, 1, 1), "Roughness": 0}
    body.data.materials[0] = stage.material("mirror", "ShaderNodeBsdfAnisotropic", **white)
    body.data.polygons.foreach_set("use_smooth", [False] * len(body.data.polygons))
    noisy = trial.noisy(kind=Kind.REFLECTION)
    return same_light(noisy, trial.bake(seed=3), rounding=5e-2)  # grazing rays are lifted off the facet


def two_captures(trial: Trial) -> Outcome:
    """The portal and the paper's camera see the same light arrive."""
    wishes: dict[str, Any] = {"kind": Kind.INCIDENT, "texels": 8, "samples": 64}
    noisy = trial.noisy(**wishes)
    other = trial.bake(seed=3, capture=CaptureMethod.PANORAMIC, **wishes)
    return same_light(noisy, other, rounding=5e-2)  # the panorama's disc is resampled, which evens noise out


def together(trial: Trial) -> Outcome:
    """Sharing an atlas with another object changes neither's light."""
    other = next(item for item in trial.scene.objects if item.name.startswith("Block"))
    for item, start in ((trial.body, 0.0), (other, 0.5)):
        layer = item.data.uv_layers["UVMap"].uv
        uv = np.empty(2 * len(layer), dtype=np.float32)
        layer.foreach_get("vector", uv)
        layer.foreach_set("vector", (uv.reshape(-1, 2) * (0.5, 1) + (start, 0)).astype(np.float32).ravel())
    half = SPEC.texels // 2 - 1  # of the columns; the one between belongs to whichever is nearer
    alone = [pixels[:, :half] for pixels in trial.noisy()]
    shared = trial.bake("Both", seed=3, objects=(BODY, other.name))
    return same_light((alone[0], alone[1]), shared[:, :half], rounding=2e-2)


def split(trial: Trial) -> Outcome:
    """The parts of a split object have the light that the whole has there."""
    body = trial.body
    body.data.materials.append(body.data.materials[0].copy())
    body.data.materials[1].name = "second"
    index = trial.rng.integers(0, 2, len(body.data.polygons)).astype(np.int32)
    index[:2] = 0, 1
    body.data.polygons.foreach_set("material_index", index)
    noisy = trial.noisy()
    whole = _covered(trial, SPEC)
    joined = np.zeros_like(noisy[0])
    for name in (material.name for material in body.data.materials):
        part = replace(SPEC, split=Split.MATERIAL, part=name)
        here = _covered(trial, part)
        joined[here] = trial.bake(seed=3, split=Split.MATERIAL, part=name)[here]
    both = np.where(whole[:, :, None, None, None], joined, noisy[0])
    return same_light(noisy, both, rounding=3e-2)  # texels on seams belong to either part


def _covered(trial: Trial, spec: BakeSpec) -> Any:
    plan = plan_of_bake(BODY, spec)
    covered = np.zeros((plan.layout.height, plan.layout.width), dtype=bool)
    covered.ravel()[plan.texel] = True
    return covered


def from_its_twin(trial: Trial) -> Outcome:
    """Baked from a copy that stands where it stands, an object shows itself."""
    noisy = trial.noisy()
    twin = trial.body.copy()
    twin.data = trial.body.data.copy()
    twin.name = "Twin"
    trial.scene.collection.objects.link(twin)
    return same_light(noisy, trial.bake(seed=3, source="Twin"), rounding=1e-2)


def accumulated(trial: Trial) -> Outcome:
    """Samples that are folded in later are those of a longer bake."""
    noisy = trial.noisy(samples=16)
    with tempfile.TemporaryDirectory() as folder:
        spec = replace(SPEC, seed=3)
        bake_object(trial.scene, BODY, spec, Path(folder))
        result = bake_object(trial.scene, BODY, replace(spec, accumulate=True), Path(folder))
        return same_light(noisy, _read(result))


def refreshed(trial: Trial) -> Outcome:
    """Where nothing has changed, a refresh changes nothing; where the light has, it is a new bake."""
    block = next(item for item in trial.scene.objects if item.name.startswith("Block"))
    with tempfile.TemporaryDirectory() as folder:
        spec = replace(SPEC, seed=3)
        bake_object(trial.scene, BODY, spec, Path(folder))
        block.location.z += 0.5
        result = bake_object(trial.scene, BODY, replace(spec, refresh=True), Path(folder))
        return same_light(trial.noisy(), _read(result), rounding=2e-2)


def _read(result: Any) -> Floats:
    pixels, _ = read_atlas(result.files.atlas)
    buckets: Floats = result.layout.to_buckets(pixels.astype(np.float32)).copy()
    return buckets


def layers(trial: Trial) -> Outcome:
    """To ask for layers beside the whole leaves the whole what it is."""
    return nearly(trial.bake(), trial.bake(layers=tuple(Layer)), 1e-5)


RELATIONS: dict[str, Relation] = {
    "no light": dark,
    "lights add up": lights_add_up,
    "reflection and incident": reflection_is_incident,
    "a mirror": mirror,
    "portal and panorama": two_captures,
    "together and alone": together,
    "parts and the whole": split,
    "from its twin": from_its_twin,
    "accumulated": accumulated,
    "refreshed": refreshed,
    "layers beside": layers,
}
