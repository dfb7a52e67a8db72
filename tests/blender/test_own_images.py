# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that are texture sets: which are, what a bake says of them, and what shows them."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from mathutils import Matrix, Vector
from PIL import Image as PilImage
from PIL.PngImagePlugin import PngInfo

from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import normalised
from radtex_addon.export.export_manifest import read_manifest
from radtex_addon.export.exporting import Exported, export_steps
from radtex_addon.export.exporting_scene import export_scene_steps
from radtex_addon.export.gltf import extension_in
from radtex_addon.export.image_files import EXTEND, REPEAT, move_images
from radtex_addon.export.material_images import _metal_and_roughness, _pictures
from radtex_addon.export.unity_unreal import baked_matrix
from radtex_addon.formats.containers.exr import read_render
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.formats.sidecar_file import opened
from radtex_addon.forms.hlsl_lookup import IMAGE_TEXTURES
from radtex_addon.forms.layered.files.layered_files import read_layered_sidecar
from radtex_addon.forms.layered.files.sidecar import LayeredSidecar
from radtex_addon.forms.layered.preview.material import preview_layered_material
from radtex_addon.scene.image_materials import find_image_material
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.blender.image_stage import (
    NAME,
    SCENE,
    SIDE,
    UVS,
    bake_crate,
    bake_pair,
    bake_sheet,
    image,
    squares,
    texture_set,
)
from tests.blender.lookup_stage import set_up_render
from tests.finished_bakes import finished_bake
from tests.gltf_schema import problems
from tests.reference.importers import attributes_of

context: Any = bpy.context  # to the stubs, every pointer may be None
REPLACED = {"colour", "tint", "normal"}


def sidecar_of(folder: Path) -> Path:
    return folder / f"{NAME}.radiance.json"


@pytest.fixture(scope="module")
def baked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return finished_bake(tmp_path_factory.mktemp("crate"), bake_crate)


@pytest.fixture(scope="module")
def mixed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return finished_bake(tmp_path_factory.mktemp("mixed"), bake_crate, mixed=True)


def exported(folder: Path, out: Path, target: Target = Target.GLTF, **settings: Any) -> Exported:
    return finished(export_steps(sidecar_of(folder), ExportSpec(target, **settings), out))


def test_a_material_of_images_is_found() -> None:
    found = find_image_material(texture_set(), UVS)
    assert found is not None
    assert found.uv_map == UVS
    assert [source and (source.image.name, source.channel) for source in found.sources] == [
        ("Painted colour", None),
        ("Painted metal", 2),
        ("Painted metal", 1),
        ("Painted normal", None),
    ]
    assert (found.base, found.metallic, found.roughness, found.strength) == ((1, 1, 1), 1, 1, 1)


def _insert(tree: Any, kind: str, **settings: Any) -> Any:
    """A node between the colour's image and the shader."""
    node = tree.nodes.new(kind)
    for key, value in settings.items():
        setattr(node, key, value)
    return node


def _factor(tree: Any, shader: Any) -> None:
    """As the importer makes a baseColorFactor."""
    mix = _insert(tree, "ShaderNodeMix", data_type="RGBA", blend_type="MULTIPLY")
    factor, one, other = (each for each in mix.inputs if each.enabled)
    factor.default_value, other.default_value = 1, (0.5, 0.25, 1, 1)
    tree.links.new(tree.nodes["colour"].outputs["Color"], one)
    tree.links.new(next(each for each in mix.outputs if each.enabled), shader.inputs["Base Color"])


def test_a_constant_factor_is_told() -> None:
    material: Any = texture_set()
    _factor(material.node_tree, _shader(material.node_tree))
    found = find_image_material(material, UVS)
    assert found is not None
    np.testing.assert_allclose(found.base, (0.5, 0.25, 1))


def _shader(tree: Any) -> Any:
    return next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")


def _noise(tree: Any, shader: Any) -> None:
    tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs["Color"], shader.inputs["Base Color"])


def _contrast(tree: Any, shader: Any) -> None:
    node = tree.nodes.new("ShaderNodeBrightContrast")
    tree.links.new(tree.nodes["colour"].outputs["Color"], node.inputs["Color"])
    tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])


