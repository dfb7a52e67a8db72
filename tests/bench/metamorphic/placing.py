# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a scene stands, how large it is and by which hand it is made changes no light."""

from __future__ import annotations

from math import pi
from typing import Any

import bpy
import numpy as np
from mathutils import Euler, Matrix

from tests.bench.metamorphic.scenes import transform_scene
from tests.bench.metamorphic.trial import Outcome, Relation, Trial, same_bits, same_light


def turned(trial: Trial) -> Outcome:
    """Light does not know the axes: the atlas is in the surface's own frame."""
    return _moved(trial, Euler(trial.rng.uniform(-pi, pi, 3).tolist()).to_matrix().to_4x4())


def shifted(trial: Trial) -> Outcome:
    """Nor where the origin is."""
    return _moved(trial, Matrix.Translation(trial.rng.uniform(-50, 50, 3).tolist()))


def scaled(trial: Trial) -> Outcome:
    """Radiance has no unit of length: lamps of so much more power light a larger scene alike."""
    return _moved(trial, Matrix.Scale(10 ** trial.rng.uniform(-3, 4), 4))


def mirrored(trial: Trial) -> Outcome:
    """A mirror image has mirrored frames, in which the same light comes from the same side."""
    return _moved(trial, Matrix.Scale(-1, 4, (1, 0, 0)))


def far_away(trial: Trial) -> Outcome:
    """Ten thousand units off, rays of a scene of twenty units start 0.5 from the surface: nearly the same."""
    way = np.array(trial.rng.normal(size=3))
    matrix = Matrix.Translation((1e4 * way / np.linalg.norm(way)).tolist()) @ Matrix.Scale(10, 4)
    return _moved(trial, matrix, rounding=0.1)


def _moved(trial: Trial, matrix: Matrix, rounding: float = 5e-3) -> Outcome:
    noisy = trial.noisy()
    transform_scene(matrix)
    return same_light(noisy, trial.bake(seed=3), rounding)


def transform_applied(trial: Trial) -> Outcome:
    """The object's matrix or the mesh's places: the same surface. A mirroring one turns the faces around.

    Faces are flat: smooth normals are means, which uneven scales do not keep.
    """
    body = _flat(trial.body)
    body.scale = trial.rng.choice([-1, 1], 3) * trial.rng.uniform(0.5, 1.3, 3)
    bpy.context.view_layer.update()
    noisy = trial.noisy()
    _apply(body, body.matrix_world.copy())
    return same_light(noisy, trial.bake(seed=3))


def sheared_by_parent(trial: Trial) -> Outcome:
    """A parent that is scaled unevenly shears a turned child: no place, turn and scale say that."""
    parent: Any = bpy.data.objects.new("Parent", None)
    trial.scene.collection.objects.link(parent)
    parent.scale = trial.rng.choice([-1, 1], 3) * trial.rng.uniform(0.4, 1.5, 3)
    parent.rotation_euler = trial.rng.uniform(-1, 1, 3)
    _flat(trial.body).parent = parent
    bpy.context.view_layer.update()
    noisy = trial.noisy()
    sheared = trial.body.matrix_world.copy()
    trial.body.parent = None
    _apply(trial.body, sheared)
    return same_light(noisy, trial.bake(seed=3))


def _flat(body: Any) -> Any:
    body.data.polygons.foreach_set("use_smooth", [False] * len(body.data.polygons))
    return body


def _apply(body: Any, matrix: Matrix) -> None:
    """Move an object's matrix into its mesh."""
    body.data.transform(matrix)
    if matrix.to_3x3().determinant() < 0:
        body.data.flip_normals()
    body.data.update()
    body.matrix_basis = Matrix.Identity(4)
    bpy.context.view_layer.update()


def unit_system(trial: Trial) -> Outcome:
    """Units are how Blender writes lengths, not what they are."""
    first = trial.bake()
    units = trial.scene.unit_settings
    units.system, units.scale_length = "IMPERIAL", 10 ** float(trial.rng.uniform(-3, 3))
    return same_bits(first, trial.bake())


def camera(trial: Trial) -> Outcome:
    """Buckets are seen by no camera of the scene's, wherever it is and whatever its lens does."""
    first = trial.bake()
    lens: Any = bpy.data.cameras.new("Camera")
    item = bpy.data.objects.new("Camera", lens)
    trial.scene.collection.objects.link(item)
    trial.scene.camera = item
    item.location = trial.rng.uniform(-3, 3, 3).tolist()
    lens.type = ("PERSP", "ORTHO", "PANO")[int(trial.rng.integers(3))]
    lens.dof.use_dof, lens.dof.aperture_fstop = True, 0.1
    lens.clip_start, lens.clip_end, lens.shift_x = 0.5, 1.0, 0.3
    trial.scene.render.use_motion_blur = True
    return same_bits(first, trial.bake())


def doubled(trial: Trial) -> Outcome:
    """Light adds up: twice the power of all that shines is twice the light."""
    noisy = trial.noisy()
    lamps: Any = bpy.data.lights
    for lamp in lamps:
        lamp.energy *= 2
    for tree in (each.node_tree for each in (*bpy.data.materials, *bpy.data.worlds)):
        for node in tree.nodes if tree else ():
            if node.type in {"EMISSION", "BACKGROUND"}:
                node.inputs["Strength"].default_value *= 2
    return same_light(noisy, trial.bake(seed=3) / 2)


RELATIONS: dict[str, Relation] = {
    "the scene turned": turned,
    "the scene shifted": shifted,
    "the scene scaled": scaled,
    "the scene mirrored": mirrored,
    "the scene far away": far_away,
    "transform applied": transform_applied,
    "sheared by a parent": sheared_by_parent,
    "unit system": unit_system,
    "camera": camera,
    "all light doubled": doubled,
}
