# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports and comparisons of bakes that show another frame, some lamps, or another object's light."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake import progress
from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object
from radtex_addon.preview.swap import switch_off, switch_on
from radtex_addon.report.finished_bake import find_bake, read_bake
from radtex_addon.report.report_bake import ReportResult, ReportSpec, report_path, report_steps
from radtex_addon.report.side_by_side import Comparison, ComparisonSpec, compare_steps
from radtex_addon.report.viewpoint import Viewpoint
from radtex_addon.settings.spec import BakeSpec, Kind, Unwrap
from tests.blender import stage
from tests.blender.batch_process import Batch
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.test_frames import SPEC as FRAME
from tests.blender.test_frames import growing_ball
from tests.blender.test_lamps import floor
from tests.blender.test_source import SPEC as SOURCED
from tests.blender.test_source import balls, cage_around

pytestmark = [pytest.mark.usefixtures("temporary"), pytest.mark.one_blender]
context: Any = bpy.context  # to the stubs, every pointer may be None

LIT = BakeSpec(texels=16, bucket=4, samples=16)
QUICK = ReportSpec(views=1, pixels=48, samples=16)
ALIKE = 30  # decibels


def report(sidecar: Path, spec: ReportSpec = QUICK) -> ReportResult:
    before = fingerprint()
    found = progress.finished(report_steps(context.scene, sidecar, spec, report_path(sidecar)))
    assert differences(before, fingerprint()) == {}
    return found


def compare(bakes: dict[str, Path | None], place: tuple[float, float, float] = (0, 0, 5)) -> Comparison:
    """From a camera that looks down from that place."""
    camera = bpy.data.objects.new("Viewpoint", bpy.data.cameras.new("Viewpoint"))
    context.scene.collection.objects.link(camera)
    context.scene.camera, camera.location = camera, place
    context.view_layer.update()
    eye = Viewpoint.of_camera(context.scene, context.view_layer)
    named = {bpy.data.objects[name]: sidecar for name, sidecar in bakes.items()}
    return progress.finished(compare_steps(context.scene, named, eye, ComparisonSpec(32, 8)))


# frames


def test_a_frame_is_judged_as_the_scene_is_then(out: Path) -> None:
    growing_ball()
    made = bake_object(context.scene, "Ball", replace(FRAME, unwrap_at=None, samples=2), out).files
    found = report(made.sidecar, replace(QUICK, variants=True))
    print(f"\n{found.psnr:.1f} dB, energy {found.energy:.3f}")
    assert found.energy == pytest.approx(1, abs=0.02)
    assert found.page == out / "Ball-0005.report.html"
    assert "frame 5" in found.page.read_text(encoding="utf-8")
    assert context.scene.frame_current == 3
    assert set(found.lost) == {"samples", "bucket", "texels"}, "half of the settings, at that frame"
    assert max(map(abs, found.lost.values())) < 0.5


def test_a_frame_is_compared_with_the_scene_as_it_is_then(out: Path) -> None:
    growing_ball()
    made = bake_object(context.scene, "Ball", FRAME, out, preview=Filter.QUADRILINEAR).files
    found = compare({"Ball": made.sidecar}, (5, 0, 6))
    print(f"\n{found.figures.psnr:.1f} dB, energy {found.figures.energy:.3f}")
    assert found.figures.energy == pytest.approx(1, abs=0.02)
    assert context.scene.frame_current == 3
    switch_on(bpy.data.objects["Ball"], made.sidecar)
    shown = compare({"Ball": None}, (5, 0, 6))
    assert shown.figures.energy == pytest.approx(1, abs=0.02)
    assert context.scene.frame_current == 3


def test_bakes_of_different_frames_are_not_compared_at_once(out: Path) -> None:
    growing_ball()
    bpy.ops.mesh.primitive_cube_add()
    context.object.name = "Cube"
    ball = bake_object(context.scene, "Ball", FRAME, out, preview=Filter.QUADRILINEAR).files.sidecar
    other = replace(FRAME, frame=7)
    cube = bake_object(context.scene, "Cube", other, out, preview=Filter.QUADRILINEAR).files.sidecar
    with pytest.raises(InputError, match="'Ball' is baked at frame 5 and 'Cube' at frame 7: compare them"):
        compare({"Ball": ball, "Cube": cube})
    plain = replace(FRAME, frame=None, unwrap_at=None)
    plain_cube = bake_object(context.scene, "Cube", plain, out, preview=Filter.QUADRILINEAR).files.sidecar
    with pytest.raises(InputError, match="'Ball' is baked at frame 5 and 'Cube' at none of its own: compare"):
        compare({"Ball": ball, "Cube": plain_cube})


# lamps


@pytest.mark.parametrize("lights", [("Indoors", "Evening"), ("Noon", "world")])
def test_some_lamps_are_judged_with_those_alone_lit(lights: tuple[str, ...], out: Path) -> None:
    floor()
    sidecar = bake_object(context.scene, "Floor", replace(LIT, lights=lights), out).files.sidecar
    found = report(sidecar)
    print(f"\n{lights}: {found.psnr:.1f} dB, energy {found.energy:.3f}, floor {found.floor:.1f} dB")
    assert found.energy == pytest.approx(1, abs=0.05)
    assert found.page == out / f"Floor-{'+'.join(lights)}.report.html"
    assert f"light of {', '.join(lights)}" in found.page.read_text(encoding="utf-8")
    if "Noon" in lights:
        bpy.data.objects.remove(bpy.data.objects["Noon"])
        with pytest.raises(InputError, match="there is no lamp or collection 'Noon'"):
            report(sidecar)