def _moved(tree: Any, shader: Any) -> None:
    mapping = tree.nodes.new("ShaderNodeMapping")
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["UV"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], tree.nodes["colour"].inputs["Vector"])


def _other_layer(tree: Any, shader: Any) -> None:
    node = tree.nodes.new("ShaderNodeUVMap")
    node.uv_map = "Another"
    tree.links.new(node.outputs["UV"], tree.nodes["colour"].inputs["Vector"])


def _coat(tree: Any, shader: Any) -> None:
    shader.inputs["Coat Weight"].default_value = 0.5


def _glow(tree: Any, shader: Any) -> None:
    shader.inputs["Emission Strength"].default_value = 1


def _data_as_colour(tree: Any, shader: Any) -> None:
    tree.nodes["colour"].image.colorspace_settings.name = "Non-Color"


def _clipped(tree: Any, shader: Any) -> None:
    tree.nodes["colour"].extension = "CLIP"


def _lost(tree: Any, shader: Any) -> None:
    tree.nodes["colour"].image = None


def _lost_file(tree: Any, shader: Any) -> None:
    image = tree.nodes["colour"].image
    image.unpack(method="REMOVE")
    image.source, image.filepath = "FILE", "//gone.png"


def _mixed(tree: Any, shader: Any) -> None:
    add = tree.nodes.new("ShaderNodeAddShader")
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(shader.outputs[0], add.inputs[0])
    tree.links.new(add.outputs[0], output.inputs["Surface"])


@pytest.mark.parametrize(
    "change",
    [
        _noise,
        _contrast,
        _moved,
        _other_layer,
        _coat,
        _glow,
        _data_as_colour,
        _clipped,
        _lost,
        _lost_file,
        _mixed,
    ],
)
def test_any_other_material_is_none(change: Callable[[Any, Any], None]) -> None:
    material: Any = texture_set()
    change(material.node_tree, _shader(material.node_tree))
    assert find_image_material(material, UVS) is None


def test_the_sidecar_tells_how_images_give_the_colours(baked: Path) -> None:
    facts = read_layered_sidecar(opened(sidecar_of(baked)))
    (look,) = facts.looks
    assert look is not None
    assert (look.uv_map, look.metallic, look.strength) == (UVS, 1, 1)
    np.testing.assert_allclose(look.diffuse, 1, atol=0.1)
    # metal reflects about all of its colour, what is no metal about 4 %
    np.testing.assert_allclose(np.array(look.metal) / look.dielectric, 1 / 0.04, rtol=0.25)
    assert LayeredSidecar.from_json(facts.to_json()).looks == facts.looks


def test_only_some_materials_are_images(mixed: Path) -> None:
    first, second = read_layered_sidecar(opened(sidecar_of(mixed))).looks
    assert first is not None
    assert second is None


def shot(path: Path, name: str, material: bpy.types.Material | None = None, behind: bool = False) -> Floats:
    """A side of what the open file shows, from above or from `behind`, by Cycles: (H, W, 3)."""
    scene = context.scene
    item = scene.objects[name]
    if material is not None:
        for slot in item.material_slots:
            slot.material = material
    data: Any = bpy.data.cameras.new("Close")
    data.type, data.ortho_scale = "ORTHO", 0.7
    camera = bpy.data.objects.new("Close", data)
    camera.matrix_world = item.matrix_world
    if behind:
        camera.matrix_world = item.matrix_world @ Matrix.Rotation(np.pi, 4, "X")
    camera.location = item.matrix_world @ Vector((0.1, 0.2, -3 if behind else 3))
    scene.collection.objects.link(camera)
    scene.camera = camera
    set_up_render(scene, "CYCLES")
    scene.cycles.samples = 64 if material is None and path.stem == "cycles" else 4
    scene.render.resolution_x = scene.render.resolution_y = 96
    scene.render.resolution_percentage = 100
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    (picture,) = read_render(path).values()
    return picture[..., :3].astype(np.float64)


def psnr(one: Floats, other: Floats) -> float:
    shown = [np.clip(each, 0, 1) ** (1 / 2.2) for each in (one, other)]
    return float(-10 * np.log10(np.mean((shown[0] - shown[1]) ** 2)))


