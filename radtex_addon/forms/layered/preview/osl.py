# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_layered.osl as a Script node, for Cycles on the CPU: see `preview.osl`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import numpy.typing as npt

from ....formats.sidecar_file import AnySidecar, opened
from ....preview.osl import SHADERS, script_node
from ....scene.mesh.copy import MATERIAL
from ..files.arrangement import DISTANCES
from ..files.layered_files import read_layered_sidecar
from ..files.sidecar import LayeredSidecar
from ..shader_values import FULL, Stored, shader_facts

SOURCE = SHADERS / "radtex_layered.osl"
_WITHOUT = "_range"  # values of textures in a form of their own; a bake's files are as they are


def add_layered_osl_node(
    tree: bpy.types.NodeTree, sidecar: AnySidecar, source: Path = SOURCE
) -> bpy.types.Node:
    """A Script node that samples the bake in the layered layout whose sidecar is the file `sidecar`.

    Inputs, with the default of an unlinked one, vectors in world space: UV; Normal (the shading normal),
    Incoming (the direction to the viewer) and Position (the shaded point); Tangent (a fallback made from the
    normal) and Sign (+1), which matter only where light comes through; Material, which of several materials
    is linked to their numbers on the baked mesh's faces. Outputs: Color, scene-linear Rec.709, premultiplied
    by Alpha. The bake's numbers are in the node's text. The scene must render with Open Shading Language on
    the CPU, as for `preview.osl.add_osl_node`. Raises FormatError as `read_layered_sidecar` does, InputError
    for more lamps than shaders take and as `add_osl_node` does.
    """
    file = opened(sidecar)
    facts = read_layered_sidecar(file)
    text = f"{constants_of(facts)}\n{source.read_text(encoding='utf-8')}"
    node = script_node(tree, source.name, text, {"Bake": str(file.path.with_suffix(""))})
    if len(facts.materials) > 1:  # OSL's own getattribute does not find it in Cycles
        number = cast(Any, tree.nodes.new("ShaderNodeAttribute"))
        number.attribute_name = MATERIAL
        tree.links.new(number.outputs["Fac"], node.inputs["Material"])
    return node


def constants_of(sidecar: LayeredSidecar) -> str:
    """The definitions that radtex_layered.osl needs before it. Raises InputError for too many lamps."""
    found = shader_facts(replace(sidecar, looks=()), {DISTANCES: Stored(mean=sidecar.nearness)}, FULL)
    materials = found["materials"]
    values = {name: value for name, value in found["values"].items() if not name.endswith(_WITHOUT)}
    values |= {name: [one[name] for one in materials] for name in materials[0]}
    lines = [f"#define {name} {value}" for name, value in found["defines"].items()]
    lines.append(f"#define RADTEX_MATERIALS {len(materials)}")
    sizes = {
        "FINE": sidecar.colour,
        "WIDTHS": sidecar.width,
        "TEXELS": (sidecar.bake.width, sidecar.bake.height),
        "COARSE": sidecar.coarse,
    }
    values |= {f"radtex_{name}": list(size) for name, size in sizes.items()}
    if "radtex_shell" in values:  # RADTEX_SHELL is how many
        values["radtex_shell_planes"] = values.pop("radtex_shell")
    for name, value in values.items():
        lines.append(f"#define {name.upper()} {_braces(value)}")
    for name, counted in (
        ("MATERIAL", "material"),
        ("LOBES", "lobes"),
        ("GLOSS", "gloss"),
        ("BRUSH", "brush"),
        ("LAMPS", "lamp_place"),
        ("SHELL", "shell_planes"),
        ("BOXES", "box_low"),
    ):
        if f"radtex_{counted}" in values:
            lines.append(f"#define RADTEX_{name}_COUNT {np.size(values[f'radtex_{counted}'])}")
    return "\n".join(lines)


def _braces(value: npt.ArrayLike) -> str:
    """Numbers as a list of OSL, all as floats."""
    numbers = np.ravel(np.asarray(value, dtype=np.float64)).tolist()
    return f"{{ {', '.join(map(repr, numbers))} }}"
