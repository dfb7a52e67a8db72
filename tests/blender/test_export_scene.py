# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Several bakes exported as one scene: nodes in their places, textures once, bounds, levels of detail."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from mathutils import Matrix, Quaternion

from radtex_addon.bake.progress import finished
from radtex_addon.cli import main as batch_module
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.export.export_manifest import Manifest
from radtex_addon.export.exporting import Exported, export_steps
from radtex_addon.export.exporting_scene import export_scene_steps
from radtex_addon.export.folder import LIST, files_in
from radtex_addon.export.gltf import extension_in
from radtex_addon.export.targets import web
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.furnished_room import LEVELS, NODES, bake_room
from tests.gltf_schema import extensions_of, problems

pytestmark = pytest.mark.one_blender
context: Any = bpy.context  # to the stubs, every pointer may be None

_TO_BLENDER = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The sidecars of a room's bakes, and the boxes of its objects; not to be written to."""
    sidecars = bake_room(tmp_path_factory.mktemp("room"))
    return {"sidecars": sidecars, "boxes": {item.name: _box(item) for item in bpy.data.objects}}


def _box(item: Any) -> tuple[Floats, Floats]:
    places = np.array([item.matrix_world @ vertex.co for vertex in item.data.vertices])
    return places.min(axis=0), places.max(axis=0)


@pytest.fixture(scope="module")
def made(room: dict[str, Any], tmp_path_factory: pytest.TempPathFactory) -> Exported:
    """The room as glTF; not to be written to."""
    return export(room["sidecars"], out=tmp_path_factory.mktemp("exported") / "Room.gltf")


@pytest.fixture(scope="module")
def glb(made: Exported) -> Glb:
    return Glb.read(made.folder / "Room.glb")


@pytest.fixture
def sidecars(room: dict[str, Any], tmp_path: Path) -> list[Path]:
    """The same in a folder of its own, to be written to."""
    first: Path = room["sidecars"][0]
    shutil.copytree(first.parent, tmp_path / "baked")
    return [tmp_path / "baked" / path.name for path in room["sidecars"]]


