# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Exported folders: what is in them, what is refused, and that nothing is half-written."""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.core.errors import BakeError, FormatError, InputError, RadTexError
from radtex_addon.core.sampler import Filter
from radtex_addon.export import folder as folder_module
from radtex_addon.export.export_manifest import read_manifest
from radtex_addon.export.exporting import Exported, export_steps
from radtex_addon.export.folder import LIST, files_in
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, Compression, Layout
from radtex_addon.textures.export_spec import Arrangement, ExportSpec, Target, TextureFormat
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint

pytestmark = pytest.mark.one_blender
context: Any = bpy.context  # to the stubs, every pointer may be None

PLAIN = BakeSpec(texels=24, bucket=4, samples=1)
LAYERED = BakeSpec(texels=16, samples=1, layout=Layout.LAYERED)
GLTF = ExportSpec(Target.GLTF)
ENGINES = (Target.GLTF, Target.UNITY, Target.UNREAL, Target.RAW)
GLOW = (0.5, 0.25, 0.125)


def _baked(spec: BakeSpec, folder: Path) -> Path:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2)
    context.object.name = "Ball/1"
    shader = "ShaderNodeEmission" if spec.layout is Layout.BUCKETS else "ShaderNodeBsdfGlossy"
    context.object.data.materials.append(stage.material("glow", shader, Color=(*GLOW, 1)))
    stage.hdri(stage.world())
    bake_object(context.scene, "Ball/1", spec, folder, preview=Filter.QUADRILINEAR)
    return folder


@pytest.fixture(scope="module")
def bakes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Folders of one bake each; not to be written to."""
    specs = {"plain": PLAIN, "layered": LAYERED}
    return {name: _baked(spec, tmp_path_factory.mktemp(name) / "baked") for name, spec in specs.items()}


@pytest.fixture
def bake(bakes: dict[str, Path], tmp_path: Path) -> Callable[[str], Path]:
    """A copy of a bake; gives its sidecar."""

    def copied(name: str) -> Path:
        shutil.copytree(bakes[name], tmp_path / "bake", dirs_exist_ok=True)
        return next((tmp_path / "bake").glob("*.radiance.json"))

    return copied


def export(sidecar: Path, spec: ExportSpec = GLTF, out: Path | None = None, **options: bool) -> Exported:
    return finished(export_steps(sidecar, spec, out, **options))


# what is in a folder


def of_engine(target: Target, name: str) -> set[str]:
    """What a folder has for the target's engine alone."""
    identifier = name.replace("-", "_")
    if target is Target.UNITY:
        return {f"{name}.shader", f"{name}.hlsl", f"Editor/_{identifier}_radiance.cs"}
    if target is Target.UNREAL:
        return {f"{name}.custom.hlsl", f"import_{identifier}_radiance.py", "LICENSE.txt"}
    return set()


@pytest.mark.parametrize("form", ["plain", "layered"])
@pytest.mark.parametrize("target", ENGINES)
def test_a_folder_has_all_that_its_manifest_names(
    target: Target, form: str, bake: Callable[[str], Path], temporary: Path
) -> None:
    sidecar = bake(form)
    made = export(sidecar, ExportSpec(target))
    assert made.folder == sidecar.parent / f"{made.name}.{target}"
    assert list(made.files) == [name for name in files_in(made.folder) if name != LIST]
    assert made.bytes == sum((made.folder / name).stat().st_size for name in made.files)
    manifest = read_manifest(made.folder / f"{made.name}.export.json")
    assert manifest.bake == json.loads(sidecar.read_text(encoding="utf-8"))
    named = {manifest.mesh, manifest.flat, *(entry.file for entry in manifest.textures.values())}
    assert named <= set(made.files)
    readme = (made.folder / "README.txt").read_text(encoding="utf-8")
    for name in named:
        assert f"{name}: " in readme
    assert max(len(line) for line in readme.splitlines()) <= 110
    others = {name for name in made.files if not name.startswith("shaders/")} - named
    assert others == {"README.txt", f"{made.name}.export.json", *of_engine(target, made.name)}
    check_shaders(made, target, form)


