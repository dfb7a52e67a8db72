# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake replaces only if told to: a better one, or another file's; and never: another object's."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import pytest

from tests.blender import stage
from tests.blender.batch_process import QUICK, Batch, refusal

pytestmark = [pytest.mark.one_blender, pytest.mark.usefixtures("temporary")]
context: Any = bpy.context  # to the stubs, every pointer may be None
Saved = Callable[[str], Path]
QUICKEST = [*QUICK, "--no-denoise"]


@pytest.fixture
def saved(tmp_path: Path) -> Saved:
    """Save a .blend with Ball, of two materials, and others whose bakes have the names of its parts."""
    stage.world()
    materials = [stage.material(name, "ShaderNodeBsdfDiffuse") for name in ("Gold", "Iron")]
    for number, name in enumerate(("Ball", "Ball.Gold", "Ball-0001", "Ball.material", "Ball-Key")):
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=2, y_subdivisions=1, location=(3 * number, 0, 0))
        context.object.name = name
        for each in materials:
            context.object.data.materials.append(each)
        context.object.data.polygons[1].material_index = 1
    bpy.ops.object.light_add(type="POINT", location=(0, 0, 3))
    context.object.name = "Key"

    def save(name: str) -> Path:
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
        return path

    return save


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def facts(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text())
    return found


@pytest.mark.parametrize(
    ("other", "options", "named"),
    [
        ("Ball.Gold", ["--split", "material"], "object 'Ball.Gold', not of object 'Ball', material Gold"),
        ("Ball-0001", ["--frames", "1"], "object 'Ball-0001', not of object 'Ball', frame 1"),
        ("Ball-Key", ["--lights", "Key"], "object 'Ball-Key', not of object 'Ball', light of Key"),
    ],
)
def test_a_bake_of_another_object_stays(
    saved: Saved, out: Path, batch: Batch, other: str, options: list[str], named: str
) -> None:
    blend = saved("room.blend")
    assert batch(blend, "--object", other, *QUICKEST, "--out", out).code == 0
    before = contents(out)
    for way in (["--changed"], ["--overwrite"], ["--overwrite-any"], ["--resume"], ["--accumulate"], []):
        ended = batch(blend, "--object=Ball", *QUICKEST, *options, *way, "--out", out)
        assert named in ended.err.splitlines()[-1], way
        assert "rename one of them, or choose another folder (--out)" in ended.err, way
        assert ended.code == 2, way
        assert contents(out) == before, way


def test_a_part_stays_where_an_object_of_its_files_name_is_baked(
    saved: Saved, out: Path, batch: Batch
) -> None:
    blend = saved("room.blend")
    assert (
        batch(blend, "--object=Ball", *QUICKEST, "--split=material", "--save-preview", "--out", out).code == 0
    )
    before = contents(out)
    ended = batch(blend, "--object=Ball.Gold", *QUICKEST, "--changed", "--out", out)
    assert "is a bake of object 'Ball', material Gold, not of object 'Ball.Gold'" in ended.err
    ended = batch(blend, "--object=Ball.material", *QUICKEST, "--changed", "--save-preview", "--out", out)
    assert "Ball.material.preview.blend is the preview of object 'Ball'" in ended.err
    assert ended.code == 2
    assert contents(out) == before


def test_an_atlas_of_others_by_the_same_name_stays(saved: Saved, out: Path, batch: Batch) -> None:
    blend = saved("room.blend")
    own_uv = ["--texels=16", *(word for word in QUICKEST if word not in ("--uv", "UVMap", "--texels", "4"))]
    shared = [blend, "--object=Ball", "--object=Ball.Gold", *own_uv, "--together=Ball", "--out", out]
    assert batch(*shared).code == 0
    before = contents(out)
    ended = batch(blend, "--object=Ball", *QUICKEST, "--changed", "--out", out)
    assert "is a bake of the atlas 'Ball' of Ball, Ball.Gold, not of object 'Ball'" in ended.err
    assert ended.code == 2
    assert contents(out) == before
    assert batch(*shared, "--object=Ball-0001", "--changed").code == 0  # the same atlas, with one object more


