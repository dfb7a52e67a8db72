# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Zips that install on a Blender whose Python is not one that RadTex ships wheels for."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from zipfile import ZipFile

ROOT = Path(__file__).resolve().parents[2]


def build_zip(folder: Path) -> Path:
    """The extension for this system, as it ships."""
    subprocess.run([sys.executable, str(ROOT / ".ci/build_zip.py"), f"--out={folder}"], check=True)
    system = {"linux": "linux", "darwin": "macos", "win32": "windows"}[sys.platform]
    return next(folder.glob(f"*-{system}_x64.zip"))


def with_wheels(archive: Path, wheels: Sequence[Path]) -> Path:
    """A zip with other wheels, sealed as ours are."""
    spec = importlib.util.spec_from_file_location("seal_wheel", ROOT / ".ci/seal_wheel.py")
    assert spec is not None
    assert spec.loader is not None
    sealing = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sealing)
    names = ", ".join(f'"./wheels/{wheel.name}"' for wheel in wheels)
    result = archive.with_name("radtex-other-python.zip")
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