def check_shaders(made: Exported, target: Target, form: str) -> None:
    """The includes are those that the layout needs, and raw folders have them in every language."""
    names = {Path(name).name for name in made.files if name.startswith("shaders/")}
    layered = "_layered" if form == "layered" else ""
    if target is Target.UNREAL:
        code = (made.folder / f"{made.name}.custom.hlsl").read_text(encoding="utf-8")
        assert "#include" not in code
        assert "MIT" in code.splitlines()[1]
        return
    if target is Target.RAW:
        endings = {Path(name).suffix for name in names if name.startswith("radtex")}
        assert endings == {".glsl", ".hlsl", ".wgsl", ".gdshaderinc", ".osl"}
    else:
        expected = {f"radtex{layered}.hlsl", "radtex_unity.hlsl"}
        assert names == {"LICENSE", *(expected if target is Target.UNITY else {f"radtex{layered}.glsl"})}
    for path in (made.folder / "shaders").iterdir():
        included = re.findall(r'^#include "(.+)"', path.read_text(encoding="utf-8"), re.MULTILINE)
        assert set(included) <= names


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"arrangement": Arrangement.SLICES}, "slices would be a texture array"),
        ({"limit": 16}, "Unreal takes none cut into pages"),
    ],
)
def test_unreal_gets_no_arrays(
    options: dict[str, Any], words: str, bake: Callable[[str], Path], out: Path
) -> None:
    with pytest.raises(InputError, match=words) as refused:
        export(bake("plain"), ExportSpec(Target.UNREAL, **options), out)
    assert refused.value.message.remedies
    assert not out.exists()


def test_an_exr_is_the_bakes_light(bake: Callable[[str], Path]) -> None:
    sidecar = bake("plain")
    made = export(sidecar, ExportSpec(Target.RAW, TextureFormat.EXR))
    (entry,) = read_manifest(made.folder / f"{made.name}.export.json").textures.values()
    ours, _ = read_atlas(sidecar.with_suffix(".exr"))
    theirs, _ = read_atlas(made.folder / entry.file)
    np.testing.assert_array_equal(theirs, ours)
    np.testing.assert_allclose(theirs[..., :3].astype(np.float32), np.broadcast_to(GLOW, ours[..., :3].shape))


def test_a_name_no_filesystem_takes_is_in_the_facts_only(bake: Callable[[str], Path]) -> None:
    made = export(bake("plain"))
    assert made.name.startswith("Ball_1-")
    assert read_manifest(made.folder / f"{made.name}.export.json").bake["object"] == "Ball/1"


# what was there before


def test_what_others_put_there_stays_and_what_we_wrote_goes(
    bake: Callable[[str], Path], tmp_path: Path
) -> None:
    sidecar, out = bake("plain"), tmp_path / "out"
    export(sidecar, ExportSpec(Target.RAW), out)
    (out / "mine").mkdir()
    (out / "mine" / "scene.txt").write_text("mine")
    (out / "shaders" / "own.glsl").write_text("mine too")
    with pytest.raises(InputError, match=r"is already there: overwrite it"):
        export(sidecar, GLTF, out)
    made = export(sidecar, GLTF, out, overwrite=True)
    assert (out / "mine" / "scene.txt").read_text() == "mine"
    assert (out / "shaders" / "own.glsl").is_file()
    assert not (out / "shaders" / "radtex.hlsl").exists()
    assert {"mine/scene.txt", "shaders/own.glsl"} == set(files_in(out)) - set(made.files) - {LIST}
    export(sidecar, GLTF, out, overwrite=True)
    assert (out / "mine" / "scene.txt").read_text() == "mine"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no FIFOs")
