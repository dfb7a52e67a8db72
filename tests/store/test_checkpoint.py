# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checkpoints: what was kept comes back bit by bit, or not at all; finished files reach their places."""

from __future__ import annotations

import json
import logging
import os
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from radtex_addon.bake.plan import CapturePlan, Tile, plan_capture
from radtex_addon.bake.progress import Progress, Stage, finished
from radtex_addon.bake.session import fill_atlas
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import BakeError, InputError
from radtex_addon.store.checkpoint import (
    Checkpoint,
    announce,
    check_free,
    publish_earlier,
    remove_left,
    replaced_by,
)
from radtex_addon.store.checkpoint_files import (
    KEY,
    LOCK,
    PIECE_FORMAT,
    Key,
    is_unfinished,
    read_key,
    write_key,
)
from tests.bake.test_session import card, telltale
from tests.reference.analytic import AnalyticCapture

FACTS = {"samples": "16", "mesh": "sha256:aa"}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "out" / "Card.radiance.radtex-unfinished"


def begun(folder: Path, resume: bool = False, **facts: str) -> Checkpoint:
    checkpoint = Checkpoint(folder, resume, [folder.parent / "Card.radiance.exr"])
    checkpoint.set_facts({**FACTS, **facts})
    return checkpoint


def some() -> dict[str, npt.NDArray[Any]]:
    random = np.random.default_rng(3)
    return {
        "cells": random.normal(size=(7, 3, 3, 4)).astype(np.float32)[:, ::-1],  # not in one piece of memory
        "half": random.normal(size=5).astype(np.float16),
        "marks": random.random((4, 2)) < 0.5,
        "none": np.zeros((0, 3), dtype=np.int64),
    }


def test_a_piece_comes_back_bit_by_bit(folder: Path) -> None:
    checkpoint = begun(folder)
    assert not folder.parent.exists()  # before the first piece
    checkpoint.keep("first", some())
    assert is_unfinished(folder)
    checkpoint.close()
    resumed = begun(folder, resume=True)
    assert resumed.names() == ["first"]
    found = resumed.found("first")
    assert found is not None
    assert list(found) == list(some())
    for name, array in some().items():
        assert found[name].dtype == array.dtype
        np.testing.assert_array_equal(found[name], array)
    assert resumed.found("second") is None


@pytest.mark.parametrize("theirs", [[], ["notes.txt"]])
def test_nothing_is_there_after_the_end_but_what_is_not_ours(folder: Path, theirs: list[str]) -> None:
    checkpoint = begun(folder)
    checkpoint.keep("first", some())
    for name in theirs:
        (folder / name).write_text("mine")
    checkpoint.remove()
    assert [path.name for path in folder.parent.rglob("*") if path.is_file()] == theirs
    assert folder.exists() == bool(theirs)
    assert not is_unfinished(folder)


def test_every_byte_of_a_piece_is_guarded(folder: Path, caplog: pytest.LogCaptureFixture) -> None:
    begun(folder).keep("first", {"values": np.arange(6, dtype=np.float32)})
    path = folder / "first.piece"
    whole = path.read_bytes()
    for place in range(len(whole)):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        assert begun(folder, resume=True).found("first") is None, place
    for length in range(len(whole)):  # as a power cut leaves it
        path.write_bytes(whole[:length])
        assert begun(folder, resume=True).found("first") is None, length
    assert caplog.messages[-1].startswith(f"{path} is damaged and is made again")
    path.write_bytes(whole)
    assert begun(folder, resume=True).found("first") is not None


def test_a_piece_of_another_bake_or_name_is_not_taken(folder: Path) -> None:
    begun(folder).keep("first", some())
    foreign = folder.with_name("other")
    begun(foreign, samples="64").keep("second", some())
    (foreign / "second.piece").replace(folder / "second.piece")
    (folder / "third.piece").write_bytes((folder / "first.piece").read_bytes())
    resumed = begun(folder, resume=True)
    assert resumed.found("second") is None
    assert resumed.found("third") is None
    assert resumed.found("first") is not None


