# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The export dialog: what it says of bakes and folders, which settings it shows, what OK then does."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.core.sampler import Filter
from radtex_addon.export.exporting import ExportSource, about_texture_bytes, export_steps
from radtex_addon.export.targets import web
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, Kind
from radtex_addon.textures.export_spec import ExportSpec, Target
from radtex_addon.textures.kept_exports import kept_exports
from radtex_addon.ui import registration
from radtex_addon.ui.operators.export_dialog import dialog_title, draw_dialog
from radtex_addon.ui.operators.export_operator import RADTEX_OT_export
from radtex_addon.ui.settings.preferences import ADDON, preferred
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.test_swap import LAYERED, NAME, PLAIN, bake_of, ball

pytestmark = pytest.mark.one_blender

context: Any = bpy.context  # to the stubs, every pointer may be None
radtex: Any = bpy.ops.radtex  # type: ignore[attr-defined]  # ours, not Blender's

SHADOW = BakeSpec(kind=Kind.SHADOW, texels=16)
OTHER = "Other"
STORED = {"format", "zstd", "arrangement", "levels", "limit", "mesh"}


class RADTEX_OT_asked(RADTEX_OT_export):  # noqa: N801  # Blender wants such names
    """The export operator, whose dialog is written down instead of shown; OK is pressed in it"""

    bl_idname = "radtex.asked"
    is_pressed = True
    drawn: RecordedLayout
    title: str

    def execute(self, context: Any) -> Any:
        self.ask_for(context)
        type(self).drawn = RecordedLayout()
        type(self).title = dialog_title(self._sources)
        draw_dialog(self.drawn, self, self._planned())
        return super().execute(context) if self.is_pressed else {"FINISHED"}


@pytest.fixture(scope="module")
def bakes(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Path]:
    """Folders of bakes of a ball, and of one more in the first; not to be written to."""
    specs = {"plain": PLAIN, "layered": LAYERED, "shadow": SHADOW}
    folders = {name: bake_of(spec, tmp_path_factory.mktemp(name)).parent for name, spec in specs.items()}
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    ball(OTHER)
    bake_object(context.scene, OTHER, PLAIN, folders["plain"], preview=Filter.QUADRILINEAR)
    return folders


