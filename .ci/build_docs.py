# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
#
# /// script
# requires-python = ">=3.11"
# dependencies = []
# ///
"""Build the documentation's site: `uv run .ci/build_docs.py`, into dist/site.

1. uv makes an environment, .venv-docs, of uv.lock: Sphinx, and Blender as a module, which the reference is
   written from.
2. Sphinx builds the pages of docs. Every warning is an error.
3. Every link, anchor and picture in what was built is followed (check_site.py).

`--external` asks for the addresses of other sites, too, which needs the internet. dist/site/index.html opens
from disk, and any static server shows the folder.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

from check_site import dead_links

ROOT = Path(__file__).resolve().parent.parent
SITE = ROOT / "dist/site"
UV = os.environ.get("UV") or shutil.which("uv") or "uv"


def main() -> int:
    """Build the site and return the exit code: 0 only if nothing was wrong."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--external", action="store_true", help="check links to other sites, too")
    external = parser.parse_args().external
    shutil.rmtree(SITE, ignore_errors=True)
    failed = sphinx("html", SITE) != 0
    if external:
        failed |= sphinx("linkcheck", ROOT / "dist/links") != 0
    dead = dead_links(SITE)
    for link in dead:
        print(link, file=sys.stderr)
    if failed or dead:
        return 1
    print(f"{SITE / 'index.html'}: {len(list(SITE.rglob('*.html')))} pages")
    return 0


def sphinx(builder: str, out: Path) -> int:
    """Run one of Sphinx's builders over all pages, and return its exit code."""
    command = [UV, "run", "--quiet", "--frozen", "--python=3.13", f"--project={ROOT}", "--group=docs"]
    command += ["python", "-m", "sphinx", f"--builder={builder}", "--fail-on-warning", "--keep-going"]
    command += ["--quiet", "--fresh-env", f"--doctree-dir={ROOT / 'dist/.doctrees'}"]
    environment = os.environ | {"UV_PROJECT_ENVIRONMENT": str(ROOT / ".venv-docs")}
    environment.pop("VIRTUAL_ENV", None)
    command += [str(ROOT / "docs"), str(out)]
    return subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