def test_links_fifos_and_empty_folders_of_others_stay(bake: Callable[[str], Path], tmp_path: Path) -> None:
    sidecar, out, elsewhere = bake("plain"), tmp_path / "out", tmp_path / "elsewhere"
    export(sidecar, ExportSpec(Target.RAW), out)
    elsewhere.mkdir()
    (elsewhere / "radtex.hlsl").write_text("mine")
    (out / "link").symlink_to(elsewhere, target_is_directory=True)
    (out / "lost").symlink_to("nowhere")
    os.mkfifo(out / "fifo")
    (out / "shaders" / "empty").mkdir()
    (out / "large.bin").write_bytes(b"mine")
    os.link(out / "large.bin", tmp_path / "its other name")
    export(sidecar, GLTF, out, overwrite=True)
    assert (out / "link").readlink() == elsewhere
    assert (elsewhere / "radtex.hlsl").read_text() == "mine"
    assert (out / "lost").readlink() == Path("nowhere")
    assert (out / "fifo").is_fifo()
    assert (out / "shaders" / "empty").is_dir()
    assert (out / "large.bin").samefile(tmp_path / "its other name"), "it is a copy"
    assert not (out / "shaders" / "radtex.hlsl").exists()


@pytest.mark.parametrize("there", ["file", "folder", "link", "shaders"])
def test_what_is_in_the_way_is_named_and_stays(
    there: str, bake: Callable[[str], Path], tmp_path: Path
) -> None:
    sidecar, out, elsewhere = bake("plain"), tmp_path / "out", tmp_path / "elsewhere"
    made = export(sidecar, ExportSpec(Target.RAW, TextureFormat.EXR), out)
    texture = out / f"{made.name}.radiance.ktx2"  # the next export writes it
    elsewhere.mkdir()
    if there == "file":
        texture.write_text("mine")
    elif there == "folder":
        texture.mkdir()
    elif there == "link":
        texture.symlink_to(elsewhere / "texture")
    else:
        texture = out / "shaders"
        shutil.rmtree(texture)
        texture.symlink_to(elsewhere, target_is_directory=True)
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    with pytest.raises(InputError, match=rf"{re.escape(str(texture))} is in the way, and no export wrote it"):
        export(sidecar, GLTF, out, overwrite=True)
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before
    assert list(elsewhere.iterdir()) == []


def test_a_list_that_names_files_elsewhere_removes_none(bake: Callable[[str], Path], tmp_path: Path) -> None:
    sidecar, out, mine = bake("plain"), tmp_path / "out", tmp_path / "mine.txt"
    export(sidecar, ExportSpec(Target.RAW), out)
    mine.write_text("mine")
    with (out / LIST).open("a", encoding="utf-8") as listed:
        listed.write(f"../mine.txt\n{mine}\nshaders/../../mine.txt\n\n.\n")
    export(sidecar, GLTF, out, overwrite=True)
    assert mine.read_text() == "mine"


