# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stages with odd input: materials, lamps, surroundings."""

from __future__ import annotations

from math import radians
from typing import Any, cast

import bpy

from tests.bench.fidelity.scenes import Stage
from tests.bench.fidelity.scenes.materials import assign, principled
from tests.bench.fidelity.scenes.meshes import as_subject, link, made
from tests.bench.fidelity.scenes.stage import start
from tests.blender.odd_input import Shader, balls, material, mixed, node, output, stage_of

RED, GREEN, GREY = (0.7, 0.1, 0.05, 1.0), (0.1, 0.5, 0.1, 1.0), (0.5, 0.5, 0.5, 1.0)
WHITE = (1.0, 1.0, 1.0, 1.0)
_DUSK, _BRIGHT = (0.15, 0.2, 0.35, 1.0), (1.6, 1.4, 1.0, 1.0)

DIFFUSE = node("BsdfDiffuse", Color=RED)
CLEAR = node("BsdfTransparent")
PRINCIPLED = node("BsdfPrincipled", Base_Color=RED, Roughness=0.4)


def _start(sky: bool) -> None:
    """Empty the open file; light it by a blue sky, bright on one side, or by nothing."""
    start("sunset.exr", strength=1.0, turn=0)
    world: Any = cast(bpy.types.Scene, bpy.context.scene).world
    world.cycles.sampling_method = "NONE"  # a map of its light takes longer than all of a small bake
    tree = world.node_tree
    tree.nodes.clear()
    end, background = tree.nodes.new("ShaderNodeOutputWorld"), tree.nodes.new("ShaderNodeBackground")
    tree.links.new(background.outputs[0], end.inputs[0])
    background.inputs[0].default_value = (0, 0, 0, 1)
    if sky:
        towards = tree.nodes.new("ShaderNodeVectorMath")
        towards.operation = "DOT_PRODUCT"
        towards.inputs[1].default_value = (-0.5, -0.7, 0.5)
        tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], towards.inputs[0])
        ramp = tree.nodes.new("ShaderNodeValToRGB")
        tree.links.new(towards.outputs["Value"], ramp.inputs[0])
        for element, place, colour in zip(
            ramp.color_ramp.elements, (0.0, 0.9), (_DUSK, _BRIGHT), strict=True
        ):
            element.position, element.color = place, colour
        tree.links.new(ramp.outputs[0], background.inputs[0])


def opaque() -> Stage:
    """No roughness, and no material."""
    _start(sky=True)
    made_of = {
        "glossy": node("BsdfGlossy", Color=GREY, Roughness=0.0),
        "diffuse": DIFFUSE,
        "toon": node("BsdfToon", Color=GREEN),
        "toon glossy": _toon_glossy,
        "sheen": node("BsdfSheen", Color=WHITE),
        "hair": node("BsdfHair", Color=GREY),
        "translucent": node("BsdfTranslucent", Color=GREEN),
        "emission": node("Emission", Color=GREEN, Strength=2.0),
    }
    rows = [material(name, shader) for name, shader in made_of.items()]
    return stage_of(balls([*rows, material("nothing", None), None]))


def _toon_glossy(tree: Any) -> Any:
    socket = node("BsdfToon", Color=GREEN)(tree)
    socket.node.component = "GLOSSY"
    return socket


def glowing() -> Stage:
    """What glows in patterns: alone, beside diffuse light, and at the rim."""
    _start(sky=True)
    cells = output("TexVoronoi", "Color")
    lamps = node(
        "BsdfPrincipled", Base_Color=RED, Emission_Color=cells, Emission_Strength=output("TexWave", "Fac")
    )
    facing = output("LayerWeight", "Facing")
    rim = node("AddShader", _0=DIFFUSE, _1=node("Emission", Color=GREEN, Strength=facing))
    made_of = {
        "cells": node("Emission", Color=cells),
        "lamps": lamps,
        "rim": rim,
        "matt": DIFFUSE,
    }
    return stage_of(balls([material(name, shader) for name, shader in made_of.items()]))


def see_through() -> Stage:
    """Glass, refraction, and what camera rays pass."""
    _start(sky=True)
    rows = [
        material("glass", node("BsdfGlass", Roughness=0.0)),
        material("refraction", node("BsdfRefraction", Roughness=0.0, IOR=1.3)),
        material("transparent", node("BsdfTransparent", Color=(0.9, 0.7, 0.3, 1))),
        material("holdout", node("Holdout")),
        material("volume", None, node("VolumePrincipled", Density=3.0, Color=GREY)),
        material(
            "glass volume", node("BsdfRefraction", IOR=1.01), node("VolumeAbsorption", Color=RED, Density=2.0)
        ),
    ]
    return stage_of(balls(rows), see_through=True)


def alphas() -> Stage:
    """Alpha of every kind."""
    _start(sky=True)
    facing = output("LayerWeight", "Facing")
    camera = output("LightPath", "Is Camera Ray")
    image = output("TexChecker", "Fac")
    tinted = node("BsdfTransparent", Color=(1.0, 0.3, 0.1, 1))
    rows = [
        material("half", node("BsdfPrincipled", Base_Color=RED, Alpha=0.5)),
        material("texture", node("BsdfPrincipled", Base_Color=RED, Alpha=image)),
        material("none", node("BsdfPrincipled", Base_Color=RED, Alpha=0.0)),
        material("camera sees", mixed(camera, CLEAR, DIFFUSE)),
        material("camera does not", mixed(camera, DIFFUSE, CLEAR)),
        material("angle", mixed(facing, CLEAR, DIFFUSE)),
        material("coloured", mixed(0.5, tinted, DIFFUSE)),
        material("added", node("AddShader", _0=tinted, _1=node("Emission", Color=GREEN, Strength=0.2))),
    ]
    return stage_of(balls(rows), see_through=True)


