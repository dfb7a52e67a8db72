# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A texel density: objects of every size come out alike, the atlas's size follows, and a cap says so."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.cli.arguments import parse
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError, MemoryLimitError
from radtex_addon.core.islands import signed_areas
from radtex_addon.core.sampler import Filter
from radtex_addon.farm.farm_files import FarmFiles
from radtex_addon.farm.farm_manifest import read_manifest
from radtex_addon.farm.prepare_farm import prepare_steps
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.job import bake_object, part_specs
from radtex_addon.job.about_texels import with_about_texels
from radtex_addon.job.bake_plan import plan_bakes
from radtex_addon.job.bake_request import BakeRequest
from radtex_addon.scene.uv.unwrap import unwrap_steps
from radtex_addon.scene.uv.unwrap_options import UnwrapOptions
from radtex_addon.settings import spec as bake_spec
from radtex_addon.settings.spec import BakeSpec, Unwrap
from radtex_addon.store.bake_folder import BakeFolder
from tests.blender import stage
from tests.blender.test_unwrap_choice import quads, read

pytestmark = [pytest.mark.usefixtures("temporary", "empty_file"), pytest.mark.one_blender]
context: Any = bpy.context  # to the stubs, every pointer may be None

QUICK = BakeSpec(bucket=2, samples=1, density=32, unwrap=Unwrap.UVUNWRAP)


def cube(name: str, size: float, x: float = 0) -> Any:
    bpy.ops.mesh.primitive_cube_add(size=size, location=(x, 0, 0), rotation=(0.1, 0.2, x))
    made = context.object
    made.name = name
    return made


def baked(name: str, spec: BakeSpec, out: Path) -> Any:
    """The sidecar of a bake, and its preview's path."""
    made = bake_object(context.scene, name, spec, out, preview=Filter.QUADRILINEAR, overwrite=True)
    return read_sidecar(made.files.sidecar), made.files.preview


def texels_per_unit(preview: Path, name: str, width: int, height: int) -> Floats:
    """Of each triangle of the baked copy in a preview, from the lengths of its edges on it and in texels."""
    bpy.ops.wm.open_mainfile(filepath=str(preview))
    item: Any = bpy.data.objects[name]
    mesh: Any = item.data
    uv = np.empty(len(mesh.loops) * 2, dtype=np.float32)
    mesh.uv_layers.active.data.foreach_get("uv", uv)
    flat = uv.reshape(-1, 3, 2) * [width, height]
    place = np.array([item.matrix_world @ mesh.vertices[loop.vertex_index].co for loop in mesh.loops])
    corners = place.reshape(-1, 3, 3)
    units, texels = (np.linalg.norm(ends - np.roll(ends, 1, axis=1), axis=-1) for ends in (corners, flat))
    found: Floats = (texels / units).mean(axis=1)
    return found


def test_objects_of_different_size_come_out_alike(tmp_path: Path) -> None:
    cube("One", 1)
    cube("Three", 3, 10)
    made = {name: baked(name, QUICK, tmp_path) for name in ("One", "Three")}
    for name, (sidecar, preview) in made.items():
        found = texels_per_unit(preview, name, sidecar.width, sidecar.height)
        assert found == pytest.approx(np.full(12, 32.0), rel=0.05), name
        assert sidecar.texel_density.asked == 32
        assert sidecar.texel_density.reached == pytest.approx(float(found.mean()), rel=0.01)
        assert (sidecar.width % 4, sidecar.height % 4) == (0, 0)
    assert made["Three"][0].width > 2 * made["One"][0].width


def test_objects_in_one_atlas_keep_their_relative_size(tmp_path: Path) -> None:
    cube("One", 1)
    cube("Three", 3, 10)
    sidecar, preview = baked("Both", replace(QUICK, objects=("One", "Three")), tmp_path)
    for name in ("One", "Three"):
        found = texels_per_unit(preview, name, sidecar.width, sidecar.height)
        assert found.mean() == pytest.approx(32, rel=0.05), name


def test_a_metre_is_what_the_scenes_unit_scale_says(tmp_path: Path) -> None:
    cube("Cup", 1)
    metres, _ = baked("Cup", QUICK, tmp_path / "metres")
    context.scene.unit_settings.scale_length = 0.01
    centimetres, _ = baked("Cup", replace(QUICK, density=3200), tmp_path / "centimetres")
    assert (metres.width, metres.height) == (centimetres.width, centimetres.height)
    assert centimetres.texel_density.reached == pytest.approx(100 * metres.texel_density.reached, rel=1e-3)
    context.scene.unit_settings.system = "NONE"  # Blender then ignores the scale
    assert baked("Cup", QUICK, tmp_path / "none")[0].width == metres.width


@pytest.mark.parametrize("named", ["Mine", None])
def test_a_layer_of_ones_own_is_as_large_as_its_mean_density_needs(tmp_path: Path, named: str | None) -> None:
    quads((0, 0, 0.48), (0.52, 0, 0.48), (0, 0.52, 0.48))  # each is a unit square
    spec = replace(QUICK, unwrap=Unwrap.AUTO, uv_layer=named, density=64 * 0.48)
    sidecar, _ = baked("Quads", spec, tmp_path)
    assert (sidecar.uv_map, sidecar.width, sidecar.height) == ("Mine", 64, 64)
    assert sidecar.texel_density.reached == pytest.approx(64 * 0.48, rel=1e-3)