@pytest.fixture(autouse=True)
def _page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A web page in place of the built one, which a clone has only once its zip was built."""
    folder = tmp_path / "page"
    folder.mkdir()
    for name in web.FILES:
        (folder / name).write_text(web._UNNAMED)
    monkeypatch.setattr(web, "BUILT", folder)


def export(sidecars: list[Path], target: Target = Target.GLTF, **options: Any) -> Exported:
    return finished(export_scene_steps(sidecars, ExportSpec(target), "Room", **options))


def facts_of(made: Exported) -> dict[str, Any]:
    text = (made.folder / "Room.export.json").read_text(encoding="utf-8")
    facts: dict[str, Any] = json.loads(text)
    return facts


def matrix_of(node: dict[str, Any]) -> Floats:
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    move, scale = node.get("translation", (0, 0, 0)), node.get("scale", (1, 1, 1))
    return np.array(Matrix.LocRotScale(move, Quaternion((w, x, y, z)), scale))


def positions(glb: Glb, node: dict[str, Any]) -> Floats:
    """All corners of a node's mesh in Blender's world."""
    parts = glb.document["meshes"][node["mesh"]]["primitives"]
    place = np.concatenate(
        [glb.accessor(part["attributes"]["POSITION"])[glb.accessor(part["indices"])] for part in parts]
    )
    matrix = matrix_of(node)
    found: Floats = (place @ matrix[:3, :3].T + matrix[:3, 3]) @ _TO_BLENDER.T
    return found


def test_each_object_is_a_node_in_its_place(room: dict[str, Any], glb: Glb) -> None:
    nodes = {node["name"]: node for node in glb.document["nodes"]}
    shown = [glb.document["nodes"][index]["name"] for index in glb.document["scenes"][0]["nodes"]]
    assert sorted(shown) == sorted(NODES)
    assert sorted(nodes) == sorted([*NODES, *LEVELS])
    boxes = room["boxes"]
    for name in (*NODES[:4], "Tree_LOD0", *LEVELS):
        place = positions(glb, nodes[name])
        np.testing.assert_allclose([place.min(axis=0), place.max(axis=0)], boxes[name], atol=1e-4)
    crate = np.concatenate([positions(glb, nodes[name]) for name in ("Crate.Red", "Crate.Gold")])
    np.testing.assert_allclose([crate.min(axis=0), crate.max(axis=0)], boxes["Crate"], atol=1e-4)
    assert np.linalg.norm(nodes["Table"]["translation"]) > 1, "its origin stays where the artist had it"


def test_a_node_is_what_an_export_of_its_bake_alone_has(
    room: dict[str, Any], glb: Glb, tmp_path: Path
) -> None:
    for sidecar, name in ((room["sidecars"][0], "Ball"), (room["sidecars"][2], "Gem")):
        finished(export_steps(sidecar, ExportSpec(Target.GLTF), tmp_path / name))
        alone = Glb.read(tmp_path / name / f"{name}.glb")
        (theirs,) = alone.document["nodes"]
        (ours,) = (node for node in glb.document["nodes"] if node["name"] == name)
        assert {**ours, "mesh": 0} == theirs
        both = [
            each.document["meshes"][node["mesh"]]["primitives"]
            for each, node in ((glb, ours), (alone, theirs))
        ]
        for one, two in zip(*both, strict=True):
            for key in one["attributes"]:
                np.testing.assert_array_equal(
                    glb.accessor(one["attributes"][key]), alone.accessor(two["attributes"][key])
                )
            np.testing.assert_array_equal(glb.accessor(one["indices"]), alone.accessor(two["indices"]))
            facts, expected = (
                extension_in(each.document["materials"][part["material"]])
                for each, part in ((glb, one), (alone, two))
            )
            assert facts == expected | {"mesh": "Room.glb"}


def test_bounds_are_those_of_the_values(glb: Glb) -> None:
    used = [part["attributes"]["POSITION"] for mesh in glb.document["meshes"] for part in mesh["primitives"]]
    assert len(used) == len(set(used)) == len(NODES) + len(LEVELS) + 1, "Gem has two materials"
    for index in used:
        accessor, values = glb.document["accessors"][index], glb.accessor(index)
        np.testing.assert_array_equal(np.float32(accessor["min"]), values.min(axis=0))
        np.testing.assert_array_equal(np.float32(accessor["max"]), values.max(axis=0))


def test_levels_of_detail_are_in_the_place_of_the_finest(
    made: Exported, glb: Glb, room: dict[str, Any], out: Path
) -> None:
    document = glb.document
    of_levels = [node for node in document["nodes"] if "extensions" in node]
    (finest,) = of_levels
    assert finest["name"] == "Tree_LOD0"
    numbers = finest["extensions"]["MSFT_lod"]["ids"]
    assert [document["nodes"][number]["name"] for number in numbers] == LEVELS
    assert "MSFT_lod" in document["extensionsUsed"]
    entries = {entry["node"]: entry for entry in facts_of(made)["scene"]}
    assert [entry["node"] for entry in entries["Tree_LOD0"]["lods"]] == LEVELS
    few = export([room["sidecars"][0]] * 2, out=out)
    assert [entry["node"] for entry in facts_of(few)["scene"]] == ["Ball"], "named twice, it is there once"
    assert "MSFT_lod" not in Glb.read(few.folder / "Room.glb").document["extensionsUsed"]


@pytest.mark.parametrize("target", [each for each in Target if each not in (Target.UNITY, Target.UNREAL)])
def test_a_folder_has_one_manifest_and_each_texture_once(
    target: Target, sidecars: list[Path], temporary: Path
) -> None:
    made = export(sidecars, target)
    assert made.folder == sidecars[0].with_name(f"Room.{target}")
    facts = facts_of(made)
    assert list(facts) == ["version", "tool", "name", "mesh", "scene"]
    assert (facts["version"], facts["name"], facts["mesh"]) == (1, "Room", "Room.glb")
    assert [entry["node"] for entry in facts["scene"]] == NODES
    entries = [each for entry in facts["scene"] for each in (entry, *entry.get("lods", []))]
    named: dict[str, Any] = {}
    for entry in entries:
        assert "mesh" not in entry
        manifest = Manifest.from_json(json.dumps({**entry, "mesh": facts["mesh"]}))
        files = {manifest.flat, *(each.file for each in manifest.textures.values())}
        assert named.setdefault(manifest.name, files) == files
    every = [file for files in named.values() for file in files]
    assert len(every) == len(set(every))
    assert len(named) == 8, "Chair and Table share an atlas"
    assert {path for path in made.files if path.endswith((".ktx2", ".dds", ".png"))} == set(every)
    assert {"Room.glb", "Room.export.json"} <= set(made.files)
    assert len([name for name in made.files if name.endswith((".glb", ".export.json"))]) == 2
    images = Glb.read(made.folder / "Room.glb").document["images"]
    assert sorted(image["name"] for image in images) == sorted(f"{name}.flat.png" for name in named)
    for extension in extensions_of(made.folder / "Room.glb"):
        assert problems(extension) == []
    if target is Target.WEB:
        assert "Room.export.json" in (made.folder / "index.html").read_text(encoding="utf-8")
    elif target is Target.GODOT:
        *_, listed = (made.folder / "README.txt").read_text(encoding="utf-8").split("shows in any scene.\n")
        flats = {file for file in every if file.endswith(".flat.png")}
        assert set(listed.splitlines()) == {"Room.glb", *every} - flats
    else:
        text = (made.folder / "README.txt").read_text(encoding="utf-8")
        assert all(name in text for name in (*NODES, *every))
        assert {"shaders/LICENSE"} < {name for name in made.files if name.startswith("shaders/")}


def test_the_session_is_as_it_was_and_nothing_is_left(sidecars: list[Path], temporary: Path) -> None:
    before, there = fingerprint(), set(sidecars[0].parent.iterdir())
    steps = export_scene_steps(sidecars, ExportSpec(Target.GLTF), "Room")
    for _ in range(12):
        next(steps)
    steps.close()
    assert differences(before, fingerprint()) == {}
    assert set(sidecars[0].parent.iterdir()) == there
    made = export(sidecars)
    assert differences(before, fingerprint()) == {}
    assert list(made.files) == [name for name in files_in(made.folder) if name != LIST]
    with pytest.raises(InputError, match="is already there: overwrite it"):
        export(sidecars)
    assert export(sidecars, overwrite=True).files == made.files


def _twice(sidecars: list[Path]) -> list[Path]:
    shutil.copytree(sidecars[0].parent, sidecars[0].parent.with_name("other"))
    return [sidecars[0], sidecars[0].parent.with_name("other") / sidecars[0].name]


def _renamed(sidecars: list[Path], name: str = "Moon") -> list[Path]:
    """Another object's bake whose files have the first one's name, in another folder."""
    two = _twice(sidecars)
    facts = json.loads(two[1].read_text(encoding="utf-8"))
    two[1].write_text(json.dumps({**facts, "object": name}), encoding="utf-8")
    return two


def _of_one_object(sidecars: list[Path]) -> list[Path]:
    return [sidecars[1], _renamed(sidecars, "Chair")[1]]


@pytest.mark.parametrize(
    ("chosen", "options", "words"),
    [
        (_twice, {}, r"would be written to the same files: leave one out"),
        (_renamed, {}, r"would be written to the same files: leave one out"),
        (_of_one_object, {}, r"Furniture\.radiance\.json and .*Ball\.radiance\.json are both of 'Chair'"),
        (lambda _: [], {}, r"a scene of no bakes"),
        (lambda found: found[:1], {"mirror": True}, r"mirrors one bake, not a whole scene"),
    ],
)
def test_what_is_no_scene_is_refused(
    chosen: Callable[[list[Path]], list[Path]],
    options: dict[str, Any],
    words: str,
    sidecars: list[Path],
    out: Path,
) -> None:
    spec = ExportSpec(Target.GODOT, **options)
    with pytest.raises(InputError, match=words):
        finished(export_scene_steps(chosen(sidecars), spec, "Room", out))
    assert not out.exists()


def test_the_command_line_takes_a_folder_or_a_list(
    sidecars: list[Path], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    def ran(*words: str) -> tuple[int, list[dict[str, Any]], str]:
        capfd.readouterr()
        options = ["--to", "gltf", "--progress", "json"]
        code = batch_module.main(["export", *words, *options], inside_blender=False)
        said, error = capfd.readouterr()
        return code, [json.loads(line) for line in said.splitlines() if line.startswith("{")], error

    folder = sidecars[0].parent
    code, events, _ = ran(str(folder), "--scene", "Room")
    assert code == 0
    *progress, done = events
    stages = [event["stage"] for event in progress]
    assert list(dict.fromkeys(stages)) == ["textures", "flat", "mesh", "pack"]
    assert stages == sorted(stages, key=["textures", "flat", "mesh", "pack"].index), "none begins twice"
    assert (done["object"], done["files"]) == ("Room", [str(folder / "Room.gltf")])
    scene = json.loads((folder / "Room.gltf" / "Room.export.json").read_text(encoding="utf-8"))["scene"]
    assert sorted(entry["node"] for entry in scene) == sorted(NODES)
    out = tmp_path / "two"
    code, _, _ = ran(str(sidecars[0]), str(sidecars[2]), "--scene", "Two", "--out", str(out))
    assert (code, (out / "Two.glb").is_file()) == (0, True)
    code, _, error = ran(str(sidecars[0]), str(sidecars[2]), "--out", str(tmp_path / "three"))
    assert code == 2
    assert "or export them as one scene (--scene)" in error
    code, _, error = ran(str(sidecars[0]), str(sidecars[0]), "--overwrite")
    assert code == 2
    assert "would be that of two: export them one by one" in error
