# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/*.osl as Script nodes: for Cycles on the CPU, in Blender builds with Open Shading Language.

Blender 5.2 filters an OSL shader's textures bilinearly, whatever the shader asks for. A lookup at a pixel's
centre gives that pixel, but rounding mixes in a little of its neighbour: 1e-4 if the image is 1,000 pixels
wide, 1e-3 if 10,000. The node groups do not have this error.
"""

from __future__ import annotations

import importlib
import logging
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import bpy

from ..core.atlas import AtlasLayout
from ..core.errors import InputError
from ..core.sampler import Filter
from ..formats.sidecar_file import AnySidecar, read_facts
from ..scene.working_space import REC_709, working_space

SHADERS = Path(__file__).parents[2] / "shaders"
SOURCE = SHADERS / "radtex.osl"
_FILTERS = {Filter.NEAREST: 0, Filter.LINEAR: 1, Filter.QUADRILINEAR: 2}

_log = logging.getLogger(__name__)


def add_osl_node(
    tree: bpy.types.NodeTree, atlas: Path, layout: AtlasLayout, kind: Filter, source: Path = SOURCE
) -> bpy.types.Node:
    """A Script node that samples the atlas file as the node group does, with sockets of the same names.

    Inputs, with the default of an unlinked one: UV, Normal (the shading normal), Tangent (a fallback made
    from the normal), Sign (+1), Incoming (the direction to the viewer); outputs: Color and Alpha. The scene
    must render with Open Shading Language (`scene.cycles.shading_system`) on the CPU. Raises InputError if
    this Blender cannot compile the shader, or if the file's working space is not Rec.709.
    """
    constants = {
        "Atlas": str(atlas),
        "Width": layout.width,
        "Height": layout.height,
        "Bucket": layout.bucket,
        "Filter": _FILTERS[kind],
    }
    return script_node(tree, source.name, source.read_text(encoding="utf-8"), constants)


def check_scene(scene: bpy.types.Scene) -> None:
    """Raise InputError if the scene's device for Cycles cannot run Script nodes."""
    if cast(Any, scene).cycles.device == "GPU":
        raise InputError(
            f"scene '{scene.name}' renders on the GPU, and Script nodes (OSL) run on the CPU: set Render "
            "Properties > Device to CPU, or choose the nodes for Eevee and Cycles"
        )


def switch_osl_on(scene: bpy.types.Scene) -> bool:
    """Let Cycles run Script nodes in this scene. Returns False if it did so already."""
    cycles = cast(Any, scene).cycles
    before = bool(cycles.shading_system)
    cycles.shading_system = True
    return not before


def no_script(sidecar: AnySidecar) -> InputError:
    """The error for a bake that has no OSL shader."""
    facts = read_facts(sidecar)
    return InputError(
        f"{facts.source} is a bake of kind {facts.text('kind')}, which has no Script node (OSL): choose the "
        "nodes for Eevee and Cycles"
    )


def script_node(
    tree: bpy.types.NodeTree, name: str, source: str, constants: Mapping[str, Any]
) -> bpy.types.Node:
    """A Script node with the shader `source`, in a text of that name, its sockets set to `constants`.

    The shader has a socket BottomUp besides. Raises InputError as `add_osl_node` does; nothing is added then.
    """
    if working_space() != REC_709:
        raise InputError(f"OSL shows Rec.709, and the file works in {working_space()}: use the node group")
    node = cast(Any, tree.nodes.new("ShaderNodeScript"))
    text = cast(Any, bpy.data.texts.new(name))
    text.from_string(source)
    try:
        _compile(node, text)
    except InputError:
        tree.nodes.remove(node)
        bpy.data.texts.remove(text)
        raise
    for socket, value in constants.items():
        node.inputs[socket].default_value = value
    # 4.5 reads textures with OpenImageIO, from the top row; 5.2 with Cycles's own reader, from the bottom row
    node.inputs["BottomUp"].default_value = bpy.app.version >= (5, 0)
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
            f"{text.name}: does not compile ({'; '.join(reports)}), its errors are on the console; use the "
            "node group"
        )


@contextmanager
def _bundled_packages() -> Iterator[None]:
    """Make Blender's own Python packages importable, such as oslquery: as a module, Blender hides them."""
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
