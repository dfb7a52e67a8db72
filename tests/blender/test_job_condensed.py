# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes for a budget or a target: textures of that size, that near, and no other form's beside them."""

from __future__ import annotations

from collections.abc import Generator
from itertools import islice
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.condense import condense
from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.progress import Stage
from radtex_addon.bake.spec import BakeSpec, Layout
from radtex_addon.core.condensed import CondensedAtlas
from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.core.shared import Axis, SharedAtlas
from radtex_addon.formats.image_files import layer_path
from radtex_addon.formats.packing import layer_names
from radtex_addon.formats.shared_files import read_condensed, texture_path
from radtex_addon.job import BakeResult, bake_object, bake_steps
from tests.blender import stage
from tests.blender.conftest import PlannedError
from tests.blender.unfinished import take_pieces

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

HEADERS = 148  # bytes of a DDS file before its texture


def spec(**changes: Any) -> BakeSpec:
    options = {"texels": 16, "bucket": 6, "samples": 1, "budget": 40_000}
    return BakeSpec(layout=Layout.SHARED, **(options | changes))


def ball() -> Any:
    """A ball that reflects, roughly, in a world with lamps."""
    stage.lamps()
    bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=8)
    context.object.name = "Ball"
    context.object.data.materials.append(stage.material("Ball", "ShaderNodeBsdfAnisotropic", Roughness=0.3))
    return context.object


def bake(out: Path, wanted: BakeSpec, **options: Any) -> BakeResult:
    return bake_object(context.scene, "Ball", wanted, out, **options)


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def textures(axis: Axis = Axis.MIRROR) -> set[str]:
    return {texture_path(Path("Ball.radiance.json"), layer).name for layer in layer_names([axis], True)}


@pytest.mark.parametrize("budget", [25_000, 60_000])
def test_a_budget_is_kept_and_made_use_of(out: Path, budget: int) -> None:
    ball()
    # One lamp, less noise: Blender's UV sphere has its faces in another order each time, and clusters differ.
    bpy.data.objects.remove(bpy.data.objects["Point"])
    context.view_layer.update()
    result = bake(out, spec(budget=budget))
    assert names(out) == {"Ball.radiance.json", *textures()} == {path.name for path in result.files.all}
    size = sum(path.stat().st_size - HEADERS for path in result.files.images)
    chosen = result.condensed
    assert chosen is not None
    assert size == chosen.bytes
    assert 0.85 * budget < size <= budget
    atlas, sidecar = read_condensed(out / "Ball.radiance.json")
    assert chosen.clusters == tuple(len(lobe.ends) for lobe in atlas.lobes)
    assert (chosen.colour, chosen.surroundings) == (sidecar.colour, sidecar.surroundings)
    assert 15 < chosen.agreement < 60
    assert Stage.CONDENSE in result.seconds


def test_a_larger_budget_comes_nearer(out: Path) -> None:
    ball()
    small, large = (bake(out / str(budget), spec(budget=budget)).condensed for budget in (25_000, 150_000))
    assert small is not None
    assert large is not None
    print(f"{small.bytes} bytes: {small.agreement:.1f} dB; {large.bytes} bytes: {large.agreement:.1f} dB")
    assert large.agreement > small.agreement + 2


def test_a_target_is_reached_with_the_fewest_clusters_tried(
    out: Path, caplog: pytest.LogCaptureFixture
) -> None:
    ball()
    modest, fine = (
        bake(out / str(target), spec(budget=None, target=target)).condensed for target in (20.0, 26.0)
    )
    assert modest is not None
    assert fine is not None
    assert modest.agreement >= 20
    assert fine.agreement >= 26
    assert modest.clusters <= fine.clusters
    assert caplog.text == ""
    most = bake(out / "60", spec(budget=None, target=60.0)).condensed
    assert most is not None
    assert f"condensed textures of object 'Ball' come to {most.agreement:.1f} dB" in caplog.text


