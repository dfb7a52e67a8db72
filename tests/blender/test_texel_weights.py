# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Painted weights: a vertex group says where the unwrap gives more or fewer texels."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.piece_store import NO_STORE
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.core.errors import InputError
from radtex_addon.core.islands import find_overlap, signed_areas, surface_areas
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.job import bake_object
from radtex_addon.job.changed_bakes import BakeState, changes
from radtex_addon.prepare.unwrapping import unwrap_options, unwrap_surfaces
from radtex_addon.report.finished_bake import read_bake
from radtex_addon.report.mesh import find_mesh
from radtex_addon.scene.mesh.evaluated import EvaluatedMesh, evaluate
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.scene.uv.painted_sizes import times_as_many
from radtex_addon.settings.spec import BakeSpec, Unwrap

pytestmark = pytest.mark.one_blender

context: Any = bpy.context  # to the stubs, every pointer may be None
GROUP = "Texels"


def ball(radius: float = 0.3, x: float = 0.0) -> Any:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=radius, location=(x, 0, 0))
    item = context.object
    item.data.shade_smooth()
    return item


def paint(item: Any, weight: float, where: Callable[[Any], bool] = lambda _: True) -> Any:
    """Paint the object's vertices, of those at a place where it is asked for."""
    group = item.vertex_groups.get(GROUP) or item.vertex_groups.new(name=GROUP)
    group.add([vertex.index for vertex in item.data.vertices if where(vertex.co)], weight, "REPLACE")
    return item


def above(place: Any) -> bool:
    return bool(place.z > 0.01)


def unwrapped(
    *items: Any, painted: bool = True, texels: int = 128, **spec: Any
) -> list[tuple[EvaluatedMesh, Floats]]:
    """The objects' meshes, and their coordinates (F, 3, 2) in texels of the atlas that they share."""
    asked = BakeSpec(texels=texels, texel_weights=GROUP if painted else None, **spec)
    with scratch_scene(context.scene) as scratch:
        meshes = [evaluate(scratch, item, asked.texel_weights) for item in items]
    made = finished(unwrap_surfaces(meshes, asked, metres=1.0, store=NO_STORE, known={}))
    (part,) = made.parts
    assert find_overlap(np.concatenate(made.uvs)).fraction < 1e-3
    size = [part.width, part.height]
    return [(mesh, uv.astype(np.float64) * size) for mesh, uv in zip(meshes, made.uvs, strict=True)]


def along(mesh: EvaluatedMesh, uv: Floats, some: Bools | None = None) -> float:
    """Texels along a scene unit of the surface, in the mean over `some` of its triangles."""
    chosen = slice(None) if some is None else some
    surface = surface_areas(mesh.world_position[mesh.triangles[chosen]]).sum()
    return float(np.sqrt(np.abs(signed_areas(uv[chosen])).sum() / surface))


def upper(mesh: EvaluatedMesh) -> Bools:
    """Triangles well above the middle, and no others."""
    found: Bools = mesh.position[mesh.triangles][..., 2].min(axis=1) > 0.02
    return found


def lower(mesh: EvaluatedMesh) -> Bools:
    found: Bools = mesh.position[mesh.triangles][..., 2].max(axis=1) < -0.02
    return found


def test_weights_count_twice_as_usual_and_a_quarter() -> None:
    found = times_as_many(np.array([0, 0.25, 0.5, 0.75, 1]))
    assert found.tolist() == pytest.approx([0.25, 0.5, 1, 2**0.5, 2])


@pytest.mark.parametrize("method", [Unwrap.AUTO, Unwrap.UVUNWRAP, Unwrap.BLENDER])
def test_what_is_painted_has_more_texels(method: Unwrap) -> None:
    item = paint(paint(ball(), 0.5), 1.0, above)
    ((mesh, uv),) = unwrapped(item, unwrap=method)
    assert along(mesh, uv, upper(mesh)) == pytest.approx(2 * along(mesh, uv, lower(mesh)), rel=0.15)
    paint(item, 0.0, lambda place: not above(place))
    ((mesh, uv),) = unwrapped(item, unwrap=method, texels=256)
    assert along(mesh, uv, upper(mesh)) == pytest.approx(8 * along(mesh, uv, lower(mesh)), rel=0.2)


def test_a_half_everywhere_is_as_if_nothing_was_painted() -> None:
    item = ball()
    ((_, before),) = unwrapped(item, painted=False, unwrap=Unwrap.UVUNWRAP)
    ((_, after),) = unwrapped(paint(item, 0.5), unwrap=Unwrap.UVUNWRAP)
    assert after == pytest.approx(before)


def test_what_is_not_in_the_group_is_as_before() -> None:
    """Of the object as of another one in the same atlas that has no such group."""
    found = unwrapped(paint(ball(), 1.0, above), ball(x=2), texels=256)
    (painted, uv), (other, other_uv) = found
    usual = along(other, other_uv)
    assert along(painted, uv, lower(painted)) == pytest.approx(usual, rel=0.1)
    assert along(painted, uv, upper(painted)) == pytest.approx(2 * usual, rel=0.1)


def test_a_density_is_multiplied() -> None:
    """What has a half has the density, but for a row of faces at the border, whose weights are between."""
    ((mesh, before),) = unwrapped(ball(), painted=False, density=300.0)
    ((mesh, after),) = unwrapped(paint(context.object, 1.0, above), density=300.0)
    for some, times in ((lower(mesh), 1), (upper(mesh), 2)):
        assert along(mesh, after, some) == pytest.approx(times * along(mesh, before, some), rel=0.04)


