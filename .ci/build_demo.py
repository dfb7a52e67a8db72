# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Build a live demo that any static host serves: `uv run .ci/build_demo.py FOLDER`.

1. .ci/build_web.py builds the page.
2. `bake.py demo` bakes the demo's head, in a few minutes.
3. `bake.py export` makes FOLDER of it: the page, the mesh, the textures, and a mirror ball that moves.

FOLDER may hold an earlier demo, which is replaced; nothing else.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
UV = os.environ.get("UV") or shutil.which("uv") or "uv"


def main() -> None:
    """Build it, and say how to look at it. Raises SystemExit where a step fails, which has said why."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="what to upload afterwards")
    folder = parser.parse_args().folder.absolute()
    run(".ci/build_web.py")
    with tempfile.TemporaryDirectory() as baked:
        run("bake.py", "demo", "--out", baked)
        run("bake.py", "export", baked, "--to", "web", "--mirror", "--out", str(folder), "--overwrite")
    print(f'{folder}: upload it, or look at it by "python -m http.server --directory {folder}"')


def run(script: str, *arguments: str) -> None:
    """Run one of the repository's scripts in its environment."""
    command = [UV, "run", "--frozen", f"--project={ROOT}", str(ROOT / script), *arguments]
    code = subprocess.run(command, cwd=ROOT, check=False).returncode
    if code:
        sys.exit(code)


if __name__ == "__main__":
    main()
