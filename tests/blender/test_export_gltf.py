# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The exported .glb: the bake's mesh and frame to the last bit, our extension, the session as it was."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import addon_utils
import bpy
import numpy as np
import pytest
from mathutils import Matrix, Quaternion
from PIL import Image

from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import normalised
from radtex_addon.core.sampler import Filter
from radtex_addon.core.surface import SurfaceMesh
from radtex_addon.export.export_manifest import read_manifest
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.gltf import extension_in, to_gltf
from radtex_addon.export.quantised import quantise
from radtex_addon.export.targets import web
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.job import bake_object
from radtex_addon.scene.mesh.copy import NORMAL, SIGN, TANGENT
from radtex_addon.scene.preview_file import baked_copy, surface_of
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.textures.export_spec import ExportSpec, MeshPacking, Target
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.lived_in import lived_in_scene

context: Any = bpy.context  # to the stubs, every pointer may be None

TINY = BakeSpec(texels=64, bucket=2, samples=1)


def wedge() -> Any:
    """A mesh with sharp and smooth edges and two materials, not at its origin."""
    place, turn = (1, -2, 0.5), (0.4, 0.2, 1.1)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, location=place, rotation=turn)
    item = context.object
    item.name = "Wedge"
    item.scale = (1, 1.5, 0.7)
    for polygon in item.data.polygons:
        polygon.use_smooth = polygon.center.z > -0.3
    for name in ("one", "two"):
        item.data.materials.append(stage.material(name, "ShaderNodeEmission", Color=(0.5, 0.3, 0.2, 1)))
        item.data.polygons[len(item.data.materials)].material_index = len(item.data.materials) - 1
    return item


def baked(name: str, folder: Path) -> Path:
    files = bake_object(context.scene, name, TINY, folder, preview=Filter.NEAREST).files
    return files.sidecar


