# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A copy of the package with one more kind, form or option: what docs/extending.md tells to write.

python -m tests.examples.extended     prints what the example of each adds to the package
"""

from __future__ import annotations

import difflib
import shutil
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
_END_OF_MEMBERS = "\n    @property\n    def traits(self) -> KindTraits"
_END_OF_KINDS = "}\n\n\nDEFAULT_KIND"
_END_OF_FIELDS = "\n\n_DEFAULTS"
_END_OF_LIGHT = "))\n\nLAYOUT"
_END_OF_FORMS = "LAYERED)\n"

KIND_MEMBER = '    IRRADIANCE = "irradiance"\n'
KIND_ROW = """    Kind.IRRADIANCE: KindTraits(
        title="Irradiance",
        tooltip="The light that arrives, in cells that all count the same for a matt surface",
        light=Light.ARRIVING,
        rays=Rays.COSINE,
        source=True,
        lamps=True,
        judged=False,
    ),
"""
FORM_ROW = (
    'FormTraits("mean", "buckets", "means", layers=False, accumulates=False, refreshes=False, farm=False)'
)
OPTION_FIELD = "    only_front: bool = False\n"
OPTION_ROW = """    _row("only_front", flag="--only-front", title="Only Front", called="front alone",
         help="bake what is seen from in front alone", tooltip="Bake what is seen from in front alone",
         applies=lambda kind, _: kind.looks_at_surface, refusal="{kind} has no front", added=True,
         mark=Mark(on="is of the front alone", off="is of all sides",
                   unlike="is of the front alone: compare a bake of all sides")),
"""


def add_option(folder: Path) -> Path:
    """Copy the package into `folder`, with an option `only_front`."""
    package = _copied(folder)
    changes = {_END_OF_FIELDS: OPTION_FIELD + _END_OF_FIELDS, _END_OF_LIGHT: OPTION_ROW + _END_OF_LIGHT}
    _insert(package / "settings" / "options.py", changes)
    return package


def add_kind(folder: Path, form: str = "") -> Path:
    """Copy the package into `folder`, with a kind `irradiance`, of a `form` if one is named."""
    package = _copied(folder)
    row = KIND_ROW.replace("        source", f"        form={form},\n        source") if form else KIND_ROW
    _insert(
        package / "settings" / "kinds.py",
        {_END_OF_MEMBERS: KIND_MEMBER + _END_OF_MEMBERS, _END_OF_KINDS: row + _END_OF_KINDS},
    )
    return package


def add_form(folder: Path) -> Path:
    """Copy the package into `folder`, with a form `mean`, and a kind `irradiance` that has it."""
    package = add_kind(folder, form="MEAN")
    shutil.copytree(ROOT / "tests" / "examples" / "mean", package / "forms" / "mean")
    row = f"MEAN = {FORM_ROW}\n"
    forms = {"\nFORMS = (": f"\n{row}FORMS = (", _END_OF_FORMS: "LAYERED, MEAN)\n"}
    _insert(package / "settings" / "forms.py", forms)
    _insert(package / "settings" / "kinds.py", {"AMBIENT, BITS": "AMBIENT, BITS, MEAN"})
    return package


def _copied(folder: Path) -> Path:
    """The package without what is built, in a folder that can be a process's working directory."""
    left_out = shutil.ignore_patterns("node_modules", "__pycache__", "built")
    shutil.copytree(ROOT / "shaders", folder / "shaders")
    return Path(shutil.copytree(ROOT / "radtex_addon", folder / "radtex_addon", ignore=left_out))


def _insert(path: Path, changes: dict[str, str]) -> None:
    text = path.read_text(encoding="utf-8")
    for found, instead in changes.items():
        assert text.count(found) == 1, (path, found)
        text = text.replace(found, instead)
    path.write_text(text, encoding="utf-8", newline="\n")


def summary(package: Path) -> list[str]:
    """A line for each file that differs from the package's: its path, and how many lines were added."""
    lines = []
    for path in sorted(package.rglob("*.py")):
        ours = ROOT / "radtex_addon" / path.relative_to(package)
        before = ours.read_text(encoding="utf-8").splitlines() if ours.is_file() else []
        now = path.read_text(encoding="utf-8").splitlines()
        added = sum(line.startswith("+ ") for line in difflib.ndiff(before, now))
        if before != now:
            lines.append(f"{path.relative_to(package)}: {'edited' if before else 'new'}, +{added}")
    return lines


if __name__ == "__main__":
    for add in (add_option, add_kind, add_form):
        with tempfile.TemporaryDirectory() as folder:
            print(add.__name__, *summary(add(Path(folder))), sep="\n  ", file=sys.stdout)
