# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Odd meshes: baked, or refused in one line with nothing left; never black or clear without a word."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from math import cos, inf, nan, pi, sin
from pathlib import Path
from typing import Any

import bmesh
import bpy
import numpy as np
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.job import bake_object, check_request
from radtex_addon.settings.spec import BakeSpec
from tests.blender import stage

context: Any = bpy.context
CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
UV = ((0, 0), (1, 0), (1, 1), (0, 1))
NEW = bpy.app.version >= (5, 0, 0)


def item(vertices: Sequence[Any], faces: Sequence[Any], edges: Sequence[Any] = (), uv: bool = False) -> Any:
    """A mesh object, on request with the unit square on its first face."""
    data: Any = bpy.data.meshes.new("Odd")
    data.from_pydata(vertices, edges, faces)
    if uv:
        layer = data.uv_layers.new(name="UVMap")
        for corner, place in zip(layer.uv, UV[: len(faces[0])], strict=False):
            corner.vector = place
    made = bpy.data.objects.new("Odd", data)
    context.scene.collection.objects.link(made)
    return made


def cube(scale: float = 1, far: float = 0) -> Any:
    bpy.ops.mesh.primitive_cube_add()
    context.object.name = "Odd"
    context.object.location.x = far
    context.object.scale = (scale,) * 3
    return context.object


def bake(out: Path, uv: str | None = None, **wishes: Any) -> np.ndarray[Any, Any]:
    """The colours of a small bake in white light, which is all that there is."""
    stage.world()
    if uv is None and "UVMap" in context.scene.objects["Odd"].data.uv_layers:  # quicker than an unwrap
        uv = "UVMap"
    spec = BakeSpec(texels=12, bucket=2, samples=1, uv_layer=uv, **wishes)
    files = bake_object(context.scene, "Odd", spec, out).files
    colours: np.ndarray[Any, Any] = read_atlas(files.atlas)[0][..., :3].astype(float)
    return colours


def with_coordinates(value: float, everywhere: bool = False) -> None:
    vertices = cube().data.vertices
    for vertex in vertices if everywhere else vertices[:1]:
        vertex.co.x = value


def with_normals(*normal: float) -> None:
    if not NEW:
        pytest.skip("this Blender keeps unit normals alone")
    made = cube().data.attributes.new("custom_normal", "FLOAT_VECTOR", "CORNER")
    made.data.foreach_set("vector", np.tile(np.array(normal, dtype=np.float32), 24))


def with_shape_key(value: float) -> None:
    made = cube()
    made.shape_key_add(name="Basis")
    key = made.shape_key_add(name="Key")
    key.data[0].co.x, key.value = value, 1


def thread() -> None:
    item([(0, 0, 0), (1, 0, 0), (1, 1e-9, 0)], [(0, 1, 2)])