def by_camera() -> Stage:
    """Materials that ask for the camera."""
    _start(sky=True)

    def coloured(share: Shader) -> Shader:
        colour = node("MixRGB", _0=share, _1=RED, _2=(0.05, 0.2, 0.7, 1))
        return node("BsdfPrincipled", Base_Color=colour, Roughness=0.4)

    far = output("CameraData", "View Distance")

    def by_distance(tree: Any) -> Any:
        near = tree.nodes.new("ShaderNodeMath")
        near.operation = "LESS_THAN"
        near.inputs[1].default_value = 2.0
        tree.links.new(far(tree), near.inputs[0])
        return near.outputs[0]

    rows = [
        material("is camera ray", coloured(output("LightPath", "Is Camera Ray"))),
        material("is glossy ray", coloured(output("LightPath", "Is Glossy Ray"))),
        material("facing", coloured(output("LayerWeight", "Facing"))),
        material("fresnel", mixed(node("Fresnel"), DIFFUSE, node("BsdfGlossy", Roughness=0.1))),
        material(
            "emission at the rim", node("Emission", Color=WHITE, Strength=output("LayerWeight", "Facing"))
        ),
        material("view distance", coloured(by_distance)),
        material("ray length", coloured(output("LightPath", "Ray Length"))),
        material("window", node("Emission", Color=output("TexCoord", "Window"))),
    ]
    return stage_of(balls(rows))


def whole(name: str) -> Stage:
    """All of the object is odd in one way."""
    _start(sky=True)
    known: dict[str, list[bpy.types.Material | None]] = {
        "no slot": [],
        "transparent": [material("transparent", CLEAR)],
        "holdout": [material("holdout", node("Holdout"))],
        "alpha 0": [material("alpha 0", node("BsdfPrincipled", Base_Color=RED, Alpha=0.0))],
        "unseen": [material("unseen", mixed(output("LightPath", "Is Camera Ray"), DIFFUSE, CLEAR))],
    }
    item = balls([None])
    cast(bpy.types.Mesh, item.data).materials.clear()
    for one in known[name]:
        cast(Any, item.data).materials.append(one)
    clear = name in ("transparent", "holdout", "alpha 0", "unseen")
    return stage_of(item, see_through=clear)


def _lamp(kind: str, place: tuple[float, float, float], energy: float, size: float) -> None:
    data: Any = cast(Any, bpy.data.lights).new(kind, kind)
    data.energy = energy
    if kind == "SUN":
        data.angle = size
    elif kind == "AREA":
        data.size = size
    else:
        data.shadow_soft_size = size
    item: Any = bpy.data.objects.new(kind, data)
    item.location = place
    item.rotation_euler = (-item.location).to_track_quat("-Z", "Y").to_euler()
    link(item)


def lamps(size: float, kinds: str = "POINT SPOT AREA SUN", inside: bool = False) -> Stage:
    """Glossy balls under lamps of a size in a black world."""
    _start(sky=False)
    places = {"POINT": (-2.0, -2, 1.5), "SPOT": (2.0, -2, 2), "AREA": (0.0, -1, 3), "SUN": (1.0, -0.4, 0.5)}
    watts = {"POINT": 150.0, "SPOT": 300.0, "AREA": 80.0, "SUN": 1.0}
    for kind in kinds.split():
        _lamp(kind, places[kind], watts[kind], size)
    if inside:
        _lamp("POINT", (0.0, 0.0, 0.0), 20.0, size)
    rows = [
        principled("rough", (0.7, 0.1, 0.05), Roughness=0.3),
        principled("metal", (0.8, 0.7, 0.5), Metallic=1.0, Roughness=0.2),
    ]
    return stage_of(balls(rows))


def surroundings(name: str) -> Stage:
    """None at all, or what glows of the object itself."""
    _start(sky=False)
    cast(bpy.types.Scene, bpy.context.scene).world = None
    plain = principled("metal", (0.8, 0.7, 0.5), Metallic=1.0, Roughness=0.2)
    glow = material("glow", node("Emission", Color=GREEN, Strength=2.0))
    return stage_of(balls([plain, glow] if name == "own glow" else [plain]), floor=False)


def room() -> Stage:
    """A room seen from within, its normals inwards, with a ball in it and a lamp."""
    _start(sky=False)
    bpy.ops.mesh.primitive_cube_add(size=4)
    item = as_subject(made())
    mesh = cast(bpy.types.Mesh, item.data)
    mesh.flip_normals()
    for name, colour in (("wall", (0.7, 0.6, 0.5)), ("red", (0.7, 0.1, 0.05))):
        mesh.materials.append(principled(name, colour, Roughness=0.3))
    mesh.polygons[0].material_index = 1
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=0.6, location=(0.6, 0.9, -1.3))
    bpy.ops.object.shade_smooth()
    assign(made(), principled("ball", (0.1, 0.4, 0.1), Roughness=0.2))
    _lamp("POINT", (0.0, 0.0, 1.4), 120.0, 0.2)
    stage = stage_of(item, floor=False)
    camera: Any = stage.tuning[0]
    camera.location, camera.data.lens = (-1.5, -1.6, 0.3), 18
    camera.rotation_euler = (radians(85), 0, radians(-40))
    return stage


def glass_shell() -> Stage:
    """A clear ball around another."""
    _start(sky=True)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=0.4)
    bpy.ops.object.shade_smooth()
    assign(made(), principled("ball", (0.1, 0.4, 0.1), Roughness=0.2))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=1.0)
    item = as_subject(made())
    bpy.ops.object.shade_smooth()
    cast(Any, item.data).materials.append(material("shell", node("BsdfGlass", IOR=1.1)))
    return stage_of(item)
