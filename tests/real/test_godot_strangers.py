# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The addon for Godot, given files that a stranger made: it runs nothing of them, in a real Godot."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radtex_addon.export.gltf import extension_in
from radtex_addon.formats.containers.dds import write_texture
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.formats.containers.ktx2 import write_ktx2
from radtex_addon.formats.containers.texture import PixelFormat, encode_texture
from tests.gltf_schema import EXTENSION_FOLDER
from tests.real.godot import filled, run_godot, said_by_godot
from tests.real.root import Root
from tests.strangers.attacks import BASES, attacks

# A resource with a script that runs, in the editor too, as soon as the resource is loaded.
EVIL = """[gd_resource type="Resource" format=3]

[sub_resource type="GDScript" id="1"]
script/source = "@tool
extends Resource

func _init() -> void:
	FileAccess.open(\\"res://ran.txt\\", FileAccess.WRITE).store_string(\\"ran\\")
"

[resource]
script = SubResource("1")
"""
LEADS = '[remap]\nimporter="texture"\ntype="Resource"\npath="res://evil.tres"\n\n[deps]\n\n[params]\n'
REFUSED = "is not as RadTex writes it"


def export(folder: Path, changes: Mapping[str, object]) -> Path:
    """The example of our extension, the entry of its texture changed."""
    shutil.copytree(EXTENSION_FOLDER / "example", folder)
    glb = Glb.read(folder / "Ball.glb")
    extension_in(glb.document["materials"][0])["textures"]["radiance"] |= changes
    glb.write(folder / "Ball.glb")
    return folder


def said_at_import(root: Root, place: tuple[Path, str]) -> str:
    """What Godot says at the import of a project, in which no script ran that is not the addon's."""
    folder, inside = place
    (folder / "evil.tres").write_text(EVIL, encoding="utf-8")
    (folder.parent / "up").mkdir(exist_ok=True)
    (folder.parent / "up" / "evil.tres").write_text(EVIL, encoding="utf-8")
    said = said_by_godot(root, ["--headless", "--path", inside, "--import"])
    assert not (folder / "ran.txt").exists(), said
    return said


def test_the_script_of_a_resource_runs_when_it_is_loaded(root: Root, tmp_path: Path) -> None:
    """What the others rely on: whoever loads this resource, by its name or another one, runs its script."""
    folder, inside = filled(root, export(tmp_path / "export", {}))
    (folder / "evil.tres").write_text(EVIL, encoding="utf-8")
    for name, leads in (("evil.tres", False), ("Other.ktx2", True), ("Other.dds", True)):
        (folder / "ran.txt").unlink(missing_ok=True)
        if leads:
            shutil.copy(folder / "Ball.radiance.ktx2", folder / name)
            (folder / f"{name}.import").write_text(LEADS, encoding="utf-8")
        script = f'extends SceneTree\n\nfunc _init() -> void:\n\tload("res://{name}")\n\tquit()\n'
        (folder / "load.gd").write_text(script, encoding="utf-8")
        said_by_godot(root, ["--headless", "--path", inside, "--script", "res://load.gd"])
        assert (folder / "ran.txt").exists(), name


@pytest.mark.parametrize("uri", ["evil.tres", "../up/evil.tres", "%2E%2E/up/evil.tres"])
def test_a_file_of_another_kind_is_not_loaded(uri: str, root: Root, tmp_path: Path) -> None:
    place = filled(root, export(tmp_path / "export", {"container": "dds", "uri": uri}))
    assert REFUSED in said_at_import(root, place)


@pytest.mark.parametrize("ending", ["import", "remap"])
@pytest.mark.parametrize("container", ["ktx2", "dds"])
def test_a_file_that_leads_to_another_is_not_followed(
    container: str, ending: str, root: Root, tmp_path: Path
) -> None:
    """A texture that Godot would load by itself, but for the .import or .remap beside it."""
    name = f"Ball.radiance.{container}"
    entry = {"file": name, "uri": name, "container": container, "format": "RGBA16F", "levels": 1}
    folder, inside = filled(root, export(tmp_path / "export", entry))
    light = np.random.default_rng(1).random((96, 96, 4)).astype(np.float16)
    texture = encode_texture([light[None]], PixelFormat.RGBA16F)
    if container == "dds":
        write_texture(folder / name, texture)
    else:
        write_ktx2(folder / name, texture)
    (folder / f"{name}.{ending}").write_text(LEADS, encoding="utf-8")
    assert "ERROR: RadTex" not in said_at_import(root, (folder, inside))


def test_all_that_strangers_make_is_refused(root: Root, tmp_path: Path) -> None:
    """By the check that comes before all else; what RadTex wrote passes."""
    folder, inside = filled(root, export(tmp_path / "export", {}))
    made: list[Any] = [*BASES.values(), *(facts for _, facts in attacks("gltf"))]
    (folder / "made.json").write_text(json.dumps(made), encoding="utf-8")
    shutil.copy(Path(__file__).parent / "inside/godot/check.gd", folder)
    run_godot(root, ["--headless", "--path", inside, "--script", "res://check.gd"])
    found = json.loads((folder / "found.json").read_text(encoding="utf-8"))
    ours, theirs = found[: len(BASES)], found[len(BASES) :]
    assert ours == [""] * len(BASES)
    for (what, _), problem in zip(attacks("gltf"), theirs, strict=True):
        print(f"{what}: {problem}")
    assert [what for (what, _), problem in zip(attacks("gltf"), theirs, strict=True) if not problem] == []