REFUSED: dict[str, tuple[Callable[[], object], str]] = {
    "a vertex that is nan": (lambda: with_coordinates(nan), "1 vertices whose coordinates are not finite"),
    "all that are nan": (lambda: with_coordinates(nan, True), "8 vertices whose coordinates are not finite"),
    "an infinite vertex": (lambda: with_coordinates(-inf), "1 vertices whose coordinates are not finite"),
    "a shape key that is nan": (lambda: with_shape_key(nan), "1 vertices whose coordinates are not finite"),
    "a place that is nan": (lambda: cube(far=nan), "a transform that is not finite: reset it"),
    "no scale": (lambda: cube(0), "scaled to nothing along an axis"),
    "nearly no scale": (lambda: cube(1e-12), "is 3.46e-12 scene units across, Cycles traces 1e-06 to 1e"),
    "a huge scale": (lambda: cube(1e12), "is 3.46e.12 scene units across, Cycles traces 1e-06 to 1e"),
    "very far away": (lambda: cube(far=1e7), "stands 1e.07 scene units from the origin and is 3.46 across"),
    "normals that are nan": (lambda: with_normals(nan, 0, 1), "normals that are not finite"),
    "huge normals": (lambda: with_normals(0, 0, 1e30), "normals that are not finite"),
    "no faces": (lambda: item(CORNERS, []), "has no faces in renders"),
    "loose edges": (lambda: item(CORNERS, [], [(0, 1), (1, 2)]), "has no faces in renders"),
    "a vertex": (lambda: item([(0, 0, 0)], []), "has no faces in renders"),
    "nothing": (lambda: item([], []), "has no faces in renders"),
    "a face that is a point": (lambda: item([(0, 0, 0)] * 3, [(0, 1, 2)]), "has faces, but no area"),
    "a face that is a line": (
        lambda: item([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)]),
        "has faces, but no area",
    ),
    "a thread": (thread, "is as thin as a thread, with an edge of 1 scene units and an area of 5e-10"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_baked_is_one_line(case: str, out: Path, temporary: Path) -> None:
    make, words = REFUSED[case]
    make()
    with pytest.raises(InputError, match=f"object 'Odd'.*{words}") as refused:
        bake(out)
    assert "\n" not in str(refused.value)
    assert not out.exists()


@pytest.mark.parametrize("points", [[(0, 0, 0)] * 3, [(0, 0, 0), (1, 0, 0), (2, 0, 0)]])
def test_no_area_is_refused_on_a_layer_too(points: list[Any], out: Path, temporary: Path) -> None:
    item(points, [(0, 1, 2)], uv=True)
    with pytest.raises(InputError, match="object 'Odd' has faces, but no area to bake"):
        bake(out, "UVMap")
    assert not out.exists()


def star(spikes: int = 20) -> Any:
    reach = [2.0 if index % 2 else 0.5 for index in range(2 * spikes)]
    turn = pi / spikes
    corners = [(r * cos(i * turn), r * sin(i * turn), 0) for i, r in enumerate(reach)]
    return item(corners, [tuple(range(2 * spikes))])


def holed() -> Any:
    inside = [(0.3, 0.3, 0), (0.3, 0.6, 0), (0.6, 0.6, 0), (0.6, 0.3, 0)]
    return item(CORNERS + inside, [(0, 1, 2, 3, 0, 4, 5, 6, 7, 4)])


def wrong_material() -> Any:
    made = cube()
    made.data.materials.append(None)
    for face in made.data.polygons:
        face.material_index = 77
    return made


def unbound(kind: str) -> Any:
    made = cube()
    made.modifiers.new("unbound", kind)
    return made


def flat_and_points() -> Any:
    return item([*CORNERS, (2, 0, 0), (2, 0, 0), (2, 0, 0)], [(0, 1, 2, 3), (4, 5, 6)])


def fan() -> Any:
    """Four triangles on one edge."""
    ends = [(1, 0, 0.5), (-1, 0, 0.5), (0, 1, 0.5), (0, -1, 0.5)]
    return item([(0, 0, 0), (0, 0, 1), *ends], [(0, 1, 2 + index) for index in range(4)])


BAKED: dict[str, Callable[[], Any]] = {
    "no thickness": lambda: item(CORNERS, [(0, 1, 2, 3)]),
    "a triangle": lambda: item(CORNERS[:3], [(0, 1, 2)]),
    "some faces without area": flat_and_points,
    "a star of one face": star,
    "a face with a hole": holed,
    "an edge of four faces": fan,
    "a material that is not there": wrong_material,
    "an armature modifier without one": lambda: unbound("ARMATURE"),
    "a boolean modifier without an operand": lambda: unbound("BOOLEAN"),
    "very small": lambda: cube(1e-5),
    "very large": lambda: cube(1e7),
}


@pytest.mark.parametrize("case", BAKED)
def test_what_bakes_all_the_same(case: str, out: Path, temporary: Path) -> None:
    """A matt surface of 0.8 in white light is 0.8 where nothing else of it is seen."""
    BAKED[case]()
    colours = bake(out)
    assert np.isfinite(colours).all()
    assert 0.55 < np.median(colours) < 0.92
    assert len(list(out.iterdir())) == 2


def test_what_is_far_away_is_baked_with_a_warning(
    out: Path, temporary: Path, caplog: pytest.LogCaptureFixture
) -> None:
    cube(far=1e4)
    assert 0.7 < np.median(bake(out)) < 0.9
    assert "stands 1e+04 scene units from the origin" in caplog.text
    assert "move the scene to the origin" in caplog.text


def edited(made: Any, twice: bool = False, turned: Callable[[int], bool] = lambda _: False) -> None:
    """Join a mesh to a copy of itself, or turn some of its faces, by index, inside out."""
    shape = bmesh.new()
    shape.from_mesh(made.data)
    if twice:
        bmesh.ops.duplicate(shape, geom=[*shape.verts, *shape.edges, *shape.faces])
    bmesh.ops.reverse_faces(shape, faces=[face for face in shape.faces if turned(face.index)])
    shape.to_mesh(made.data)
    shape.free()


def test_faces_that_are_there_twice_are_told_and_baked_once(
    out: Path, temporary: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """On a UV layer on which they would overlap everywhere."""
    edited(cube(), twice=True)
    assert np.isfinite(bake(out)).all()
    assert "24 of the 24 triangles of object 'Odd' lie on one another, which Cycles shows as" in caplog.text
    assert "choose Mesh > Merge > By Distance" in caplog.text


def test_faces_that_are_turned_inside_out_are_told(
    out: Path, temporary: Path, caplog: pytest.LogCaptureFixture
) -> None:
    bpy.ops.mesh.primitive_uv_sphere_add()
    context.object.name = "Odd"
    context.object.data.uv_layers.remove(context.object.data.uv_layers[0])
    edited(context.object, turned=lambda index: index % 2 == 0)
    told = "faces of object 'Odd' are turned inside out: along .* of its edges neighbours face opposite"
    with pytest.raises(InputError, match=f"12 texels are too few .*, since {told}.*Recalculate Outside"):
        bake(out)
    assert re.search(f"{told}.*choose Mesh > Normals > Recalculate Outside", caplog.text)


def test_normals_that_look_inwards_or_nowhere(out: Path, temporary: Path) -> None:
    for number, normal in enumerate([(0, 0, 0), (0, 0, -1), (1e-30, 0, 0)]):
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        with_normals(*normal)
        assert np.isfinite(bake(out / str(number))).all()


@pytest.mark.one_blender
def test_ten_thousand_islands_want_texels(out: Path, temporary: Path) -> None:
    """On a layer of their own they bake; an unwrap says how many texels they need."""
    place = np.stack(np.meshgrid(np.arange(100), np.arange(100)), axis=-1).reshape(-1, 1, 2)
    corners = (place + np.array([[0, 0], [0.5, 0], [0, 0.5]])).reshape(-1, 2)
    faces = np.arange(len(corners)).reshape(-1, 3)
    made = item(np.column_stack([corners, np.zeros(len(corners))]).tolist(), faces.tolist())
    made.data.uv_layers.new(name="UVMap").uv.foreach_set("vector", (corners / 100).astype(np.float32).ravel())
    assert 0.7 < np.median(bake(out, "UVMap")) < 0.9


def test_missing_images_and_libraries_are_told(tmp_path: Path, out: Path) -> None:
    made = cube()
    material = stage.material("white", "ShaderNodeBsdfDiffuse")
    made.data.materials.append(material)
    node: Any = material.node_tree.nodes.new("ShaderNodeTexImage")
    image = bpy.data.images.new("gone", 4, 4)
    image.source, image.filepath = "FILE", "//nowhere/gone.png"
    node.image = image
    library = tmp_path / "library.blend"
    bpy.data.libraries.write(str(library), {bpy.data.meshes.new("linked")})
    blocks: Any = bpy.data
    with blocks.libraries.load(str(library), link=True) as (_, wanted):
        wanted.meshes = ["linked"]
    context.scene.collection.objects.link(bpy.data.objects.new("linked", wanted.meshes[0]))
    stage.world()
    spec = BakeSpec(texels=4, uv_layer="UVMap")
    said = check_request(context.scene, "Odd", spec, out, preview=False, overwrite=False)
    assert list(map(str, said)) == ["image 'gone' is missing, and shows magenta: put //nowhere/gone.png back"]
    library.unlink()
    said = check_request(context.scene, "Odd", spec, out, preview=False, overwrite=False)
    assert len(said) == 2
    assert "library.blend is missing, and all that is linked from it: put it back" in str(said[1])


@pytest.mark.one_blender
@pytest.mark.parametrize(
    "sizes",
    [
        {"texels": 10**8},
        {"bucket": 10**5},
        {"samples": 10**12},
        {"padding": 10**9},
        {"memory_mb": 10**12},
        {"texels": 65536, "bucket": 256},
        {"frame": 10**9},
        {"samples": 10**6, "layout": "layered"},
        {"texels": 20000, "layout": "layered"},
        {"texels": 20000, "kind": "transfer"},
    ],
)
def test_sizes_that_no_machine_has_are_refused_before_memory_is_taken(sizes: dict[str, Any]) -> None:
    with pytest.raises(
        InputError, match=r"give a whole number from|is the most: lower one|of memory, this"
    ) as refused:
        BakeSpec(**sizes)
    assert "\n" not in str(refused.value)
