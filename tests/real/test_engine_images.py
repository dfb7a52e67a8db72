# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports for Unity and Unreal whose materials are shown by their own images, against the preview.

Neither engine was run: their importers are emulated, and the exported shaders executed (`test_unity`,
`test_unreal`), one lookup for each pixel that a camera sees of the exported mesh.
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as PilImage

from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.export.export_manifest import read_manifest
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.image_files import BASE
from radtex_addon.export.unity_unreal import baked_matrix, material_numbers
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.forms.hlsl_lookup import IMAGE_TEXTURES
from radtex_addon.report.metrics import Mask, Picture
from radtex_addon.textures.export_spec import ExportSpec, Target, TextureFormat
from tests.blender.image_stage import NAME
from tests.lookups import SIDE
from tests.real import test_unity, test_unreal
from tests.real.engine_lookups import Asked, imported
from tests.real.engines import HEADERS, Compilers, Mesh, by_dxc
from tests.real.exhibit import Bake, Camera, decibels
from tests.real.preview_shot import Shots
from tests.real.unreal_editor import Editor
from tests.real.webgpu import Texture, image
from tests.reference.importers import attributes_of

CAMERAS = (
    Camera("whole", (3.6, -4.4, 3.2), (0.3, -0.2, 0.5), pixels=SIDE),
    Camera("near", (0.9, -1.6, 3.0), (0.5, -0.35, 1.4), fovy=20.0, pixels=SIDE),
)
LEAST = 36.0  # dB
FILES = [f"{NAME}.image.Painted_{kind}.png" for kind in ("colour", "metal", "normal")]


@pytest.fixture(scope="module")
def wanted(crate: Bake, tmp_path_factory: pytest.TempPathFactory) -> list[Picture]:
    """The preview, as Cycles shows it."""
    return Shots(crate.preview, "cycles", tmp_path_factory.mktemp("shots"), NAME).pictures(CAMERAS)


def exported(crate: Bake, target: Target, folder: Path) -> Path:
    spec = ExportSpec(target, format=TextureFormat.DDS_RGBA16F)
    return finished(export_steps(crate.sidecar, spec, folder / target)).folder


@dataclass(frozen=True, eq=False)
class Seen:
    """What a camera sees of an exported mesh: attributes of vertices, by pixel; `place` is in the bake."""

    attributes: dict[str, Floats]
    place: Floats
    material: Ints
    hit: Mask


def seen_by(camera: Camera, glb: Glb) -> Seen:
    baked, rays = baked_matrix(glb), camera.rays
    count, numbers = len(rays.away), list(material_numbers(glb).values())
    near, material = np.full(count, np.inf), np.full(count, numbers[0])
    found: dict[str, Floats] = {}
    for k, primitive in enumerate(glb.document["meshes"][0]["primitives"]):
        values = attributes_of(glb, k)
        places = values["POSITION"].astype(float) @ baked[:, :3].T + baked[:, 3]
        found = found or {name: np.zeros((count, each.shape[1])) for name, each in values.items()}
        for corners in glb.accessor(primitive["indices"]).reshape(-1, 3):
            first, second, third = places[corners]
            sides = np.broadcast_to(np.stack([second - first, third - first], axis=1), (count, 3, 2))
            across = np.linalg.inv(np.dstack([sides, -rays.away])) @ (np.asarray(camera.place) - first)
            weight = np.column_stack([1 - across[:, 0] - across[:, 1], across[:, :2]])
            nearer = (weight >= 0).all(axis=1) & (across[:, 2] > 0) & (across[:, 2] < near)
            near[nearer] = across[nearer, 2]
            material[nearer] = numbers[primitive["material"]]
            for name, each in values.items():
                found[name][nearer] = weight[nearer] @ each[corners]
    hit = np.isfinite(near)
    place = np.asarray(camera.place) + np.where(hit, near, 1)[:, None] * rays.away
    return Seen({name: each.astype(np.float32) for name, each in found.items()}, place, material, hit)


def read_dds(path: Path) -> Texture:
    """A DDS of half floats with its mip levels."""
    data = path.read_bytes()
    height, width = np.frombuffer(data, "<u4", 2, 12)
    assert np.frombuffer(data, "<u4", 1, 128) == 10
    levels, at = [], 148
    for level in range(int(np.frombuffer(data, "<u4", 1, 28)[0]) or 1):
        size = max(int(height) >> level, 1), max(int(width) >> level, 1), 4
        levels.append(np.frombuffer(data, "<f2", int(np.prod(size)), at).reshape(size))
        at += 2 * int(np.prod(size))
    return image(*levels)


def linear(path: Path, texture: str) -> Floats:
    """An image's file (H, W, 3) as an importer decodes it, row 0 below."""
    values = np.asarray(PilImage.open(path).convert("RGB"), dtype=np.float32)[::-1] / 255
    decoded = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    return (decoded if texture == BASE else values).astype(np.float32)