@pytest.fixture(scope="module")
def of_wedge(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a wedge's bake and of its export, `made`; not to be written to."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    wedge()
    folder = tmp_path_factory.mktemp("wedge")
    addon_utils.disable("io_scene_gltf2", default_set=False)
    try:
        exported(baked("Wedge", folder), folder / "made")
        assert addon_utils.check("io_scene_gltf2")[1] is False, "an exporter that is off stays off"
    finally:
        addon_utils.enable("io_scene_gltf2", default_set=False)
    return folder


def exported(sidecar: Path, out: Path, target: Target = Target.GLTF) -> Glb:
    """An export whose mesh is not compressed."""
    made = finished(export_steps(sidecar, ExportSpec(target, mesh=MeshPacking.PLAIN), out))
    return Glb.read(out / f"{made.name}.glb")


@dataclass
class Corners:
    """A primitive's corners, one after the other."""

    position: Floats
    uv: Floats
    normal: Floats
    tangent: Floats


def corners(glb: Glb, mesh: int = 0) -> Corners:
    (primitive,) = glb.document["meshes"][mesh]["primitives"]
    index, named = glb.accessor(primitive["indices"]), primitive["attributes"]
    assert set(named) == {"POSITION", "TEXCOORD_0", "NORMAL", "TANGENT"}
    return Corners(
        *(glb.accessor(named[key])[index] for key in ("POSITION", "TEXCOORD_0", "NORMAL", "TANGENT"))
    )


def node_matrix(glb: Glb) -> Floats:
    """The node's matrix (4, 4), in glTF's axes."""
    (node,) = glb.document["nodes"]
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    move, scale = node.get("translation", (0, 0, 0)), node.get("scale", (1, 1, 1))
    return np.array(Matrix.LocRotScale(move, Quaternion((w, x, y, z)), scale))


def in_world(glb: Glb) -> SurfaceMesh:
    """What a program has of the file in the world, its normals unit, in glTF's axes."""
    found, matrix = corners(glb), node_matrix(glb)
    turn = matrix[:3, :3]
    mirrored = np.sign(np.linalg.det(turn))
    return SurfaceMesh(
        position=found.position @ turn.T + matrix[:3, 3],
        triangles=np.arange(len(found.position)).reshape(-1, 3),
        normal=normalised(found.normal @ np.linalg.inv(turn)),
        tangent=normalised(found.tangent[:, :3] @ turn.T),
        sign=found.tangent[:, 3] * mirrored,
        uv=found.uv,
    )


def test_the_frame_is_the_bakes_to_the_last_bit(of_wedge: Path) -> None:
    glb = Glb.read(of_wedge / "made" / "Wedge.glb")
    with baked_copy(of_wedge / "Wedge.preview.blend", ("Wedge",), "RadTex") as (_, copy):
        mesh: Any = copy.data
        count = len(mesh.loops)
        values = {NORMAL: np.empty((count, 3), np.float32), TANGENT: np.empty((count, 3), np.float32)}
        for name, array in values.items():
            mesh.attributes[name].data.foreach_get("vector", array.ravel())
        sign, uv = np.empty(count, np.float32), np.empty((count, 2), np.float32)
        mesh.attributes[SIGN].data.foreach_get("value", sign)
        mesh.uv_layers["RadTex"].uv.foreach_get("vector", uv.ravel())
        vertex = np.empty(count, np.int32)
        mesh.loops.foreach_get("vertex_index", vertex)
        place = np.empty((len(mesh.vertices), 3), np.float32)
        mesh.vertices.foreach_get("co", place.ravel())
    found = corners(glb)
    np.testing.assert_array_equal(found.position, to_gltf(place[vertex]))
    np.testing.assert_allclose(found.uv, uv * (1, -1) + (0, 1), atol=0.51 / 65535)  # 1 - v, in 16 bits
    for name, ours in ((NORMAL, found.normal), (TANGENT, found.tangent[:, :3])):
        unit = normalised(to_gltf(values[name]).astype(np.float64)).astype(np.float32)
        np.testing.assert_array_equal(ours, unit)
        np.testing.assert_allclose(ours, to_gltf(values[name]), atol=2e-7)  # it was unit before
    np.testing.assert_array_equal(found.tangent[:, 3], sign)
    assert set(np.unique(sign)) == {-1.0, 1.0} or set(np.unique(sign)) == {1.0}


FLOATS = {"POSITION": 5126, "NORMAL": 5126, "TANGENT": 5126, "TEXCOORD_0": 5126}
SHORT = FLOATS | {"TEXCOORD_0": 5123}
QUANTISED = SHORT | {"NORMAL": 5122, "TANGENT": 5122}
STORED = {Target.RAW: FLOATS, Target.GLTF: SHORT, Target.GODOT: SHORT, Target.WEB: QUANTISED}


@pytest.mark.usefixtures("any_page")
@pytest.mark.parametrize("target", STORED)
def test_vertices_have_the_bits_that_loaders_read(of_wedge: Path, target: Target, tmp_path: Path) -> None:
    sidecar = of_wedge / "Wedge.radiance.json"
    exact = corners(exported(sidecar, tmp_path / "exact", Target.RAW))
    glb = exported(sidecar, tmp_path / "made", target)
    found, document = corners(glb), glb.document
    (primitive,) = document["meshes"][0]["primitives"]
    accessors = {name: document["accessors"][index] for name, index in primitive["attributes"].items()}
    assert {name: each["componentType"] for name, each in accessors.items()} == STORED[target]
    for each in accessors.values():
        view = document["bufferViews"][each["bufferView"]]
        assert (view["byteLength"] / each["count"]) % 4 == 0
        assert view["byteOffset"] % 4 == 0
        assert each.get("normalized", False) is (each["componentType"] != 5126)
    # Beyond core glTF are the frame's bits alone, and a loader that does not read these must refuse.
    beyond = STORED[target] is QUANTISED
    for key in ("extensionsUsed", "extensionsRequired"):
        assert ("KHR_mesh_quantization" in document.get(key, [])) is beyond
    np.testing.assert_array_equal(found.position, exact.position)
    np.testing.assert_allclose(found.uv, exact.uv, atol=0.51 / 65535)
    np.testing.assert_allclose(found.normal, exact.normal, atol=0.51 / 32767)
    np.testing.assert_allclose(found.tangent, exact.tangent, atol=0.51 / 32767)
    np.testing.assert_array_equal(found.tangent[:, 3], exact.tangent[:, 3])


@pytest.mark.parametrize(("texels", "beyond"), [((4096, 64), 0.0), ((64, 64), 0.01)])
def test_coordinates_that_rounding_would_show_stay_floats(
    of_wedge: Path, texels: tuple[int, int], beyond: float
) -> None:
    """Of large atlases, and where images repeat."""
    glb = Glb.read(of_wedge / "made" / "Wedge.glb")
    (primitive,) = glb.document["meshes"][0]["primitives"]
    coordinates = glb.accessor(primitive["attributes"]["TEXCOORD_0"])
    coordinates[0, 0] = 1 + beyond
    primitive["attributes"]["TEXCOORD_0"] = glb.add_vertices(coordinates)
    exact = glb.accessor(primitive["attributes"]["TANGENT"])
    quantise(glb, Target.WEB.traits, texels)
    index = primitive["attributes"]["TEXCOORD_0"]
    assert glb.document["accessors"][index]["componentType"] == 5126
    np.testing.assert_array_equal(glb.accessor(index), coordinates)
    normal, tangent = (glb.accessor(primitive["attributes"][name]) for name in ("NORMAL", "TANGENT"))
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1, atol=1e-4)
    np.testing.assert_allclose(tangent, exact, atol=0.51 / 32767)


