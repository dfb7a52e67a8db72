# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A name that would end a line, a string or a comment ends none in any generated file."""

from __future__ import annotations

import shutil
import sys
import unicodedata
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.core.errors import FormatError
from radtex_addon.core.sampler import Filter
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.exporting_scene import export_scene_steps
from radtex_addon.export.targets import web
from radtex_addon.farm.prepare_farm import prepare_steps
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.textures.export_spec import ExportSpec, Target

pytestmark = pytest.mark.one_blender
context: Any = bpy.context  # to the stubs, every pointer may be None
EVIL = "evil"
NAME = f'Va"se\u2028{EVIL}\n{EVIL}\r{EVIL}\u2029{EVIL}\u0085{EVIL}\\'
TINY = BakeSpec(texels=8, bucket=2, samples=1)
UNSEEN = ("Cc", "Cf", "Zl", "Zp")
BINARY = (".glb", ".ktx2", ".dds", ".exr", ".png", ".blend", ".npz")
SCENES = (Target.WEB, Target.GODOT, Target.GLTF, Target.RAW)


def named_plane() -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_plane_add()
    context.object.name = NAME
    assert context.object.name == NAME


@pytest.fixture(scope="module")
def bake(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sidecar of an object with that name; not to be written to."""
    named_plane()
    folder = tmp_path_factory.mktemp("names")
    return bake_object(context.scene, NAME, TINY, folder, preview=Filter.NEAREST).files.sidecar


@pytest.fixture(autouse=True)
def page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A page's files in the place of the built ones."""
    folder = tmp_path / "built"
    folder.mkdir()
    for name in web.FILES:
        (folder / name).write_text(web._UNNAMED, encoding="utf-8")
    monkeypatch.setattr(web, "BUILT", folder)


def check_texts(folder: Path) -> None:
    """No text in a folder has a line that begins with what stands behind a line end of the name."""
    texts = [path for path in folder.rglob("*") if path.is_file() and path.suffix not in BINARY]
    assert texts
    for path in texts:
        text = path.read_bytes().decode("utf-8")
        strange = {one for one in text if unicodedata.category(one) in UNSEEN} - {"\n", "\t"}
        assert not strange, f"{path.name} has {strange}"
        assert not [line for line in text.splitlines() if line.lstrip(" /#").startswith(EVIL)], path.name


@pytest.mark.parametrize("target", Target)
def test_an_export_has_the_name_in_one_line(target: Target, bake: Path, tmp_path: Path) -> None:
    finished(export_steps(bake, ExportSpec(target), tmp_path / "out"))
    check_texts(tmp_path / "out")


@pytest.mark.parametrize("target", SCENES)
def test_a_scene_has_the_name_in_one_line(target: Target, bake: Path, tmp_path: Path) -> None:
    finished(export_scene_steps([bake], ExportSpec(target), NAME, tmp_path / "out"))
    check_texts(tmp_path / "out")


@pytest.mark.skipif(sys.platform == "win32", reason="no file has such a name there")
@pytest.mark.parametrize("name", [f"a\n{EVIL}", f"a\u2028{EVIL}", "a\u202eb", 'a"b', "a\\b", "a:b", ".a"])
def test_a_bake_whose_files_were_given_such_a_name_is_not_exported(
    name: str, bake: Path, tmp_path: Path
) -> None:
    renamed = tmp_path / f"{name}.radiance.json"
    shutil.copyfile(bake, renamed)
    with pytest.raises(FormatError, match="is no name for files of an export") as caught:
        finished(export_steps(renamed, ExportSpec(Target.RAW), tmp_path / "out"))
    assert len(str(caught.value).splitlines()) == 1


def test_a_farm_has_the_name_in_one_line(tmp_path: Path) -> None:
    named_plane()
    farm = finished(prepare_steps(context.scene, NAME, TINY, tmp_path))
    check_texts(farm.files.folder)
    job = (farm.files.folder / "openjd.yaml").read_text(encoding="utf-8")
    assert (
        'default: "RadTex Va\\"se\\\\u2028evil\\\\nevil\\\\revil' in job
    )  # a job's name has no line ends at all