def test_a_close_up_of_the_preview_is_as_sharp_as_the_images(baked: Path, tmp_path: Path) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(baked / SCENE), load_ui=False)
    truth = shot(tmp_path / "cycles.exr", NAME)
    bpy.ops.wm.open_mainfile(filepath=str(baked / f"{NAME}.preview.blend"), load_ui=False)
    read = {Path(each.filepath).name for each in bpy.data.images}
    assert not {f"{NAME}.radiance.{layer}.exr" for layer in REPLACED} & read
    ours = psnr(shot(tmp_path / "images.exr", NAME), truth)
    maps = preview_layered_material("Maps", sidecar_of(baked), "RadTex")
    by_maps = psnr(shot(tmp_path / "maps.exr", NAME, maps), truth)
    print(f"by its images {ours:.1f} dB, by maps {by_maps:.1f} dB")
    assert ours > 24
    assert ours > by_maps + 1.5


def test_a_normal_map_is_seen_from_behind_as_in_the_maps_that_cycles_renders(tmp_path: Path) -> None:
    folder = finished_bake(tmp_path / "sheet", bake_sheet)
    bpy.ops.wm.open_mainfile(filepath=str(folder / f"{NAME}.preview.blend"), load_ui=False)
    ours = [shot(tmp_path / "images.exr", NAME, behind=behind) for behind in (False, True)]
    maps = preview_layered_material("Maps", sidecar_of(folder), "RadTex", hull=True)
    seen = [shot(tmp_path / "maps.exr", NAME, maps, behind=behind) for behind in (False, True)]
    front, back = (psnr(one, other) for one, other in zip(ours, seen, strict=True))
    print(f"front {front:.1f} dB, back {back:.1f} dB")
    assert back > front - 1.1  # 1.6 dB less if a back's normal map is not turned
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    glb = Glb.read(exported(folder, tmp_path / "made").folder / f"{NAME}.glb")
    (primitive,) = glb.document["meshes"][0]["primitives"]
    tangent, normal = (glb.accessor(primitive["attributes"][name]) for name in ("TANGENT", "NORMAL"))
    up = normal @ normal[0] > 0
    sides = [np.unique(np.round(tangent[some], 3), axis=0) for some in (up, ~up)]
    np.testing.assert_allclose(sides[0], -sides[1], atol=2e-3)  # both directions, and the sign


def test_an_export_has_the_images_once_and_light_alone(baked: Path, tmp_path: Path) -> None:
    made = exported(baked, tmp_path / "made")
    manifest = read_manifest(made.folder / f"{NAME}.export.json")
    assert manifest.images
    assert not REPLACED & set(manifest.textures)
    glb = Glb.read(made.folder / f"{NAME}.glb")
    document = glb.document
    assert len(document["images"]) == 3
    for listed in document["images"]:
        view = document["bufferViews"][listed["bufferView"]]
        data = bytes(glb.buffer[view["byteOffset"] : view["byteOffset"] + view["byteLength"]])
        assert data.startswith(b"\x89PNG")
        assert listed["name"] not in bpy.data.images  # what was loaded is gone
    (material,) = document["materials"]
    assert problems(extension_in(material)) == []
    readme = (made.folder / "README.txt").read_text()
    assert "TEXCOORD_1 the baked UV layer" in readme
    assert "also inside the mesh's file" not in readme
    assert "KHR_materials_unlit" not in document["extensionsUsed"]
    assert {"baseColorTexture", "metallicRoughnessTexture"} <= set(material["pbrMetallicRoughness"])
    assert material["normalTexture"]["scale"] == 1
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    light, images = (glb.accessor(attributes[f"TEXCOORD_{number}"]) for number in (1, 0))
    assert len(np.unique(np.round(images, 4), axis=0)) == 14  # of Blender's cube
    assert len(np.unique(np.round(light, 4), axis=0)) == 24


