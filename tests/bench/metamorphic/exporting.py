# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What leaves RadTex says of the bake what the bake is: the mesh, the texels, the light looked up."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Quaternion

from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.core.sampler import Filter
from radtex_addon.export.export_manifest import read_manifest
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.gltf import extension_in
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.job import bake_object
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.bench.metamorphic.scenes import BODY
from tests.bench.metamorphic.trial import SPEC, Outcome, Relation, Trial

_FROM_GLTF = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))


def gltf_mesh(trial: Trial) -> Outcome:
    """The exported mesh stands where the object renders, mirrored and sheared by parents as it may be."""
    _put_below_parent(trial)
    places = _world_places(trial.body)
    with tempfile.TemporaryDirectory() as folder:
        glb = _exported(trial, Path(folder))
        found = _gltf_places(glb)
    size = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
    gaps = np.linalg.norm(found[:, None] - places[None], axis=2)
    worst = max(float(gaps.min(axis=1).max()), float(gaps.min(axis=0).max()))
    return Outcome(worst / size, 1e-5)


def manifest_facts(trial: Trial) -> Outcome:
    """Sidecar and manifest state sizes, samples and seed of the files that lie beside them."""
    with tempfile.TemporaryDirectory() as folder:
        glb = _exported(trial, Path(folder))
        facts = read_manifest(Path(folder) / "export" / f"{BODY}.export.json")
        sidecar = read_sidecar(Path(folder) / f"{BODY}.radiance.json")
        pixels, header = read_atlas(Path(folder) / f"{BODY}.radiance.exr")
        stated = extension_in(glb.document["materials"][0])["bake"]
        wrong = [
            header != sidecar,
            pixels.shape[:2] != (sidecar.height * sidecar.bucket, sidecar.width * sidecar.bucket),
            (sidecar.samples, sidecar.bucket) != (SPEC.samples, SPEC.bucket),
            stated != facts.bake,
            not all((Path(folder) / "export" / each.file).is_file() for each in facts.textures.values()),
        ]
    return Outcome(float(sum(wrong)), 0)


def _put_below_parent(trial: Trial) -> None:
    parent: Any = bpy.data.objects.new("Parent", None)
    trial.scene.collection.objects.link(parent)
    parent.scale = trial.rng.choice([-1, 1], 3) * trial.rng.uniform(0.4, 1.5, 3)
    parent.rotation_euler = trial.rng.uniform(-1, 1, 3)
    parent.location = trial.rng.uniform(-1, 1, 3)
    trial.body.parent = parent
    bpy.context.view_layer.update()


def _exported(trial: Trial, folder: Path) -> Glb:
    bake_object(trial.scene, BODY, replace(SPEC, half=True), folder, preview=Filter.NEAREST)
    made = finished(
        export_steps(folder / f"{BODY}.radiance.json", ExportSpec(Target.GLTF), folder / "export")
    )
    return Glb.read(made.folder / f"{made.name}.glb")


def _world_places(item: Any) -> Floats:
    places: Floats = np.array([item.matrix_world @ vertex.co for vertex in item.data.vertices])
    return places


def _gltf_places(glb: Glb) -> Floats:
    """World places (V, 3) of the one mesh, in Blender's axes."""
    (node,) = glb.document["nodes"]
    if "matrix" in node:
        matrix = Matrix(np.array(node["matrix"]).reshape(4, 4).T.tolist())
    else:
        x, y, z, w = node.get("rotation", (0, 0, 0, 1))
        place, size = node.get("translation", (0, 0, 0)), node.get("scale", (1, 1, 1))
        matrix = Matrix.LocRotScale(place, Quaternion((w, x, y, z)), size)
    (primitive,) = glb.document["meshes"][0]["primitives"]
    world = np.array(_FROM_GLTF @ matrix)
    local = glb.accessor(primitive["attributes"]["POSITION"]).astype(np.float64)
    places: Floats = local @ world[:3, :3].T + world[:3, 3]
    return places


RELATIONS: dict[str, Relation] = {
    "glTF's mesh": gltf_mesh,
    "facts and files": manifest_facts,
}
