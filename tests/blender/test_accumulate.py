# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Accumulating and refreshing: k samples and k more are 2k; what does not fit an atlas leaves it as it is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.layers import Layer
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.forms.buckets import bake as buckets
from radtex_addon.job import BakeResult, bake_object
from radtex_addon.settings.spec import BakeSpec, CaptureMethod, Kind
from tests.blender import stage
from tests.blender.conftest import PlannedError

pytestmark = [pytest.mark.one_blender, pytest.mark.usefixtures("temporary")]
context: Any = bpy.context  # to the stubs, every pointer may be None

SPEC = BakeSpec(texels=24, bucket=4, samples=4, half=False)
MORE = replace(SPEC, accumulate=True)
SIDECAR = "Ball.radiance.json"


def lit_ball() -> Any:
    stage.hdri(stage.world())
    stage.lamps()
    context.scene.cycles.sampling_pattern = "TABULATED_SOBOL"  # others begin anew for each number of samples
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=0.6)
    context.object.name = "Ball"
    context.object.data.materials.append(
        stage.material("gold", "ShaderNodeBsdfAnisotropic", Color=(1, 0.7, 0.3, 1), Roughness=0.4)
    )
    return context.object


def bake(out: Path, spec: BakeSpec) -> Floats:
    return read_buckets(bake_object(context.scene, "Ball", spec, out).files.sidecar)[0]


def contents(out: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()}


@pytest.mark.parametrize("kind", [Kind.RADIANCE, Kind.REFLECTION])
def test_k_samples_and_k_more_are_twice_as_many(out: Path, kind: Kind) -> None:
    lit_ball()
    few = bake(out, replace(SPEC, kind=kind))
    folded = bake(out, replace(MORE, kind=kind))
    at_once = bake(out / "at once", replace(SPEC, kind=kind, samples=8))
    largest = float(at_once.max())
    print(f"\n{kind}: 4 + 4 against 8: {np.abs(folded - at_once).max() / largest:.1e} of {largest:.1f}")
    assert np.abs(folded - at_once).max() <= 1e-6 * max(1, largest)
    assert np.abs(few - at_once).max() > 1e-2
    assert read_sidecar(out / f"Ball.{kind}.json").samples == 8


def test_a_third_bake_is_folded_by_its_share(out: Path) -> None:
    lit_ball()
    bake(out, SPEC)
    bake(out, MORE)
    folded = bake(out, replace(MORE, samples=8))
    np.testing.assert_allclose(folded, bake(out / "at once", replace(SPEC, samples=16)), atol=1e-5)
    bpy.data.objects["Ball"].location.z = 0.5  # which leaves the mesh as it is
    bake(out, MORE)
    assert read_sidecar(out / SIDECAR).samples == 20


def reshape() -> None:
    bpy.data.objects["Ball"].data.vertices[0].co.z += 0.01
    bpy.data.objects["Ball"].data.update()


@pytest.mark.parametrize(
    ("first", "specs"),
    [
        (
            SPEC,
            {
                replace(MORE, texels=32): r"has \d+ x \d+ texels of 4 cells, this bake",
                replace(MORE, bucket=5): "texels of 4 cells, this bake .* of 5",
                MORE: "is of another mesh",
            },
        ),
        (replace(SPEC, layers=(Layer.GLOSSY,)), {MORE: "has layers"}),
    ],
)
def test_an_atlas_of_something_else_stays_what_it_is(
    out: Path, first: BakeSpec, specs: dict[BakeSpec, str]
) -> None:
    lit_ball()
    bake(out, first)
    before = contents(out)
    for spec, words in specs.items():
        if words == "is of another mesh":
            reshape()
        with pytest.raises(InputError, match=words):
            bake(out, spec)
        assert contents(out) == before


def test_nothing_to_accumulate_onto_is_said(out: Path) -> None:
    lit_ball()
    with pytest.raises(InputError, match=r"Ball\.radiance\.json is not there to accumulate onto: bake it"):
        bake(out, MORE)
    assert not out.exists()


