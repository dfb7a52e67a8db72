# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Accumulating and refreshing some places alone: there as everywhere, elsewhere to the bit what it was."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.arrays import Bools, Floats, Ints
from radtex_addon.core.errors import InputError
from radtex_addon.formats.bucket_files import read_counts
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.forms.buckets import bake as buckets
from radtex_addon.job import bake_object
from radtex_addon.scene.mesh.named_regions import chosen_triangles
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec
from tests.blender import stage
from tests.blender.conftest import PlannedError

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

SPEC = BakeSpec(texels=24, bucket=4, samples=4, half=False)
MORE = replace(SPEC, accumulate=True, where="Top")
SIDECAR = "Ball.radiance.json"


def lit_ball() -> Any:
    """A ball whose upper vertices are a group."""
    stage.world((0.2, 0.3, 0.4))
    stage.lamps()
    context.scene.cycles.sampling_pattern = "TABULATED_SOBOL"  # others begin anew for each number of samples
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=0.6)
    ball = context.object
    ball.name = "Ball"
    ball.data.materials.append(
        stage.material("gold", "ShaderNodeBsdfAnisotropic", Color=(1, 0.7, 0.3, 1), Roughness=0.4)
    )
    upper = [
        vertex.index for vertex in ball.data.vertices if vertex.co.z > 0.1
    ]  # a face with two of them is in
    ball.vertex_groups.new(name="Top").add(upper, 1.0, "REPLACE")
    return ball


def bake(out: Path, spec: BakeSpec) -> Floats:
    return read_buckets(bake_object(context.scene, "Ball", spec, out).files.sidecar)[0]


def counts(out: Path) -> Ints:
    facts = read_sidecar(out / SIDECAR)
    if not facts.texel_samples:
        return np.full((facts.height, facts.width), facts.samples)
    return read_counts(facts.texel_samples, facts.width, facts.height, SIDECAR)


def cells(of_texels: Bools) -> Bools:
    return of_texels.repeat(SPEC.bucket, axis=0).repeat(SPEC.bucket, axis=1)


@pytest.mark.one_blender
def test_more_samples_go_where_they_are_wanted(out: Path) -> None:
    lit_ball()
    before = bake(out, SPEC)
    after = bake(out, MORE)
    assert read_sidecar(out / SIDECAR).samples == 4
    assert set(np.unique(counts(out))) == {4, 8}
    wanted = cells(counts(out) == 8)
    assert 0.3 < wanted.mean() < 0.7
    assert np.array_equal(after[~wanted], before[~wanted])
    assert (after[wanted] != before[wanted]).any(axis=-1).mean() > 0.95
    many = bake(out / "many", replace(SPEC, samples=64))
    error_before, error_after = (np.abs(some - many)[wanted].mean() for some in (before, after))
    print(f"\nerror where there are more: {error_before:.4f} before, {error_after:.4f} after")
    assert error_after < 0.85 * error_before  # by 1 / sqrt(2)


@pytest.mark.one_blender
def test_twice_as_many_there_are_as_good_at_once_as_one_after_the_other(out: Path) -> None:
    lit_ball()
    bake(out, SPEC)
    bake(out / "at once", SPEC)
    bake(out, MORE)
    folded = bake(out, MORE)
    at_once = bake(out / "at once", replace(MORE, samples=8))
    np.testing.assert_allclose(folded, at_once, atol=1e-6 * float(at_once.max()))
    assert np.array_equal(counts(out), counts(out / "at once"))
    assert set(np.unique(counts(out))) == {4, 12}


@pytest.mark.one_blender
def test_then_everywhere_each_texel_goes_on_from_its_own(out: Path) -> None:
    """The share of each bake is that of its samples, as a glow tells that changes meanwhile."""
    ball = lit_ball()
    ball.data.materials[0] = stage.material("glow", "ShaderNodeEmission", Strength=1.0)
    bake(out, SPEC)
    bake(out, MORE)
    ball.data.materials[0] = stage.material("bright", "ShaderNodeEmission", Strength=3.0)
    folded = bake(out, replace(SPEC, accumulate=True, samples=4))[..., :3]
    assert set(np.unique(counts(out))) == {8, 12}
    np.testing.assert_allclose(folded[cells(counts(out) == 8)], 4 / 8 * 1 + 4 / 8 * 3, rtol=1e-5)
    np.testing.assert_allclose(folded[cells(counts(out) == 12)], 8 / 12 * 1 + 4 / 12 * 3, rtol=1e-5)


@pytest.mark.one_blender
def test_everywhere_by_name_is_everywhere(out: Path) -> None:
    lit_ball()
    bake(out, SPEC)
    bake(out / "plain", SPEC)
    named = bake(out, replace(MORE, where="gold"))
    plain = bake(out / "plain", replace(MORE, where=None))
    assert np.array_equal(named, plain)
    assert read_sidecar(out / SIDECAR) == read_sidecar(out / "plain" / SIDECAR)


