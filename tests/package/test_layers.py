# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Imports point one way.

core <- formats <- bake <- settings <- scene <- cycles <- preview, textures, prepare <- forms <- export
<- store <- job <- report, farm <- worker <- ui, cli.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

pytestmark = pytest.mark.one_blender

PACKAGE = Path(__file__).resolve().parents[2] / "radtex_addon"

# Left to right; layers in one row do not know each other.
ORDER = [
    {"version"},
    {"core"},
    {"formats"},
    {"bake"},
    {"settings"},
    {"scene"},
    {"cycles"},
    {"preview", "textures", "prepare"},
    {"forms"},
    {"export"},
    {"store"},
    {"job"},
    {"report", "farm"},
    {"worker"},
    {"ui", "cli"},
]
RANK = {layer: rank for rank, row in enumerate(ORDER) for layer in row}

BLENDER = {
    *("addon_utils", "bl_operators", "bl_ui", "blf", "bpy", "bmesh", "mathutils", "bpy_extras", "gpu"),
    "gpu_extras",
    "_cycles",
}
ALLOWED: dict[str, set[str]] = {
    "version": set(),
    "core": {"numpy"},
    "formats": {"numpy", "Imath", "OpenEXR", "zstandard"},
    "bake": {"numpy"},
    "settings": {"numpy"},
    "scene": {"numpy"} | BLENDER,
}
ALLOWED |= {layer: {"numpy"} | BLENDER for row in ORDER[6:] for layer in row}

# A script that runs in a process without Blender and without the rest of the package.
WORKER = ("scene", "uv", "xatlas_worker")

UNWRAP_JOB = ("scene", "uv", "uvunwrap_job")

# The one module that judges pictures.
METRICS = ("report", "metrics")

# The modules that a worker is run with: they need no Blender, so that nothing of it is held while one runs.
OUTSIDE: set[tuple[str, ...]] = {("worker", name) for name in ("job", "order", "orders", "process", "queue")}

BY_MODULE: dict[tuple[str, ...], set[str]] = {
    WORKER: {"numpy", "xatlas"},
    METRICS: {"numpy", "flip_evaluator"},
    UNWRAP_JOB: {"numpy", "uvunwrap"},
} | {module: set() for module in OUTSIDE}

# As in ("core", "atlas") for core/atlas.py.
MODULES = [
    path.relative_to(PACKAGE).with_suffix("").parts
    for path in sorted(PACKAGE.rglob("*.py"))
    if path != PACKAGE / "__init__.py"
]


def imports(module: tuple[str, ...], source: str) -> Iterator[tuple[str, ...]]:
    """Everything that a module imports, wherever the import stands; names in the package begin with ""."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (tuple(alias.name.split(".")) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield tuple((node.module or "").split("."))
        elif isinstance(node, ast.ImportFrom):
            base = ["", *module[: len(module) - node.level], *(node.module.split(".") if node.module else ())]
            yield from ((*base, alias.name) for alias in node.names)


def trespasses(module: tuple[str, ...], source: str) -> list[str]:
    """Imports that the module's layer may not make.

    `import radtex_addon` is one too: as bl_ext.user_default.radtex.radtex_addon it is not on the path.
    """
    layer = module[0]

    def may(top: str, *rest: str) -> bool:
        if top:
            return top in BY_MODULE.get(module, ALLOWED[layer]) | sys.stdlib_module_names
        if module == WORKER:
            return False
        return rest[0] == layer or (rest[0] in RANK and RANK[rest[0]] < RANK[layer])

    return [".".join(name) for name in imports(module, source) if not may(*name)]


def source_of(module: tuple[str, ...]) -> str:
    return PACKAGE.joinpath(*module).with_suffix(".py").read_text(encoding="utf-8")


def test_every_module_is_of_a_layer_and_imports_only_from_the_layers_left_of_it() -> None:
    assert {module[0] for module in MODULES} <= RANK.keys()
    found = {".".join(module): trespasses(module, source_of(module)) for module in MODULES}
    assert {module: names for module, names in found.items() if names} == {}


ATLAS = ("core", "atlas")


@pytest.mark.parametrize(
    ("module", "source"),
    [
        (ATLAS, "import bpy"),
        (ATLAS, "def f():\n    from mathutils import Vector"),
        (ATLAS, "from ..ui import operator"),
        (ATLAS, "from .. import formats"),
        (ATLAS, "import scipy.optimize"),
        (ATLAS, "from radtex_addon.core import errors"),
        (WORKER, "import bpy"),
        (WORKER, "from ..core.errors import InputError"),
        (("scene", "packing"), "import xatlas"),
        (METRICS, "import bpy"),
        (("report", "page"), "import flip_evaluator"),
        (("worker", "queue"), "import bpy"),
    ],
)
def test_a_trespass_is_seen(module: tuple[str, ...], source: str) -> None:
    assert trespasses(module, source)


@pytest.mark.parametrize(
    ("module", "source"),
    [
        (ATLAS, "import numpy as np, json\nfrom .errors import ShapeError\nfrom ..version import VERSION"),
        (WORKER, "import numpy, xatlas, pickle"),
        (METRICS, "import numpy, flip_evaluator"),
        (("worker", "handover"), "import bpy"),
    ],
)
def test_what_a_module_may_import_is_no_trespass(module: tuple[str, ...], source: str) -> None:
    assert set(MODULES) >= OUTSIDE
    assert not trespasses(module, source)


def test_what_lies_in_a_bakes_folder_is_asked_of_its_owner() -> None:
    """`store/bake_folder.py`; the format of pieces is also that of a farm's frames and tasks."""
    inside = {("", "store", "checkpoint"), ("", "store", "checkpoint_files")}
    found = {
        "/".join(module)
        for module in MODULES
        if module[0] != "store" and any(name[:3] in inside for name in imports(module, source_of(module)))
    }
    assert found == {"farm/farm_manifest", "farm/tasks"}


