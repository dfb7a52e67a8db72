# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel shows the latest picture of each bake that runs, and each bake's UV map."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.formats.containers.png import encode_png
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.ui.jobs import pictures
from radtex_addon.ui.panel.jobs_panel import map_figures
from radtex_addon.worker.job import Job, JobMap, JobState
from radtex_addon.worker.order import Handover
from radtex_addon.worker.orders import order_bake


@pytest.fixture(autouse=True)
def _forgotten() -> Iterator[None]:
    yield
    pictures.unregister()


def job(tmp_path: Path, number: int = 1) -> Job:
    path = tmp_path / f"{number}.png"
    handover = Handover(tmp_path, tmp_path / "room.blend", "Scene", None, "cpu", 0.0)
    order = order_bake(handover, "Card", BakeSpec(), tmp_path)
    return Job(number, order, state=JobState.RUNNING, picture=path)


def painted(one: Job, width: int, time: int) -> None:
    assert one.picture is not None
    one.picture.write_bytes(encode_png(np.full((4, width, 3), 0.5, dtype=np.float32)))
    os.utime(one.picture, ns=(time, time))


def test_a_picture_is_shown_while_it_is_there_and_its_bake_runs(tmp_path: Path) -> None:
    one, other = job(tmp_path), job(tmp_path, 2)
    assert not pictures.update([one, other])
    painted(one, 8, 10**9)
    assert pictures.update([one, other])
    assert list(pictures._album.collection) == ["1"]
    assert pictures.icon(other) == 0
    assert not pictures.update([one, other])  # nothing new
    assert pictures.update([replace(one, state=JobState.DONE), other])
    assert list(pictures._album.collection) == []


def test_a_new_picture_replaces_the_old_one(tmp_path: Path) -> None:
    one = job(tmp_path)
    for width in (8, 16):
        painted(one, width, width * 10**9)
        assert pictures.update([one])
        assert tuple(pictures._album.collection["1"].image_size) == (width, 4)


def mapped(one: Job, tmp_path: Path) -> Job:
    path = tmp_path / f"{one.number}.map.png"
    path.write_bytes(encode_png(np.full((8, 8, 3), 0.5, dtype=np.float32)))
    return replace(one, map=JobMap(path, islands=41, coverage=0.554))


def test_a_map_is_shown_where_it_is_unfolded_and_stays_when_its_file_goes(tmp_path: Path) -> None:
    one, other = mapped(job(tmp_path), tmp_path), job(tmp_path, 2)
    assert pictures.update([one, other])
    assert not pictures.update([one, other])  # nothing new
    assert pictures.unfolded_map(one) is None
    pictures.toggle_map(1)
    assert tuple(pictures.unfolded_map(one).image_size) == (8, 8)
    assert pictures.unfolded_map(other) is None
    assert one.map is not None
    one.map.picture.unlink()
    ended = replace(one, state=JobState.DONE)
    pictures.update([ended, other])
    assert tuple(pictures.unfolded_map(ended).image_size) == (8, 8)
    pictures.toggle_map(1)
    assert pictures.unfolded_map(ended) is None


def test_maps_of_jobs_that_are_taken_off_the_list_are_freed_and_the_others_stay(tmp_path: Path) -> None:
    one, other = mapped(job(tmp_path), tmp_path), mapped(job(tmp_path, 2), tmp_path)
    pictures.update([one, other])
    pictures.toggle_map(1)
    pictures.toggle_map(2)
    pictures.update([other])
    assert list(pictures._album.maps) == ["2"]
    assert not pictures.is_unfolded(one)
    assert pictures.unfolded_map(other) is not None


def test_the_figures_of_a_map_are_one_line(tmp_path: Path) -> None:
    assert map_figures(JobMap(tmp_path, 41, 0.554)) == "41 islands cover 55%"
    assert map_figures(JobMap(tmp_path, 1, 1.0)) == "1 island covers 100%"
