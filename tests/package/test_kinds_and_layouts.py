# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What depends on a bake's kind or layout lies in `forms` and in the tables: elsewhere neither is compared.

python -m tests.package.test_kinds_and_layouts      counts the comparisons, and says where they are
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

import pytest

from radtex_addon.bake.kinds import KINDS, Kind, Layout
from tests.package.test_layers import PACKAGE

pytestmark = pytest.mark.one_blender

_TABLES = {("bake", "kinds.py"), ("bake", "forms.py")}
_NAMES = {*map(str, Kind), *map(str, Layout), "sphere"}
_CONSTANTS = {"LAYOUT", "KIND", "LAYERED", "BUCKETS", "SPHERE", "SHADOW", "DEFAULT_KIND"}


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


if __name__ == "__main__":
    found = list(comparisons())
    print(*found, f"{len(found)} comparisons", sep="\n")
