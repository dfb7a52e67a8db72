# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""CHANGELOG.md is read as it is written: releases, groups, entries; what is out of place is named."""

from __future__ import annotations

import pytest

from radtex_addon.core.errors import FormatError
from radtex_addon.formats.changelog import CHANGELOG, changes_since, parse_changelog, plain
from radtex_addon.version import VERSION

TEXT = """\
<!-- a licence -->
# Changelog

Some words.

## [Unreleased]

### Fixed

- Not out yet.

## [0.10.0] - 2027-02-01

### Added

- **Two** lines, with `code`
  and a [link](docs/x.md#y).
- Second.

### Removed

- Third.

## [0.9.1] - 2026-12-24
### Fixed
- Fourth.

## [0.1.0] - 2026-11-25
"""


def test_releases_groups_and_entries() -> None:
    unreleased, latest, middle, first = parse_changelog(TEXT)
    assert (unreleased.version, unreleased.date) == ("Unreleased", "")
    assert unreleased.groups == {"Fixed": ["Not out yet."]}
    assert (latest.version, latest.date) == ("0.10.0", "2027-02-01")
    assert list(latest.groups) == ["Added", "Removed"]
    assert latest.groups["Added"] == ["**Two** lines, with `code` and a [link](docs/x.md#y).", "Second."]
    assert middle.groups == {"Fixed": ["Fourth."]}
    assert first.groups == {}


def test_marks_of_markdown_are_left_out_of_the_dialog() -> None:
    assert (
        plain("**Two** lines, with `code` and a [link](docs/x.md#y).") == "Two lines, with code and a link."
    )
    assert plain("*Good* ([docs/x.md](docs/x.md), [a](b)), as (said).") == "Good, as (said)."


@pytest.mark.parametrize(
    ("seen", "now", "shown"),
    [
        ("0.9.1", "0.10.0", ["0.10.0"]),  # 10 comes after 9
        ("0.1.0", "0.10.0", ["0.10.0", "0.9.1"]),
        ("0.1.0", "0.9.1", ["0.9.1"]),
        ("0.10.0", "0.10.0", []),
        ("0.10.0", "0.9.1", []),  # a step back
    ],
)
def test_what_came_since_a_version(seen: str, now: str, shown: list[str]) -> None:
    assert [release.version for release in changes_since(parse_changelog(TEXT), seen, now)] == shown


@pytest.mark.parametrize(
    "text",
    [
        "## 0.1.0 - 2026-11-25\n",
        "## [0.1.0]\n",
        "## [Unreleased] - 2026-11-25\n",
        "## [Unreleased]\n### Improved\n",
        "## [Unreleased]\n- of no group\n",
        "## [Unreleased]\n### Added\nnot an entry\n",
    ],
)
def test_what_is_out_of_place_is_named_by_its_line(text: str) -> None:
    with pytest.raises(FormatError, match=rf"CHANGELOG\.md, line {len(text.splitlines())}: "):
        parse_changelog(text)


def test_ours_has_an_unreleased_part_and_this_version_above_all_earlier_ones() -> None:
    unreleased, latest, *earlier = parse_changelog(CHANGELOG.read_text(encoding="utf-8"))
    assert unreleased.version == "Unreleased"
    assert latest.version == VERSION
    assert latest.groups
    dates = [release.date for release in (latest, *earlier)]
    assert dates == sorted(dates, reverse=True)