def test_an_image_of_metal_and_roughness_has_these_alone(tmp_path: Path) -> None:
    """Occlusion beside them, which no lookup reads, is white; what else a file tells is left out."""
    rng = np.random.default_rng(3)
    levels = rng.integers(0, 256, (SIDE, SIDE, 4), dtype=np.uint8)
    texts = PngInfo()
    texts.add_text("Raw profile type exif", "0" * 9000, zip=True)
    buffer = io.BytesIO()
    PilImage.fromarray(levels, "RGBA").save(buffer, "PNG", pnginfo=texts)
    material: Any = texture_set()
    for key in ("metal", "normal"):
        made: Any = material.node_tree.nodes[key].image
        made.pack(data=buffer.getvalue(), data_len=len(buffer.getvalue()))
        made.source = "FILE"
        made.reload()
    own = find_image_material(material, UVS)
    assert own is not None
    found = _pictures(own, 2048)
    assert found.metal is not None
    assert found.normal is not None
    metal = np.asarray(PilImage.open(io.BytesIO(found.metal.data)))
    np.testing.assert_array_equal(metal, np.dstack([np.full((SIDE, SIDE), 255), levels[..., 1:3]]))
    assert len(found.metal.data) < 0.65 * len(found.normal.data)
    np.testing.assert_array_equal(np.asarray(PilImage.open(io.BytesIO(found.normal.data))), levels)
    assert b"Raw profile" not in found.normal.data
    assert len(bpy.data.images) == 3


def test_tangents_are_those_of_the_images(baked: Path, tmp_path: Path) -> None:
    made = exported(baked, tmp_path / "made")
    glb = Glb.read(made.folder / f"{NAME}.glb")
    (primitive,) = glb.document["meshes"][0]["primitives"]
    place, uv, tangent = (
        glb.accessor(primitive["attributes"][name]) for name in ("POSITION", "TEXCOORD_0", "TANGENT")
    )
    for corners in glb.accessor(primitive["indices"]).reshape(-1, 3):
        sides, along = place[corners[1:]] - place[corners[0]], uv[corners[1:]] - uv[corners[0]]
        towards_u = np.linalg.solve(along, sides)[0]
        np.testing.assert_allclose(
            tangent[corners, :3], np.tile(towards_u / np.linalg.norm(towards_u), (3, 1)), atol=1e-4
        )


@pytest.mark.parametrize(
    ("target", "settings"),
    [(Target.RAW, {}), (Target.GLTF, {"image_limit": 0}), (Target.UNITY, {"image_limit": 0})],
)
def test_other_exports_have_the_bakes_maps(
    target: Target, settings: dict[str, Any], baked: Path, tmp_path: Path
) -> None:
    made = exported(baked, tmp_path / "made", target, **settings)
    facts = json.loads((made.folder / f"{NAME}.export.json").read_text())
    assert "images" not in facts
    assert {"colour", "normal"} <= set(facts["textures"])
    assert "radtex_images" not in facts["shader"]["materials"][0]
    document = Glb.read(made.folder / f"{NAME}.glb").document
    assert len(document["images"]) == 1


