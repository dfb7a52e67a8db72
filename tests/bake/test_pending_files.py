# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of a bake on their way to their places: all get there, wherever the bake is stopped."""

from __future__ import annotations

from pathlib import Path

import pytest

from radtex_addon.bake.announce import announce, publish_earlier
from radtex_addon.bake.checkpoint import Checkpoint, remove_left
from radtex_addon.bake.key import KEY, Key, is_unfinished, read_key, replaced_by, write_key
from radtex_addon.core.errors import BakeError
from tests.bake.test_checkpoint import FACTS, begun, some

WHOLE = {name: f"new {name}" for name in ("Card.radiance.exr", "Card.radiance.json")}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "out" / "Card.radiance.radtex-unfinished"


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


def test_files_take_their_places_once_all_are_written(folder: Path) -> None:
    with both(folder) as checkpoint:
        written(checkpoint, folder)
        assert outside(folder) == {}
        assert checkpoint.made is None
        checkpoint.publish({"paths": 3})
        assert outside(folder) == WHOLE
        assert checkpoint.made == {"paths": 3}
        checkpoint.remove()
    assert {path.name for path in folder.parent.iterdir()} == set(WHOLE)


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
        checkpoint._made = {}  # and there it dies
    publish_earlier(folder)
    assert outside(folder) == WHOLE
    assert read_key(folder).made == {"paths": 3}


def test_a_stranger_among_the_written_files_takes_no_place(folder: Path) -> None:
    with both(folder) as checkpoint:
        written(checkpoint, folder)
        checkpoint.place(folder.parent / "letter.txt").write_text("of another")
        checkpoint.publish({})
    assert outside(folder) == WHOLE


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