def test_some_lamps_are_not_compared_with_all_light_whoever_shows_them(out: Path) -> None:
    floor()
    noon = replace(LIT, lights=("Noon",))
    sidecar = bake_object(context.scene, "Floor", noon, out, preview=Filter.QUADRILINEAR).files.sidecar
    assert find_bake(out, "Floor").path == sidecar
    with pytest.raises(InputError, match=r"Floor-Noon\.radiance\.json has the light of 'Noon' alone"):
        compare({"Floor": sidecar})
    switch_on(bpy.data.objects["Floor"], sidecar)
    with pytest.raises(InputError, match="the preview of 'Floor' has the light of 'Noon' alone"):
        compare({"Floor": None})
    switch_off(bpy.data.objects["Floor"])
    whole = bake_object(context.scene, "Floor", LIT, out, preview=Filter.QUADRILINEAR).files.sidecar
    assert find_bake(out, "Floor").path == whole
    switch_on(bpy.data.objects["Floor"], whole)
    assert compare({"Floor": None}).figures.energy == pytest.approx(1, abs=0.1)


def test_an_object_that_was_baked_alone_is_judged_alone_and_not_compared_with_the_scene(out: Path) -> None:
    floor()
    bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -0.5))
    context.object.data.materials.append(stage.material("glow", "ShaderNodeEmission", Strength=5))
    bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, 6))
    context.object.data.materials.append(stage.material("ceiling", "ShaderNodeEmission", Strength=2))
    alone = replace(LIT, alone=True)
    sidecar = bake_object(context.scene, "Floor", alone, out, preview=Filter.QUADRILINEAR).files.sidecar
    assert report(sidecar).energy == pytest.approx(1, abs=0.05)
    with pytest.raises(InputError, match=r"Floor\.radiance\.json was baked without the other objects"):
        compare({"Floor": sidecar})
    switch_on(bpy.data.objects["Floor"], sidecar)
    with pytest.raises(InputError, match="the preview of 'Floor' was baked without the other objects"):
        compare({"Floor": None})


def test_light_that_no_camera_sees_is_not_compared(out: Path) -> None:
    floor()
    for kind in (Kind.INCIDENT, Kind.SHADOW):
        spec = BakeSpec(kind=kind, texels=8, bucket=4, samples=1)
        made = bake_object(context.scene, "Floor", spec, out / kind, preview=Filter.QUADRILINEAR)
        sidecar = made.files.sidecar
        words = rf"Floor\.{kind}\.json holds {kind} light, which no camera sees"
        with pytest.raises(InputError, match=words):
            compare({"Floor": sidecar})
        switch_on(bpy.data.objects["Floor"], sidecar)
        with pytest.raises(InputError, match=f"the preview of 'Floor' holds {kind} light"):
            compare({"Floor": None})
        switch_off(bpy.data.objects["Floor"])


# another object's light


@pytest.mark.parametrize("caged", [False, True])
def test_a_bake_from_another_object_is_judged_by_what_that_one_shows(caged: bool, out: Path) -> None:
    balls()
    spec = SOURCED
    if caged:
        cage_around(lambda _: 0.3)
        spec = replace(spec, extrusion=None, cage="Cage")
    sidecar = bake_object(context.scene, "Low", spec, out).files.sidecar
    found = report(sidecar)
    print(f"\n{found.psnr:.1f} dB, energy {found.energy:.3f}")
    assert found.energy == pytest.approx(1, abs=0.05)
    assert found.psnr > 25
    assert "from High" in found.page.read_text(encoding="utf-8")
    again = read_bake(sidecar).spec("auto")
    assert (again.source, again.cage, again.extrusion) == ("High", spec.cage, spec.extrusion)
    for side in (-1, 1):  # a corridor: half the views are of its walls
        bpy.ops.mesh.primitive_cube_add(size=1, location=(side * 2, 0, 0), scale=(0.1, 30, 30))
    assert report(sidecar).energy == pytest.approx(1, abs=0.05)
    bpy.data.objects.remove(bpy.data.objects["High"])
    with pytest.raises(InputError, match="no object 'High' in scene"):
        report(sidecar)


def test_half_of_the_settings_is_baked_from_that_object_too(out: Path) -> None:
    balls()
    sidecar = bake_object(context.scene, "Low", SOURCED, out).files.sidecar
    found = report(sidecar, replace(QUICK, variants=True))
    print(f"\n{found.lost}")
    assert set(found.lost) == {"samples", "bucket", "texels"}
    assert max(map(abs, found.lost.values())) < 8, "the simple object's own light costs 20"


# scenes


def test_a_report_looks_at_the_scene_that_is_named(tmp_path: Path, batch: Batch) -> None:
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = "Card"
    context.object.data.materials.append(stage.material("White", "ShaderNodeBsdfDiffuse"))
    stage.world((0.25, 0.25, 0.25))
    night = context.scene
    day: Any = bpy.data.scenes.new("Day")
    day.collection.objects.link(bpy.data.objects["Card"])
    context.window.scene = day
    stage.world((1, 1, 1))
    context.window.scene = night
    blend, baked = tmp_path / "two.blend", tmp_path / "baked"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    bake_object(day, "Card", replace(LIT, unwrap=Unwrap.BLENDER), baked)
    quick = ("--views=1", "--pixels=32", "--samples=4", "--progress=json")
    told = batch("report", baked, "--scene", blend, "--in-scene", "Day", *quick)
    assert (told.code, told.err) == (0, "")
    assert '"energy": 1.0' in told.out or '"energy": 0.99' in told.out, told.out
    unknown = batch("report", baked, "--scene", blend, "--in-scene", "Noon", *quick)
    assert "there is no scene 'Noon' in the file" in unknown.err