@pytest.mark.parametrize("stops", ["shaders/radtex.glsl", "README.txt", LIST])
def test_an_export_that_stopped_amid_its_moves_is_known_and_completed(
    stops: str, bake: Callable[[str], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sidecar, out, whole = bake("plain"), tmp_path / "out", tmp_path / "whole"
    export(sidecar, GLTF, whole)
    export(sidecar, ExportSpec(Target.RAW), out)
    (out / "mine").mkdir()
    assert folder_module.is_whole(out)
    move, moved = Path.replace, []

    def stopped(path: Path, place: Path) -> Path:
        moved.append(place)
        if place == out / stops and moved.count(out / LIST) == 1 + (stops == LIST):
            raise OSError(5, "Input/output error")
        return move(path, place)

    monkeypatch.setattr(Path, "replace", stopped)
    with pytest.raises(BakeError, match=r"out could not be written: Input/output error"):
        export(sidecar, GLTF, out, overwrite=True)
    monkeypatch.undo()
    assert not folder_module.is_whole(out)
    export(sidecar, GLTF, out, overwrite=True)
    assert folder_module.is_whole(out)
    (out / "mine").rmdir()
    assert {name: (out / name).read_bytes() for name in files_in(out)} == {
        name: (whole / name).read_bytes() for name in files_in(whole)
    }


def test_wherever_an_export_stops_nothing_is_left(
    bake: Callable[[str], Path], tmp_path: Path, temporary: Path
) -> None:
    sidecar, out = bake("layered"), tmp_path / "out"
    before, there = fingerprint(), set(tmp_path.iterdir())
    taken = 0
    while True:
        steps = export_steps(sidecar, GLTF, out)
        ended = any(_is_over(steps) for _ in range(taken + 1))
        steps.close()
        assert differences(before, fingerprint()) == {}
        if ended:
            break
        assert set(tmp_path.iterdir()) == there
        taken += 1
    assert set(tmp_path.iterdir()) == there | {out}


def _is_over(steps: Any) -> bool:
    return next(steps, None) is None


def test_a_failure_at_the_end_leaves_the_earlier_export(
    bake: Callable[[str], Path], out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sidecar = bake("plain")
    out.mkdir()  # an empty folder is as good as none
    export(sidecar, ExportSpec(Target.RAW), out)
    before = {name: (out / name).read_bytes() for name in files_in(out)}

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(folder_module, "_write_list", full)
    with pytest.raises(RadTexError, match=r"could not be written: No space left on device"):
        export(sidecar, GLTF, out, overwrite=True)
    assert {name: (out / name).read_bytes() for name in files_in(out)} == before
    assert set(out.parent.iterdir()) == {out, sidecar.parent}


# what is refused


def _newer(sidecar: Path) -> None:
    facts = json.loads(sidecar.read_text(encoding="utf-8"))
    sidecar.write_text(json.dumps(facts | {"version": 2}), encoding="utf-8")


def _cut(sidecar: Path) -> None:
    image = sidecar.with_suffix(".exr")
    image.write_bytes(image.read_bytes()[: image.stat().st_size // 2])


def _foreign(sidecar: Path) -> None:
    sidecar.with_suffix(".exr").write_bytes(b"\x89PNG, or so it says")


def _no_atlas(sidecar: Path) -> None:
    sidecar.with_suffix(".exr").unlink()


def _no_preview(sidecar: Path) -> None:
    next(sidecar.parent.glob("*.preview.blend")).unlink()


def _no_blend(sidecar: Path) -> None:
    next(sidecar.parent.glob("*.preview.blend")).write_text("mine")


def _other_layer(sidecar: Path) -> None:
    facts = json.loads(sidecar.read_text(encoding="utf-8"))
    sidecar.write_text(json.dumps(facts | {"uv_map": "Mine"}), encoding="utf-8")


@pytest.mark.parametrize(
    ("spoil", "kind", "words"),
    [
        (_newer, FormatError, r"is of version 2, this RadTex reads 1: update RadTex"),
        (_cut, FormatError, r"\.exr is damaged"),
        (_foreign, FormatError, r"\.exr is not an OpenEXR file"),
        (_no_atlas, FormatError, r"\.exr cannot be read: No such file"),
        (_no_preview, InputError, r"\.preview\.blend is missing.*bake it again with a preview"),
        (_no_blend, FormatError, r"\.preview\.blend is no \.blend that this Blender reads"),
        (_other_layer, FormatError, r"of another bake"),
    ],
)
def test_a_bake_that_cannot_be_read_is_named(
    spoil: Callable[[Path], None],
    kind: type[RadTexError],
    words: str,
    bake: Callable[[str], Path],
    out: Path,
    temporary: Path,
) -> None:
    sidecar = bake("plain")
    spoil(sidecar)
    before = fingerprint()
    with pytest.raises(kind, match=words) as refused:
        export(sidecar, GLTF, out)
    assert "\n" not in str(refused.value)
    assert refused.value.exit_code == 2
    assert differences(before, fingerprint()) == {}
    assert not out.exists()
    assert {path.name for path in out.parent.iterdir()} == {"bake", "temporary"}


@pytest.mark.parametrize(
    ("spec", "shader"),
    [
        (PLAIN, "Diffuse"),
        (replace(PLAIN, compression=Compression.DWAA), "Diffuse"),
        (replace(LAYERED, compression=Compression.DWAA), "Glossy"),
    ],
    ids=["plain", "dwaa", "layered-glossy-dwaa"],
)
def test_a_preview_of_another_unwrap_is_refused(spec: BakeSpec, shader: str, tmp_path: Path) -> None:
    bpy.ops.mesh.primitive_monkey_add()
    name, scene = context.object.name, context.scene
    context.object.data.materials.append(stage.material("white", f"ShaderNodeBsdf{shader}"))
    stage.hdri(stage.world())
    spec = replace(spec, texels=64, bucket=2 if spec.layout is Layout.BUCKETS else spec.bucket)
    bake_object(scene, name, replace(spec, padding=4), tmp_path / "baked", preview=Filter.QUADRILINEAR)
    files = bake_object(scene, name, spec, tmp_path / "new", preview=Filter.QUADRILINEAR).files
    export(files.sidecar, GLTF, tmp_path / "good")
    assert files.preview is not None
    shutil.copyfile(tmp_path / "baked" / files.preview.name, files.preview)
    with pytest.raises(FormatError, match=r"is of another bake: bake it again with a preview"):
        export(files.sidecar, GLTF, tmp_path / "bad")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"target": Target.WEB, "format": TextureFormat.EXR}, "format exr: web does not read it: choose"),
        ({"target": Target.WEB, "format": TextureFormat.KTX2_BC6H}, "ktx2-bc6h: web does not read it"),
        ({"target": Target.UNITY, "format": TextureFormat.KTX2_RGBA16F}, "unity does not read it"),
        ({"target": Target.UNREAL, "format": TextureFormat.DDS_BC6H}, "unreal does not read it"),
        ({"target": Target.RAW, "levels": 0}, "levels 0: give a whole number from 1 to"),
        ({"target": Target.RAW, "limit": 1}, "limit 1: a texture needs 16 pixels at least"),
    ],
)
def test_what_a_target_does_not_take_is_refused(options: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=re.escape(words)):
        ExportSpec(**options)


def test_a_limit_below_what_can_be_split_is_refused(bake: Callable[[str], Path], out: Path) -> None:
    spec = ExportSpec(Target.RAW, TextureFormat.KTX2_RGBA16F, arrangement=Arrangement.SLICES, limit=16)
    with pytest.raises(InputError, match="16"):
        export(bake("plain"), spec, out)
    assert not out.exists()


def test_places_that_would_lose_something_are_refused(bake: Callable[[str], Path], tmp_path: Path) -> None:
    sidecar = bake("plain")
    before = {name: (sidecar.parent / name).read_bytes() for name in files_in(sidecar.parent)}
    for place in (sidecar.parent, tmp_path):
        with pytest.raises(InputError, match="holds the bake itself"):
            export(sidecar, GLTF, place, overwrite=True)
    with pytest.raises(InputError, match="is a file, or a link"):
        export(sidecar, GLTF, sidecar, overwrite=True)
    with pytest.raises(InputError, match="is a file"):
        export(sidecar, GLTF, sidecar / "inside", overwrite=True)
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.txt").write_text("mine")
    with pytest.raises(InputError, match="holds other things than an export"):
        export(sidecar, GLTF, mine, overwrite=True)
    assert {name: (sidecar.parent / name).read_bytes() for name in files_in(sidecar.parent)} == before
    assert (mine / "thesis.txt").read_text() == "mine"
