# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that are baked as if they stood alone."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.job import bake_object
from radtex_addon.job.changed_bakes import BakeState, Changes, changes
from radtex_addon.settings.spec import BakeSpec, Kind
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.test_job import pixels_of

pytestmark = pytest.mark.usefixtures("empty_file")
context: Any = bpy.context  # to the stubs, every pointer may be None

SPEC = BakeSpec(texels=4, bucket=2, samples=1, uv_layer="UVMap", alone=True)
UNCHANGED = Changes(BakeState.UNCHANGED)
SEEN = Changes(BakeState.CHANGED, ("surroundings",))


def plane(name: str, height: float, shader: str, **inputs: Any) -> Any:
    bpy.ops.mesh.primitive_plane_add(size=2, location=(0, 0, height))
    context.object.name = name
    context.object.data.materials.append(stage.material(name, shader, **inputs))
    return context.object


def room() -> None:
    """A floor below a glowing panel, and another that a collection's instance shows; a lamp, a world."""
    stage.world((0.3, 0.2, 0.1))
    plane("Floor", 0, "ShaderNodeBsdfDiffuse")
    panel = plane("Panel", 0.5, "ShaderNodeEmission", Color=(1, 0, 0, 1))
    parts, lamps = bpy.data.collections.new("Parts"), bpy.data.collections.new("Lamps")
    parts.objects.link(panel)
    bpy.ops.object.collection_instance_add(collection="Parts", location=(1, 0, 0))
    context.scene.collection.children.link(lamps)
    bpy.ops.object.light_add(type="POINT", location=(3, 0, 3))
    context.object.name = "Lamp"
    lamps.objects.link(context.object)
    context.scene.collection.objects.unlink(context.object)


def floor(out: Path, spec: BakeSpec = SPEC) -> Any:
    return pixels_of(bake_object(context.scene, "Floor", spec, out, overwrite=True))


def taken_away() -> None:
    for item in list(bpy.data.objects):
        if item.name not in ("Floor", "Lamp"):
            bpy.data.objects.remove(item)


@pytest.mark.parametrize("lights", [(), ("Lamps",)], ids=["all light", "a collection of lamps"])
def test_it_is_as_if_the_others_were_not_there(lights: tuple[str, ...], out: Path) -> None:
    room()
    spec = replace(SPEC, lights=lights)
    among = floor(out / "among", replace(spec, alone=False))
    before = fingerprint()
    alone = floor(out, spec)
    assert differences(before, fingerprint()) == {}
    taken_away()
    np.testing.assert_array_equal(alone, floor(out / "away", replace(spec, alone=False)))
    assert np.abs(alone - among).max() > 0.5 * alone[..., :3].max()


@pytest.mark.one_blender
def test_neighbours_change_nothing_and_lamps_do(out: Path) -> None:
    room()
    floor(out)
    assert json.loads((out / "Floor.radiance.json").read_text())["alone"] is True
    bpy.data.objects["Panel"].location.z = 1
    assert changes(context.scene, "Floor", SPEC, out) == UNCHANGED
    assert "settings" in changes(context.scene, "Floor", replace(SPEC, alone=False), out).parts
    bpy.data.objects["Lamp"].location.z = 4
    assert changes(context.scene, "Floor", SPEC, out) == SEEN
    with pytest.raises(InputError, match="was baked alone"):
        bake_object(context.scene, "Floor", replace(SPEC, alone=False, accumulate=True), out)


def test_a_hull_shows_other_objects() -> None:
    with pytest.raises(InputError, match="proxy shows other objects: leave the choice to bake it alone out"):
        BakeSpec(kind=Kind.PROXY, alone=True)
