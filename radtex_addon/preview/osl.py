# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex.osl as a Script node: for Cycles on the CPU, in builds that bring Open Shading Language.

Blender 5.2 reads a shader's textures bilinearly whatever it asks for. Read at a pixel's centre that is the
pixel, but for rounding: 1e-4 of its neighbour for an atlas 1,000 pixels wide, 1e-3 for 10,000. The node group
has no such limit.
"""

from __future__ import annotations

import importlib
import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import bpy

from ..core.atlas import AtlasLayout
from ..core.errors import InputError
from ..core.sampler import Filter

SOURCE = Path(__file__).parents[2] / "shaders" / "radtex.osl"
_FILTERS = {Filter.NEAREST: 0, Filter.LINEAR: 1, Filter.QUADRILINEAR: 2}

_log = logging.getLogger(__name__)


def add_osl_node(
    tree: bpy.types.NodeTree, atlas: Path, layout: AtlasLayout, kind: Filter, source: Path = SOURCE
) -> bpy.types.Node:
    """A Script node that samples the atlas file as the node group does, with sockets of the same names.

    Inputs: UV, Normal (unlinked: the shading normal), Tangent (the fallback), Sign (+1), Incoming (the
    viewer); outputs: Color and Alpha. The scene must render with Open Shading Language
    (`scene.cycles.shading_system`) on the CPU, working in Rec.709. Raises InputError where this Blender
    cannot compile the shader.
    """
    node = cast(Any, tree.nodes.new("ShaderNodeScript"))
    text = cast(Any, bpy.data.texts.new(source.name))
    text.from_string(source.read_text(encoding="utf-8"))
    try:
        _compile(node, text)
    except InputError:
        tree.nodes.remove(node)
        bpy.data.texts.remove(text)
        raise
    constants = {
        "Atlas": str(atlas),
        "Width": layout.width,
        "Height": layout.height,
        "Bucket": layout.bucket,
        "Filter": _FILTERS[kind],
        "BottomUp": bpy.app.version
        >= (5, 0),  # 4.5 reads textures by OpenImageIO, 5.2 by Cycles's own reader
    }
    for name, value in constants.items():
        node.inputs[name].default_value = value
    return cast(bpy.types.Node, node)


def _compile(node: Any, text: Any) -> None:
    """Compile the node's script and give it its sockets, as the button "Script Node Update" does."""
    reports: list[str] = []
    try:
        with _bundled_packages():
            node.mode = (
                "INTERNAL"  # keeps the compiled shader in the node: nothing is written beside the source
            )
            node.script = text
            cycles_osl = importlib.import_module("cycles.osl")
            done = cycles_osl.update_script_node(node, lambda _kind, message: reports.append(message))
    except (ImportError, AttributeError) as error:
        raise InputError(
            f"{text.name}: this Blender has no OSL ({error}); use an official build, or the node group"
        ) from error
    _log.debug("%s: %s", text.name, "; ".join(reports))
    if not done:
        raise InputError(
            f"{text.name}: does not compile ({'; '.join(reports)}); its errors are on the console"
        )


@contextmanager
def _bundled_packages() -> Iterator[None]:
    """Make the Python packages that Blender brings importable, oslquery among them; its module hides them."""
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    python = Path(bpy.utils.resource_path("LOCAL"), "python")
    folders = [str(python / "lib" / version / "site-packages"), str(python / "lib" / "site-packages")]
    added = [folder for folder in folders if folder not in sys.path and Path(folder).is_dir()]
    sys.path.extend(added)
    try:
        yield
    finally:
        for folder in added:
            sys.path.remove(folder)