def test_no_modules_import_each_other() -> None:
    assert find_circle() is None


def find_circle() -> list[str] | None:
    """One circle of imports, those inside functions among them, those for type checkers not; None if none."""
    modules = {_name(path): path for path in PACKAGE.rglob("*.py")}
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


# `scene.objects` has what does not render and lacks instances, and an object's own `matrix_world` is stale
# where a viewport hides it: scene/mesh/render_contents.py answers what renders, and where. These modules may
# read them all the same, because …
READERS: dict[str, str] = {
    **dict.fromkeys(
        (
            "cli/collection_objects",
            "cli/run_compare",
            "farm/assemble_farm",
            "farm/freeze_scene",
            "job/about_texels",
            "job/checks",
            "job/layout_choice",
            "job/assets",
            "job/scene_atlases",
            "job/instances",
            "job/left_out",
            "job/preflight",
            "job/previews",
            "preview/hidden_objects",
            "preview/kept_copies",
            "scene/mesh/cage",
            "scene/objects",
            "ui/jobs/bake_times",
            "ui/operators/bake_operator",
            "ui/operators/delete_operator",
            "ui/operators/instances_operator",
            "ui/operators/scene_operator",
            "ui/panel/forecast",
            "ui/panel/request_checks",
            "ui/settings/object_settings",
        ),
        "they look objects up that are named, whether they render or not",
    ),
    "scene/regroup": "sorts all objects of a scratch scene by whether they render",
    "forms/layered/capture/panoramas": "sorts all objects of a scratch scene by whether they render",
    "scene/checks/see_through": "asks of each whether it renders",
    "preview/swap": "finds previews, and tells whether an object moved in the viewport",
    "farm/blend": "reads a scene of ours",
    "scene/preview_file": "reads and places a copy of ours",
    "export/exporting": "reads a copy of ours",
    "report/views": "places a camera of ours",
    "scene/objects": "says where things are without a render, those too that viewports hide",
    "scene/geometry_digests": "reads evaluated objects",
    "scene/mesh/mesh_checks": "what a viewport shows, where it shows the object",
    "scene/mesh/evaluated": "reads the render's depsgraph",
    "ui/operators/texels_operator": "draws in a viewport, which shows objects where it has them",
    "scene/surfaces": "compares places in the depsgraph that lists both",
    "scene/mesh/about_area": "an estimate, of the viewport",
    "scene/block_digests": "where an object is that texture coordinates refer to",
    "scene/camera_place": "the scene's cameras, which every depsgraph evaluates",
    "report/viewpoint": "the scene's camera, which every depsgraph evaluates",
}
_SCENES = {"scene", "scratch", "copy", "bare"}
_OF_OURS = {"self", "mesh", "evaluated", "prepared", "piece", "source", "instance"}  # not Blender's objects


def reads_scene(source: str) -> bool:
    """Whether a module reads all objects of a scene, or an object's own matrix."""
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.Attribute) or not isinstance(node.value, ast.Name):
            continue
        if node.attr == "objects" and node.value.id in _SCENES:
            return True
        if node.attr == "matrix_world" and node.value.id not in _OF_OURS:
            return True
    return False


def test_what_renders_is_asked_in_one_place() -> None:
    found = {"/".join(module) for module in MODULES if reads_scene(source_of(module))}
    assert found - READERS.keys() == set(), "ask scene/mesh/render_contents.py"
    assert READERS.keys() - found == set(), "no longer needed in READERS"
