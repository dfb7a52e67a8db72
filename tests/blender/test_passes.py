# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments of a bake in passes, and the server of its page."""

from __future__ import annotations

import urllib.request
from pathlib import Path

import pytest

from radtex_addon.cli.arguments import parse
from radtex_addon.cli.serving import address, serving
from radtex_addon.core.errors import InputError
from radtex_addon.export.page_server import HERE
from radtex_addon.settings.spec import Layout

pytestmark = pytest.mark.one_blender
BAKE = ["room.blend", "--object", "Vase"]
PAGE = ["--save-preview", "--export", "web"]


def test_passes_are_of_buckets_and_may_be_served() -> None:
    asked = parse([*BAKE, *PAGE, "--passes", "3", "--serve", "8000"], inside_blender=False)
    assert (asked.passes, asked.serve) == (3, 8000)
    assert asked.bakes.open_layout is None
    assert asked.bakes.spec.layout is Layout.BUCKETS
    assert not asked.bakes.spec.denoise
    plain = parse(BAKE, inside_blender=False)
    assert (plain.passes, plain.serve) == (1, None)
    assert plain.bakes.open_layout is not None
    assert plain.bakes.spec.denoise


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--passes", "0"], "1 or more"),
        ([*PAGE, "--passes", "2", "--layout", "layered", "--serve", "0"], "does not take in passes"),
        (["--passes", "2", "--kind", "shadow"], "kind shadow cannot be accumulated"),
        (["--serve", "8000"], "--export web"),
        ([*PAGE, "--serve", "70000"], "a port from 0 to 65535"),
    ],
)
def test_what_cannot_be_refined_or_served_is_refused(options: list[str], words: str) -> None:
    with pytest.raises(InputError, match=words):
        parse([*BAKE, *options], inside_blender=False)


def test_files_are_served_without_being_cached(tmp_path: Path) -> None:
    folder = tmp_path / "My vase.web"
    folder.mkdir()
    (folder / "index.html").write_text("a page")
    with serving(tmp_path, 0) as port:
        assert port
        where = address(port, folder)
        assert where == f"http://{HERE}:{port}/My%20vase.web/?watch"
        with urllib.request.urlopen(where) as answer:
            assert answer.read() == b"a page"
            assert answer.headers["Cache-Control"] == "no-store"
        with pytest.raises(InputError, match="cannot be had"), serving(tmp_path, port):
            pass
    with serving(tmp_path, None) as none:
        assert none is None
