# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""However a surface came to be, it is the same surface: modifiers, instances, triangles, slots."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from radtex_addon.settings.spec import BakeSpec
from tests.bench.metamorphic.scenes import BODY
from tests.bench.metamorphic.trial import Outcome, Relation, Trial, nearly, same_bits, same_light
from tests.blender.casting import plan_of_bake


def modifiers_applied(trial: Trial) -> Outcome:
    """Modifiers are evaluated as renders do: applied at render levels they give the same triangles."""
    body = trial.body
    simple = body.modifiers.new("Subdivision", "SUBSURF")
    simple.levels, simple.render_levels = 0, 1
    simple.subdivision_type = ("SIMPLE", "CATMULL_CLARK")[int(trial.rng.integers(2))]
    bend = body.modifiers.new("Twist", "SIMPLE_DEFORM")
    bend.deform_method, bend.angle = "TWIST", float(trial.rng.uniform(0.1, 0.6))
    first = trial.bake()
    simple.levels = 1
    graph = bpy.context.evaluated_depsgraph_get()
    mesh = bpy.data.meshes.new_from_object(body.evaluated_get(graph), depsgraph=graph)
    body.modifiers.clear()
    body.data = mesh
    return nearly(first, trial.bake())


def triangulated(trial: Trial) -> Outcome:
    """A flat face of four corners is rendered as two triangles, along the diagonal that Blender says."""
    body = trial.body
    body.data.polygons.foreach_set("use_smooth", [False] * len(body.data.polygons))
    first = trial.bake()
    body.data = _in_triangles(body.data)
    return nearly(first, trial.bake())


def _in_triangles(mesh: Any) -> Any:
    mesh.calc_loop_triangles()
    made: Any = bpy.data.meshes.new(mesh.name)
    triangles = [tuple(each.vertices) for each in mesh.loop_triangles]
    made.from_pydata([vertex.co for vertex in mesh.vertices], [], triangles)
    layer = made.uv_layers.new(name="UVMap")
    for face, each in zip(made.polygons, mesh.loop_triangles, strict=True):
        for corner, loop in zip(face.loop_indices, each.loops, strict=True):
            layer.uv[corner].vector = mesh.uv_layers["UVMap"].uv[loop].vector
    for material in mesh.materials:
        made.materials.append(material)
    made.polygons.foreach_set("use_smooth", [False] * len(made.polygons))
    return made


def subdivided(trial: Trial) -> Outcome:
    """Cutting triangles into coplanar ones moves no point, and flat faces keep their normals."""
    trial.body.data = _in_triangles(trial.body.data)
    noisy = trial.noisy()
    for item in trial.scene.objects:
        if item.type == "MESH":
            cut = item.modifiers.new("Cut", "SUBSURF")
            cut.subdivision_type, cut.levels, cut.render_levels = "SIMPLE", 2, 2
    return same_light(noisy, trial.bake(seed=3))


def shape_key(trial: Trial) -> Outcome:
    """A shape key half in is the mesh half way."""
    body, share = trial.body, float(trial.rng.uniform(0, 1))
    body.shape_key_add(name="Basis")
    key: Any = body.shape_key_add(name="Moved")
    start = np.array([vertex.co for vertex in body.data.vertices])
    moved = start + trial.rng.uniform(-0.2, 0.2, start.shape)
    key.data.foreach_set("co", moved.ravel())
    key.value = share
    first = trial.bake()
    body.shape_key_clear()
    body.data.vertices.foreach_set("co", (start + share * (moved - start)).ravel())
    body.data.update()
    return nearly(first, trial.bake(), 2e-3)


def instanced(trial: Trial) -> Outcome:
    """An instance of a collection is as good as its objects."""
    blocks = [item for item in trial.scene.objects if item.name.startswith("Block")]
    first = trial.bake()
    inner = bpy.data.collections.new("Inner")
    for item in blocks:
        trial.scene.collection.objects.unlink(item)
        inner.objects.link(item)
    empty: Any = bpy.data.objects.new("Instance", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", inner
    trial.scene.collection.objects.link(empty)
    return nearly(first, trial.bake(), 1e-2)


def equal_materials(trial: Trial) -> Outcome:
    """Two equal materials shade as one does."""
    body = trial.body
    first = trial.bake()
    body.data.materials.append(body.data.materials[0].copy())
    index = trial.rng.integers(0, 2, len(body.data.polygons))
    body.data.polygons.foreach_set("material_index", index.astype(np.int32))
    return nearly(first, trial.bake(), 1e-3)


def object_slot(trial: Trial) -> Outcome:
    """A slot may belong to the object or to the mesh."""
    body = trial.body
    first = trial.bake()
    material = body.data.materials[0]
    body.data.materials[0] = None
    body.material_slots[0].link = "OBJECT"
    body.material_slots[0].material = material
    return same_bits(first, trial.bake())


def unseen(trial: Trial) -> Outcome:
    """What no ray can meet casts nothing."""
    noisy = trial.noisy()
    twin = trial.body.copy()
    twin.name, twin.location = "Unseen", (0.3, 0.2, 0.1)
    trial.scene.collection.objects.link(twin)
    for ray in ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow"):
        setattr(twin, f"visible_{ray}", False)
    return same_light(noisy, trial.bake(seed=3))


def unwrapped(trial: Trial) -> Outcome:
    """Another unwrap shows the same body: the mean light of all its texels is the same, if they are alike."""
    body = trial.body
    body.data.materials[0] = next(m for m in bpy.data.materials if m.name.startswith("floor"))
    size = 24
    own, other = (_mean(trial, uv_layer=layer, texels=size, samples=4) for layer in ("UVMap", None))
    return Outcome(abs(own - other) / own, 0.15)


def _mean(trial: Trial, **wishes: Any) -> float:
    """Light of a body, the mean of its texels."""
    buckets = trial.bake(padding=1, **wishes)
    plan = plan_of_bake(BODY, BakeSpec(bucket=4, padding=1, **wishes))
    covered = np.zeros(buckets.shape[:2], dtype=bool)
    covered.ravel()[plan.texel] = True
    return float(buckets[covered][..., :3].mean())


RELATIONS: dict[str, Relation] = {
    "modifiers applied": modifiers_applied,
    "triangulated": triangulated,
    "flat faces subdivided": subdivided,
    "shape key": shape_key,
    "instanced": instanced,
    "two equal materials": equal_materials,
    "slot of the object": object_slot,
    "an unseen object": unseen,
    "unwrapped anew": unwrapped,
}