@pytest.fixture
def any_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A web page in place of the built one, which a clone has only once its zip was built."""
    folder = tmp_path / "page"
    folder.mkdir()
    for name in web.FILES:
        (folder / name).write_text(web._UNNAMED)
    monkeypatch.setattr(web, "BUILT", folder)


def mirrored() -> Any:
    item = wedge()
    item.scale = (1, -1.5, 0.7)
    return item


def sheared_and_mirrored() -> Any:
    item = wedge()
    bpy.ops.object.empty_add(rotation=(0.3, 0.5, 0.2))
    context.object.scale = (1, -3, 0.5)
    item.parent = context.object
    return item


def animated() -> Any:
    item = wedge()
    item.keyframe_insert("location", frame=1)
    item.location.x += 5
    item.keyframe_insert("location", frame=20)
    context.scene.frame_set(12)
    return item


@pytest.mark.parametrize("make", [mirrored, sheared_and_mirrored, animated])
def test_it_stands_in_the_world_as_the_bake_had_it(make: Any, out: Path, tmp_path: Path) -> None:
    item = make()
    context.view_layer.update()
    low, high = world_box(item)
    sidecar = baked("Wedge", out)
    found = in_world(exported(sidecar, tmp_path / "made"))
    place = found.position @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # back to z up
    np.testing.assert_allclose(place.min(axis=0), low, atol=1e-4)
    np.testing.assert_allclose(place.max(axis=0), high, atol=1e-4)
    with baked_copy(out / "Wedge.preview.blend", ("Wedge",), "RadTex") as (_, copy):
        surface = surface_of(copy, "RadTex")
    expected = surface.corner_position.reshape(-1, 3)
    np.testing.assert_allclose(found.position, to_gltf(expected), atol=1e-5)
    np.testing.assert_allclose(found.normal, to_gltf(normalised(surface.normal)).reshape(-1, 3), atol=1e-5)
    np.testing.assert_allclose(found.tangent, to_gltf(normalised(surface.tangent)).reshape(-1, 3), atol=1e-5)
    np.testing.assert_array_equal(found.sign, surface.sign.ravel())
    assert_v_grows_along_the_bitangent(found)


def world_box(item: Any) -> tuple[Floats, Floats]:
    place = np.array([item.matrix_world @ vertex.co for vertex in item.data.vertices])
    return place.min(axis=0), place.max(axis=0)


def assert_v_grows_along_the_bitangent(found: SurfaceMesh) -> None:
    """The sign is right: along sign cross(N, T), Blender's v grows, which is 1 - v here."""
    place, uv = found.position.reshape(-1, 3, 3), found.uv.reshape(-1, 3, 2).astype(np.float64)
    edges, steps = place[:, 1:] - place[:, :1], uv[:, 1:] - uv[:, :1]
    area = np.linalg.det(steps)
    whole = np.abs(area) > 1e-6
    along = np.linalg.inv(steps[whole]) @ edges[whole]  # position by u, by v
    bitangent = (found.sign[:, None] * np.cross(found.normal, found.tangent)).reshape(-1, 3, 3)[whole]
    same = np.einsum("fkc,fc->fk", bitangent, -along[:, 1])
    assert (same > 0).mean() > 0.99  # tangents are averaged, and slivers may turn


def test_the_material_says_it_to_us_and_to_others(of_wedge: Path) -> None:
    made = of_wedge / "made"
    glb = Glb.read(made / "Wedge.glb")
    (material,) = glb.document["materials"]
    manifest = read_manifest(made / "Wedge.export.json")
    facts = extension_in(material)
    assert "extras" not in material
    assert {key: facts[key] for key in facts if key != "textures"} == {
        key: value for key, value in manifest.facts().items() if key != "textures"
    }
    for texture in facts["textures"].values():
        assert (made / texture["uri"]).is_file()
    assert set(glb.document["extensionsUsed"]) == {"KHR_materials_unlit", "RADTEX_radiance_texture"}
    assert "extensionsRequired" not in glb.document
    (image,) = glb.document["images"]
    view = glb.document["bufferViews"][image["bufferView"]]
    png = bytes(glb.buffer[view["byteOffset"] :][: view["byteLength"]])
    assert png == (made / manifest.flat).read_bytes()
    assert Image.open(io.BytesIO(png)).size == tuple(manifest.bake["texels"])
    assert material["pbrMetallicRoughness"]["baseColorTexture"]["index"] == 0
    assert [node["name"] for node in glb.document["nodes"]] == ["Wedge"]


@pytest.mark.one_blender
def test_the_session_is_as_it_was(out: Path, tmp_path: Path) -> None:
    name = lived_in_scene().name
    sidecar = baked(name, out)
    before = fingerprint()
    exported(sidecar, tmp_path / "made")
    assert differences(before, fingerprint()) == {}