@pytest.mark.parametrize("target", [Target.UNITY, Target.UNREAL])
def test_engines_have_images_as_files(target: Target, mixed: Path, tmp_path: Path) -> None:
    folders = {each: exported(mixed, tmp_path / each, each).folder for each in (target, Target.GLTF)}
    ours, plain = (Glb.read(folder / f"{NAME}.glb") for folder in folders.values())
    inside = {each["name"]: each["bufferView"] for each in plain.document["images"]}
    for kind in ("colour", "metal", "normal"):
        number = next(view for name, view in inside.items() if f"Painted {kind}" in name)
        view = plain.document["bufferViews"][number]
        data = plain.buffer[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        assert (folders[target] / f"{NAME}.image.Painted_{kind}.png").read_bytes() == data
    assert [each["name"] for each in ours.document["images"]] == [f"{NAME}.flat.png"]  # of the other material
    first, second = ours.document["materials"]
    assert "baseColorTexture" not in first["pbrMetallicRoughness"]
    assert second["pbrMetallicRoughness"]["baseColorTexture"]["index"] == 0
    baked = baked_matrix(plain)[:, :3]
    for number in range(2):
        found, before = attributes_of(ours, number), attributes_of(plain, number)
        for name in ("TEXCOORD_0", "TEXCOORD_1"):
            np.testing.assert_allclose(found[name], before[name], atol=1e-5)
        tangent, normal = (
            normalised(values)
            for values in (before["TANGENT"][:, :3] @ baked.T, before["NORMAL"] @ np.linalg.inv(baked))
        )
        np.testing.assert_allclose(found["TEXCOORD_2"], tangent[:, :2], atol=1e-5)
        np.testing.assert_allclose(found["TEXCOORD_4"], normal[:, :2], atol=1e-5)
    readme = (folders[target] / "README.txt").read_text()
    assert f"{NAME}.image.Painted_normal.png: normal map, y up" in readme
    assert "TEXCOORD_1 the baked UV layer" in readme
    assert "also inside the mesh's file" in readme  # the flat lightmap of the other material


def test_images_are_made_as_small_as_the_limit(baked: Path, tmp_path: Path) -> None:
    small, whole = (
        exported(baked, tmp_path / str(limit), image_limit=limit).folder / f"{NAME}.glb"
        for limit in (16, 2048)
    )
    found = Glb.read(small)
    for listed in found.document["images"]:
        view = found.document["bufferViews"][listed["bufferView"]]
        head = found.buffer[view["byteOffset"] + 16 : view["byteOffset"] + 24]
        assert np.frombuffer(head, ">u4").tolist() == [16, 16]
    assert SIDE > 16
    assert small.stat().st_size < whole.stat().st_size


def test_by_material(mixed: Path, tmp_path: Path) -> None:
    """One material has its images, the other the bake's maps and the flat lightmap."""
    made = exported(mixed, tmp_path / "made")
    manifest = read_manifest(made.folder / f"{NAME}.export.json")
    assert manifest.images
    assert "colour" in manifest.textures
    glb = Glb.read(made.folder / f"{NAME}.glb")
    first, second = glb.document["materials"]
    assert problems(extension_in(first)) == problems(extension_in(second)) == []
    assert "normalTexture" in first
    assert "extensions" not in first
    assert "normalTexture" not in second
    assert "KHR_materials_unlit" in second["extensions"]
    facts = extension_in(first)["shader"]["materials"]
    assert ["radtex_images" in each for each in facts] == [True, False]
    other = glb.document["meshes"][0]["primitives"][1]["attributes"]
    np.testing.assert_array_equal(glb.accessor(other["TEXCOORD_0"]), glb.accessor(other["TEXCOORD_1"]))


def test_objects_that_share_an_atlas_keep_their_own_images(tmp_path: Path) -> None:
    folder = finished_bake(tmp_path / "pair", bake_pair)
    bpy.ops.wm.open_mainfile(filepath=str(folder / f"{NAME}.preview.blend"), load_ui=False)
    for number in range(2):
        (slot,) = context.scene.objects[f"{NAME} {number}"].material_slots
        images = {each.image.name for each in slot.material.node_tree.nodes if each.type == "TEX_IMAGE"}
        assert images == {f"Set {number} {kind}" for kind in ("colour", "metal", "normal")}
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    made = exported(folder, tmp_path / "made")
    whole = Glb.read(made.folder / f"{NAME}.glb").document
    steps = export_scene_steps([sidecar_of(folder)], ExportSpec(Target.GLTF), "Hall", tmp_path / "scene")
    scene = Glb.read(finished(steps).folder / "Hall.glb").document
    for document in (whole, scene):
        assert len(document["images"]) == 4  # the metal's and the normal's are the same
        bases = [each["pbrMetallicRoughness"]["baseColorTexture"]["index"] for each in document["materials"]]
        names = [document["images"][document["textures"][index]["source"]]["name"] for index in bases]
        assert names == ["Set 0 colour", "Set 1 colour"]
    assert len(scene["nodes"]) == 2


def test_a_scene_has_them_too(baked: Path, tmp_path: Path) -> None:
    steps = export_scene_steps([sidecar_of(baked)], ExportSpec(Target.GLTF), "Hall", tmp_path / "made")
    made = finished(steps)
    document = Glb.read(made.folder / "Hall.glb").document
    assert len(document["images"]) == 3
    (material,) = document["materials"]
    assert problems(extension_in(material)) == []


def test_a_lost_image_is_told_and_the_maps_are_exported(
    baked: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    preview = baked / f"{NAME}.preview.blend"
    bpy.ops.wm.open_mainfile(filepath=str(preview), load_ui=False)
    lost = next(each for each in bpy.data.images if each.name == "Painted metal")
    lost.unpack(method="REMOVE")
    lost.filepath = "//gone.png"
    copy = tmp_path / "copy"
    copy.mkdir()
    for each in baked.iterdir():
        if each.is_file() and each != preview:
            (copy / each.name).write_bytes(each.read_bytes())
    bpy.ops.wm.save_as_mainfile(filepath=str(copy / preview.name))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    made = exported(copy, tmp_path / "made")
    assert "image 'Painted metal' is missing" in caplog.text
    assert not read_manifest(made.folder / f"{NAME}.export.json").images


def test_metal_and_roughness_of_two_images_become_one(tmp_path: Path) -> None:
    material: Any = texture_set()
    tree = material.node_tree
    shader = _shader(tree)
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image("Rough", squares((0.2, 0.2, 0.2), (0.6, 0.6, 0.6))[:32, :32])
    tree.links.new(node.outputs["Color"], shader.inputs["Roughness"])
    own = find_image_material(material, UVS)
    assert own is not None
    made = _metal_and_roughness(own, own.metallic_image, own.roughness_image, 2048)
    assert made is not None
    (tmp_path / "made.png").write_bytes(made.data)
    read: Any = bpy.data.images.load(str(tmp_path / "made.png"))
    read.colorspace_settings.name = "Non-Color"
    pixels = np.array(read.pixels[:]).reshape(SIDE, SIDE, 4)
    metal, rough = squares((0,), (1,), 2)[..., 0], squares((0.2,), (0.6,))[:32, :32, 0]
    np.testing.assert_allclose(pixels[..., 2], metal, atol=3e-3)
    np.testing.assert_allclose(pixels[::2, ::2, 1], rough, atol=3e-3)


def test_a_file_is_imported_in_one_way(tmp_path: Path) -> None:
    """An image that is used in two ways is two files; names that are alike or odd become different ones."""
    glb = Glb({"samplers": [{"wrapS": REPEAT}, {"wrapS": EXTEND}], "images": [], "textures": []}, bytearray())
    document = glb.document
    kinds = ("png", "jpeg", "png")
    for k, name in enumerate(["Rust/1.png", "rust 1.PNG.001", "\u9306"]):
        view = glb.add_view(bytes([k]))
        document["images"].append({"bufferView": view, "mimeType": f"image/{kinds[k]}", "name": name})
    for source, sampler in ((0, 0), (1, 0), (2, 0), (0, 1)):
        document["textures"].append({"source": source, "sampler": sampler})

    def material(name: str, base: int, metal: int | None, bump: int | None) -> dict[str, Any]:
        shading = {"baseColorTexture": {"index": base}}
        shading |= {} if metal is None else {"metallicRoughnessTexture": {"index": metal}}
        more = {} if bump is None else {"normalTexture": {"index": bump}}
        return {"name": name, "pbrMetallicRoughness": shading, **more}

    document["extensionsUsed"] = ["KHR_materials_unlit", "another"]
    document["materials"] = [
        *(material("a", 0, 1, 2), material("b", 3, 0, None), material("c", 0, None, 2)),
        material("not by images", 0, None, None) | {"extensions": {"KHR_materials_unlit": {}}},
    ]
    numbers = {"a": 4, "b": 0, "c": 2, "not by images": 1}
    found = move_images(glb, numbers, {0, 2, 4}, tmp_path / "Vase")
    assert all([each.texture for each in row] == [*IMAGE_TEXTURES] for row in found.values())
    names = {number: [each.file.split(".")[2] for each in row] for number, row in found.items()}
    assert names == {
        4: ["Rust_1", "rust_1_2", "image"],
        0: ["Rust_1_3", "Rust_1_4", "flat"],
        2: ["Rust_1", "white", "image"],
    }
    files = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert files["Vase.image.Rust_1.png"] == files["Vase.image.Rust_1_4.png"] == b"\0"
    assert files["Vase.image.rust_1_2.jpg"] == b"\1"
    assert found[0][0].wrap == EXTEND
    flat = np.asarray(PilImage.open(tmp_path / "Vase.image.flat.png"))
    assert np.abs(flat.astype(int) - [128, 128, 255]).max() <= 1
    assert document["textures"] == [{"source": 0, "sampler": 0}]
    assert [each["name"] for each in document["images"]] == ["Rust/1.png"]
    assert document["extensionsUsed"] == ["KHR_materials_unlit"]
