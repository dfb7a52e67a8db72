# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is new is offered after an update, once, and never on a first install."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from radtex_addon.ui.operators import changes_operator
from radtex_addon.ui.operators.changes_operator import RADTEX_OT_show_changes, shown_changes
from radtex_addon.ui.panel.main_panel import draw_news
from radtex_addon.ui.settings import seen_version
from radtex_addon.version import VERSION
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.ui_stage import context, ops, preferences, registered

pytestmark = pytest.mark.one_blender

OFFER = ["radtex.show_changes", "radtex.dismiss_changes"]
LATER = "99.2.0"
TEXT = """\
# Changelog

## [Unreleased]

### Added

- Not yet.

## [99.2.0] - 2099-02-01

### Added

- **Fur**: it is baked by `--fur`, see [docs/fur.md](docs/fur.md).

### Fixed

- A crash.

## [99.1.0] - 2099-01-01

### Changed

- A word.

## [0.1.0] - 2026-11-25

### Added

- The first.
"""


@pytest.fixture(autouse=True)
def _registered(empty_file: None) -> Iterator[None]:
    with registered():
        yield


@pytest.fixture
def updated(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Two releases later; 0.1.0's changes were seen."""
    for module in (seen_version, changes_operator):
        monkeypatch.setattr(module, "VERSION", LATER)
    changelog = tmp_path / "CHANGELOG.md"
    changelog.write_text(TEXT, encoding="utf-8")
    monkeypatch.setattr("radtex_addon.formats.changelog.CHANGELOG", changelog)
    preferences().seen_version = "0.1.0"


def offered() -> list[str]:
    """The operators of the panel's line."""
    layout = RecordedLayout()
    draw_news(layout)
    return [name for name, _arguments in layout.buttons]


def test_a_first_install_offers_nothing() -> None:
    assert preferences().seen_version == ""
    assert not offered()
    seen_version.register()  # as Blender enables it
    assert preferences().seen_version == VERSION
    assert not offered()


def test_an_update_is_offered_until_it_is_dismissed(updated: None) -> None:
    seen_version.register()
    assert offered() == OFFER
    assert ops.radtex.dismiss_changes() == {"FINISHED"}
    assert preferences().seen_version == LATER
    assert context.preferences.is_dirty, "so that Blender saves it"
    assert not offered()
    with pytest.raises(RuntimeError, match="context is incorrect"):
        ops.radtex.dismiss_changes()


def test_to_have_seen_the_changes_takes_the_offer_away(updated: None) -> None:
    assert ops.radtex.show_changes() == {"FINISHED"}
    assert not offered()


def test_a_step_back_to_an_earlier_version_is_no_news() -> None:
    preferences().seen_version = LATER
    assert not offered()


def test_the_dialog_has_all_releases_since_then_this_one_alone(updated: None) -> None:
    assert shown_changes() == [
        ("99.2.0 · Added", ["Fur: it is baked by --fur, see docs/fur.md."]),
        ("99.2.0 · Fixed", ["A crash."]),
        ("99.1.0 · Changed", ["A word."]),
    ]
    seen_version.mark_seen()
    assert [heading for heading, _entries in shown_changes()] == ["99.2.0 · Added", "99.2.0 · Fixed"]


def test_the_dialog_draws_them_and_leads_to_the_whole_list(updated: None) -> None:
    layout = RecordedLayout()
    shown = cast(RADTEX_OT_show_changes, SimpleNamespace(layout=layout, changes=shown_changes()))
    RADTEX_OT_show_changes.draw(shown, None)
    assert layout.texts[:2] == ["99.2.0 · Added", "Fur: it is baked by --fur, see docs/fur.md."]
    ((name, arguments),) = layout.buttons
    assert name == "wm.path_open"
    assert Path(arguments.filepath).read_text(encoding="utf-8") == TEXT


def test_a_long_list_ends_with_how_many_more_there_are(
    updated: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(changes_operator, "_MOST_ENTRIES", 2)
    shown: list[Any] = shown_changes()
    assert sum(len(entries) for _heading, entries in shown) == 2
    assert shown[-1] == ("… and 1 more, in the whole list", [])
