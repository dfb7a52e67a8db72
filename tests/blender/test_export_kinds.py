# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""`bake.py export` of finished bakes of every kind: what takes them, refuses them, and a shadow's bits."""

from __future__ import annotations

import json
import shutil
import struct
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from PIL import Image

from radtex_addon.bake.progress import finished
from radtex_addon.bake.transfer_buckets import mean_over_lights
from radtex_addon.cli import main as batch_module
from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.export.export_manifest import read_manifest
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.folder import files_in
from radtex_addon.export.pack import SHADERS
from radtex_addon.formats.codecs.srgb import to_srgb
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.formats.containers.texture import PixelFormat
from radtex_addon.formats.shadow_files import read_shadow_of
from radtex_addon.formats.transfer_files import read_transfer
from radtex_addon.job import bake_object
from radtex_addon.job.preflight import run_preflight
from radtex_addon.settings.spec import BakeSpec, Kind
from radtex_addon.textures.entry import Arranged, Container
from radtex_addon.textures.export_spec import ExportSpec, Target, TextureFormat
from tests.blender import stage
from tests.blender.batch_process import Outcome, refusal
from tests.reference.textures import read_ktx2

pytestmark = pytest.mark.one_blender
context: Any = bpy.context  # to the stubs, every pointer may be None
SPECS = {
    Kind.SHADOW: BakeSpec(kind=Kind.SHADOW, texels=12, bucket=8),
    Kind.AO: BakeSpec(kind=Kind.AO, texels=12, bucket=4, samples=1),
    Kind.PROXY: BakeSpec(kind=Kind.PROXY, texels=12, bucket=4, samples=1),
    Kind.INCIDENT: BakeSpec(kind=Kind.INCIDENT, texels=12, bucket=4, samples=1),
    Kind.TRANSFER: BakeSpec(kind=Kind.TRANSFER, texels=16, samples=1),
}
EVERYBODY = (Kind.PROXY, Kind.INCIDENT)


@pytest.fixture(scope="module")
def bakes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folders of one bake each, by kind, of a box around a ball; not to be written to."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_cube_add(size=2)
    context.object.name = "Box"
    colour = (0.8, 0.4, 0.2, 1)
    context.object.data.materials.append(stage.material("Box", "ShaderNodeBsdfDiffuse", Color=colour))
    bpy.ops.mesh.primitive_ico_sphere_add(radius=0.6)
    context.object.data.materials.append(stage.material("Ball", "ShaderNodeEmission"))
    folder = tmp_path_factory.mktemp("kinds")
    for kind, spec in SPECS.items():
        bake_object(context.scene, "Box", spec, folder / kind, preview=Filter.QUADRILINEAR)
    return folder