def test_what_differs_is_named_in_one_line(folder: Path) -> None:
    begun(folder).keep("first", some())
    with pytest.raises(InputError) as raised:
        begun(folder, resume=True, samples="64", mesh="sha256:bb")
    assert str(raised.value) == (
        f"{folder} is of a bake that differs in samples (16, now 64), mesh: bake as before, or begin anew"
    )
    begun(folder, resume=True)


def test_without_resume_all_is_begun_anew_at_the_first_piece(folder: Path) -> None:
    begun(folder).keep("first", some())
    anew = begun(folder, samples="64")
    assert anew.names() == []
    assert anew.found("first") is None
    assert (folder / "first.piece").exists()
    anew.keep("second", some())
    assert sorted(path.name for path in folder.iterdir()) == [KEY, LOCK, "second.piece"]
    assert begun(folder, resume=True, samples="64").names() == ["second"]


def test_an_input_error_leaves_another_bakes_pieces_alone(folder: Path) -> None:
    begun(folder).keep("first", some())
    resumed = begun(folder, resume=True)
    resumed.keep("second", some())
    resumed.drop_own()
    assert resumed.names() == ["first", "second"]
    other = begun(folder.with_name("other"))
    other.keep("first", some())
    other.drop_own()
    assert not folder.with_name("other").exists()


def test_a_key_without_sense_is_an_error_that_says_how_to_go_on(folder: Path) -> None:
    begun(folder).keep("first", some())
    assert replaced_by(folder) == {"Card.radiance.exr"}
    whole = (folder / KEY).read_text()
    broken = json.dumps(json.loads(whole) | {"processes": ["a"]})
    for text in ("", whole[:-9], "[]", "{}", broken, whole.replace('"version": 1', '"version": 2')):
        (folder / KEY).write_text(text)
        with pytest.raises(InputError, match=r"damaged.*begin anew"):
            begun(folder, resume=True)


