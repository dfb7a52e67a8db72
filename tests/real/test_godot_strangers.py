# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The addon for Godot, given files that a stranger made: it runs nothing of them, in a real Godot."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

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
REFUSED = "is not as this addon knows it"


def export(folder: Path, changes: Mapping[str, object]) -> Path:
    """The example of our extension, the entry of its texture changed."""
    shutil.copytree(EXTENSION_FOLDER / "example", folder)
    glb = Glb.read(folder / "Ball.glb")
    extension_in(glb.document["materials"][0])["textures"]["radiance"] |= changes
    glb.write(folder / "Ball.glb")
    return folder


def test_the_script_of_a_resource_runs_when_it_is_loaded(root: Root, tmp_path: Path) -> None:
    """What the others rely on: whoever loads this resource, by its name or another one, runs its script."""
    folder, inside = filled(root, {"own": export(tmp_path / "export", {})})
    (folder / "evil.tres").write_text(EVIL, encoding="utf-8")
    for name, leads in (("evil.tres", False), ("Other.ktx2", True), ("Other.dds", True)):
        (folder / "ran.txt").unlink(missing_ok=True)
        if leads:
            shutil.copy(folder / "own/Ball.radiance.ktx2", folder / name)
            (folder / f"{name}.import").write_text(LEADS, encoding="utf-8")
        script = f'extends SceneTree\n\nfunc _init() -> void:\n\tload("res://{name}")\n\tquit()\n'
        (folder / "load.gd").write_text(script, encoding="utf-8")
        said_by_godot(root, ["--headless", "--path", inside, "--script", "res://load.gd"])
        assert (folder / "ran.txt").exists(), name


def test_no_script_of_a_stranger_runs_at_the_import(root: Root, tmp_path: Path) -> None:
    """A file of another kind is refused; a texture that Godot would load by itself is read, but the .import
    or .remap beside it, which lead to a script, are not followed."""
    exports, textures = {}, {}
    for number, uri in enumerate(("evil.tres", "../up/evil.tres", "%2E%2E/up/evil.tres")):
        exports[f"evil{number}"] = export(tmp_path / f"evil{number}", {"container": "dds", "uri": uri})
    light = np.random.default_rng(1).random((96, 96, 4)).astype(np.float16)
    texture = encode_texture([light[None]], PixelFormat.RGBA16F)
    for container, ending in product(("ktx2", "dds"), ("import", "remap")):
        file = f"Ball.radiance.{container}"
        entry = {"file": file, "uri": file, "container": container, "format": "RGBA16F", "levels": 1}
        exports[f"{container}-{ending}"] = export(tmp_path / f"{container}-{ending}", entry)
        textures[f"{container}-{ending}"] = file
    folder, inside = filled(root, exports)
    for name, file in textures.items():
        write = write_texture if file.endswith("dds") else write_ktx2
        write(folder / name / file, texture)
        (folder / name / f"{file}.{name.partition('-')[2]}").write_text(LEADS, encoding="utf-8")
    for name in (".", "up", *exports):
        (folder / name).mkdir(exist_ok=True)
        (folder / name / "evil.tres").write_text(EVIL, encoding="utf-8")
    said = said_by_godot(root, ["--headless", "--path", inside, "--import"])
    assert not (folder / "ran.txt").exists(), said
    assert said.count("ERROR: RadTex") == said.count(REFUSED) == 3, said


def test_all_that_strangers_make_is_refused(root: Root, tmp_path: Path) -> None:
    """By the check that comes before all else; what RadTex wrote passes."""
    folder, inside = filled(root, {"own": export(tmp_path / "export", {})})
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