@pytest.fixture
def export(bakes: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> Callable[..., Outcome]:
    """`bake.py export` of a copy of one kind's bake, beside which the folder is made."""

    def exported(kind: Kind, target: Target, *options: str) -> Outcome:
        shutil.copytree(bakes / kind, tmp_path / "baked", dirs_exist_ok=True)
        capfd.readouterr()
        words = ["export", str(tmp_path / "baked"), "--to", target, *options, "--progress", "none"]
        return Outcome(batch_module.main(words, inside_blender=False), *capfd.readouterr())

    return exported


@pytest.mark.parametrize("kind", SPECS)
def test_a_finished_bake_of_any_kind_is_exported(
    export: Callable[..., Outcome], tmp_path: Path, kind: Kind
) -> None:
    """As glTF, too: test_gltf_extension."""
    ended = export(kind, Target.RAW)
    assert (ended.code, ended.err) == (0, "")
    made = tmp_path / "baked/Box.raw"
    assert {"Box.glb", "Box.flat.png", f"Box.{kind}.ktx2", "shaders/radtex.glsl"} <= set(files_in(made))
    manifest = read_manifest(made / "Box.export.json")
    assert (manifest.bake["kind"], list(manifest.textures)) == (kind, [str(kind)])


@pytest.mark.parametrize("kind", EVERYBODY)
@pytest.mark.parametrize("target", [Target.UNITY, Target.UNREAL])
def test_what_is_looked_up_by_the_viewer_goes_to_every_engine(
    export: Callable[..., Outcome], kind: Kind, target: Target
) -> None:
    assert export(kind, target).code == 0


@pytest.mark.parametrize("kind", SPECS)
def test_godots_project_has_the_addon_and_the_light_that_a_kind_needs(
    export: Callable[..., Outcome], tmp_path: Path, kind: Kind
) -> None:
    ended = export(kind, Target.GODOT)
    assert (ended.code, ended.err) == (0, "")
    made = tmp_path / "baked/Box.godot"
    addon = {f"addons/radtex/{name}" for name in ("plugin.cfg", "importer.gd", "LICENSE", "README.md")}
    assert addon | {"project.godot", "Box.glb", f"Box.{kind}.ktx2"} <= set(files_in(made))
    assert {f"addons/radtex/lookups/{each.name}" for each in SHADERS.glob("*.gdshaderinc")} <= set(
        files_in(made)
    )
    scene = (made / "main.tscn").read_text(encoding="utf-8")
    assert "@" not in scene
    assert ("DirectionalLight3D" in scene) is (kind in (Kind.SHADOW, Kind.TRANSFER))
    assert ("ProceduralSkyMaterial" in scene) is (kind is Kind.AO)


def test_a_hulls_fallback_is_clear_and_has_a_front_alone(
    export: Callable[..., Outcome], tmp_path: Path
) -> None:
    """Of the box around the ball: beside the ball is nothing."""
    for kind, clear in ((Kind.PROXY, True), (Kind.INCIDENT, False)):
        assert export(kind, Target.GLTF, "--out", str(tmp_path / f"{kind}.gltf")).code == 0
        folder = tmp_path / f"{kind}.gltf"
        (material,) = Glb.read(folder / "Box.glb").document["materials"]
        assert (material.get("alphaMode"), material["doubleSided"]) == (
            ("BLEND", False) if clear else (None, True)
        )
        with Image.open(folder / "Box.flat.png") as flat:
            assert flat.mode == ("RGBA" if clear else "RGB")
            shown = np.asarray(flat)
        if clear:
            assert 0 < shown[..., 3].mean() < 250
            assert shown[..., :3][shown[..., 3] > 8].min() > 200  # as white as the ball
        shutil.rmtree(tmp_path / "baked")


def test_a_layer_that_the_bake_lacks_is_refused(export: Callable[..., Outcome]) -> None:
    told = refusal(export(Kind.PROXY, Target.RAW, "--layer", "base"))
    assert "has no layer base, its layers are: none: bake it with that layer (--layer base)" in told
    assert "--layer haze: choose from diffuse" in refusal(export(Kind.PROXY, Target.RAW, "--layer", "haze"))


@pytest.mark.parametrize(
    ("kind", "target"),
    [*product((Kind.SHADOW, Kind.AO), (Target.UNITY, Target.UNREAL))],
)
def test_who_does_not_show_a_kind_refuses_it_by_name(
    export: Callable[..., Outcome], tmp_path: Path, kind: Kind, target: Target
) -> None:
    words = refusal(export(kind, target))
    assert f"Box.{kind}.json is of kind {kind}, which {target} does not show: choose " in words
    assert not (tmp_path / f"baked/Box.{target}").exists()


@pytest.mark.parametrize(
    ("target", "shader"), [(Target.UNITY, "Box.hlsl"), (Target.UNREAL, "Box.custom.hlsl")]
)
def test_a_transfer_goes_to_engines_that_have_its_shader(
    export: Callable[..., Outcome], tmp_path: Path, target: Target, shader: str
) -> None:
    assert export(Kind.TRANSFER, target).code == 0
    made = tmp_path / f"baked/Box.{target}"
    assert "radtex_transfer(radtex_atlas, " in (made / shader).read_text(encoding="utf-8")
    entry = read_manifest(made / "Box.export.json").textures["transfer"]
    assert (entry.container, entry.format) == (Container.DDS, PixelFormat.RGBA16F)  # 9 cells are no blocks


def test_a_transfer_too_large_for_one_texture_is_cut_into_pages(
    export: Callable[..., Outcome], tmp_path: Path
) -> None:
    assert export(Kind.TRANSFER, Target.RAW, "--limit", "100", "--format", "ktx2-rgba16f").code == 0
    made = tmp_path / "baked/Box.raw"
    entry = read_manifest(made / "Box.export.json").textures["transfer"]
    columns, rows = entry.pages
    assert entry.layers == columns * rows > 1
    assert max(entry.size) <= 100
    words = (made / "README.txt").read_text()
    assert f"#define RADTEX_PAGES, pages = ({columns}, {rows}, {entry.page_texels[0]}, " in words
    pixels, _ = read_transfer(tmp_path / "baked/Box.transfer.json")
    width, height = entry.size
    layers = np.ascontiguousarray(read_ktx2(made / entry.file).levels[0]).view(np.float16)
    first = layers.reshape(-1, height, width, 4)[0]
    np.testing.assert_array_equal(first, pixels[:height, :width])
    told = refusal(export(Kind.TRANSFER, Target.RAW, "--limit", "100", "--format", "exr", "--overwrite"))
    assert "which cannot be split: raise the limit of 100 (--limit)" in told


def test_a_transfers_cells_are_those_of_the_bake(export: Callable[..., Outcome], tmp_path: Path) -> None:
    assert export(Kind.TRANSFER, Target.RAW, "--format", "ktx2-rgba16f").code == 0
    made = tmp_path / "baked/Box.raw"
    entry = read_manifest(made / "Box.export.json").textures["transfer"]
    assert (entry.arrangement, entry.levels, entry.pages) == (Arranged.MATRIX, 1, (1, 1))
    pixels, facts = read_transfer(tmp_path / "baked/Box.transfer.json")
    stored = np.ascontiguousarray(read_ktx2(made / entry.file).levels[0]).view(np.float16)
    np.testing.assert_array_equal(stored.reshape(pixels.shape), pixels)
    assert "radtex_transfer(atlas, (16, " in (made / "README.txt").read_text()
    assert (made / "shaders/radtex_transfer.glsl").is_file()
    white = mean_over_lights(pixels, facts.layout)[..., :3]
    flat: Any = bpy.data.images.load(str(made / "Box.flat.png"))
    shown = np.array(flat.pixels[:]).reshape(facts.layout.height, facts.layout.width, 4)[..., :3]
    scale = read_manifest(made / "Box.export.json").flat_scale
    np.testing.assert_allclose(shown, to_srgb(white * scale), atol=1 / 255)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--arrangement", "slices"), "one level in a matrix: leave --arrangement and --levels out"),
        (("--levels", "2"), "one level in a matrix: leave --arrangement and --levels out"),
        (("--limit", "16", "--format", "exr"), "which cannot be split"),
    ],
)
def test_what_a_transfer_cannot_be_is_named(
    export: Callable[..., Outcome], options: tuple[str, ...], words: str
) -> None:
    assert words in refusal(export(Kind.TRANSFER, Target.RAW, *options))