def test_what_fails_leaves_the_atlas_and_is_resumed(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lit_ball()
    bake(out, SPEC)
    before = contents(out)

    def fail(*_: object) -> None:
        raise PlannedError

    with monkeypatch.context() as patch:
        patch.setattr(buckets, "write_bands", fail)
        with pytest.raises(PlannedError):
            bake(out, MORE)
    assert contents(out) == before
    made = bake_object(context.scene, "Ball", MORE, out, resume=True)
    np.testing.assert_allclose(
        read_buckets(made.files.sidecar)[0], bake(out / "at once", replace(SPEC, samples=8)), atol=1e-5
    )


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"kind": Kind.SHADOW}, "kind shadow cannot be accumulated"),
        ({"layers": (Layer.BASE,)}, "layers cannot be accumulated"),
        ({"kind": Kind.INCIDENT, "capture": CaptureMethod.PANORAMIC}, "capture panoramic cannot be"),
    ],
)
def test_what_cannot_be_accumulated_is_named(options: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        BakeSpec(accumulate=True, **options)


# refreshing: what a change touches is as if baked anew, all else stays, most paths are saved

FINE = BakeSpec(texels=48, bucket=4, samples=16, half=False, uv_layer="UVMap")
AGAIN = replace(FINE, refresh=True, samples=1)


def lit_card() -> Any:
    """A large card in dim light, a small lamp low over one of its corners; returns the lamp."""
    stage.world((0.1, 0.1, 0.1))
    stage.clamps_off()
    bpy.ops.mesh.primitive_plane_add(size=8)
    context.object.name = "Card"
    context.object.data.materials.append(
        stage.material("d", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1))
    )
    bpy.ops.object.light_add(type="SPOT", location=(-2.5, -2.5, 1.5))
    lamp = context.object
    lamp.data.energy, lamp.data.spot_size, lamp.data.shadow_soft_size = 100, 1.2, 0.1
    return lamp


def card(out: Path, spec: BakeSpec) -> tuple[Floats, BakeResult]:
    made = bake_object(context.scene, "Card", spec, out)
    return read_buckets(made.files.sidecar)[0], made


def test_what_has_changed_is_refreshed_and_all_else_stays(out: Path) -> None:
    lamp = lit_card()
    before, first = card(out, FINE)
    unchanged, made = card(out, AGAIN)
    assert np.array_equal(unchanged, before)
    assert made.paths < first.paths / 16
    lamp.data.energy = 300
    refreshed, made = card(out, AGAIN)
    anew, _ = card(out / "anew", FINE)
    print(f"\n{made.paths} paths of {first.paths}: {made.paths / first.paths:.2f}")
    assert made.paths < first.paths / 2
    changed = np.abs(anew - before).mean(axis=-1)
    left = np.abs(refreshed - anew).mean(axis=-1)
    print(f"error {left.mean():.5f} of a change of {changed.mean():.5f}, at most {left.max():.4f}")
    assert left.mean() < 0.05 * changed.mean()
    assert np.array_equal(refreshed[-40:, -40:], before[-40:, -40:]), "the far corner was touched"
    touched = (refreshed != before).any(axis=-1).mean()
    assert 0.05 < touched < 0.5
    assert read_sidecar(out / "Card.radiance.json").samples == 16
    stage.world((1, 1, 1))  # light that is everywhere
    refreshed, _ = card(out, AGAIN)
    assert np.array_equal(refreshed, card(out / "all anew", FINE)[0])


def test_a_change_of_colour_alone_is_found(out: Path) -> None:
    lamp = lit_card()
    lamp.data.color = (1, 0.2, 0.2)
    before, _ = card(out, FINE)
    lamp.data.color = (0.2, 1, 0.2)  # as bright, summed over the channels
    refreshed, _ = card(out, AGAIN)
    anew, _ = card(out / "anew", FINE)
    changed, left = (np.abs(anew - each).mean() for each in (before, refreshed))
    print(f"\nerror {left:.5f} of a change of {changed:.5f}")
    assert left < 0.05 * changed


def test_refreshing_and_accumulating_exclude_each_other(out: Path) -> None:
    with pytest.raises(InputError, match="contradict each other"):
        BakeSpec(accumulate=True, refresh=True)
    lit_card()
    with pytest.raises(InputError, match=r"Card\.radiance\.json is not there to refresh: bake it first"):
        card(out, AGAIN)