@pytest.mark.one_blender
def test_only_the_place_is_refreshed_with_the_samples_it_has(out: Path) -> None:
    lit_ball()
    bake(out, SPEC)
    before = bake(out, MORE)
    stage.world((3.0, 3.0, 3.0))
    after = bake(out, replace(SPEC, refresh=True, where="Top"))
    wanted = cells(counts(out) == 8)
    assert np.array_equal(after[~wanted], before[~wanted])
    assert (after[wanted] != before[wanted]).any(axis=-1).mean() > 0.9
    assert set(np.unique(counts(out))) == {4, 8}


@pytest.mark.one_blender
def test_what_fails_is_resumed(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lit_ball()
    bake(out, SPEC)
    before = (out / SIDECAR).read_bytes()
    bake(out / "whole", SPEC)
    whole = bake(out / "whole", MORE)

    def fail(*_: object) -> None:
        raise PlannedError

    with monkeypatch.context() as patch:
        patch.setattr(buckets, "write_bands", fail)
        with pytest.raises(PlannedError):
            bake(out, MORE)
    assert (out / SIDECAR).read_bytes() == before
    with pytest.raises(InputError, match=r"differs in where \(Top, now gold\)"):
        bake_object(context.scene, "Ball", replace(MORE, where="gold"), out, resume=True)
    made = bake_object(context.scene, "Ball", MORE, out, resume=True)
    assert np.array_equal(read_buckets(made.files.sidecar)[0], whole)


@pytest.mark.one_blender
def test_a_place_on_one_of_several_objects_is_found_in_their_atlas(out: Path) -> None:
    lit_ball()
    bpy.ops.mesh.primitive_cube_add(size=0.5, location=(1.5, 0, 0))
    context.object.name = "Box"
    context.object.data.materials.append(stage.material("tin", "ShaderNodeBsdfDiffuse"))
    both = replace(SPEC, objects=("Ball", "Box"))
    before = bake(out, both)
    after = bake(out, replace(both, accumulate=True, where="tin"))
    wanted = cells(counts(out) == 8)
    assert 0.1 < wanted.mean() < 0.7
    assert np.array_equal(after[~wanted], before[~wanted])
    assert (after[wanted] != before[wanted]).any(axis=-1).mean() > 0.5


def triangles(name: str) -> Floats:
    """Which triangles of the ball a name chooses."""
    with scratch_scene(context.scene) as scratch:
        (chosen,) = chosen_triangles(scratch, [bpy.data.objects["Ball"]], name)
    return chosen.astype(float)


def test_a_vertex_group_goes_through_modifiers(out: Path) -> None:
    ball = lit_ball()
    plain = triangles("Top")
    assert plain.mean() == pytest.approx(0.5, abs=0.02)
    ball.modifiers.new("Rounder", "SUBSURF").render_levels = 1
    finer = triangles("Top")
    assert len(finer) > 3 * len(plain)
    assert finer.mean() == pytest.approx(0.5, abs=0.1)


def test_faces_are_named_by_an_attribute_or_a_material(out: Path) -> None:
    ball = lit_ball()
    count = len(ball.data.polygons)
    marks = ball.data.attributes.new("marked", "BOOLEAN", "FACE")
    marks.data.foreach_set("value", np.arange(count) < count // 4)
    corners = np.array([len(polygon.vertices) - 2 for polygon in ball.data.polygons])
    assert triangles("marked").sum() == corners[: count // 4].sum()
    ball.data.materials.append(stage.material("tin", "ShaderNodeBsdfDiffuse"))
    for polygon in list(ball.data.polygons)[: count // 2]:
        polygon.material_index = 1
    assert triangles("tin").sum() == corners[: count // 2].sum()
    assert triangles("gold").sum() == corners[count // 2 :].sum()


def test_a_name_that_means_nothing_or_two_things_is_refused_before_anything_is_baked(out: Path) -> None:
    ball = lit_ball()
    bake(out, SPEC)
    ball.vertex_groups.new(name="Nothing")
    with pytest.raises(InputError, match="no face belongs to 'Nothing'"):
        bake(out, replace(MORE, where="Nothing"))
    words = r"'Ball' has no vertex group, boolean face attribute or material 'Rim': it has .*'gold'.*'Top'"
    with pytest.raises(InputError, match=words):
        bake(out, replace(MORE, where="Rim"))
    ball.vertex_groups.new(name="gold")
    with pytest.raises(InputError, match="has a vertex group and a material called 'gold': rename one"):
        bake(out, replace(MORE, where="gold"))
    assert not (out / "Ball.radiance.radtex-unfinished").exists()


@pytest.mark.one_blender
@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"where": "Top"}, "where 'Top' is for what is accumulated or refreshed"),
        ({"where": "", "accumulate": True}, "the name of where is empty"),
    ],
)
def test_where_alone_asks_for_nothing(options: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        BakeSpec(**options)