def test_one_form_replaces_the_other(out: Path) -> None:
    ball()
    dense = BakeSpec(layout=Layout.SHARED, texels=16, bucket=6, samples=1)
    images = {layer_path(Path("Ball.radiance.json"), layer).name for layer in layer_names([Axis.MIRROR])}
    bake(out, dense)
    with pytest.raises(InputError, match="already there"):
        bake(out, spec())
    bake(out, spec(), overwrite=True)
    assert names(out) == {"Ball.radiance.json", *textures()}
    bake(out, dense, overwrite=True)
    assert names(out) == {"Ball.radiance.json", *images}


def test_a_failure_while_it_is_measured_leaves_the_other_form(
    out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ball()
    bake(out, BakeSpec(layout=Layout.SHARED, texels=16, bucket=6, samples=1))
    before = {path.name: path.read_bytes() for path in out.iterdir()}

    def fails(*_: object) -> float:
        assert len(names(out)) == len(before) + 1, "the folder of finished pieces"
        assert (out / "Ball.radiance.radtex-unfinished" / "written").is_dir(), "where the new files wait"
        raise PlannedError

    monkeypatch.setattr("radtex_addon.forms.condensed.condense.agreement", fails)
    with pytest.raises(PlannedError):
        bake(out, spec(), overwrite=True)
    assert take_pieces(out)
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


def test_it_ends_between_blocks_of_work_and_leaves_nothing(out: Path) -> None:
    ball()
    taken, given_up = 0, True
    while given_up:
        steps = bake_steps(context.scene, "Ball", spec(budget=25_000), out, overwrite=True)
        condensing = (step for step in steps if step.stage is Stage.CONDENSE)
        given_up = sum(1 for _ in islice(condensing, taken)) == taken
        steps.close()
        if given_up:
            take_pieces(out)
            assert not out.exists()
            taken = 1 + 4 * taken
    assert taken > 50
    assert names(out) == {"Ball.radiance.json", *textures()}


def test_a_target_s_tries_are_made_once_each(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ball()
    tried: list[int] = []

    def noted(atlas: SharedAtlas, plan: CapturePlan, clusters: int) -> Generator[None, None, CondensedAtlas]:
        tried.append(clusters)
        return condense(atlas, plan, clusters)

    monkeypatch.setattr("radtex_addon.forms.condensed.condense.condense", noted)
    made = bake(out, spec(budget=None, target=60.0)).condensed
    assert made is not None
    assert len(tried) > 2
    assert tried == sorted(set(tried))
    atlas, _ = read_condensed(out / "Ball.radiance.json")
    assert made.clusters == tuple(len(lobe.ends) for lobe in atlas.lobes)


def test_a_budget_too_small_for_the_texels_is_refused_before_it_is_baked(out: Path) -> None:
    ball()
    with pytest.raises(
        InputError, match=r"budget 9 KiB: 64 x 6. texels take [0-9]+ KiB at least; give more, or fewer"
    ):
        bake(out, spec(texels=64, budget=9_000))
    assert not out.exists() or names(out) == set()


def test_a_budget_that_what_it_shows_does_not_fit_is_told(
    out: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Glass, which has two lobes: that is not known before it is baked."""
    ball().data.materials[0] = stage.material("Glass", "ShaderNodeBsdfGlass", Roughness=0.2)
    made = bake(out, spec(budget=16_000)).condensed
    assert made is not None
    assert len(made.clusters) == 2
    assert made.bytes > 16_000
    assert "budget 16 KiB: the textures of object 'Ball' take" in caplog.text
    assert names(out) == {"Ball.radiance.json", *textures(), *textures(Axis.THROUGH)}


def test_a_preview_holds_its_textures(out: Path) -> None:
    """What the textures decode to: Blender reads no such files with the right rows."""
    ball()
    result = bake(out, spec(), preview=Filter.QUADRILINEAR)
    assert result.files.preview is not None
    libraries: Any = bpy.data.libraries
    with libraries.load(str(result.files.preview)) as (there, wanted):
        wanted.images = list(there.images)
        wanted.materials = list(there.materials)
    assert "RadTex Ball" in there.materials
    packed = [image for image in wanted.images if image.packed_file]
    assert packed
    assert all(np.isfinite(image.pixels[:]).all() for image in packed)
