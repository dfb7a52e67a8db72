# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The zips, built once for all tests, by the command that builds them for a release."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def zips(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """One zip for each platform, as in {"linux-x64": …/radtex-0.1.0-linux_x64.zip}."""
    out = tmp_path_factory.mktemp("dist")
    subprocess.run([sys.executable, str(ROOT / ".ci/build_zip.py"), f"--out={out}"], check=True)
    return {path.stem.rpartition("-")[2].replace("_", "-"): path for path in out.glob("*.zip")}
