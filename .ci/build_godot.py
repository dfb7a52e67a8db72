# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the addon for Godot as its asset library wants it: `uv run .ci/build_godot.py`.

dist/radtex-godot-VERSION.zip has the folder addons/radtex alone, the shader includes in its folder lookups.
Unpack it into a project, and enable RadTex under Project > Project Settings > Plugins.

With --repository FOLDER also the files of a repository that has nothing but the addon, from which the asset
library downloads a commit: commit them there, and tag them.
"""

from __future__ import annotations

import argparse
import configparser
import shutil
import sys
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from radtex_addon.export.targets.godot import copy_addon  # noqa: E402  # after the path

GITIGNORE = "# what Godot makes of a project\n.godot/\n*.translation\n"
GITATTRIBUTES = """\
* text=auto eol=lf
*.png binary

# Users get the addon alone.
/** export-ignore
/addons !export-ignore
/addons/** !export-ignore
"""


def build_addon(folder: Path) -> Path:
    """Write the zip into `folder`; returns its path."""
    with tempfile.TemporaryDirectory() as project:
        addon = copy_addon(Path(project))
        facts = configparser.ConfigParser()
        facts.read(addon / "plugin.cfg", encoding="utf-8")
        version = facts["plugin"]["version"].strip('"')
        path = folder / f"radtex-godot-{version}.zip"
        folder.mkdir(parents=True, exist_ok=True)
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in sorted(addon.rglob("*")):
                if file.is_file():
                    archive.write(file, file.relative_to(project))
    return path


def write_repository(folder: Path) -> None:
    """Write what the asset library asks of a repository; FileExistsError where the addon is there already."""
    addon = copy_addon(folder)
    for name in ("LICENSE", "README.md"):
        shutil.copyfile(addon / name, folder / name)
    shutil.copyfile(ROOT / "docs" / "figures" / "listing-godot-icon.png", folder / "icon.png")
    (folder / ".gitignore").write_text(GITIGNORE, encoding="utf-8", newline="\n")
    (folder / ".gitattributes").write_text(GITATTRIBUTES, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=ROOT / "dist")
    parser.add_argument("--repository", type=Path, metavar="FOLDER")
    given = parser.parse_args()
    print(build_addon(given.out))
    if given.repository:
        write_repository(given.repository)
        print(given.repository)
