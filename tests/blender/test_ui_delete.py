# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Deleting bakes from the disk: their own files alone, told before."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake.progress import Stage
from radtex_addon.job import bake_steps
from radtex_addon.preview.swap import is_on
from radtex_addon.store.output_files import delete_bake, files_of_bakes
from radtex_addon.ui.operators.delete_operator import told_files
from radtex_addon.ui.operators.export_sources import export_sources
from radtex_addon.ui.settings.request import spec_of, values_of
from tests.blender import stage
from tests.blender.ui_stage import context, ops, registered, settings
from tests.finished_bakes import finished_bake

pytestmark = pytest.mark.one_blender


@pytest.fixture(autouse=True)
def _baked(empty_file: None, out: Path) -> Iterator[None]:
    """Two cards with bakes, previews and exports, one of which holds a file of somebody else."""
    with registered():
        finished_bake(out, bake_cards)
        cards(out)
        (out / "Cup.gltf" / "mine.txt").write_text("by hand")
        (out / "Cup.notes.txt").write_text("by hand")
        yield


def cards(out: Path) -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.world()
    settings().directory = str(out)
    settings().atlas_layout = "buckets"
    settings().texels, settings().bucket, settings().samples = 4, 2, 1
    for name in ("Cup", "Plate"):
        bpy.ops.mesh.primitive_plane_add(size=2)
        context.object.name = name


def bake_cards(out: Path) -> None:
    cards(out)
    for name in ("Cup", "Plate"):
        assert ops.radtex.bake(object=name) == {"FINISHED"}
        assert ops.radtex.export(object=name, target="raw") == {"FINISHED"}
    assert ops.radtex.export(object="Cup", target="gltf") == {"FINISHED"}


def names(out: Path) -> set[str]:
    return {path.name for path in out.iterdir()}


def test_a_bakes_files_are_told_and_these_alone_are_deleted(out: Path) -> None:
    before, plate = names(out), {name for name in names(out) if name.startswith("Plate")}
    (found,) = files_of_bakes(export_sources(context.scene, context.view_layer, "Cup", ""))
    own = {"Cup.radiance.json", "Cup.radiance.exr", "Cup.preview.blend", "Cup.raw", "Cup.gltf"}
    assert {path.name for path in found.all} == own
    *listed, last = told_files([found])
    assert set(listed) == own
    assert last.endswith(f" in {out}")
    assert ops.radtex.preview_toggle(object="Cup", action="ON") == {"FINISHED"}
    assert ops.radtex.preview_toggle(object="Plate", action="ON") == {"FINISHED"}
    assert ops.radtex.delete_bake(object="Cup") == {"FINISHED"}
    assert names(out) == plate | {"Cup.gltf", "Cup.notes.txt"} | (before & {"preview-images"})
    assert [path.name for path in (out / "Cup.gltf").iterdir()] == ["mine.txt"]
    assert [is_on(bpy.data.objects[name]) for name in ("Cup", "Plate")] == [False, True]
    assert not bpy.data.objects["Cup"].hide_render
    with pytest.raises(RuntimeError, match="Cup"):
        ops.radtex.delete_bake(object="Cup")
    assert ops.radtex.bake(object="Cup") == {"FINISHED"}


def test_exported_files_that_were_changed_stay(out: Path) -> None:
    (model,) = (out / "Cup.gltf").glob("*.glb")
    model.write_bytes(model.read_bytes() + b"edited")
    for path in (out / "Cup.gltf").iterdir():
        os.utime(path)  # as by a program that copies the folder
    (found,) = files_of_bakes(export_sources(context.scene, context.view_layer, "Cup", ""))
    assert delete_bake(found) == [model]
    assert {path.name for path in (out / "Cup.gltf").iterdir()} == {"mine.txt", model.name}
    assert not (out / "Cup.raw").exists()


def test_a_preview_that_another_bake_has_too_stays(out: Path) -> None:
    settings().kind = "shadow"
    assert ops.radtex.bake(object="Cup", overwrite=True) == {"FINISHED"}
    assert ops.radtex.delete_bake(object="Cup", bake=str(out / "Cup.radiance.json")) == {"FINISHED"}
    left = {name for name in names(out) if name.startswith("Cup.") and "notes" not in name}
    assert left == {"Cup.shadow.json", "Cup.shadow.exr", "Cup.preview.blend", "Cup.gltf"}
    bpy.data.objects.remove(bpy.data.objects["Cup"])
    assert ops.radtex.delete_bake(object="Cup", bake=str(out / "Cup.shadow.json")) == {"FINISHED"}
    assert not {name for name in names(out) if name.startswith("Cup.shadow") or "Cup.preview" in name}


def test_a_preview_stays_with_a_bake_of_a_newer_radtex(out: Path) -> None:
    (out / "Cup.caustics.json").write_text('{"version": 99, "kind": "caustics"}')
    assert ops.radtex.delete_bake(object="Cup", bake=str(out / "Cup.radiance.json")) == {"FINISHED"}
    assert (out / "Cup.preview.blend").is_file()
    assert not (out / "Cup.radiance.json").exists()


def test_an_unfinished_bake_is_refused(out: Path) -> None:
    settings().kind = "radiance"
    steps: Any = bake_steps(context.scene, "Cup", spec_of(values_of(settings())), out, overwrite=True)
    while next(steps).stage is not Stage.WRITE:
        pass
    steps.close()
    before = names(out)
    with pytest.raises(RuntimeError, match=r"The bake of 'Cup' is not finished: go on with it \(Resume\)"):
        ops.radtex.delete_bake(object="Cup")
    assert names(out) == before