def test_what_no_camera_can_see_gets_texels_where_they_are_painted() -> None:
    core, shell = paint(ball(0.2), 0.5), ball(0.4)
    for weight, least, most in ((0.0, 0.1, 0.4), (1.0, 1.5, 2.5)):
        (inner, outer) = unwrapped(paint(core, weight), shell)
        assert least < along(*inner) / along(*outer) < most


def test_modifiers_keep_what_is_painted() -> None:
    """Half a ball, mirrored and subdivided: both halves are painted, and no weight is lost in between."""
    item = paint(ball(), 1.0, above)
    item.modifiers.new("both", "MIRROR")
    item.modifiers.new("smooth", "SUBSURF").render_levels = 1
    ((mesh, uv),) = unwrapped(item, texels=256)
    assert len(mesh.triangles) > 4 * len(item.data.polygons)
    for side in (-1, 1):
        there = side * mesh.position[mesh.triangles][..., 0].mean(axis=1) > 0.02
        many, usual = along(mesh, uv, upper(mesh) & there), along(mesh, uv, lower(mesh) & there)
        assert many == pytest.approx(2 * usual, rel=0.15)


def test_geometry_nodes_may_make_the_weights() -> None:
    item = ball()
    tree: Any = bpy.data.node_groups.new("weights", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    start, end = (tree.nodes.new(f"NodeGroup{way}") for way in ("Input", "Output"))
    store, place, split = (
        tree.nodes.new(kind)
        for kind in ("GeometryNodeStoreNamedAttribute", "GeometryNodeInputPosition", "ShaderNodeSeparateXYZ")
    )
    store.inputs["Name"].default_value = GROUP
    more = tree.nodes.new("ShaderNodeMath")
    more.operation, more.inputs[1].default_value = "GREATER_THAN", 0.01
    for one, other in (
        (start.outputs[0], store.inputs["Geometry"]),
        (place.outputs[0], split.inputs[0]),
        (split.outputs["Z"], more.inputs[0]),
        (more.outputs[0], store.inputs["Value"]),
        (store.outputs[0], end.inputs[0]),
    ):
        tree.links.new(one, other)
    item.modifiers.new("nodes", "NODES").node_group = tree
    ((mesh, uv),) = unwrapped(item, texels=256)
    assert along(mesh, uv, upper(mesh)) == pytest.approx(8 * along(mesh, uv, lower(mesh)), rel=0.2)


def test_a_bake_has_the_texels_and_changes_with_the_paint(out: Path) -> None:
    """Also where the active UV layer would have been fit: it knows nothing of the paint."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=8, y_subdivisions=8)
    item = context.object
    spec = BakeSpec(texels=64, bucket=2, samples=1)
    plain = read_sidecar(bake_object(context.scene, item.name, spec, out / "plain").files.sidecar)
    assert plain.uv_map != "RadTex"
    paint(item, 1.0, lambda place: place.x > 0)
    spec = BakeSpec(texels=64, bucket=2, samples=1, texel_weights=GROUP)
    result = bake_object(context.scene, item.name, spec, out)
    sidecar = read_sidecar(result.files.sidecar)
    assert (sidecar.texel_weights, sidecar.uv_map) == (GROUP, "RadTex")
    assert changes(context.scene, item.name, spec, out).state is BakeState.UNCHANGED
    paint(item, 0.2, lambda place: place.x < 0)
    again = changes(context.scene, item.name, spec, out)
    assert (again.state, again.parts) == (BakeState.CHANGED, ("mesh",))


def test_a_group_that_nothing_has_is_refused_and_one_that_others_have_is_told(
    out: Path, caplog: pytest.LogCaptureFixture
) -> None:
    names = ball().name, ball(x=2).name
    context.scene.objects[names[0]].vertex_groups.new(name="Arm")
    spec = BakeSpec(texels=32, bucket=2, samples=1, texel_weights=GROUP, objects=names)
    with pytest.raises(InputError, match=rf"'{names[0]}' or '{names[1]}' has no .* '{GROUP}'.*'Arm'"):
        bake_object(context.scene, "Both", spec, out)
    paint(ball(x=4), 1.0)
    bake_object(context.scene, "Both", spec, out)
    assert f"no vertex group '{GROUP}' in renders" in caplog.text


@pytest.mark.parametrize("fields", [{"texel_weights": ""}, {"texel_weights": GROUP, "uv_layer": "Mine"}])
def test_weights_without_a_name_or_for_a_layer_of_ones_own_are_refused(fields: dict[str, str]) -> None:
    with pytest.raises(InputError, match="texel weights"):
        BakeSpec(**fields)  # type: ignore[arg-type]  # the fields are texts


def test_a_report_unwraps_again_as_it_was_painted(out: Path) -> None:
    """There is no preview: the layer is made anew, and has to fit the atlas."""
    item = paint(ball(), 1.0, above)
    spec = BakeSpec(texels=64, bucket=2, samples=1, texel_weights=GROUP)
    bake = read_bake(bake_object(context.scene, item.name, spec, out).files.sidecar)
    for weight, fits in ((1.0, True), (0.0, False)):
        paint(item, weight, above)
        with scratch_scene(context.scene) as scratch:
            options = unwrap_options(bake.spec("cpu"), 1.0)
            steps = find_mesh(scratch, find_object(scratch, item.name), bake, options)
            with nullcontext() if fits else pytest.raises(InputError, match="does not fit"):
                finished(steps)