def test_each_part_of_an_object_has_the_density(tmp_path: Path) -> None:
    item = cube("Box", 2)
    for name in ("red", "blue"):
        item.data.materials.append(stage.material(name, "ShaderNodeEmission"))
    item.data.polygons[0].material_index = 1
    specs = part_specs(context.scene, "Box", replace(QUICK, split="material"))  # type: ignore[arg-type]
    made = {spec.part: baked("Box", spec, tmp_path)[0] for spec in specs}
    assert made["red"].width * made["red"].height > 3 * made["blue"].width * made["blue"].height
    for sidecar in made.values():
        assert sidecar.texel_density.reached == pytest.approx(32, rel=0.05)


def test_a_density_that_needs_too_many_texels_is_capped_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(bake_spec, "MOST_TEXELS", 64)
    cube("Hall", 3)
    with caplog.at_level(logging.WARNING):
        sidecar, _ = baked("Hall", QUICK, tmp_path)
    assert max(sidecar.width, sidecar.height) == 64
    reached = sidecar.texel_density.reached
    assert 5 < reached < 64 / 9  # three faces along a side
    (said,) = [str(record.msg) for record in caplog.records if "texels per metre" in str(record.msg)]
    needed = int(said.split("about ")[1].split(" ")[0])
    assert needed == pytest.approx(300, rel=0.1)  # as in the first test
    assert said == (
        f"'Hall' would need about {needed} texels along a side for 32 texels per metre; 64 is the most, "
        f"which gives it {reached:.4g} texels per metre: ask for fewer"
    )


def test_the_estimate_is_near_and_no_more_than_the_cap() -> None:
    cube("One", 1)
    cube("Three", 3, 10)
    for name, made in (("One", 112), ("Three", 300)):  # longer sides, of the first test
        assert with_about_texels(context.scene, name, QUICK).texels == pytest.approx(made, rel=0.2)
    assert with_about_texels(context.scene, "Three", replace(QUICK, density=1e6)).texels == 4096
    assert with_about_texels(context.scene, "nothing", QUICK).texels >= 1
    plain = replace(QUICK, density=None)
    assert with_about_texels(context.scene, "One", plain) is plain


def test_a_plan_has_estimates_and_the_bake_checks_the_memory_it_really_needs(
    tmp_path: Path,
) -> None:
    cube("Three", 3)
    request = BakeRequest(("Three",), QUICK, tmp_path)
    ((_, spec),) = plan_bakes(context.scene, request).wanted
    assert 200 < spec.texels < 400
    tight = replace(spec, texels=16, memory_mb=60)  # as if it had been estimated far too low
    with pytest.raises(MemoryLimitError, match="32 texels per metre, a side of 3"):
        bake_object(context.scene, "Three", replace(tight, bucket=24), tmp_path)


def test_a_finished_bake_is_one_of_the_density_whatever_was_estimated(tmp_path: Path) -> None:
    cube("Cup", 1)
    sidecar, _ = baked("Cup", QUICK, tmp_path)
    assert BakeFolder("Cup", replace(QUICK, texels=7), tmp_path).is_finished()
    assert not BakeFolder("Cup", replace(QUICK, density=33), tmp_path).is_finished()
    longer = max(sidecar.width, sidecar.height)
    assert not BakeFolder("Cup", replace(QUICK, density=None, texels=longer), tmp_path).is_finished()


def test_a_farm_has_the_texels_of_the_unwrap(tmp_path: Path) -> None:
    cube("Cup", 1)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "cup.blend"))
    farm = finished(prepare_steps(context.scene, "Cup", QUICK, tmp_path / "farm"))
    manifest = read_manifest(FarmFiles(farm.files.folder))
    assert manifest.spec.texels == max(manifest.facts.width, manifest.facts.height)
    assert manifest.spec.density == 32
    density = manifest.facts.texel_density
    assert density is not None
    assert density.reached == pytest.approx(32, rel=0.05)


def test_a_speck_has_few_texels() -> None:
    cube("Speck", 0.01)
    mesh = read(context.object)
    made = finished(unwrap_steps(mesh, 128, Unwrap.UVUNWRAP, UnwrapOptions(density=1, most=4096)))
    assert max(made.width, made.height) <= 32
    assert (np.abs(signed_areas(made.uv)) > 0).all()


def test_the_command_line_takes_a_density_in_place_of_texels() -> None:
    line = ["a.blend", "--object", "A"]
    spec = parse([*line, "--density", "1.5/mm"], inside_blender=False).bakes.spec
    assert spec == BakeSpec(density=1500, denoise=True)
    with pytest.raises(InputError, match="--texels and --density contradict"):
        parse([*line, "--density", "64", "--texels", "128"], inside_blender=False)