def test_pieces_of_another_format_are_not_taken_and_stay(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun(folder).keep("first", some())
    kept = {path.name: path.read_bytes() for path in folder.iterdir()}
    now = f'"pieces": {PIECE_FORMAT}'
    with monkeypatch.context() as later:
        later.setattr("radtex_addon.store.checkpoint_files.PIECE_FORMAT", 77)
        with pytest.raises(InputError, match=r"pieces of format \d+, .*of format 77: .*, or begin anew"):
            begun(folder, resume=True)
        (folder / KEY).write_text((folder / KEY).read_text().replace(now, '"pieces": 77'))
        assert begun(folder, resume=True).found("first") is None, "its own label tells, too"
        (folder / KEY).write_bytes(kept[KEY])
    assert {path.name: path.read_bytes() for path in folder.iterdir() if path.name in kept} == kept
    assert begun(folder, resume=True).found("first") is not None


def test_one_at_a_time_works_on_a_bake(folder: Path) -> None:
    check_free(folder)
    with begun(folder) as first:
        first.keep("first", some())
        who = f"is in use, process {os.getpid()} on .* bakes into it: wait for its end, or end it$"
        with pytest.raises(InputError, match=who):
            check_free(folder)
        for resume in (True, False):
            other = begun(folder, resume=resume)
            with pytest.raises(InputError, match=who):
                other.keep("second", some())
            other.drop_own()
        first.keep("third", some())
    check_free(folder)
    with begun(folder, resume=True) as second:
        assert second.found("first") is not None
        assert second.found("third") is not None
        late = begun(folder, resume=True)
        second.remove()
        with pytest.raises(BakeError, match="has gone"):
            late.keep("first", some())
    assert list(folder.parent.iterdir()) == []


def test_what_killed_processes_were_writing_goes_with_the_end(folder: Path) -> None:
    """Whether the bake was gone on with, or begun anew."""
    begun(folder).keep("first", some())
    for pid, resume in ((2**30, True), (2**30 + 1, False)):
        key = json.loads((folder / KEY).read_text())
        key["processes"].append(pid)
        (folder / KEY).write_text(json.dumps(key))
        (folder.parent / f".radtex-{pid}-aa.exr").touch()
        (folder / f".radtex-{pid}-bb.piece").touch()
        begun(folder, resume=resume).keep("second", some())
    begun(folder, resume=True).keep("third", some())
    with begun(folder, resume=True) as last:
        assert last.found("third") is not None
        last.remove()
    assert list(folder.parent.iterdir()) == []


def test_a_refusing_system_and_a_folder_that_goes_away_are_one_line(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    checkpoint = begun(folder)
    checkpoint.keep("first", some())

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np.lib.format, "write_array", full)
    with pytest.raises(BakeError, match=r"second\.piece could not be written: No space left on device"):
        checkpoint.keep("second", some())
    monkeypatch.undo()
    assert begun(folder, resume=True).names() == ["first"]
    shutil.rmtree(folder)
    with pytest.raises(BakeError, match="has gone"):
        checkpoint.keep("second", some())
    assert not folder.exists()
    checkpoint.close()


# the session


class Counting:
    """A capture that fails after some tiles."""

    def __init__(self, plan: CapturePlan, tiles: int) -> None:
        self._capture = AnalyticCapture(plan, telltale(plan), side=1)
        self._left = tiles
        self.rows: list[int] = []

    def render(self, tile: Tile) -> Floats:
        if not self._left:
            raise BakeError("Cycles failed")
        self._left -= 1
        self.rows.extend(range(tile.first_row, tile.first_row + tile.rows))
        return self._capture.render(tile)


def test_a_session_goes_on_where_another_ended(folder: Path) -> None:
    plan = plan_capture(card(width=40, height=40), 2)
    whole = finished(fill_atlas(plan, Counting(plan, 10_000), 64))
    first = Counting(plan, 3)
    with pytest.raises(BakeError):
        finished(fill_atlas(plan, first, 64, store=begun(folder)))
    second = Counting(plan, 10_000)
    steps = fill_atlas(plan, second, 64, store=begun(folder, resume=True))
    assert next(steps) == Progress(Stage.CAPTURE, len(first.rows) * plan.columns, len(plan.texel))
    np.testing.assert_array_equal(finished(steps), whole)
    assert sorted(first.rows + second.rows) == list(range(plan.rows)), "every row once"
    third = Counting(plan, 0)
    image = finished(fill_atlas(plan, third, 64, store=begun(folder, resume=True)))
    np.testing.assert_array_equal(image, whole)
    assert third.rows == []


def test_a_damaged_tile_alone_is_captured_again(folder: Path, caplog: pytest.LogCaptureFixture) -> None:
    plan = plan_capture(card(width=40, height=40), 2)
    whole = finished(fill_atlas(plan, Counting(plan, 10_000), 64, store=begun(folder)))
    pieces = sorted(folder.glob("tile-*.piece"))
    assert len(pieces) > 2
    spoilt = pieces[1]
    spoilt.write_bytes(spoilt.read_bytes()[:-100])
    again = Counting(plan, 10_000)
    with caplog.at_level(logging.WARNING):
        image = finished(fill_atlas(plan, again, 64, store=begun(folder, resume=True)))
    np.testing.assert_array_equal(image, whole)
    _, first, rows = spoilt.stem.split("-")
    assert again.rows == list(range(int(first), int(first) + int(rows)))
    assert len(caplog.messages) == 1


WHOLE = {name: f"new {name}" for name in ("Card.radiance.exr", "Card.radiance.json")}


def written(checkpoint: Checkpoint, folder: Path) -> None:
    """Write an atlas and its sidecar where the checkpoint wants them."""
    for name in WHOLE:
        checkpoint.place(folder.parent / name).write_text(f"new {name}")


def both(folder: Path, resume: bool = False, **facts: str) -> Checkpoint:
    checkpoint = Checkpoint(folder, resume, [folder.parent / name for name in WHOLE])
    checkpoint.set_facts({**FACTS, **facts})
    return checkpoint


def outside(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.parent.iterdir() if path.is_file()}


def test_files_take_their_places_once_all_are_written_and_a_strangers_none(folder: Path) -> None:
    with both(folder) as checkpoint:
        written(checkpoint, folder)
        checkpoint.place(folder.parent / "letter.txt").write_text("of another")
        assert outside(folder) == {}
        assert checkpoint.made is None
        checkpoint.publish({"paths": 3})
        assert outside(folder) == WHOLE
        assert checkpoint.made == {"paths": 3}
        checkpoint.remove()
    assert outside(folder) == WHOLE


@pytest.mark.parametrize("fails_at", sorted(WHOLE))
def test_whoever_stops_amid_the_moves_is_gone_on_with_by_the_rest(
    folder: Path, fails_at: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    move = Path.replace

    def stopped(path: Path, place: Path) -> Path:
        if Path(place).name == fails_at:
            raise OSError(5, "Input/output error")
        return move(path, place)

    with both(folder) as checkpoint:
        written(checkpoint, folder)
        monkeypatch.setattr(Path, "replace", stopped)
        with pytest.raises(BakeError, match=rf"out/{fails_at} could not be written: Input/output error"):
            checkpoint.publish({"paths": 3})
    monkeypatch.undo()
    assert len(outside(folder)) == sorted(WHOLE).index(fails_at), "the sidecar comes last"
    with both(folder, resume=True) as resumed:
        assert resumed.made == {"paths": 3}
        resumed.publish(resumed.made)
        assert outside(folder) == WHOLE
        resumed.remove()
    assert not folder.exists()


def test_without_the_last_file_none_takes_its_place(folder: Path) -> None:
    with both(folder) as checkpoint:
        written(checkpoint, folder)
    assert outside(folder) == {}
    assert [path.name for path in folder.iterdir()] == [KEY], "what half of a bake wrote is of no use"
    with both(folder, resume=True) as resumed:
        assert resumed.made is None


def test_who_begins_anew_finds_the_earlier_files_together(folder: Path) -> None:
    """An accumulation folds into them: half of the old and half of the new would be no atlas."""
    with both(folder) as checkpoint:
        written(checkpoint, folder)
        write_key(folder, Key(FACTS, sorted(WHOLE), [], {"paths": 3}))  # all is written, nothing is moved
        checkpoint.made = {}  # and there it dies
    publish_earlier(folder)
    assert outside(folder) == WHOLE
    assert read_key(folder).made == {"paths": 3}


def test_a_bake_that_was_killed_amid_its_end_is_over(folder: Path) -> None:
    begun(folder).keep("first", some())
    (folder / KEY).unlink()  # goes first
    assert not is_unfinished(folder)
    remove_left(folder)
    assert not folder.exists()
    begun(folder).keep("first", some())
    remove_left(folder)
    assert is_unfinished(folder), "it is not over"


def test_a_bake_that_was_announced_starts_with_nothing_and_may_replace_files(folder: Path) -> None:
    announce(folder, [folder.parent / "Card.radiance.exr"])
    assert is_unfinished(folder)
    assert replaced_by(folder) == {"Card.radiance.exr"}
    resumed = begun(folder, resume=True, samples="64")
    assert resumed.names() == []
    assert resumed.found("first") is None
    resumed.keep("first", some())
    resumed.close()
    assert begun(folder, resume=True, samples="64").names() == ["first"]
    announce(folder, [])
    refused = begun(folder, resume=True)
    refused.drop_own()
    assert not folder.exists()
