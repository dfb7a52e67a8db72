# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The wheels as they ship run beside the libraries that Blender itself links."""

from __future__ import annotations

import csv
import hashlib
import io
import subprocess
import sys
from base64 import urlsafe_b64encode
from pathlib import Path
from zipfile import ZipFile

import pytest

pytestmark = pytest.mark.one_blender

PYTHON = (f"-cp{sys.version_info.major}{sys.version_info.minor}-", "-abi3-")


@pytest.fixture(scope="module")
def wheels(zips: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The wheels for Linux and this Python, taken out of the zip."""
    folder = tmp_path_factory.mktemp("wheels")
    with ZipFile(zips["linux-x64"]) as archive:
        names = [name for name in archive.namelist() if name.endswith(".whl")]
        ours = [name for name in names if any(tag in name for tag in PYTHON)]
        return [Path(archive.extract(name, folder)) for name in ours]


def test_each_wheels_record_is_true(wheels: list[Path]) -> None:
    assert len(wheels) == 4
    for wheel in wheels:
        with ZipFile(wheel) as archive:
            assert archive.testzip() is None
            (record,) = [name for name in archive.namelist() if name.endswith("/RECORD")]
            listed = list(csv.reader(io.StringIO(archive.read(record).decode())))
            files = {name for name in archive.namelist() if not name.endswith("/")}
            assert {name for name, _digest, _size in listed} == files
            for name, digest, size in listed:
                content = archive.read(name)
                found = urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
                assert name == record or (digest, int(size)) == (f"sha256={found}", len(content))


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux looks up symbols across all libraries")
def test_they_run_where_blenders_libraries_come_first(wheels: list[Path], tmp_path: Path) -> None:
    site = tmp_path / "site"
    for wheel in wheels:
        with ZipFile(wheel) as archive:
            archive.extractall(site)
    script = Path(__file__).with_name("beside_blender.py")
    process = subprocess.run(
        [sys.executable, "-I", str(script), str(site), str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (process.returncode, process.stderr) == (0, "")
    modules = process.stdout.splitlines()[-4:]
    assert all(Path(module).is_relative_to(site) for module in modules)
