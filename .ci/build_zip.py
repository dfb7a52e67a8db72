# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the extension's zips, one per platform: `uv run .ci/build_zip.py`.

1. Fetch the wheels that blender_manifest.toml names, with uv.lock's hashes, into wheels/fetched/ (kept).
2. Seal those for Linux against Blender's own libraries (seal_wheel.py), and lay all of them into wheels/.
3. Build the web page that exports ship (build_web.py).
4. Build and validate with Blender's own tool, taken from the bpy wheel of the running environment.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import groupby
from pathlib import Path
from typing import Any

from build_web import alone, build_web
from seal_wheel import seal_wheel

ROOT = Path(__file__).resolve().parent.parent
UV = os.environ.get("UV") or shutil.which("uv") or "uv"


@dataclass(frozen=True)
class Wheel:
    """A wheel that the manifest names: where it belongs and what uv.lock says its published bytes hash to."""

    path: Path
    sha256: str

    @property
    def fetched(self) -> Path:
        """The file as it was published."""
        return self.path.parent / "fetched" / self.path.name

    @property
    def requirement(self) -> str:
        """The pinned requirement that selects this very file, as pip reads it."""
        name, version = self.path.name.split("-")[:2]
        return f"{name}=={version} --hash=sha256:{self.sha256}"

    @property
    def target(self) -> tuple[str, str, str]:
        """Python, system and end of the machine's name, as in ("cp313", "manylinux", "64")."""
        python, _abi, platform = self.path.stem.split("-")[-3:]
        return python, platform.split("_")[0], platform.split("_")[-1]

    @property
    def platforms(self) -> list[str]:
        """The platform tags; a wheel may bear several, joined by dots."""
        return self.path.stem.split("-")[-1].split(".")

    def is_here(self) -> bool:
        """Whether the published file lies in wheels/fetched/ with the right bytes."""
        return self.fetched.is_file() and hashlib.sha256(self.fetched.read_bytes()).hexdigest() == self.sha256

    def lay(self) -> None:
        """Put what ships into wheels/."""
        published = self.fetched.read_bytes()
        self.path.write_bytes(seal_wheel(published) if self.target[1] == "manylinux" else published)


def main() -> None:
    """Fetch, build, validate, and print where the zips are."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=ROOT / "dist", metavar="DIR", help="default: dist/")
    out: Path = parser.parse_args().out
    with alone():
        wheels = named_wheels()
        fetch_wheels(wheels)
        for wheel in wheels:
            wheel.lay()
        build_web()
        zips = build(out)
    for path in zips:
        print(f"{path}  {path.stat().st_size / 2**20:.1f} MiB", flush=True)


def named_wheels() -> list[Wheel]:
    """Read the manifest's wheels and look each up in uv.lock.

    Raises SystemExit where the lock has no such file: the manifest was not brought up to date.
    """
    manifest = read_toml("blender_manifest.toml")
    hashes = {
        wheel["url"].rpartition("/")[2]: wheel["hash"].removeprefix("sha256:")
        for package in read_toml("uv.lock")["package"]
        for wheel in package.get("wheels", ())
    }
    wheels = [(ROOT / name).resolve() for name in manifest["wheels"]]
    if unknown := [path.name for path in wheels if path.name not in hashes]:
        raise SystemExit(f"uv.lock has no {', '.join(unknown)}: bring blender_manifest.toml up to date")
    return [Wheel(path, hashes[path.name]) for path in wheels]


def fetch_wheels(wheels: list[Wheel]) -> None:
    """Download those that are not here yet, for each Python and platform in one go."""
    missing = sorted((wheel for wheel in wheels if not wheel.is_here()), key=lambda wheel: wheel.target)
    for (python, _system, _machine), group in groupby(missing, key=lambda wheel: wheel.target):
        wheels_of_target = list(group)
        print("fetching", *(wheel.path.name for wheel in wheels_of_target), flush=True)
        download(wheels_of_target, python.removeprefix("cp"))
    if wrong := [wheel.path.name for wheel in wheels if not wheel.is_here()]:
        raise SystemExit(f"wheels/fetched/ lacks {', '.join(wrong)} after the download")


def download(wheels: list[Wheel], python_version: str) -> None:
    """Let the locked pip fetch wheels of one Python and platform; a wrong hash makes it fail."""
    platforms = sorted({tag for wheel in wheels for tag in wheel.platforms})
    with tempfile.TemporaryDirectory() as folder:
        requirements = Path(folder, "requirements.txt")
        requirements.write_text("\n".join(wheel.requirement for wheel in wheels), encoding="utf-8")
        run(
            [UV, "run", "--quiet", "--frozen", "--isolated", "--only-group=package", f"--directory={ROOT}"],
            ["python", "-m", "pip", "download", "--quiet", "--no-deps"],
            ["--only-binary=:all:", "--require-hashes"],
            [
                f"--dest={ROOT / 'wheels/fetched'}",
                f"--python-version={python_version}",
                "--implementation=cp",
            ],
            [f"--platform={tag}" for tag in platforms],
            [f"--requirement={requirements}"],
        )


def build(out: Path) -> list[Path]:
    """Make one zip per platform in `out` with Blender's tool, and have it check each."""
    blender = blender_resources()
    tool = [sys.executable, str(blender / "scripts/addons_core/bl_pkg/cli/blender_ext.py")]
    tags = f"--valid-tags={blender / 'scripts/modules/_bpy_internal/extensions/tags.py'}"
    out.mkdir(parents=True, exist_ok=True)
    run(tool, ["build", "--split-platforms", f"--source-dir={ROOT}", f"--output-dir={out}", tags])
    manifest = read_toml("blender_manifest.toml")
    platforms = [platform.replace("-", "_") for platform in manifest["platforms"]]
    zips = [out / f"{manifest['id']}-{manifest['version']}-{platform}.zip" for platform in platforms]
    for path in zips:
        run(tool, ["validate", tags, str(path)])
    return zips


def blender_resources() -> Path:
    """Find the folder of scripts inside the installed bpy wheel, without starting Blender."""
    spec = find_spec("bpy")
    if spec is None or spec.origin is None:
        raise SystemExit("there is no bpy in this environment: run `uv run .ci/build_zip.py`")
    return next(path.parent for path in Path(spec.origin).parent.glob("[0-9]*/scripts"))


def read_toml(name: str) -> dict[str, Any]:
    """Read one of the repository's TOML files."""
    return tomllib.loads((ROOT / name).read_text(encoding="utf-8"))


def run(*parts: list[str]) -> None:
    """Run a command, or stop with its exit code; it has said why."""
    result = subprocess.run([argument for part in parts for argument in part], check=False)
    if result.returncode:
        raise SystemExit(result.returncode)


if __name__ == "__main__":
    main()
