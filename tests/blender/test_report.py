# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports: objects whose light is known, views that are hidden, meshes that were changed."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake import progress
from radtex_addon.core.errors import FormatError, InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.sidecar_file import SidecarFile
from radtex_addon.job import bake_object
from radtex_addon.report.causes import Cause, HalvedBake, first_change
from radtex_addon.report.finished_bake import find_bake, read_bake
from radtex_addon.report.gbuffer import BakedSurface, CameraRays, eroded
from radtex_addon.report.report_bake import ReportResult, ReportSpec, report_path, report_steps
from radtex_addon.report.sizes import gpu_bytes, sizes_of
from radtex_addon.settings.spec import BakeSpec, Compression, Kind, Layout, Unwrap
from tests.blender import stage
from tests.blender.card_frame import give_frame
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.lived_in import lived_in_scene

pytestmark = pytest.mark.one_blender
context: Any = bpy.context  # to the stubs, every pointer may be None

TINY = BakeSpec(texels=24, bucket=2, samples=1)
QUICK = ReportSpec(views=2, pixels=48, samples=1)
GLOW = (0.5, 0.25, 0.125)
DENOISED = 42  # decibels: the denoiser darkens even surfaces by up to a hundredth


def ball(name: str = "Ball", place: tuple[float, float, float] = (0, 0, 0)) -> Any:
    """A ball that glows evenly: every view of it is known."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, location=place)
    made = context.object
    made.name = name
    made.data.materials.append(stage.material(name, "ShaderNodeEmission", Color=(*GLOW, 1)))
    return made


def striped(item: Any, scale: float) -> None:
    """Make the object glow in stripes of world space."""
    tree = item.data.materials[0].node_tree
    waves = tree.nodes.new("ShaderNodeTexWave")
    waves.inputs["Scale"].default_value = scale
    tree.links.new(tree.nodes.new("ShaderNodeNewGeometry").outputs["Position"], waves.inputs["Vector"])
    tree.links.new(waves.outputs["Color"], tree.nodes["Emission"].inputs["Color"])


def bake(name: str, spec: BakeSpec, out: Path, **options: Any) -> Path:
    return bake_object(context.scene, name, spec, out, **options).files.sidecar


def report(sidecar: Path, spec: ReportSpec = QUICK) -> ReportResult:
    return progress.finished(report_steps(context.scene, sidecar, spec, report_path(sidecar)))


# what is found


@pytest.mark.parametrize("layout", Layout)
def test_a_ball_that_glows_evenly_is_as_it_should_be(layout: Layout, out: Path, temporary: Path) -> None:
    ball("<b>Ball & Co")
    cells = 14 if layout is Layout.LAYERED else 4
    sidecar = bake("<b>Ball & Co", replace(TINY, layout=layout, bucket=cells, samples=16), out)
    found = report(sidecar)
    assert found.psnr > DENOISED
    assert found.energy == pytest.approx(1, abs=1e-2)
    assert found.flip is not None
    assert found.flip < 0.05
    assert found.lost == {}
    assert found.page.name.endswith(".report.html")
    text = found.page.read_text(encoding="utf-8")
    maps = 1 + QUICK.views  # the map, and the checker in each view
    assert len(re.findall(r'src="data:image/png;base64,', text)) == 3 * QUICK.views + maps
    assert re.search(r"<p>\d+ islands? covers? \d+% of \d+ × \d+ texels, with [\d.]+ texels to a unit", text)
    assert re.findall(r"(?:https?:)?//[a-z]", re.sub(r"base64,[^\"]*", "", text)) == []
    assert "&lt;b&gt;Ball &amp; Co" in text
    assert "<b>" not in text
    assert "the eye finds no difference" in text
    if layout is Layout.LAYERED:
        layered = read_bake(sidecar)
        sizes = {size.name.split(".")[-2]: size for size in sizes_of(layered)}
        assert gpu_bytes(layered) == sum(size.rgba16f for size in sizes.values())
        assert sizes["colour"].rgb9e5 == sizes["colour"].rgba16f // 2
        assert gpu_bytes(layered, cells=2) < 4 * gpu_bytes(layered)


def two_balls(out: Path, **options: Any) -> Path:
    """The sidecar of a ball that glows evenly and of a striped one, in one atlas."""
    ball("Even")
    striped(ball("Striped", (1.5, 0, 0)), 3.0)
    spec = replace(TINY, texels=48, objects=("Even", "Striped"))
    return bake("Both", spec, out, **({"preview": Filter.NEAREST} | options))


def test_objects_in_one_atlas_are_judged_together_and_each_by_itself(out: Path, temporary: Path) -> None:
    sidecar = two_balls(out)
    before = fingerprint()
    found = report(sidecar, replace(QUICK, pixels=96, samples=4))
    assert differences(before, fingerprint()) == {}
    assert [*found.parts] == ["Striped", "Even"]  # the worst first
    assert found.parts["Even"].mean.psnr > DENOISED - 2
    assert found.parts["Striped"].mean.psnr < 30
    assert found.parts["Striped"].mean.psnr < found.psnr < found.parts["Even"].mean.psnr
    assert found.parts["Even"].psnr.keys() == {"View 1", "View 2"}
    assert found.parts["Even"].mean.energy == pytest.approx(1, abs=1e-2)
    text = found.page.read_text(encoding="utf-8")
    assert found.page.name == "Both.report.html"
    assert text.index("<h2>Objects</h2>") < text.index(">Striped<") < text.index(">Even<")
    with pytest.raises(InputError, match="of several objects, of which no halves are baked"):
        report(sidecar, replace(QUICK, variants=True))


def test_what_is_seen_through_a_clear_part_is_the_part_behind_it(out: Path, temporary: Path) -> None:
    ball("Core").scale = (0.7,) * 3
    glass = ball("Shell").data.materials[0]
    tree: Any = glass.node_tree
    mix, clear = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfTransparent")
    shown = tree.nodes["Material Output"].inputs["Surface"]
    tree.nodes["Emission"].inputs["Color"].default_value = (0.0, 0.0, 0.6, 1)
    for one, other in ((tree.nodes["Emission"], 1), (clear, 2)):
        tree.links.new(one.outputs[0], mix.inputs[other])
    tree.links.new(mix.outputs[0], shown)
    spec = replace(TINY, texels=32, bucket=14, samples=4, layout=Layout.LAYERED, objects=("Core", "Shell"))
    found = report(bake("Both", spec, out, preview=Filter.NEAREST), replace(QUICK, samples=4))
    assert found.psnr > 30
    assert found.energy == pytest.approx(1, abs=0.05)
    assert [*found.parts] == ["Shell"]  # the core is nowhere seen by itself


def test_sheets_that_share_an_atlas_are_looked_at_from_both_sides(out: Path, temporary: Path) -> None:
    """Each has twins of its faces for its back, among those of the others."""
    names = ("Red", "Green", "Blue")
    for number, name in enumerate(names):
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=2, y_subdivisions=2, rotation=(np.pi / 2, 0, 0.5))
        context.object.name, context.object.location.x = name, 2.5 * number
        colour = tuple(0.8 * np.eye(3)[number])
        context.object.data.materials.append(stage.material(name, "ShaderNodeEmission", Color=(*colour, 1)))
    spec = replace(TINY, texels=32, bucket=14, samples=4, layout=Layout.LAYERED, objects=names)
    found = report(bake("Sheets", spec, out, preview=Filter.NEAREST), replace(QUICK, pixels=96, samples=4))
    assert {*found.parts} == {*names}
    for part in found.parts.values():
        assert part.mean.psnr > 30
        assert part.mean.energy == pytest.approx(1, abs=0.06)


def test_objects_in_one_atlas_have_to_be_as_they_were(out: Path, temporary: Path) -> None:
    sidecar = two_balls(out)
    context.scene.objects["Even"].location.x = -0.5
    with pytest.raises(InputError, match=r"'Even' does not fit .*: it was changed since: .*preview"):
        report(sidecar)
    context.scene.objects["Even"].location.x = 0
    (out / "Both.preview.blend").unlink()
    with pytest.raises(InputError, match="is missing, which holds the mesh"):
        report(sidecar)


def test_stripes_cost_texels_and_nothing_else(out: Path, temporary: Path) -> None:
    striped(ball(), 0.6)
    sidecar = bake("Ball", replace(TINY, texels=64, bucket=4, samples=2), out)
    found = report(sidecar, replace(QUICK, variants=True))
    assert found.lost["texels"] > 2
    assert abs(found.lost["samples"]) < 0.1
    assert abs(found.lost["bucket"]) < 0.1
    assert found.first_change is not None
    assert found.first_change.startswith("First give it more texels")
    assert "128 texels take about four times the paths" in found.first_change
    text = found.page.read_text(encoding="utf-8")
    for words in ("half of samples: 1<", "half of cells: 2<", "half of texels: 32<"):
        assert words in text


def test_a_bake_of_other_light_is_found_out(out: Path) -> None:
    item = ball()
    sidecar = bake("Ball", TINY, out)
    item.data.materials[0].node_tree.nodes["Emission"].inputs["Strength"].default_value = 0.5
    found = report(sidecar)
    assert found.energy == pytest.approx(2, rel=1e-2)
    display = np.array(GLOW) ** (1 / 2.2)
    error = float(np.mean((display - (np.array(GLOW) / 2) ** (1 / 2.2)) ** 2))
    assert found.psnr == pytest.approx(-10 * np.log10(error), abs=0.1)


def test_what_stands_before_the_object_is_left_out_and_walls_are_looked_round(out: Path) -> None:
    ball()
    sidecar = bake("Ball", TINY, out)
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, -1.2, 0))
    for side in (-1, 1):  # a corridor: half the views around the ball are of its walls
        bpy.ops.mesh.primitive_cube_add(size=1, location=(side * 2, 0, 0), scale=(0.1, 30, 30))
    assert report(sidecar).psnr > DENOISED
    bpy.ops.mesh.primitive_cube_add(size=2.5)
    with pytest.raises(InputError, match="no view around the object shows it"):
        report(sidecar)


# the mesh


@pytest.mark.parametrize("unwrap", Unwrap)
def test_the_unwrap_is_found_again_by_its_gutter(unwrap: Unwrap, out: Path) -> None:
    """Also in a lossy atlas."""
    striped(ball(), 0.2)
    compression = Compression.DWAA if unwrap is Unwrap.AUTO else TINY.compression
    spec = replace(TINY, unwrap=unwrap, compression=compression)
    assert report(bake("Ball", spec, out)).psnr > 14


def test_another_padding_is_found_in_the_preview_only(out: Path) -> None:
    striped(ball(), 0.2)
    spec = replace(TINY, texels=48, padding=5, unwrap=Unwrap.UVUNWRAP)
    sidecar = bake("Ball", spec, out, preview=Filter.QUADRILINEAR)
    assert report(sidecar).psnr > 14
    (out / "Ball.preview.blend").unlink()
    with pytest.raises(InputError, match="does not fit"):
        report(sidecar)


def test_a_users_layer_is_looked_up_by_its_name(out: Path) -> None:
    bpy.ops.mesh.primitive_plane_add(size=2)
    card = context.object
    card.data.materials.append(stage.material("glow", "ShaderNodeEmission", Color=(*GLOW, 1)))
    sidecar = bake(card.name, replace(TINY, uv_layer="UVMap"), out)
    assert report(sidecar).psnr > DENOISED
    card.data.uv_layers[0].name = "Other"
    with pytest.raises(InputError, match="no UV layer 'UVMap'"):
        report(sidecar)


def test_an_object_that_was_changed_does_not_fit(out: Path) -> None:
    item = ball()
    striped(item, 0.2)
    sidecar = bake("Ball", TINY, out, preview=Filter.QUADRILINEAR)
    item.modifiers.new("Bend", "SUBSURF").render_levels = 1
    with pytest.raises(InputError, match=r"object 'Ball' does not fit .*: it was changed"):
        report(sidecar)


# rays


def test_rays_meet_a_card_where_they_should() -> None:
    bpy.ops.mesh.primitive_plane_add(size=2)
    mesh = context.object.data
    mesh.calc_loop_triangles()
    triangles = [tuple(triangle.vertices) for triangle in mesh.loop_triangles]
    places = [tuple(vertex.co) for vertex in mesh.vertices]
    card = bpy.data.meshes.new("card")
    card.from_pydata(places, [], triangles)
    layer = card.uv_layers.new(name="Baked")
    for loop in card.loops:
        layer.uv[loop.index].vector = [part / 2 + 0.5 for part in places[loop.vertex_index][:2]]
    give_frame(card)
    surface = BakedSurface(card, np.diag([3.0, 3.0, 1.0, 1.0]), "Baked")
    rays = CameraRays.of_camera(
        (0, 0, 5), np.eye(3), 1.0, 10, 1
    )  # 10 x 10 wide where the card is, which is 6 x 6
    buffer = surface.gbuffer(rays, np.full(100, np.inf))
    assert buffer.inside.sum() == 36
    assert eroded(buffer.inside).sum() == 16
    x, y = np.meshgrid(np.arange(-4.5, 5), -np.arange(-4.5, 5))
    hit = buffer.hit
    place = np.stack([x, y, 0 * x], axis=2).reshape(-1, 3)[hit]
    np.testing.assert_allclose(buffer.position[hit], place, atol=1e-6)
    np.testing.assert_allclose(buffer.uv[hit], place[:, :2] / 6 + 0.5, atol=1e-6)
    away = np.array([0, 0, 5]) - place
    np.testing.assert_allclose(buffer.incidence[hit], away / np.linalg.norm(away, axis=1)[:, None], atol=1e-6)
    near = surface.gbuffer(rays, np.where(rays.away[:, 0] < 0, 4.9, np.inf))
    assert near.inside.sum() == 18
    assert surface.gbuffer(rays, np.full(100, 4.9)).hit.sum() == 0
    begun = replace(rays, origin=rays.origin + rays.away)  # each a little on its way
    same = surface.gbuffer(begun, np.full(100, np.inf))
    np.testing.assert_array_equal(same.hit, hit)
    np.testing.assert_allclose(same.uv[hit], buffer.uv[hit], atol=1e-6)


# files


def test_bakes_are_found_by_folder_file_and_object(out: Path) -> None:
    ball("One")
    ball("Two", (5, 0, 0))
    one = bake("One", TINY, out)
    (out / "notes.json").write_text('{"mine": 1}')
    (out / "broken.json").write_text("{")
    assert find_bake(out, None) == find_bake(one, "One") == SidecarFile.read(one)
    with pytest.raises(InputError, match=r"holds no bake of 'Two': it has 'One'"):
        find_bake(out, "Two")
    two = bake("Two", TINY, out)
    with pytest.raises(InputError, match=r"holds bakes of 'One', 'Two': name one"):
        find_bake(out, None)
    assert find_bake(out, "Two").path == two
    with pytest.raises(InputError, match="is a bake of 'Two', not of 'One'"):
        find_bake(two, "One")


def test_light_that_no_camera_sees_is_refused(out: Path) -> None:
    ball()
    sidecar = bake("Ball", replace(TINY, kind=Kind.INCIDENT), out)
    for place in (out, sidecar):
        with pytest.raises(InputError, match="incident light, which no camera sees"):
            find_bake(place, None)
    bake("Ball", TINY, out)
    assert find_bake(out, None).path.name == "Ball.radiance.json"


def test_files_of_two_bakes_are_refused(out: Path, tmp_path: Path) -> None:
    ball()
    sidecar = bake("Ball", TINY, out)
    other = bake("Ball", replace(TINY, samples=2), tmp_path / "other")
    sidecar.with_suffix(".exr").write_bytes(other.with_suffix(".exr").read_bytes())
    with pytest.raises(FormatError, match="of another bake"):
        read_bake(sidecar)
    sidecar.with_suffix(".exr").unlink()
    with pytest.raises(FormatError, match=r"Ball\.radiance\.exr cannot be read"):
        report(sidecar)
    assert not report_path(sidecar).exists()


def test_sizes_are_of_the_formats(out: Path) -> None:
    ball()
    plain = read_bake(bake("Ball", TINY, out / "plain"))
    width, height = plain.sidecar.width * 2, plain.sidecar.height * 2
    (size,) = sizes_of(plain)
    assert (size.width, size.height, size.rgba16f) == (width, height, 8 * width * height)
    assert size.disk == plain.images[0].stat().st_size
    assert size.rgb9e5 == 4 * width * height
    assert size.bc6h == -(-width // 4) * -(-height // 4) * 16
    assert gpu_bytes(plain, cells=2) == gpu_bytes(plain, texels=2) == 4 * gpu_bytes(plain)
    context.scene.render.film_transparent = True
    context.object.data.materials[0] = stage.material("clear", "ShaderNodeBsdfTransparent")
    (size,) = sizes_of(read_bake(bake("Ball", TINY, out / "clear")))
    assert (size.rgb9e5, size.bc6h) == (None, None), "it has an alpha"


# words


@pytest.fixture
def finished(out: Path) -> Any:
    ball()
    return read_bake(bake("Ball", TINY, out))


def variant(cause: Cause, value: int, lost: float) -> HalvedBake:
    return HalvedBake(cause, value, 20.0, None, lost, 1000, 1000)


def test_what_costs_most_is_changed_first(finished: Any) -> None:
    samples, cells = variant(Cause.SAMPLES, 8, 1.5), variant(Cause.CELLS, 4, 0.5)
    words = first_change(finished, [samples, cells])
    assert words.startswith("First give it more samples: half of them costs most, 1.5 dB (noise)")
    assert "32 samples take twice the paths, and no bytes" in words
    words = first_change(finished, [replace(samples, lost=0.4), cells])
    assert "16 cells take four times the paths" in words
    assert "No setting matters much" in first_change(finished, [replace(samples, lost=-1.0)])
    assert "too small" in first_change(finished, [])


@pytest.mark.parametrize(("views", "pixels", "samples"), [(0, 64, 8), (1, 8, 8), (1, 4096, 8), (1, 64, 0)])
def test_a_report_has_limits(views: int, pixels: int, samples: int) -> None:
    with pytest.raises(InputError, match="give a whole number from"):
        ReportSpec(views=views, pixels=pixels, samples=samples)


# the user's file


def test_the_users_file_is_as_it_was_and_the_page_whole_or_not_there(out: Path, temporary: Path) -> None:
    name = lived_in_scene().name
    sidecar = bake(name, replace(TINY, texels=64, samples=2, unwrap=Unwrap.BLENDER), out)
    before, files = fingerprint(), set(out.iterdir())
    spec = replace(QUICK, views=1, pixels=24, variants=True)
    taken = 0
    while True:
        steps = report_steps(context.scene, sidecar, spec, report_path(sidecar))
        ended = False
        for _ in range(taken + 1):
            try:
                next(steps)
            except StopIteration:
                ended = True
        steps.close()
        assert differences(before, fingerprint()) == {}
        if ended:
            break
        assert set(out.iterdir()) == files
        taken = 8 * taken + 1
    assert set(out.iterdir()) == files | {report_path(sidecar)}
