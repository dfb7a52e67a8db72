# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is new is offered after an update, once, and never on a first install; preferences and help."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import bpy
import pytest

from radtex_addon.formats.changelog import CHANGELOG, UNRELEASED, highlights, parse_changelog
from radtex_addon.formats.disk.memory import physical_memory
from radtex_addon.ui.jobs.bug_report import report_of
from radtex_addon.ui.operators import changes_operator
from radtex_addon.ui.operators.changes_operator import RADTEX_OT_show_changes, shown_changes
from radtex_addon.ui.panel import fitting
from radtex_addon.ui.panel.main_panel import draw_news
from radtex_addon.ui.settings import preferences as settings_module
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

### Highlights

- Baked *fur*.
- Bake by one button, *Go*.

### Added

- **Fur**: it is baked by `--fur`, see [docs/fur.md](docs/fur.md).

### Fixed

- A crash.

## [99.1.0] - 2099-01-01

### Changed

- A word is new. It is `new` to scripts, too.

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
    with pytest.raises(RuntimeError, match="were shown or dismissed already"):
        ops.radtex.dismiss_changes()


def test_to_have_seen_the_changes_takes_the_offer_away(updated: None) -> None:
    assert ops.radtex.show_changes() == {"FINISHED"}
    assert not offered()


def test_a_step_back_to_an_earlier_version_is_no_news() -> None:
    preferences().seen_version = LATER
    assert not offered()


def test_the_dialog_has_the_highlights_of_all_releases_since_then_of_this_one(updated: None) -> None:
    assert shown_changes() == ["Baked fur.", "Bake by one button, Go.", "A word is new."]
    seen_version.mark_seen()
    assert shown_changes() == ["Baked fur.", "Bake by one button, Go."]


def test_the_dialog_draws_them_and_leads_to_the_whole_list(
    updated: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert drawn_changes().texts[:3] == ["Baked fur.", "Bake by one button, Go.", "A word is new."]
    ((name, arguments),) = drawn_changes().buttons
    assert name == "wm.path_open"
    assert Path(arguments.filepath).read_text(encoding="utf-8") == TEXT
    monkeypatch.setattr(changes_operator, "website", lambda: "https://radtex.example/")
    assert [name for name, _ in drawn_changes().buttons] == ["wm.path_open", "wm.url_open"]


def drawn_changes() -> RecordedLayout:
    layout = RecordedLayout()
    shown = cast(RADTEX_OT_show_changes, SimpleNamespace(layout=layout, changes=shown_changes()))
    RADTEX_OT_show_changes.draw(shown, None)
    return layout


def test_the_dialog_of_this_version_is_five_short_lines() -> None:
    for version in (VERSION, UNRELEASED):
        release = next(one for one in parse_changelog(CHANGELOG.read_text("utf-8")) if one.version == version)
        lines = highlights([release], 99)
        assert 1 <= len(lines) <= 5
        assert all(len(line) < 130 and "--" not in line for line in lines)
    preferences().seen_version = ""
    assert len(drawn_changes().texts) < 16, "lines and a button, lower than any screen"


def test_a_release_without_highlights_is_told_by_its_first_sentences(updated: None) -> None:
    old = parse_changelog(TEXT.replace("### Highlights", "### Removed"))
    assert highlights(old[1:2], 3) == ["Baked fur.", "Bake by one button, Go.", "Fur:"]
    assert highlights(old[2:3], 5) == ["A word is new."]


def test_the_website_of_the_manifest_is_offered_once_there_is_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    layout: Any = RecordedLayout()
    settings_module.draw_links(layout)
    offered = [name for name, _ in layout.buttons]
    assert offered == ["radtex.copy_report", "radtex.show_changes"], "there is no website yet"
    manifest = tmp_path / "blender_manifest.toml"
    manifest.write_text('id = "radtex"\nwebsite = "https://radtex.example/"\n', encoding="utf-8")
    monkeypatch.setattr(settings_module, "MANIFEST", manifest)
    settings_module.website.cache_clear()
    try:
        settings_module.draw_links(layout)
    finally:
        settings_module.website.cache_clear()
    name, arguments = layout.buttons[-1]
    assert (name, arguments.url) == ("wm.url_open", "https://radtex.example/")


def test_memory_without_a_limit_is_called_automatic() -> None:
    layout: Any = RecordedLayout()
    settings_module.draw_memory(layout, preferences())
    assert (layout.settings, layout.texts) == (["limits_memory"], ["Automatic"])
    preferences().limits_memory = True
    half = physical_memory()
    assert half is not None
    assert preferences().memory_mb == half // 2**21
    settings_module.draw_memory(layout, preferences())
    assert layout.settings[1:] == ["limits_memory", "memory_mb"]
    preferences().limits_memory = False
    assert settings_module.preferred().memory_mb is None


def test_preferences_say_what_is_used_where_a_folder_is_empty() -> None:
    layout = _WithPlaceholders()
    shown: Any = SimpleNamespace(layout=layout, **dict.fromkeys(("limits_memory",), False))
    shown.bl_rna = preferences().bl_rna
    settings_module.RADTEX_preferences.draw(shown, None)
    told = {"output_folder", "cache_folder", "export_into"}
    assert told == layout.placeholders.keys()
    assert layout.placeholders["export_into"] == "Beside each bake"
    stored = {"device", "memory_mb", "default_preset", "export_target", "notify", "limits_memory", *told}
    assert stored - {"memory_mb"} == set(layout.settings)


def test_preferences_say_where_to_bake_on_as_many_lines_as_that_needs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room = 200.0
    monkeypatch.setattr(fitting, "sidebar_room", lambda **_: room)
    layout = _WithPlaceholders()
    shown: Any = SimpleNamespace(layout=layout, limits_memory=False, bl_rna=preferences().bl_rna)
    settings_module.RADTEX_preferences.draw(shown, None)
    lines = layout.texts[: layout.texts.index("Automatic")]
    assert " ".join(lines) == "To bake, press N over a 3D view and open the sidebar's tab RadTex"
    assert all(fitting.text_width(line) <= room for line in lines)


class _WithPlaceholders(RecordedLayout):
    """Keeps the placeholders of properties, too."""

    def __init__(self) -> None:
        super().__init__()
        self.placeholders: dict[str, str] = {}

    def prop(self, data: Any, name: str, **options: Any) -> None:
        super().prop(data, name, **options)
        if options.get("placeholder"):
            self.placeholders[name] = options["placeholder"]


def test_a_report_has_what_drew_and_what_rendered() -> None:
    versions, system, processor, window, cycles = report_of(None).splitlines()
    assert versions.startswith(f"RadTex {VERSION}, Blender {bpy.app.version_string}")
    assert system
    assert processor.startswith("CPU: ")
    assert " threads, " in processor
    assert window == "Window: none"
    assert cycles.startswith("Cycles: ")
    assert "RadTex's device: auto; Automatic is CPU" in cycles
    context.preferences.addons.remove(context.preferences.addons["cycles"])
    try:
        assert report_of(None).splitlines()[-1].startswith("Cycles is switched off")
    finally:
        context.preferences.addons.new().module = "cycles"