def test_a_bake_that_its_target_would_refuse_is_not_begun(tmp_path: Path) -> None:
    bpy.ops.mesh.primitive_plane_add()
    context.object.name = "Card"
    asked = (context.scene, ("Card",), SPECS[Kind.SHADOW], tmp_path)
    assert run_preflight(*asked, preview=True, targets=(Target.GODOT, Target.RAW)).errors == ()
    (error,) = map(str, run_preflight(*asked, preview=True, targets=(Target.GODOT, Target.UNITY)).errors)
    assert error == "the bake is of kind shadow, which unity does not show: choose web, godot, raw, gltf"


def test_of_several_kinds_in_a_folder_one_is_named(
    bakes: Path, export: Callable[..., Outcome], tmp_path: Path
) -> None:
    shutil.copytree(bakes / Kind.AO, tmp_path / "baked")
    words = refusal(export(Kind.SHADOW, Target.RAW))
    assert "holds Box.ao.json, Box.shadow.json: name one of these files instead of the folder" in words


def test_a_kind_from_the_future_is_refused(
    bakes: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    facts = json.loads((bakes / Kind.INCIDENT / "Box.incident.json").read_text())
    sidecar = tmp_path / "Box.smell.json"
    sidecar.write_text(json.dumps(facts | {"kind": "smell"}))
    capfd.readouterr()
    code = batch_module.main(
        ["export", str(sidecar), "--to", "raw", "--progress", "none"], inside_blender=False
    )
    assert "is of kind smell, which this RadTex does not know" in refusal(Outcome(code, *capfd.readouterr()))


def baked(kind: str, out: Path, cells: int = 8) -> Path:
    """The sidecar of a floor's bake, below a ball."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = "Floor"
    bpy.ops.mesh.primitive_ico_sphere_add(radius=0.4, location=(0.2, 0.1, 0.5))
    spec = BakeSpec(kind=kind, texels=12, bucket=cells, samples=2)  # type: ignore[arg-type]
    return bake_object(context.scene, "Floor", spec, out, preview=Filter.NEAREST).files.sidecar


@pytest.mark.parametrize(
    ("cells", "kind", "vk_format", "layers"),
    [
        (5, PixelFormat.R32UI, 98, 1),
        (8, PixelFormat.RG32UI, 101, 1),
        (12, PixelFormat.RG32UI, 101, 3),
    ],
)
def test_a_shadows_words_come_back_bit_by_bit(
    out: Path, cells: int, kind: PixelFormat, vk_format: int, layers: int
) -> None:
    sidecar = baked("shadow", out, cells)
    made = finished(export_steps(sidecar, ExportSpec(Target.RAW)))
    assert "shaders/radtex_shadow.glsl" in made.files
    manifest = read_manifest(made.folder / "Floor.export.json")
    entry = manifest.textures["shadow"]
    assert (entry.format, entry.layers, entry.arrangement) == (kind, layers, Arranged.WORDS)
    file = made.folder / entry.file
    assert struct.unpack_from("<I", file.read_bytes(), 12) == (vk_format,)
    texture = read_ktx2(file)
    assert texture.is_array is (layers > 1)
    words, facts = read_shadow_of(sidecar)
    stored = np.ascontiguousarray(texture.levels[0]).view("<u4")  # layers, rows, columns, words
    joined = stored.transpose(1, 2, 0, 3).reshape(facts.height, facts.width, -1)
    np.testing.assert_array_equal(joined[..., : words.shape[2]], words)
    assert not joined[..., words.shape[2] :].any()


def test_bits_have_one_format(out: Path) -> None:
    sidecar = baked("shadow", out)
    with pytest.raises(InputError, match="holds bits, not light: leave the format out"):
        finished(export_steps(sidecar, ExportSpec(Target.RAW, TextureFormat.KTX2_RGBA16F)))
    with pytest.raises(InputError, match="not blended: leave the arrangement and the levels out"):
        finished(export_steps(sidecar, ExportSpec(Target.RAW, levels=2)))
