# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Modules of the package that import each other, directly or by way of others.

python -m tests.package.import_circles
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "radtex_addon"


def main() -> None:
    circle = find_circle()
    print("circles of imports: 0" if circle is None else f"a circle: {' -> '.join(circle)}")


def find_circle() -> list[str] | None:
    """One circle of imports, those inside functions among them, those for type checkers not; None if none."""
    modules = {_name(path): path for path in PACKAGE.rglob("*.py") if "node_modules" not in path.parts}
    graph = {name: set(_imported(name, path, modules)) - {name} for name, path in modules.items()}
    try:
        tuple(TopologicalSorter(graph).static_order())
    except CycleError as error:
        found: list[str] = error.args[1]
        return found
    return None


def _name(path: Path) -> str:
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imported(name: str, path: Path, modules: dict[str, Path]) -> Iterator[str]:
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    for node in _running(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            above = package.split(".")[: len(package.split(".")) - node.level + 1] if package else []
            base = ".".join([*above, *(node.module.split(".") if node.module else [])])
            submodules = [f"{base}.{alias.name}".lstrip(".") for alias in node.names]
            found = [each for each in submodules if each in modules]
            yield from found
            if len(found) < len(submodules) and base in modules:
                yield base


def _running(node: ast.AST) -> Iterator[ast.AST]:
    """All nodes but those below `if TYPE_CHECKING`."""
    if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
        return
    yield node
    for child in ast.iter_child_nodes(node):
        yield from _running(child)


if __name__ == "__main__":
    main()
