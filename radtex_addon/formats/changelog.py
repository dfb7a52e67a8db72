# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Read CHANGELOG.md, which is kept as https://keepachangelog.com/en/1.1.0/ says.

A release is a heading `## [1.2.3] - 2026-11-25`, its groups are headings `### Added`, and entries are list
items whose further lines are indented. A release may begin with a group of our own,
`### Highlights`: up to five short lines for artists, which the panel shows.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from ..core.errors import FormatError

CHANGELOG = Path(__file__).parents[2] / "CHANGELOG.md"  # ships in the zip
UNRELEASED = "Unreleased"
HIGHLIGHTS = "Highlights"
GROUPS = (HIGHLIGHTS, "Added", "Changed", "Deprecated", "Removed", "Fixed", "Security")

_RELEASE = re.compile(r"## \[(?P<version>\d+\.\d+\.\d+|Unreleased)\](?: - (?P<date>\d{4}-\d\d-\d\d))?")
_LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")
_ASIDE = re.compile(rf" \({_LINK.pattern}(?:, {_LINK.pattern})*\)")  # links in brackets of their own
_SENTENCE = re.compile(r".*?(?:[.:](?= )|$)", re.DOTALL)
_MARKS = re.compile(r"\*|`")


@dataclass(frozen=True)
class Release:
    """One release, or what is not released yet: entries by group, each as one line of Markdown."""

    version: str
    date: str
    groups: dict[str, list[str]] = field(default_factory=dict)


def parse_changelog(text: str) -> list[Release]:
    """All releases, the latest first. Raises FormatError for a line that is out of place."""
    found: list[Release] = []
    entries: list[str] | None = None
    for number, line in enumerate(text.splitlines(), start=1):
        if line.startswith("## "):
            found.append(_release(line, number))
            entries = None
        elif not found or not line.strip():
            continue  # the introduction, and empty lines
        elif line.startswith("### "):
            entries = _group(found[-1], line.removeprefix("### "), number)
        elif entries is not None and line.startswith("- "):
            entries.append(line.removeprefix("- ").strip())
        elif entries and line.startswith("  "):
            entries[-1] += f" {line.strip()}"
        else:
            raise FormatError(f"CHANGELOG.md, line {number}: it belongs to no entry")
    return found


def changes_since(releases: list[Release], seen: str, now: str) -> list[Release]:
    """The releases after version `seen`, up to and with version `now`."""
    return [
        release
        for release in releases
        if release.version != UNRELEASED and as_numbers(seen) < as_numbers(release.version) <= as_numbers(now)
    ]


def highlights(releases: list[Release], most: int) -> list[str]:
    """What an artist should know of these releases, the latest first: at most so many short lines, plain.

    Of a release without Highlights these are the first sentences of what was added and changed.
    """
    found: list[str] = []
    for release in releases:
        lines = release.groups.get(HIGHLIGHTS) or [
            _SENTENCE.match(plain(entry))[0]  # type: ignore[index]  # it matches every text
            for entries in release.groups.values()
            for entry in entries
        ]
        found += map(plain, lines)
    return found[:most]


def as_numbers(version: str) -> tuple[int, ...]:
    """A version to compare with others: "0.10.2" is (0, 10, 2); all else is before every version."""
    return tuple(map(int, version.split("."))) if re.fullmatch(r"\d+(\.\d+)*", version) else ()


def plain(entry: str) -> str:
    """An entry without Markdown's marks, and without links that stand in brackets; of others, their words."""
    return _MARKS.sub("", _LINK.sub(r"\1", _ASIDE.sub("", entry)))


def _release(line: str, number: int) -> Release:
    match = _RELEASE.fullmatch(line.rstrip())
    if match is None or (match["version"] == UNRELEASED) != (match["date"] is None):
        raise FormatError(
            f"CHANGELOG.md, line {number}: '## [Unreleased]' or '## [1.2.3] - 2026-11-25' is expected"
        )
    return Release(match["version"], match["date"] or "")


def _group(release: Release, name: str, number: int) -> list[str]:
    if name.strip() not in GROUPS:
        raise FormatError(f"CHANGELOG.md, line {number}: a group is one of {', '.join(GROUPS)}")
    return release.groups.setdefault(name.strip(), [])
