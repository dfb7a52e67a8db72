# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
"""Show a bake in Cycles by its Open Shading Language shader, without RadTex: the active object glows with it.

    blender Vase.preview.blend -P shaders/examples/script_node.py -- baked/Vase.radiance.json

The active object is the baked copy, where the bake stood. It takes an official Blender, with OSL.
"""

import json
import sys
from pathlib import Path

import bpy  # noqa: TID251 - it runs inside Blender

SHADERS = Path(__file__).parents[1]


def values(sidecar, facts):
    """What the shader's sockets take, from the sidecar's facts."""
    (width, height), bucket = facts["texels"], facts["bucket"]
    known = {"Width": width, "Height": height, "Bucket": bucket, "BottomUp": bpy.app.version >= (5, 0)}
    return known | {"Atlas": str(sidecar.with_suffix(".exr"))}


def main(sidecar):
    """Give the active object a material that looks the bake up."""
    facts = json.loads(sidecar.read_text(encoding="utf-8"))
    if facts["layout"] != "buckets":
        sys.exit(f"{sidecar} is not in layout buckets, which alone is looked up in OSL")
    scene, baked = bpy.context.scene, bpy.context.object
    scene.render.engine, scene.cycles.device, scene.cycles.shading_system = "CYCLES", "CPU", True
    material = bpy.data.materials.new("radiance texture")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()

    lookup = tree.nodes.new("ShaderNodeScript")
    lookup.script = bpy.data.texts.load(str(SHADERS / "radtex.osl"))  # compiles it
    for name, value in values(sidecar, facts).items():
        lookup.inputs[name].default_value = value

    uv = tree.nodes.new("ShaderNodeUVMap")
    uv.uv_map = facts["uv_map"]
    tree.links.new(uv.outputs["UV"], lookup.inputs["UV"])
    tangent, sign = tree.nodes.new("ShaderNodeTangent"), tree.nodes.new("ShaderNodeAttribute")
    tangent.direction_type, tangent.uv_map = "UV_MAP", facts["uv_map"]
    sign.attribute_name = "radtex_sign"
    tree.links.new(tangent.outputs["Tangent"], lookup.inputs["Tangent"])
    tree.links.new(sign.outputs["Fac"], lookup.inputs["Sign"])

    glow, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(lookup.outputs["Color"], glow.inputs["Color"])
    tree.links.new(glow.outputs["Emission"], output.inputs["Surface"])
    baked.data.materials.clear()
    baked.data.materials.append(material)


main(Path(sys.argv[sys.argv.index("--") + 1]).absolute())
