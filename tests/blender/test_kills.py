# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that are killed, or whose disk runs full, and gone on with: to the same files, to the last bit.

The whole of it takes minutes: `python -m tests.bench.kills` and `python -m tests.bench.disks`.
"""

from __future__ import annotations

import signal
import sys
import time
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.core.errors import BakeError, InputError
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec
from tests.blender.disk import small_disk, unavailable
from tests.blender.killed import Command, digests, left_behind
from tests.blender.room import fill_room, save_room

context: Any = bpy.context  # to the stubs, every pointer may be None

pytestmark = [
    pytest.mark.one_blender,
    pytest.mark.skipif(sys.platform == "win32", reason="there are no signals"),
]

PLAIN = BakeSpec(uv_layer="UVMap", texels=24, bucket=16, samples=1, sheet=128, denoise=True)
ARGUMENTS = (
    *("--layout", "buckets", "--uv", "UVMap", "--texels", "24", "--bucket", "16"),
    *("--samples", "1", "--sheet", "128"),
)


def command(tmp_path: Path) -> Command:
    return Command(save_room(tmp_path / "room.blend"), tmp_path / "temporary", ARGUMENTS)


def test_a_killed_bake_is_gone_on_with_and_one_that_lives_is_not(tmp_path: Path) -> None:
    killed = command(tmp_path)
    whole, out = tmp_path / "whole", tmp_path / "out"
    bpy.ops.wm.open_mainfile(filepath=str(killed.blend))  # a sidecar names the .blend
    bake_object(context.scene, "Ball", PLAIN, whole)
    running = killed.start(out)
    while len(list(out.glob("*/*.piece"))) < 2:
        assert running.process.poll() is None
        time.sleep(0.001)
    running.process.send_signal(signal.SIGSTOP)
    try:
        who = f"is in use, process {running.process.pid} on .* bakes into it: wait for its end, or end it$"
        with pytest.raises(InputError, match=who):
            bake_object(context.scene, "Ball", PLAIN, out, resume=True)
    finally:
        running.process.kill()
    assert running.end().code == -signal.SIGKILL
    resumed = killed.start(out, "--resume").end()
    assert (resumed.code, resumed.err, resumed.warnings) == (0, "", [])
    assert digests(out) == digests(whole)
    assert left_behind(killed.temporary) == []


def test_a_signal_ends_a_bake_in_the_midst_of_a_long_render(tmp_path: Path) -> None:
    """Its first render would take a day."""
    arguments = ("--layout", "buckets", "--texels", "64", "--bucket", "8", "--samples", "1000000")
    endless = Command(save_room(tmp_path / "room.blend"), tmp_path / "temporary", arguments)
    running = endless.start(tmp_path / "out")
    assert running.wait_for("capture")
    running.process.send_signal(signal.SIGTERM)
    try:
        ended = running.end(30)
    finally:
        running.process.kill()
    said = "interrupted; what is finished of 'Ball' is kept: go on with it (--resume)"
    assert (ended.code, ended.err, ended.error) == (130, f"radtex: {said}\n", said)
    assert left_behind(endless.temporary) == []
    assert list((tmp_path / "out" / "Ball.radiance.radtex-unfinished").glob("*.piece"))


@pytest.mark.skipif(bool(unavailable()), reason=unavailable())
def test_a_full_disk_is_one_line_and_costs_nothing_that_is_done(tmp_path: Path) -> None:
    fill_room()
    whole = tmp_path / "whole"
    bake_object(context.scene, "Ball", PLAIN, whole)
    with small_disk(tmp_path, 8) as disk:
        out = disk.folder / "out"
        disk.fill(400 << 10)
        with pytest.raises(BakeError, match=r"/out/\S+ could not be written: No space left on device; free"):
            bake_object(context.scene, "Ball", PLAIN, out)
        (unfinished,) = out.iterdir()
        assert not list(unfinished.glob(".*"))
        assert list(unfinished.glob("*.piece"))
        disk.empty()
        bake_object(context.scene, "Ball", PLAIN, out, resume=True)
        assert digests(out) == digests(whole)
