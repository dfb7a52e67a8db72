# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""High to low: a simple object wears what a detailed one shows, found along its normals."""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree

from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.bucket_files import size_of
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.formats.sidecar import Source, read_sidecar
from radtex_addon.job import bake_object, bake_steps
from radtex_addon.prepare.prepared import Prepared, prepare
from radtex_addon.preview.swap import copy_of, originals_rendered, switch_off, switch_on
from radtex_addon.report.side_by_side import Comparison, ComparisonSpec, compare_steps
from radtex_addon.report.viewpoint import Viewpoint
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, CaptureMethod, Kind, Unwrap
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

SPEC = BakeSpec(texels=32, bucket=4, samples=2, half=False, source="High", extrusion=0.3)
BUMP = 0.12  # the highest, of a ball of radius 1


def place_material() -> bpy.types.Material:
    """Glows as its place is coded: a colour is (x, y, z) / 4 + 1/2 in world space."""
    made = stage.material("Place", "ShaderNodeEmission", Strength=1)
    tree: Any = made.node_tree
    glow = next(node for node in tree.nodes if node.type == "EMISSION")
    code = tree.nodes.new("ShaderNodeVectorMath")
    code.operation = "MULTIPLY_ADD"
    code.inputs[1].default_value, code.inputs[2].default_value = (0.25,) * 3, (0.5,) * 3
    tree.links.new(tree.nodes.new("ShaderNodeNewGeometry").outputs["Position"], code.inputs[0])
    tree.links.new(code.outputs[0], glow.inputs["Color"])
    return made


