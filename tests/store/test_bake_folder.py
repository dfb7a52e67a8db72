# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The states of a bake's folder, as `store/bake_folder.py` draws them, without any light in the files."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import InputError
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.store.bake_folder import BakeFolder, FolderState
from radtex_addon.store.checkpoint import Checkpoint
from radtex_addon.store.checkpoint_files import KEY
from radtex_addon.store.output_files import BakeOutput
from radtex_addon.store.ownership import UNSAVED, Overwrite

NEVER, OVER = Overwrite(blend=UNSAVED), Overwrite(True, any=True, blend=UNSAVED)


@pytest.fixture
def card(tmp_path: Path) -> BakeFolder:
    return BakeFolder("Card", BakeSpec(), tmp_path / "out")


def state(card: BakeFolder) -> FolderState:
    return card.state  # mypy takes a property for a value that stays


def write(card: BakeFolder, checkpoint: Checkpoint, light: str) -> None:
    """Write the files of a bake to where they wait, with a piece before them."""
    checkpoint.keep("tile", {"cells": np.zeros(3)})
    for path in (*card.files.images, card.files.sidecar):
        facts = {"object": "Card", "light": light}
        checkpoint.place(path).write_text(json.dumps(facts))


def made(card: BakeFolder) -> BakeOutput:
    return BakeOutput(card.files, AtlasLayout(8, 8, 2), covered_texels=3, paths=5, clamped=0)


def finish(card: BakeFolder, light: str = "first", overwrite: Overwrite = NEVER) -> None:
    with card.open(overwrite) as checkpoint:
        write(card, checkpoint, light)
        card.publish(checkpoint, made(card))
        checkpoint.remove()


def light_of(card: BakeFolder) -> str:
    return str(json.loads(card.files.sidecar.read_text())["light"])


def test_nothing_becomes_unfinished_written_and_finished(card: BakeFolder) -> None:
    assert state(card) is FolderState.NOTHING
    card.check_may_write(NEVER)
    with card.open(NEVER) as checkpoint:
        assert state(card) is FolderState.NOTHING, "before the first piece"
        write(card, checkpoint, "first")
        assert (state(card), checkpoint.made) == (FolderState.UNFINISHED, None)
        assert not card.files.sidecar.exists()
        card.publish(checkpoint, made(card))
        assert (state(card), light_of(card)) == (FolderState.UNFINISHED, "first")
        assert checkpoint.made == made(card).told()
        checkpoint.remove()
    assert state(card) is FolderState.FINISHED
    assert not card.files.unfinished.exists()


def test_who_stops_before_the_end_goes_on_with_its_pieces_or_its_result(card: BakeFolder) -> None:
    with card.open(NEVER) as checkpoint:
        write(card, checkpoint, "first")
    with pytest.raises(InputError, match=r"holds an unfinished bake: go on with it, or begin anew"):
        card.check_may_write(NEVER)
    card.check_may_write(NEVER, resume=True)
    with card.open(NEVER, resume=True) as resumed:
        assert resumed.found("tile") is not None
        assert card.publish_again(resumed, was_finished=False) is None
        write(card, resumed, "second")
        card.publish(resumed, made(card))
    with card.open(NEVER, resume=True) as written:
        assert card.publish_again(written, was_finished=False) == made(card)


def test_a_finished_bake_is_replaced_only_if_that_is_asked_for_and_stays_until_then(card: BakeFolder) -> None:
    finish(card)
    with pytest.raises(InputError, match=r"\.exr is already there: overwrite it, or choose another folder"):
        card.check_may_write(NEVER)
    card.check_may_write(OVER)
    with card.open(OVER) as checkpoint:
        write(card, checkpoint, "second")
        assert (state(card), light_of(card)) == (FolderState.UNFINISHED, "first")
        card.publish(checkpoint, made(card))
        assert light_of(card) == "second"


def test_a_bake_that_adds_reads_the_finished_one_and_notices_another(card: BakeFolder) -> None:
    adding = replace(card, spec=replace(card.spec, accumulate=True))
    with pytest.raises(InputError, match="is not there to accumulate onto: bake it first, without that"):
        adding.check_may_write(NEVER)
    finish(card)
    adding.check_may_write(NEVER)
    late = adding.open(NEVER)
    finish(card, "second", OVER)
    with late, pytest.raises(InputError, match=r"\.exr has changed since this bake began: start it again"):
        late.begin()
    finish(adding, "both")
    assert (state(card), light_of(card)) == (FolderState.FINISHED, "both")


def test_a_bake_that_was_announced_counts_as_unfinished_and_is_in_nobodys_way(card: BakeFolder) -> None:
    finish(card)
    card.announce((), "")
    assert state(card) is FolderState.UNFINISHED
    card.check_may_write(OVER)
    finish(card, "second", OVER)
    assert (state(card), light_of(card)) == (FolderState.FINISHED, "second")


def test_only_overwriting_goes_on_from_a_damaged_key(card: BakeFolder) -> None:
    with card.open(NEVER) as checkpoint:
        write(card, checkpoint, "first")
    (card.files.unfinished / KEY).write_text("{")
    assert state(card) is FolderState.UNFINISHED
    for ask in (card.begun_facts, card.stored_as, lambda: card.check_may_write(NEVER, resume=True)):
        with pytest.raises(InputError, match=r"key\.json is damaged: begin anew"):
            ask()
    card.check_may_write(OVER)
    finish(card, "second", OVER)
    assert (state(card), light_of(card)) == (FolderState.FINISHED, "second")