@pytest.fixture(autouse=True)
def _page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A web page in place of the built one, which a clone has only once its zip was built."""
    for name in web.FILES:
        (tmp_path / name).write_text(web._UNNAMED)
    monkeypatch.setattr(web, "BUILT", tmp_path)


@pytest.fixture(autouse=True)
def registered(bakes: Mapping[str, Path]) -> Iterator[None]:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    ball(OTHER)
    ball()
    registration.register()
    bpy.utils.register_class(RADTEX_OT_asked)
    yield
    bpy.utils.unregister_class(RADTEX_OT_asked)
    registration.unregister()


@pytest.fixture
def plain(bakes: Mapping[str, Path], tmp_path: Path) -> Path:
    """A folder of bakes of two balls, to be written to."""
    return Path(shutil.copytree(bakes["plain"], tmp_path / "bake"))


def asked(**settings: Any) -> RecordedLayout:
    """What the dialog showed before OK was pressed."""
    assert radtex.asked(**settings) == {"FINISHED"}
    return RADTEX_OT_asked.drawn


def said(drawn: RecordedLayout) -> str:
    return " ".join(drawn.texts)


@pytest.mark.parametrize("kept", ["plain", "layered", "shadow"])
def test_every_dialog_shows_the_settings_that_apply(
    kept: str, bakes: Mapping[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bake = shutil.copytree(bakes[kept], tmp_path / "bake")
    context.scene.radtex.kind = "shadow" if kept == "shadow" else "radiance"
    for target in Target:
        settings = {"bake": str(bake), "object": NAME, "target": target, "advanced": True}
        if kept == "shadow" and target in (Target.UNITY, Target.UNREAL):
            with pytest.raises(RuntimeError, match="of kind shadow, which"):
                asked(**settings)
            assert "of kind shadow, which" in said(RADTEX_OT_asked.drawn), "the dialog said so before"
            continue
        with monkeypatch.context() as patch:
            patch.setattr(RADTEX_OT_asked, "is_pressed", target is Target.GODOT)
            drawn = asked(**settings)
        assert f"{NAME}.{target}" in said(drawn)
        hidden = {
            "plain": set(),
            "layered": {"arrangement", "levels"},
            "shadow": {"format", "arrangement", "levels"},
        }[kept]
        reads_ktx2 = any(form.startswith("ktx2") for form in target.traits.formats)
        hidden |= set() if reads_ktx2 else {"zstd"}
        hidden |= set() if target in (Target.WEB, Target.GLTF) else {"mesh"}
        assert STORED - set(drawn.settings) == hidden, target
        assert drawn.settings[0] == "target"
        shows_mirror = kept != "shadow" and target in (Target.WEB, Target.GODOT)
        assert ("mirror" in drawn.settings) == shows_mirror, target
    assert (bake / f"{NAME}.godot" / f"{NAME}.glb").is_file()


def test_the_dialog_tells_which_bake_it_is_about(plain: Path) -> None:
    os.utime(plain / f"{NAME}.radiance.json", (1e9, 1e9))  # 9 September 2001
    drawn = asked(bake=str(plain), object=NAME, target="raw")
    assert RADTEX_OT_asked.title == "Export Bake of Ball"
    assert drawn.texts[0] == "Radiance, 16 x 8 texels"
    assert "Sep 2001" in said(drawn)
    assert plain.name in said(drawn)
    assert STORED.isdisjoint(drawn.settings), "they are folded away"
    assert "overwrite" not in drawn.settings, "nothing is there"


def test_an_export_that_is_there_is_said_and_replaced(plain: Path) -> None:
    settings = {"bake": str(plain), "object": NAME, "target": "raw"}
    asked(**settings)
    drawn = asked(**settings)
    assert "It is there already: will be replaced" in said(drawn)
    assert "overwrite" in drawn.settings
    with pytest.raises(RuntimeError, match="is already there"):
        asked(**settings, overwrite=False)
    assert "tick Overwrite to replace it" in said(RADTEX_OT_asked.drawn)


def test_of_several_bakes_the_number_is_said(plain: Path) -> None:
    for item in bpy.data.objects:
        item.select_set(True)
    asked(bake=str(plain), object=OTHER, target="raw")
    drawn = asked(bake=str(plain), target="raw")
    assert RADTEX_OT_asked.title == "Export 2 Bakes"
    assert "Ball, Other" in drawn.texts[0]
    assert "1 of 2 are there already" in said(drawn)
    assert "directory" not in drawn.settings
    assert (plain / f"{NAME}.raw").is_dir()


def test_several_bakes_go_into_one_scene_if_that_is_asked_for(plain: Path) -> None:
    for item in bpy.data.objects:
        item.select_set(True)
    context.scene.name = "Room"
    remembered = {"as_scene": True, "mirror": True}
    drawn = asked(bake=str(plain), target="godot", **remembered)
    assert drawn.settings[:4] == ["target", "as_scene", "scene_name", "into"]
    assert "Makes the folder Room.godot in" in said(drawn)
    assert "mirror" not in drawn.settings, "a ball mirrors one bake"
    assert (plain / "Room.godot" / "Room.glb").is_file()
    assert not (plain / f"{NAME}.godot").exists()
    drawn = asked(bake=str(plain), target="godot", scene_name="Room", **remembered)
    assert "It is there already: will be replaced" in said(drawn)
    out = plain / "elsewhere"
    asked(bake=str(plain), target="gltf", scene_name="Attic", directory=str(out), **remembered)
    assert (out / "Attic.glb").is_file()
    drawn = asked(bake=str(plain), object=NAME, target="raw", **remembered)
    assert "as_scene" not in drawn.settings, "there is one bake only"
    assert (plain / f"{NAME}.raw" / f"{NAME}.glb").is_file()


def test_what_is_hidden_does_not_count(bakes: Mapping[str, Path], tmp_path: Path) -> None:
    """Blender remembers the settings of the last dialog, which may have been of another target and bake."""
    bake = shutil.copytree(bakes["layered"], tmp_path / "bake")
    remembered = {"format": "ktx2-rgb9e5", "mirror": True, "arrangement": "slices", "levels": 3}
    asked(bake=str(bake), object=NAME, target="unity", **remembered)
    assert list((bake / f"{NAME}.unity").glob("*.dds"))


def test_a_dialog_starts_with_what_was_chosen_in_the_last_one(plain: Path, tmp_path: Path) -> None:
    """In other files, too, but for a folder that is no longer there."""
    game, settings = tmp_path / "game", {"bake": str(plain), "object": NAME}
    game.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "another.blend"), copy=True)
    addon = context.preferences.addons.new()
    addon.module = ADDON
    try:
        asked(**settings, target="raw", into=str(game))
        assert context.preferences.is_dirty
        assert (game / f"{NAME}.raw").is_dir()
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "another.blend"))
        drawn = asked(bake=str(plain), object=OTHER)
        assert f"Makes the folder {OTHER}.raw in //game" in said(drawn)
        assert (game / f"{OTHER}.raw").is_dir()
        shutil.rmtree(game)
        assert f"Makes the folder {OTHER}.raw in //bake" in said(asked(bake=str(plain), object=OTHER))
    finally:
        context.preferences.addons.remove(addon)


def test_what_was_chosen_for_a_scene_is_kept_too(plain: Path, tmp_path: Path) -> None:
    for item in bpy.data.objects:
        item.select_set(True)
    addon = context.preferences.addons.new()
    addon.module = ADDON
    try:
        asked(bake=str(plain), target="raw", as_scene=True, scene_name="Room", into=str(tmp_path))
        assert (tmp_path / "Room.raw" / "Room.glb").is_file()
        assert (preferred().export_target, preferred().export_into) == ("raw", str(tmp_path))
    finally:
        context.preferences.addons.remove(addon)


def test_the_dialog_remembers_for_each_target_what_follows_a_bake(plain: Path, tmp_path: Path) -> None:
    settings = {"bake": str(plain), "object": NAME, "into": str(tmp_path)}
    assert "again" in asked(**settings, target="raw", again=True).settings
    assert [found.spec.target for found in kept_exports(context.scene)] == [Target.RAW]
    asked(**settings, target="gltf")
    assert [found.spec.target for found in kept_exports(context.scene)] == [Target.RAW]
    asked(**settings, target="raw", levels=1)
    (found,) = kept_exports(context.scene)
    assert (found.spec.levels, found.out) == (1, tmp_path / f"{NAME}.raw"), "the last settings count"
    asked(**settings, target="raw", again=False)
    assert kept_exports(context.scene) == ()


def test_a_scene_that_follows_each_bake_says_nothing_of_its_bakes_alone(plain: Path) -> None:
    for item in bpy.data.objects:
        item.select_set(True)
    settings = {"bake": str(plain), "target": "raw"}
    asked(**settings, as_scene=True, scene_name="Room", again=True)
    asked(**settings, object=NAME)
    (found,) = kept_exports(context.scene)
    assert (found.scene, len(found.sidecars)) == ("Room", 2)
    asked(**settings, as_scene=True, scene_name="Attic")
    assert [found.name for found in kept_exports(context.scene)] == ["Room"], "another name, another export"
    asked(**settings, as_scene=True, scene_name="Room", again=False)
    assert kept_exports(context.scene) == ()


def test_two_bakes_in_one_folder_are_refused_before(plain: Path, tmp_path: Path) -> None:
    for item in bpy.data.objects:
        item.select_set(True)
    with pytest.raises(RuntimeError, match="Several bakes do not fit in one folder"):
        asked(bake=str(plain), target="raw", directory=str(tmp_path / "one"))
    assert "would be that of two" in said(RADTEX_OT_asked.drawn)
    assert not (tmp_path / "one").exists()


@pytest.mark.parametrize(
    ("kept", "settings", "words"),
    [
        ("layered", {"format": "exr"}, "mip levels, which EXRs cannot hold"),
        ("plain", {"levels": 15}, "which make 5 levels at most"),
        ("plain", {"target": "web", "mirror": True, "arrangement": "slices"}, "mirror ball reads no slices"),
    ],
)
def test_textures_that_a_bake_cannot_have_are_said_before(
    kept: str, settings: dict[str, Any], words: str, bakes: Mapping[str, Path], tmp_path: Path
) -> None:
    bake = shutil.copytree(bakes[kept], tmp_path / "bake")
    with pytest.raises(RuntimeError, match=words):
        asked(**{"bake": str(bake), "object": NAME, "target": "raw"} | settings)
    assert words in said(RADTEX_OT_asked.drawn)


@pytest.mark.parametrize("kept", ["plain", "layered", "shadow"])
@pytest.mark.parametrize("target", [Target.WEB, Target.RAW])
def test_textures_are_about_as_large_as_said(
    kept: str, target: Target, bakes: Mapping[str, Path], tmp_path: Path
) -> None:
    kind = "shadow" if kept == "shadow" else "radiance"
    sidecar, spec = bakes[kept] / f"{NAME}.{kind}.json", ExportSpec(target, zstd=False)
    made = finished(export_steps(sidecar, spec, tmp_path / "made"))
    textures = [name for name in made.files if name.endswith((".ktx2", ".dds"))]
    found = sum((made.folder / name).stat().st_size for name in textures)
    headers = 500 * len(textures)
    assert found / 3 <= about_texture_bytes(ExportSource.of(sidecar), spec) + headers <= found * 3
