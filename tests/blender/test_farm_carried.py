# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A .blend from elsewhere may name any file here: only what is what it is taken for travels with a farm."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.farm import self_contained
from radtex_addon.farm.self_contained import pack_files
from radtex_addon.scene.checks.file_checks import check_outside_files
from tests.blender import stage

pytestmark = pytest.mark.one_blender

_SECRET = b"root:x:0:0:root:/root:/bin/bash\n"
_PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture(autouse=True)
def _empty() -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def _image(path: Path) -> None:
    image: Any = bpy.data.images.new("Rust", 1, 1)
    image.source, image.filepath_raw = "FILE", str(path)
    image.use_fake_user = True


def _tiles(path: Path) -> None:
    image: Any = bpy.data.images.new("Rust", 1, 1, tiled=True)
    path.with_name("tile.1001.png").write_bytes(_PNG)
    path.rename(path.with_name("tile.1002.png"))
    image.filepath_raw = str(path.with_name("tile.<UDIM>.png"))
    image.tiles.new(1002)
    image.use_fake_user = True


def _lamp(path: Path) -> None:
    lamp: Any = bpy.data.lights.new("Spot", "SPOT")
    if lamp.node_tree is None:
        lamp.use_nodes = True
    node = lamp.node_tree.nodes.new("ShaderNodeTexIES")
    node.mode, node.filepath = "EXTERNAL", str(path)
    lamp.use_fake_user = True


def _volume(path: Path) -> None:
    cloud = bpy.data.volumes.new("Cloud")
    cloud.filepath = str(path)
    cloud.use_fake_user = True


_USERS: list[tuple[Callable[[Path], None], str]] = [
    (_image, "image 'Rust'"),
    (_tiles, "image 'Rust'"),
    (_lamp, "lamp 'Spot'"),
    (_volume, "volume 'Cloud'"),
]


@pytest.mark.parametrize(("name_it", "user"), _USERS)
def test_a_secret_does_not_travel(name_it: Callable[[Path], None], user: str, tmp_path: Path) -> None:
    (tmp_path / "secret").write_bytes(_SECRET)
    name_it(tmp_path / "secret")
    farm = tmp_path / "farm"
    farm.mkdir()
    with pytest.raises(InputError, match=rf"^{user}: \S+ does not travel, for it is no \w+"):
        pack_files(farm)
    assert [path for path in farm.rglob("*") if path.is_file()] == []
    assert bpy.data.texts[:] == []
    assert [image for image in bpy.data.images if image.packed_files] == []


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such files")
@pytest.mark.parametrize("name_it", [_image, _lamp, _volume])
@pytest.mark.parametrize("path", ["/dev/zero", "pipe", "."])
def test_no_device_pipe_or_folder_is_read(name_it: Callable[[Path], None], path: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    name_it(tmp_path / path)
    with pytest.raises(InputError, match=r"cannot be read .*it is a (device|pipe|folder) and no file"):
        pack_files(tmp_path)
    if path != ".":
        with pytest.raises(InputError, match=r"names \S+, which is a (device|pipe) and no file: put a file"):
            check_outside_files()


@pytest.mark.parametrize(("name_it", "head"), [(_image, _PNG), (_volume, b" BDV\0\0\0\0")])
def test_what_is_too_large_does_not_travel(
    name_it: Callable[[Path], None], head: bytes, tmp_path: Path
) -> None:
    path = tmp_path / "large"
    path.write_bytes(head)
    os.truncate(path, self_contained.MOST_BESIDE + 1)  # sparse
    name_it(path)
    with pytest.raises(
        InputError, match=r"has 16\.0 GiB, and \S+ GiB are the most that travel: make it smaller"
    ):
        pack_files(tmp_path)
    path.unlink()


def test_all_files_together_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(self_contained, "MOST", 20)
    for name in ("One", "Two"):
        (tmp_path / name).write_bytes(b" BDV\0\0\0\0" + bytes(4))
        bpy.data.volumes.new(name).filepath = str(tmp_path / name)
        bpy.data.volumes[name].use_fake_user = True
    with pytest.raises(InputError, match="24 bytes would travel, and 20 bytes are the most"):
        pack_files(tmp_path)


def test_what_travels_is_told(tmp_path: Path) -> None:
    shape = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 1 1 1 2 0 0 0 1 1 1\n0\n0\n1\n"
    (tmp_path / "spot.ies").write_text(shape)
    (tmp_path / "cloud.vdb").write_bytes(b" BDV\0\0\0\0grids")
    _lamp(tmp_path / "spot.ies")
    _volume(tmp_path / "cloud.vdb")
    _image(tmp_path / "not there.png")  # which the bake shows in pink
    stage.world()
    farm = tmp_path / "farm"
    farm.mkdir()
    packed = pack_files(farm)
    assert [(each.user, each.bytes, each.how) for each in packed.carried] == [
        ("lamp 'Spot'", len(shape), "in the .blend"),
        ("volume 'Cloud'", 13, "beside the .blend"),
    ]
    (name,) = packed.beside
    assert (farm / name).read_bytes() == b" BDV\0\0\0\0grids"
    assert bpy.data.texts[0].as_string().startswith("IESNA")
    assert str(packed.carried[1]) == f"volume 'Cloud': {tmp_path}/cloud.vdb (beside the .blend, 13 bytes)"


def test_a_volume_that_was_copied_already_is_not_copied_again(tmp_path: Path) -> None:
    (tmp_path / "cloud.vdb").write_bytes(b" BDV\0\0\0\0grids")
    _volume(tmp_path / "cloud.vdb")
    farm, frames = tmp_path / "farm", tmp_path / "farm" / "frames"
    frames.mkdir(parents=True)
    (name,) = pack_files(farm).beside
    volume = bpy.data.volumes["Cloud"]
    volume.filepath = str(farm / name)  # as in a draft
    assert pack_files(frames, shared=farm).carried == ()
    assert volume.filepath == f"//../{name}"
    assert list(frames.iterdir()) == []
