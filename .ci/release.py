# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Make a release of what is there: `uv run .ci/release.py 0.2.0`.

1. What CHANGELOG.md has under Unreleased becomes that version's, with today's date.
2. The version is set wherever it stands; blender_manifest.toml is the one that Blender reads.

Look at the difference, commit it, and tag it v0.2.0: docs/release.md says what follows.

`uv run .ci/release.py --notes` prints the changes of the version that is there, as Markdown; `--base URL` is
put before links to files, which would lead nowhere on a page of releases.
`uv run .ci/release.py --check v0.2.0` says whether a tag names the version that stands everywhere.
"""

from __future__ import annotations

import argparse
import re
import sys
from datetime import UTC, datetime
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from radtex_addon.core.errors import RadTexError  # noqa: E402  # after the path
from radtex_addon.formats.changelog import UNRELEASED, as_numbers, parse_changelog  # noqa: E402

CHANGELOG = "CHANGELOG.md"
_VERSION = r"(\d+\.\d+\.\d+)"
# Where the version stands: in each file, what is before and after it. The first is the one that counts.
PLACES = {
    "blender_manifest.toml": rf'^version = "{_VERSION}"$',
    "pyproject.toml": rf'^version = "{_VERSION}"$',
    "uv.lock": rf'^name = "radtex"\nversion = "{_VERSION}"$',
    "radtex_addon/version.py": rf'^VERSION = "{_VERSION}"$',
    "shaders/babylon/package.json": rf'^  "version": "{_VERSION}",$',
    "shaders/babylon/package-lock.json": rf'"name": "radtex-babylon",\n\s+"version": "{_VERSION}",$',
    "shaders/three/package.json": rf'^  "version": "{_VERSION}",$',
    "shaders/three/package-lock.json": rf'"name": "radtex-three",\n\s+"version": "{_VERSION}",$',
    "shaders/godot/addons/radtex/plugin.cfg": rf'^version="{_VERSION}"$',
    "docs/babylon.md": rf"radtex-babylon-{_VERSION}\.tgz",
    "docs/cite.md": rf"^  version = \{{{_VERSION}\}},$",
    "docs/format.md": rf'"tool": "RadTex {_VERSION}"',
    "docs/three.md": rf"radtex-three-{_VERSION}\.tgz",
}


def main() -> None:
    """Do what was asked. Raises SystemExit with one line where it cannot be done."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    asked = parser.add_mutually_exclusive_group(required=True)
    asked.add_argument("version", nargs="?", help="such as 0.2.0")
    asked.add_argument("--notes", action="store_true", help="print what is new in the version that is there")
    asked.add_argument("--check", metavar="TAG", help="compare the tag, such as v0.2.0, with all places")
    parser.add_argument("--base", default="", metavar="URL", help="of the files, for links in --notes")
    parser.add_argument("--root", type=Path, default=ROOT, help="of the repository")
    options = parser.parse_args()
    root: Path = options.root
    try:
        if options.notes:
            print(notes(read(root, CHANGELOG), current(root), options.base), end="")
        elif options.check is not None:
            check(root, options.check)
        else:
            cut(root, options.version)
    except RadTexError as error:
        raise SystemExit(str(error)) from error


def cut(root: Path, version: str) -> None:
    """Make the release `version` of what is unreleased. Raises SystemExit, before anything is written."""
    if not re.fullmatch(_VERSION, version):
        raise SystemExit(f"{version} is no version: name it as in 0.2.0")
    text = read(root, CHANGELOG)
    unreleased, *earlier = parse_changelog(text)
    if unreleased.version != UNRELEASED or not any(unreleased.groups.values()):
        raise SystemExit(f"{CHANGELOG} has nothing under Unreleased: there is nothing to release")
    if earlier and as_numbers(version) <= as_numbers(earlier[0].version):
        raise SystemExit(f"{version} is not later than {earlier[0].version}, the last release")
    changed = {name: replaced(read(root, name), name, version) for name in PLACES}
    heading = f"## [{UNRELEASED}]\n\n## [{version}] - {datetime.now(UTC).date().isoformat()}"
    changed[CHANGELOG] = text.replace(f"## [{UNRELEASED}]", heading, 1)
    for name, after in changed.items():
        (root / name).write_text(after, encoding="utf-8", newline="\n")
        print(name)


def check(root: Path, tag: str) -> None:
    """Raises SystemExit where the tag names another version than one of the places, or the last release."""
    places = {name: versions(read(root, name), name) for name in PLACES}
    released = [release.version for release in parse_changelog(read(root, CHANGELOG))]
    places[CHANGELOG] = {next((version for version in released if version != UNRELEASED), "none")}
    wrong = [
        f"{name} has {', '.join(sorted(found))}"
        for name, found in places.items()
        if found != {tag.removeprefix("v")}
    ]
    if wrong:
        raise SystemExit(f"{tag}: {'; '.join(wrong)}")


def notes(text: str, version: str, base: str = "") -> str:
    """The changelog's words on a version, without its heading; `base` goes before links to files.

    Raises SystemExit where there are none.
    """
    match = re.search(
        rf"^## \[{re.escape(version)}\][^\n]*\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL
    )
    if match is None:
        raise SystemExit(f"{CHANGELOG} has nothing about {version}")
    return re.sub(r"\]\((?!\w+:|#)", lambda _: f"]({base}", match[1].strip()) + "\n"


def current(root: Path) -> str:
    """The version that the manifest has."""
    name = next(iter(PLACES))
    (found,) = versions(read(root, name), name)
    return found


def versions(text: str, name: str) -> set[str]:
    """The versions that stand in a file's text at its places. Raises SystemExit where there is none."""
    found = set(re.findall(PLACES[name], text, re.MULTILINE))
    if not found:
        raise SystemExit(f"{name} has no version where it should: {PLACES[name]}")
    return found


def replaced(text: str, name: str, version: str) -> str:
    """The file's text with another version at its places."""
    versions(text, name)
    return re.sub(PLACES[name], lambda match: match[0].replace(match[1], version), text, flags=re.MULTILINE)


def read(root: Path, name: str) -> str:
    """A file of the repository."""
    return (root / name).read_text(encoding="utf-8")


if __name__ == "__main__":
    main()
