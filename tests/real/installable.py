# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The zips, and such that install on a Blender whose Python is not one that RadTex ships wheels for."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from zipfile import ZipFile

from tests.finished_bakes import STORE

ROOT = Path(__file__).resolve().parents[2]


def built_zips() -> Path:
    """The folder with each platform's zip, built once for a run, by the command that builds a release's.

    A zip is for both Blenders, whichever's tool has made it.
    """
    store = Path(os.environ[STORE])
    made = store / f"zips-{_sources_digest()}"
    if not made.is_dir():
        with tempfile.TemporaryDirectory(dir=store) as folder:
            out = Path(folder, "dist")
            subprocess.run([sys.executable, str(ROOT / ".ci/build_zip.py"), f"--out={out}"], check=True)
            with suppress(OSError):  # another process was faster
                out.rename(made)
    return made


def _sources_digest() -> str:
    digest = hashlib.sha256()
    folders = [ROOT.glob("*.*"), *((ROOT / name).rglob("*") for name in (".ci", "radtex_addon", "shaders"))]
    for path in sorted(path for folder in folders for path in folder):
        if path.is_file() and not {"__pycache__", "node_modules", "built"} & set(path.parts):
            digest.update(f"{path.relative_to(ROOT)}\0".encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def build_zip() -> Path:
    """The extension for this system, as it ships."""
    system = {"linux": "linux", "darwin": "macos", "win32": "windows"}[sys.platform]
    return next(built_zips().glob(f"*-{system}_x64.zip"))


def with_wheels(archive: Path, wheels: Sequence[Path], folder: Path) -> Path:
    """A zip in `folder` with other wheels, sealed as ours are."""
    spec = importlib.util.spec_from_file_location("seal_wheel", ROOT / ".ci/seal_wheel.py")
    assert spec is not None
    assert spec.loader is not None
    sealing = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sealing)
    names = ", ".join(f'"./wheels/{wheel.name}"' for wheel in wheels)
    result = folder / "radtex-other-python.zip"
    with ZipFile(archive) as source, ZipFile(result, "w") as target:
        for name in source.namelist():
            content = source.read(name)
            if name == "blender_manifest.toml":
                content = re.sub(
                    rb"(?m)^wheels = \[.*?\]", f"wheels = [{names}]".encode(), content, flags=re.DOTALL
                )
            if not name.startswith("wheels/"):
                target.writestr(name, content)
        for wheel in wheels:
            target.writestr(f"wheels/{wheel.name}", sealing.seal_wheel(wheel.read_bytes()))
    return result
