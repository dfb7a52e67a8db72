# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""No way in runs a script, or Python of a driver, that lies in a .blend; who needs one is told."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.preview import osl
from radtex_addon.preview.save import render_picture
from tests.blender import stage
from tests.blender.batch_process import QUICK, Batch, process

context: Any = bpy.context
SAID = "the driver of location of object 'Card' has no value"


class Trap:
    """A scene whose script, drivers and shader write canaries, where they run."""

    def __init__(self, folder: Path) -> None:
        self.cage = folder / "cage"
        self.cage.mkdir()
        self.blend = folder / "trap.blend"

    def writes(self, name: str) -> str:
        """A driver's expression."""
        return f"open({str(self.cage / name)!r}, 'w').close() or 0.25"

    @property
    def canaries(self) -> set[str]:
        """What has run."""
        return {path.name for path in self.cage.iterdir()}


@pytest.fixture(scope="module")
def trap(tmp_path_factory: pytest.TempPathFactory) -> Trap:
    made = Trap(tmp_path_factory.mktemp("trap"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_plane_add()
    card = context.object
    card.name = "Card"
    card.driver_add("location", 0).driver.expression = made.writes("object")
    material = stage.material("white", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1))
    card.data.materials.append(material)
    roughness = material.node_tree.nodes[0].inputs["Roughness"]
    roughness.driver_add("default_value").driver.expression = made.writes("material")
    unseen = bpy.data.objects.new("Unseen", card.data)
    unseen.hide_viewport = True  # evaluated by renders alone
    context.scene.collection.objects.link(unseen)
    unseen.location.z = -5
    unseen.driver_add("location", 1).driver.expression = made.writes("render")
    script = bpy.data.texts.new("register.py")
    script.use_module = True
    script.write(
        f"import bpy\nopen({str(made.cage / 'script')!r}, 'w').close()\n"
        f"def wrote(*_): open({str(made.cage / 'handler')!r}, 'w').close()\n"
        "bpy.app.handlers.depsgraph_update_post.append(wrote)\n"
    )
    stage.world()
    lens = bpy.data.cameras.new("Camera")
    context.scene.camera = bpy.data.objects.new("Camera", lens)
    context.scene.collection.objects.link(context.scene.camera)
    context.scene.camera.location.z = 5
    bpy.ops.wm.save_as_mainfile(filepath=str(made.blend), copy=True)
    return made


@pytest.fixture(autouse=True)
def trusting(trap: Trap, empty_file: None) -> None:
    """A user whose preferences let every file run its scripts."""
    for path in trap.cage.iterdir():
        path.unlink()
    context.preferences.filepaths.use_scripts_auto_execute = True


def test_the_trap_works(trap: Trap) -> None:
    """Or the other tests here showed nothing."""
    bpy.ops.wm.open_mainfile(filepath=str(trap.blend))
    context.view_layer.update()
    assert {"object", "material", "script"} <= trap.canaries


def test_no_command_runs_scripts(trap: Trap, out: Path, batch: Batch) -> None:
    """A report opens scenes as a comparison does."""
    ended = batch(trap.blend, "--object", "Card", *QUICK, "--save-preview", "--out", out)
    assert (ended.code, trap.canaries) == (0, set()), ended.err
    assert SAID in ended.err
    assert "material 'white'" in ended.err
    assert "object 'Unseen'" in ended.err
    assert "blender -b --enable-autoexec FILE -P bake.py" in ended.err
    assert context.preferences.filepaths.use_scripts_auto_execute, "as it was"
    small = ("--pixels", "16", "--samples", "1", "--progress", "none")
    ended = batch("compare", trap.blend, "--object", "Card", "--bake", out, "--out", out, *small)
    assert (ended.code, trap.canaries) == (0, set()), ended.err
    assert SAID in ended.err
    ended = batch("export", out, "--to", "raw", "--progress", "none")
    assert (ended.code, trap.canaries) == (0, set()), ended.err
    render_picture(out / "Card.preview.blend", out / "Card.png", pixels=16, samples=1)
    assert trap.canaries == set()


def test_a_process_of_its_own_with_the_users_preferences(trap: Trap, tmp_path: Path) -> None:
    """The panel's workers and a pipeline's runs alike."""
    home = os.environ | {"BLENDER_USER_RESOURCES": str(tmp_path)}
    bpy.ops.wm.save_userpref()
    (tmp_path / "config").mkdir()
    shutil.copy(Path(bpy.utils.resource_path("USER"), "config", "userpref.blend"), tmp_path / "config")
    ended = process(trap.blend, "--object", "Card", *QUICK, "--out", tmp_path / "out", env=home)
    assert (ended.code, trap.canaries) == (0, set()), ended.err
    assert SAID in ended.err


@pytest.mark.parametrize("trusted", [True, False])
def test_inside_blender_it_is_the_choice_of_who_started_it(
    trusted: bool, trap: Trap, out: Path, batch: Batch
) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(trap.blend), use_scripts=trusted)
    ended = batch("--object", "Card", *QUICK, "--out", out, inside_blender=True)
    assert ended.code == 0
    assert bpy.data.filepath == str(trap.blend)
    assert (SAID in ended.err) == (not trusted)
    if trusted:
        assert trap.canaries >= {"material", "object", "render", "script"}
    else:
        assert trap.canaries == set()


def test_an_osl_shader_of_a_file_writes_none(tmp_path: Path, out: Path, batch: Batch) -> None:
    """OSL knows a fprintf; Cycles prints what it says."""
    bpy.ops.mesh.primitive_plane_add()
    context.object.name = "Card"
    made = stage.material("printing", "ShaderNodeBsdfDiffuse")
    context.object.data.materials.append(made)
    text = bpy.data.texts.new("canary.osl")
    text.write(
        "shader canary(output closure color BSDF = 0)\n"
        f'{{ fprintf("{(tmp_path / "canary").as_posix()}", "ran\\n"); BSDF = 0.5 * diffuse(N); }}\n'
    )
    node: Any = made.node_tree.nodes.new("ShaderNodeScript")
    try:
        osl._compile(node, text)
    except InputError as error:
        pytest.skip(str(error))
    surface = next(one for one in made.node_tree.nodes if one.type == "OUTPUT_MATERIAL").inputs["Surface"]
    made.node_tree.links.new(node.outputs["BSDF"], surface)
    stage.world()
    context.scene.cycles.shading_system = True
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "osl.blend"), copy=True)
    ended = batch(tmp_path / "osl.blend", "--object", "Card", *QUICK, "--device", "cpu", "--out", out)
    assert (ended.code, ended.err) == (0, "")
    assert len(ended.out.splitlines()) == 3, "what it printed is not among ours"
    assert not (tmp_path / "canary").exists()