@pytest.mark.parametrize("target", [Target.UNITY, Target.UNREAL])
def test_engines_show_what_the_preview_does(
    compilers: Compilers, crate: Bake, wanted: list[Picture], target: Target, tmp_path: Path
) -> None:
    folder = exported(crate, target, tmp_path)
    manifest, glb = read_manifest(folder / f"{NAME}.export.json"), Glb.read(folder / f"{NAME}.glb")
    lookup = manifest.form.hlsl(manifest.bake, manifest.textures, target, manifest.images)
    assert lookup.of_images == {0}
    named = zip(IMAGE_TEXTURES, FILES, strict=True)
    own = tuple(imported(name, linear(folder / file, name), target) for name, file in named)
    textures = [read_dds(folder / entry.file) for entry in lookup.textures.values()]
    for camera, picture in zip(CAMERAS, wanted, strict=True):
        seen = seen_by(camera, glb)
        asked = Asked(
            lookup,
            textures,
            Mesh(baked_matrix(glb), seen.attributes),
            viewers=np.asarray(camera.place) - seen.place,
            materials=len(lookup.materials),
            error=lambda _: (0, 0),  # not asked: the preview tells
            within=(0, 0),
            images={0: own},
        )
        if target is Target.UNITY:
            drawn = test_unity.drawn(compilers, "dxc", asked, urp(folder), np.array([3.0, -2.0, 5.0]))
        else:
            drawn = test_unreal.drawn(compilers, asked)
        shown = np.where(seen.material[:, None] == 1, drawn[-1][:, :3], drawn[0][:, :3])
        inside = seen.hit.reshape(SIDE, SIDE)
        edges = [np.roll(inside, step, axis) for axis in (0, 1) for step in (-1, 1)]
        mask = inside & np.all(edges, axis=0)
        found = decibels(shown.reshape(SIDE, SIDE, 3).astype(np.float64), picture, mask)
        print(f"{target}, {camera.name}: {found:.1f} dB, {mask.mean():.0%} of the picture")
        assert found > LEAST


def urp(folder: Path) -> str:
    """The code of the export's pass that draws what is seen in Unity's URP."""
    shader = (folder / f"{NAME}.shader").read_text(encoding="utf-8")
    found = {(each.pipeline, each.name): each.code for each in test_unity.passes(shader)}
    return test_unity.complete(found["URP", "Radiance"], folder, "SHOWN_PER_PIXEL")


def test_unitys_passes_and_script_compile(compilers: Compilers, crate: Bake, tmp_path: Path) -> None:
    folder = exported(crate, Target.UNITY, tmp_path)
    found = test_unity.passes((folder / f"{NAME}.shader").read_text(encoding="utf-8"))
    for material in range(len(read_manifest(folder / f"{NAME}.export.json").bake["layered"]["materials"])):
        test_unity.compile_passes(compilers, "dxc", found, folder, f"RADTEX_MATERIAL_{material}")
    host, inside = compilers.tools.shared("unity")
    (script,) = (folder / "Editor").iterdir()
    for source in (script, HEADERS / "Declarations.cs"):
        shutil.copyfile(source, host / source.name)
    command = ["mcs", "-warnaserror", "-target:library", script.name, "Declarations.cs"]
    run = compilers.tools.run(command, cwd=inside)
    assert run.returncode == 0, run.stdout + run.stderr
    text = script.read_text(encoding="utf-8")
    for texture, file in zip(IMAGE_TEXTURES, FILES, strict=True):
        assert f'new OwnImage(0, "{texture}", "{file}", TextureWrapMode.Repeat),' in text


def test_unreals_script_imports_images(compilers: Compilers, crate: Bake, tmp_path: Path) -> None:
    folder = exported(crate, Target.UNREAL, tmp_path)
    (script,) = folder.glob("*.py")
    slots = list(material_numbers(Glb.read(folder / f"{NAME}.glb")))
    editor = Editor(slots)
    editor.run(script)
    textures = {each.name: each.values for each in editor.assets.values() if each.kind == "Texture2D"}
    stem = "T_Crate_radiance_image_Painted_"
    assert [editor.files[f"{stem}{kind}"] for kind in ("colour", "metal", "normal")] == FILES
    told = {name.removeprefix(stem): facts for name, facts in textures.items() if name.startswith(stem)}
    assert {name: facts["srgb"] for name, facts in told.items()} == {
        "colour": True,
        "metal": False,
        "normal": False,
    }
    assert told["normal"]["compression_settings"] == "TextureCompressionSettings.TC_NORMALMAP"
    assert {facts["address_x"] for facts in told.values()} == {"TextureAddress.TA_WRAP"}
    (mesh,) = (each for each in editor.assets.values() if each.kind == "StaticMesh")
    inputs = [mesh.slots[k].inputs["MaterialProperty.MP_EMISSIVE_COLOR"] for k in range(len(slots))]
    pins = [set(each.inputs["A"].inputs[""].inputs) for each in inputs]
    assert {"Base", "Metal", "Bump", "UV5"} < pins[0]
    assert not {"Colour", "Normal"} & pins[0]
    assert all({"Colour", "UV5"} < each and "Base" not in each for each in pins[1:])
    for code in sorted(folder.glob("*.hlsl")):
        assert by_dxc(compilers, _function(folder, code, int(code.stem[-1] == "1")))


def _function(folder: Path, code: Path, material: int) -> str:
    """A shader around the code of a material's Custom node."""
    manifest = read_manifest(folder / f"{NAME}.export.json")
    lookup = manifest.form.hlsl(manifest.bake, manifest.textures, Target.UNREAL, manifest.images)
    return test_unreal.around(code.read_text(encoding="utf-8"), lookup, material=material)
