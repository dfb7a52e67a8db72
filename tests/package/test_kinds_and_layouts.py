# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What depends on a bake's kind or layout lies in `forms` and in the tables, with which all others agree.

python -m tests.package.test_kinds_and_layouts      counts the comparisons, and says where they are
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

import pytest

from radtex_addon.export.targets import writer_of
from radtex_addon.settings.forms import FORMS
from radtex_addon.settings.kinds import KINDS, Kind, Lit
from radtex_addon.settings.targets import TARGETS, Target, targets_of
from tests.package import support_matrix
from tests.package.test_layers import PACKAGE

pytestmark = pytest.mark.one_blender

WEB_PAGE = PACKAGE.parent / "shaders/three/src/kinds.ts"

_TABLES = {("settings", "kinds.py"), ("settings", "forms.py")}
_NAMES = {*map(str, Kind), *(form.layout for form in FORMS)}
_CONSTANTS = {"LAYOUT", "KIND", "SHADOW", "DEFAULT_KIND", *(form.name.upper() for form in FORMS)}


def comparisons() -> Iterator[str]:
    """The file, line and text of each comparison with a kind or layout outside of `forms` and the tables."""
    for path in sorted(PACKAGE.rglob("*.py")):
        place = path.relative_to(PACKAGE).parts
        if place[0] in {"forms", "formats"} or place in _TABLES or "node_modules" in place:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            operands = [node.left, *node.comparators] if isinstance(node, ast.Compare) else []
            if any(_names_one(part) for operand in operands for part in _parts(operand)):
                yield f"{'/'.join(place)}:{node.lineno}: {ast.unparse(node)}"  # type: ignore[attr-defined]


def _parts(operand: ast.expr) -> Iterator[ast.expr]:
    yield operand
    if isinstance(operand, ast.Tuple | ast.List | ast.Set):
        for element in operand.elts:
            yield from _parts(element)


def _names_one(node: ast.expr) -> bool:
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        return node.value.id in {"Kind", "Layout"}
    if isinstance(node, ast.Name):
        return node.id in _CONSTANTS
    return isinstance(node, ast.Constant) and node.value in _NAMES


def test_no_kind_or_layout_is_compared() -> None:
    assert list(comparisons()) == []


def test_every_kind_has_a_row() -> None:
    assert list(KINDS) == list(Kind)


def test_every_target_has_a_row_and_a_writer() -> None:
    assert set(TARGETS) == set(Target)
    assert all(callable(writer_of(target).write) for target in Target)


def test_no_target_is_compared() -> None:
    """What depends on the target is a column of its row, or in its module."""
    compared = re.compile(r"(\bis|\bin|[!=]=)\s+(not\s+)?\(?Target\.[A-Z]")
    files = PACKAGE.rglob("*.py")
    assert [path.name for path in files if compared.search(path.read_text(encoding="utf-8"))] == []


def test_the_web_page_has_the_tables_kinds() -> None:
    text = WEB_PAGE.read_text(encoding="utf-8")
    (union,) = re.findall(r"export type Kind = ([^;]*);", text)
    assert re.findall(r'"(\w+)"', union) == [kind for kind in KINDS if Target.WEB in targets_of(kind)]


def test_the_web_page_lights_what_depends_on_lamps() -> None:
    """Only these kinds have a sun, whose direction is looked up."""
    text = WEB_PAGE.read_text(encoding="utf-8")
    lit = re.findall(r'^  (\w+): {[^}]*way: "L"', text, flags=re.MULTILINE)
    assert sorted(lit) == sorted(kind for kind, row in KINDS.items() if row.lit is Lit.BY_LAMPS)


def test_the_page_on_what_goes_with_what_is_what_the_code_refuses() -> None:
    remedy = "python -m tests.package.support_matrix"
    assert support_matrix.PAGE.read_text(encoding="utf-8") == support_matrix.page(), remedy


def test_no_cell_is_empty_and_no_kind_is_left_out() -> None:
    rows = [line for line in support_matrix.page().splitlines() if line.startswith("| ")]
    cells = [cell.strip() for row in rows for cell in row.strip("|").split("|")]
    assert all(cells)
    assert {row.split("|")[1].strip().partition(",")[0] for row in rows} >= set(Kind)


if __name__ == "__main__":
    found = list(comparisons())
    print(*found, f"{len(found)} comparisons", sep="\n")