def balls(bumps: float = BUMP) -> None:
    """A smooth ball "Low" of radius 1, and "High", one with bumps of that height which says where it is."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5, radius=1)
    high = context.object
    high.name = "High"
    for vertex in high.data.vertices:
        wave = np.sin(5 * vertex.co.x) * np.cos(4 * vertex.co.y) * np.sin(6 * vertex.co.z + 1)
        vertex.co *= 1 + bumps * float(wave)
    high.data.materials.append(place_material())
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=1)
    context.object.name = "Low"
    bpy.ops.object.shade_smooth()
    context.object.data.materials.append(
        stage.material("Red", "ShaderNodeEmission", Color=(9, 0, 0, 1), Strength=9)
    )


def bake(out: Path, spec: BakeSpec = SPEC, resume: bool = False) -> Floats:
    return read_buckets(bake_object(context.scene, "Low", spec, out, resume=resume).files.sidecar)[0]


def prepared_low(spec: BakeSpec) -> tuple[Prepared, list[bpy.types.ID]]:
    kept: list[bpy.types.ID] = []
    with scratch_scene(context.scene, None, kept) as scratch:
        return finished(prepare(scratch, [find_object(scratch, "Low")], spec, kept)), kept


def cells_of(image: Floats, bucket: int) -> Floats:
    """The buckets (H, W, n * n, C)."""
    height, width = image.shape[0] // bucket, image.shape[1] // bucket
    cells = image.reshape(height, bucket, width, bucket, -1).transpose(0, 2, 1, 3, 4)
    return cells.reshape(height, width, bucket**2, -1)


def test_texels_show_the_points_that_rays_find(out: Path) -> None:
    balls()
    before = fingerprint()
    made = bake_object(context.scene, "Low", SPEC, out)
    assert differences(before, fingerprint()) == {}
    image, facts = read_buckets(made.files.sidecar)
    assert (facts.object_name, facts.source) == ("Low", Source("High", 0.3, 0))
    assert size_of(facts, "")[0] == facts.width * SPEC.bucket
    radius = np.linalg.norm((cells_of(image, SPEC.bucket)[..., :3] - 0.5) * 4, axis=-1)
    assert radius.max() > 1 + BUMP / 2, "what stands out"
    assert radius.min() < 1 - BUMP / 2, "what lies below"
    plain, _ = prepared_low(replace(SPEC, source=None, extrusion=None))
    texels = plain.texels()
    high = bpy.data.objects["High"]
    tree: Any = BVHTree.FromObject(cast(Any, high), context.evaluated_depsgraph_get())
    cells = cells_of(image, SPEC.bucket)
    gaps = []
    for j, i in np.argwhere(texels.covered)[::7]:
        point, normal = (Vector(field[j, i].tolist()) for field in (texels.position, texels.normal))
        met = tree.ray_cast(point + 0.3 * normal, -normal)[0]
        gaps.append(np.abs((cells[j, i, :, :3] - 0.5) * 4 - np.array(met)).max())
    print(f"\nof {len(gaps)} texels the places that cells show are off by {max(gaps):.2g} at most")
    assert len(gaps) > 60
    assert max(gaps) < 2e-3


@pytest.mark.one_blender
def test_without_a_word_a_few_per_cent_of_the_size_are_searched(out: Path) -> None:
    balls(bumps=0.02)
    made = bake_object(context.scene, "Low", replace(SPEC, extrusion=None), out)
    facts = read_sidecar(made.files.sidecar)
    assert facts.source is not None
    assert facts.source.extrusion == pytest.approx(0.03 * np.sqrt(12), rel=0.01)
    assert facts.source.missed == 0


@pytest.mark.one_blender
def test_what_finds_nothing_is_counted_told_and_filled(out: Path, caplog: pytest.LogCaptureFixture) -> None:
    balls()
    bpy.ops.object.select_all(action="DESELECT")
    high = bpy.data.objects["High"]
    lower = [vertex for vertex in high.data.vertices if vertex.co.z < 0]
    for vertex in lower:
        vertex.co *= 0.2  # too deep to be found
    with caplog.at_level(logging.WARNING):
        made = bake_object(context.scene, "Low", SPEC, out)
    found = read_sidecar(made.files.sidecar).source
    assert found is not None
    share = found.missed / (found.missed + made.covered_texels)
    assert 0.3 < share < 0.6
    assert f"{100 * share:.2g} % of the texels of 'Low' do not reach 'High' within 0.3" in caplog.text
    assert "enlarge the extrusion" in caplog.text
    image, _ = read_buckets(made.files.sidecar)
    assert image[..., 3].min() == 1, "texels are left empty"
    radius = np.linalg.norm((cells_of(image, SPEC.bucket)[..., :3] - 0.5) * 4, axis=-1)
    assert radius.min() > 0.65, "what is filled shows nobody's place"


def cage_around(grow: Callable[[Vector], float], name: str = "Cage") -> Any:
    """A copy of "Low" whose vertices went out along their normals, by what `grow` says of their places."""
    cage: Any = bpy.data.objects["Low"].copy()
    cage.name, cage.data = name, cage.data.copy()
    context.scene.collection.objects.link(cage)
    away = [(vertex.co + grow(vertex.co) * vertex.normal).copy() for vertex in cage.data.vertices]
    for vertex, place in zip(cage.data.vertices, away, strict=True):
        vertex.co = place
    return cage


@pytest.mark.one_blender
def test_a_cage_that_is_an_extrusion_lands_where_that_does(out: Path) -> None:
    balls()
    cage = cage_around(lambda _: 0.3)
    caged = replace(SPEC, extrusion=None, cage="Cage")
    cage.hide_render = True
    bpy.data.objects["Low"].matrix_world = Matrix.Rotation(0.4, 4, "X") @ Matrix.Translation((0.1, 0, 0))
    cage.matrix_world = bpy.data.objects["Low"].matrix_world
    context.view_layer.update()
    caged, straight = (replace(each, unwrap=Unwrap.UVUNWRAP) for each in (caged, SPEC))
    (along, kept), (through, others) = prepared_low(straight), prepared_low(caged)
    assert along.source is not None
    assert through.source is not None
    assert along.source.missed == through.source.missed == 0
    gap = np.abs(along.source.texels.position - through.source.texels.position).max()
    print(f"\npoints are apart by {gap:.1e}")
    assert gap < 2e-4  # a point lies a hair inside its triangle, a normal is its own texel's
    assert through.source.extrusion == pytest.approx(0.3, rel=1e-3)
    del kept, others
    before = fingerprint()
    image, alike = bake(out / "cage", caged), bake(out, straight)
    assert differences(before, fingerprint()) == {}
    np.testing.assert_allclose(image, alike, atol=1e-4)
    facts = read_sidecar(out / "cage" / "Low.radiance.json")
    assert facts.source is not None
    assert (facts.source.cage, facts.source.missed) == ("Cage", 0)


@pytest.mark.one_blender
def test_a_cage_reaches_a_far_part_that_an_extrusion_for_the_near_ones_misses(out: Path) -> None:
    balls(bumps=0.02)
    for vertex in bpy.data.objects["High"].data.vertices:
        if vertex.co.z > 0.6:
            vertex.co *= 1.8  # a horn
    missed = {}
    cage_around(lambda place: 0.05 if place.z < 0.5 else 1.1)
    for spec in (replace(SPEC, extrusion=0.05), replace(SPEC, extrusion=None, cage="Cage")):
        made = bake_object(context.scene, "Low", spec, out / str(spec.cage))
        found = read_sidecar(made.files.sidecar).source
        assert found is not None
        missed[spec.cage] = found.missed
        place = (cells_of(read_buckets(made.files.sidecar)[0], SPEC.bucket)[..., :3] - 0.5) * 4
        highest = place[..., 2].max()
        assert (highest > 1.6) == (spec.cage is not None), highest
    assert missed[None] > 20
    assert missed["Cage"] == 0


@pytest.mark.one_blender
def test_a_cage_that_renders_casts_no_shadow(out: Path) -> None:
    balls(bumps=0)
    stage.world((0.5, 0.5, 0.5))
    high = bpy.data.objects["High"]
    high.data.materials[0] = stage.material("White", "ShaderNodeBsdfDiffuse", Color=(1, 1, 1, 1))
    spec = replace(SPEC, extrusion=None, cage="Cage", samples=4)
    cage = cage_around(lambda _: 0.3)
    assert not cage.hide_render
    image = bake(out, spec)
    np.testing.assert_allclose(image[..., :3].mean(), 0.5, rtol=0.02)


@pytest.mark.one_blender
def test_where_a_cage_touches_only_what_lies_there_is_found() -> None:
    balls(bumps=0)
    bpy.data.objects["High"].scale = (1.02, 1.02, 1.02)
    cage_around(lambda place: 0.1 if place.z > 0 else 0)
    kept = prepared_low(replace(SPEC, extrusion=None, cage="Cage"))[0].source
    assert kept is not None
    height = kept.texels.position[kept.texels.covered][:, 2]
    assert height.max() > 0.9
    assert height.min() > -0.1
    assert kept.missed > 100


@pytest.mark.one_blender
@pytest.mark.parametrize(
    ("cage", "words"),
    [
        ("Low", "object 'Low' cannot be the cage too"),
        ("High", "object 'High' cannot be the cage too"),
        ("Nobody", "cage 'Nobody' is not in scene"),
        ("Lamp", "cage 'Lamp' is no mesh of scene"),
        ("Cut", "cage 'Cut' has .* vertices and .* faces, 'Low' has .*: make it a copy of 'Low'"),
        ("Turned", "cage 'Turned' has other faces than 'Low', or in another order"),
        ("Broken", "cage 'Broken' has vertices whose coordinates are not finite"),
    ],
)
def test_a_cage_that_is_none_is_named(out: Path, cage: str, words: str) -> None:
    balls()
    bpy.ops.object.light_add()
    context.object.name = "Lamp"
    cage_around(lambda _: 0.3, "Cut").modifiers.new("Fewer", "DECIMATE").ratio = 0.5
    cage_around(lambda _: 0.3, "Turned").data.flip_normals()
    cage_around(lambda _: 0.3, "Broken").data.vertices[3].co.x = float("nan")
    with pytest.raises(InputError, match=words):
        bake(out, replace(SPEC, extrusion=None, cage=cage))
    assert not list(out.glob("*.exr"))


@pytest.mark.one_blender
def test_nothing_found_at_all_is_refused_and_the_old_atlas_stays(out: Path) -> None:
    balls()
    bake(out)
    before = {path: path.read_bytes() for path in out.iterdir()}
    bpy.data.objects["High"].location.x = 5
    with pytest.raises(InputError, match="object 'Low' does not reach 'High' within"):
        bake_object(context.scene, "Low", SPEC, out, overwrite=True)
    assert {path: path.read_bytes() for path in out.iterdir()} == before


@pytest.mark.one_blender
def test_moved_turned_and_mirrored_objects_meet_in_world_space(out: Path) -> None:
    balls()
    for name in ("High", "Low"):
        item = bpy.data.objects[name]
        item.scale, item.rotation_euler = (-1, 0.5, 1.2), (0.3, 0.2, 0.1) if name == "Low" else (0, 0, 0)
    high = bpy.data.objects["High"]
    high.parent = bpy.data.objects["Low"]
    high.scale = (1, 1, 1)
    context.view_layer.update()
    place = (cells_of(bake(out), SPEC.bucket)[..., :3] - 0.5) * 4
    inverse = np.array(high.matrix_world.inverted())
    local = place @ inverse[:3, :3].T + inverse[:3, 3]
    radius = np.linalg.norm(local, axis=-1)
    assert np.abs(radius - 1).max() < BUMP + 0.01, "a cell shows something beside the bumpy ball"
    assert radius.std() > 0.01


@pytest.mark.one_blender
def test_lamps_are_met_from_the_high_surface_and_the_low_one_casts_no_shadow(out: Path) -> None:
    balls(bumps=0.02)
    low = bpy.data.objects["Low"]
    low.scale = (1.1, 1.1, 1.1)  # all of High inside it
    bpy.ops.object.light_add(type="AREA", location=(0, 0, 3))
    context.object.data.size, context.object.data.energy = 2, 100
    light = bake(out, replace(SPEC, kind=Kind.INCIDENT, samples=4))
    assert light[..., 0].max() > 1, "the lamp is not seen"
    assert light[..., 0].max() == pytest.approx(light[..., 1].max()), "the low object's red is"
    bits = bake_object(context.scene, "Low", replace(SPEC, kind=Kind.AO, samples=16), out)
    ambient = read_buckets(bits.files.sidecar)[0][..., 3]
    assert ambient.mean() > 0.9, "the low object is in the way"


@pytest.mark.one_blender
@pytest.mark.parametrize("caged", [False, True])
def test_a_bake_goes_on_where_it_stopped_unless_the_source_has_changed(out: Path, caged: bool) -> None:
    balls()
    changing = bpy.data.objects["High"].data.vertices[0]
    spec = SPEC
    if caged:
        cage = cage_around(lambda _: 0.3)
        cage.hide_render = True
        changing, spec = cage.data.vertices[40], replace(SPEC, extrusion=None, cage="Cage")
    whole = bake(out / "whole", spec)
    for folder in (out, out / "other"):
        steps = bake_steps(context.scene, "Low", spec, folder)
        for step in steps:
            if step.stage == "fill":
                steps.close()
    np.testing.assert_array_equal(bake(out, spec, resume=True), whole)
    changing.co *= 0.95  # within the same bounds
    with pytest.raises(InputError, match=rf"differs in .*{'cage' if caged else 'source'}'s mesh"):
        bake_object(context.scene, "Low", spec, out / "other", resume=True)


def hidden(name: str) -> tuple[bool, bool]:
    item = bpy.data.objects[name]
    return item.hide_render, item.hide_viewport


def test_switched_on_in_the_scene_the_high_object_is_hidden_until_no_preview_shows_it(out: Path) -> None:
    balls()
    other = bpy.data.objects["Low"].copy()
    other.name = "Lower"
    context.scene.collection.objects.link(other)
    bpy.data.objects["High"].hide_viewport = True
    spec = replace(SPEC, texels=16, samples=1)
    sidecars = {}
    for name in ("Low", "Lower"):
        made = bake_object(context.scene, name, spec, out, preview=Filter.NEAREST)
        sidecars[name] = made.files.sidecar
    before = fingerprint()
    lows = [bpy.data.objects[name] for name in sidecars]
    for low in lows:
        switch_on(low, sidecars[low.name])
        assert hidden("High") == (True, True)
    switch_on(lows[0], sidecars["Low"])  # anew
    with originals_rendered(lows):
        assert (hidden("High"), hidden("Low"), hidden("Lower")) == ((False, True), (True, True), (True, True))
    switch_off(lows[0])
    assert hidden("High") == (True, True)
    copy = copy_of(lows[1])
    assert copy is not None
    bpy.data.objects.remove(copy)  # by hand
    switch_off(lows[1])
    assert hidden("High") == (False, True)
    changed = differences(before, fingerprint())  # the selection went with the copy that was removed
    assert {path for path in changed if "users" not in path and not path.endswith(".chosen")} == set()


def _result(steps: Generator[Any, None, Comparison]) -> Comparison:
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return cast(Comparison, end.value)


@pytest.mark.one_blender
def test_a_comparison_is_with_the_high_object_and_the_preview_without_it(out: Path) -> None:
    balls()
    made = bake_object(context.scene, "Low", SPEC, out, preview=Filter.QUADRILINEAR)
    bpy.ops.object.camera_add(location=(0, -5, 0), rotation=(np.pi / 2, 0, 0))
    context.scene.camera = context.object
    eye = Viewpoint.of_camera(context.scene, context.view_layer)
    spec = ComparisonSpec(pixels=64, samples=4, device="cpu")
    found = _result(compare_steps(context.scene, {bpy.data.objects["Low"]: made.files.sidecar}, eye, spec))
    print(f"\n{found.figures.psnr:.1f} dB")
    assert found.traced.max() < 2, "the low object is seen"
    assert found.figures.psnr > 30
    assert not bpy.data.objects["High"].hide_render
    bpy.ops.wm.open_mainfile(filepath=str(made.files.preview))
    assert "High" not in bpy.data.objects
    assert not bpy.data.objects["Low"].hide_render


@pytest.mark.one_blender
@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("Low", "object 'Low' is to be baked from itself"),
        ("Nobody", "no object 'Nobody' in scene"),
        ("Lamp", "object 'Lamp' is a light, not a mesh"),
        ("Hidden", "object 'Hidden' is hidden from render"),
    ],
)
def test_a_source_that_is_none_is_named(out: Path, source: str, words: str) -> None:
    balls()
    bpy.ops.object.light_add()
    context.object.name = "Lamp"
    bpy.ops.mesh.primitive_cube_add()
    context.object.name, context.object.hide_render = "Hidden", True
    with pytest.raises(InputError, match=words):
        bake(out, replace(SPEC, source=source))
    assert not out.exists()


@pytest.mark.one_blender
@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"source": ""}, "the name of the object to bake from is empty"),
        ({"extrusion": 0.0}, "extrusion 0: give a distance above 0"),
        ({"extrusion": float("nan")}, "extrusion nan: give a distance above 0"),
        ({"source": None}, "extrusion 0.3 is for what another object shows"),
        ({"source": None, "extrusion": None, "cage": "Cage"}, "cage Cage is for what another object shows"),
        ({"extrusion": None, "cage": ""}, "the cage's name is empty"),
        ({"cage": "Cage"}, "a cage and an extrusion contradict each other"),
        ({"kind": Kind.PROXY}, "proxy is not baked from another object"),
        ({"kind": Kind.TRANSFER}, "transfer is not baked from another object"),
        (
            {"kind": Kind.INCIDENT, "capture": CaptureMethod.PANORAMIC},
            "capture panoramic bakes from no other object",
        ),
    ],
)
def test_what_takes_no_source_is_refused(wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        replace(SPEC, **wrong)
