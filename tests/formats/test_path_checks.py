# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Folders and files whose names nobody can be given: one line, and nothing made."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.formats.disk.atomic import check_absent, check_writable
from radtex_addon.formats.disk.path_checks import (
    check_for_blender,
    check_loadable,
    check_saveable,
    check_unicode,
    nearest_folder,
)

links = pytest.mark.skipif(sys.platform == "win32", reason="links need a right there")


def test_the_nearest_folder_that_is_there(tmp_path: Path) -> None:
    assert nearest_folder(tmp_path) == tmp_path
    for name in ("a/b", "with space/and more ", "ü/日本語/🦊/e\u0301", "trail.", "-rf", "x" * 255):
        assert nearest_folder(tmp_path / name) == tmp_path
    assert nearest_folder(Path("not there")) == Path.cwd()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("x" * 300, "a name in it has 300 bytes, 255 is the most; choose another folder"),
        ("日" * 90, "a name in it has 270 bytes"),
        ("d/" * 3000, "its path with a file's name has"),
        ("\udcff", "this name is not Unicode"),
        ("a\0b", "no name may hold a zero byte"),
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="a POSIX system's bounds")
def test_names_that_no_folder_can_have(name: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=words):
        check_writable(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


@links
def test_a_link_that_leads_nowhere_is_no_folder_and_no_free_name(tmp_path: Path) -> None:
    (tmp_path / "gone").symlink_to(tmp_path / "nowhere")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    for name in ("gone", "gone/below", "loop"):
        with pytest.raises(InputError, match="is a link that leads nowhere; choose another folder"):
            check_writable(tmp_path / name)
    for name in ("gone", "loop"):
        with pytest.raises(InputError, match="is already there"):
            check_absent([tmp_path / name], overwrite=False)
        check_absent([tmp_path / name], overwrite=True)
    assert not (tmp_path / "nowhere").exists()


def test_what_blender_can_name(tmp_path: Path) -> None:
    for name in ("a b.blend", "ü日本🦊.blend", "e\u0301.blend"):
        check_saveable(tmp_path / name)
    deep = tmp_path / "/".join(["deep"] * 250) / "a.blend"
    with pytest.raises(InputError, match="bytes, and Blender handles 1023: choose another"):
        check_for_blender(deep)
    with pytest.raises(InputError, match="not Unicode"):
        check_for_blender(tmp_path / "\udcff.blend")
    nearly = tmp_path / "/".join(["deep"] * ((900 - len(os.fsencode(tmp_path))) // 5)) / "a.blend"
    check_for_blender(nearly)
    with pytest.raises(InputError, match="Blender handles 1023"):
        check_saveable(nearly)
    with pytest.raises(InputError, match="zero byte"):
        check_unicode(Path("a\0b"))
    if os.sep == "/":
        check_for_blender(tmp_path / "a\\b.blend")
        with pytest.raises(InputError, match="Blender takes a backslash for a slash"):
            check_saveable(tmp_path / "a\\b.blend")
        with pytest.raises(InputError, match=r"a\\b\.blend: Blender takes a backslash .* rename it"):
            check_loadable(tmp_path / "a\\b.blend")
