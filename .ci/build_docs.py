# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the documentation's site: `uv run .ci/build_docs.py`, into dist/site.

1. uv makes an environment, .venv-docs, with Sphinx and with Blender as a module, from which the reference is written.
2. Sphinx builds the pages of docs. Every warning is an error: a link, an anchor or a picture that is not there, a page that
   no list of pages has.
3. Figures in docs/figures that no page shows are named; they are errors, too.

`--external` asks the addresses of other sites as well, which needs the internet. Open dist/site/index.html afterwards.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

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
    codes = [sphinx("html", SITE)]
    if external:
        codes.append(sphinx("linkcheck", ROOT / "dist/links"))
    unused = unused_figures()
    for path in unused:
        print(f"{path} is shown by no page: delete it, or show it", file=sys.stderr)
    if any(codes) or unused:
        return 1
    print(f"{SITE / 'index.html'}: {len(list(SITE.rglob('*.html')))} pages")
    return 0


def sphinx(builder: str, out: Path) -> int:
    """Run one of Sphinx's builders over all pages, and return its exit code."""
    command = [UV, "run", "--frozen", "--python", "3.13", "--group", "docs", "--group", "test", "sphinx-build"]
    command += ["--builder", builder, "--fail-on-warning", "--keep-going", "--quiet", "--fresh-env"]
    command += ["--doctree-dir", str(ROOT / "dist/.doctrees"), str(ROOT / "docs"), str(out)]
    environment = os.environ | {"UV_PROJECT_ENVIRONMENT": str(ROOT / ".venv-docs")}
    environment.pop("VIRTUAL_ENV", None)
    return subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode


def unused_figures() -> list[Path]:
    """Pictures in docs/figures that neither a page nor the README shows."""
    pages = [*ROOT.glob("docs/**/*.md"), ROOT / "README.md", *ROOT.glob("shaders/**/README.md")]
    shown = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    figures = [path for path in ROOT.glob("docs/figures/*") if path.suffix not in {".json", ".md"}]
    return sorted(path.relative_to(ROOT) for path in figures if path.name not in shown)


if __name__ == "__main__":
    sys.exit(main())