def test_an_unfinished_bake_of_another_object_stays(saved: Saved, out: Path, batch: Batch) -> None:
    blend = saved("room.blend")
    (out / "Ball.Gold.radiance.radtex-unfinished").mkdir(parents=True)
    key = {
        "version": 1,
        "pieces": 1,
        "facts": {"object": "Ball.Gold", "split": "None", "part": "None"},
        "replaces": [],
        "processes": [],
        "made": None,
    }
    (out / "Ball.Gold.radiance.radtex-unfinished" / "key.json").write_text(json.dumps(key))
    before = contents(out)
    for way in ("--changed", "--overwrite", "--overwrite-any"):
        ended = batch(blend, "--object=Ball", *QUICKEST, "--split=material", way, "--out", out)
        assert "is of another bake (object Ball.Gold" in ended.err
        assert contents(out) == before


def test_a_better_bake_is_replaced_only_if_that_is_said(saved: Saved, out: Path, batch: Batch) -> None:
    blend = saved("room.blend")
    bake = [blend, "--object=Ball", *QUICKEST, "--out", out]
    assert batch(*bake, "--samples=2").code == 0
    before = contents(out)
    for way in ("--overwrite", "--changed"):
        ended = batch(*bake, way)
        assert ended.err.splitlines()[-1] == (
            f"radtex: {out / 'Ball.radiance.json'} is a better bake (buckets, 4 texels, 2 cells a side, 2 "
            "samples) than the new one would be (buckets, 4 texels, 2 cells a side, 1 sample): replace it "
            "all the same (--overwrite-any), or choose another folder (--out)"
        )
        assert ended.code == 2
        assert contents(out) == before
    assert batch(*bake, "--overwrite", "--samples=2").code == 0
    assert batch(*bake, "--changed", "--overwrite-any").code == 0
    assert facts(out / "Ball.radiance.json")["samples"] == 1
    assert batch(*bake, "--overwrite", "--samples=2").code == 0
    assert batch(*bake, "--overwrite", "--passes=2").code == 0  # as good in the end
    assert facts(out / "Ball.radiance.json")["samples"] == 2


def test_two_files_have_folders_of_their_own(saved: Saved, batch: Batch, tmp_path: Path) -> None:
    first, second = saved("a.blend"), saved("b.blend")
    bake = ["--object=Ball", *QUICKEST]
    assert batch(first, *bake).code == 0
    before = contents(tmp_path / "radtex")
    assert set(before) == {"a/Ball.radiance.exr", "a/Ball.radiance.json"}
    assert batch(second, *bake).code == 0
    assert {name: data for name, data in contents(tmp_path / "radtex").items() if name in before} == before
    assert facts(tmp_path / "radtex" / "b" / "Ball.radiance.json")["blend"] == "b.blend"


def test_a_file_asks_before_it_replaces_anothers_bake(saved: Saved, batch: Batch, out: Path) -> None:
    first, second = saved("a.blend"), saved("b.blend")
    bake = ["--object=Ball", *QUICKEST, "--out", out]
    assert batch(first, *bake).code == 0
    before = contents(out)
    for way in ("--overwrite", "--accumulate"):
        told = refusal(batch(second, *bake, way))
        assert f"{out / 'Ball.radiance.json'} is a bake of a.blend, not of b.blend" in told
        assert "(--overwrite-any)" in told
        assert contents(out) == before
    assert batch(first, *bake, "--overwrite").code == 0
    assert batch(second, *bake, "--overwrite-any").code == 0
    assert facts(out / "Ball.radiance.json")["blend"] == "b.blend"


def test_a_file_that_was_renamed_with_its_folder_goes_on(saved: Saved, batch: Batch, tmp_path: Path) -> None:
    blend, bake = saved("a.blend"), ["--object=Ball", *QUICKEST]
    assert batch(blend, *bake).code == 0
    (tmp_path / "radtex" / "a").rename(tmp_path / "radtex" / "b")
    blend.rename(tmp_path / "b.blend")
    assert batch(tmp_path / "b.blend", *bake, "--overwrite").code == 0
    assert facts(tmp_path / "radtex" / "b" / "Ball.radiance.json")["blend"] == "b.blend"
