# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A material as a game engine has it: the Principled shader's inputs, as constants and textures.

What is linked, be it an image or a procedural texture, is baked to a texture first, as a studio would that
hands it to an engine: the input is emitted, and read where a ray along the normal first meets the surface.
What engines lack or switch off by default is left out: anisotropy, sheen, subsurface scattering (which light
baked into a lightmap has anyway), bump on the specular lobe, and any emission.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.bake.plan import CapturePlan, Tile
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.cycles.capture_settings import first_hit_only
from radtex_addon.cycles.portal import Aim, PortalCapture
from radtex_addon.scene.nodes import NodeBuilder, Operand, Socket
from radtex_addon.scene.scratch import scene_copied
from radtex_addon.settings.spec import Kind

_COLOUR = ("Base Color",)
_SURFACE = ("Metallic", "Roughness", "Transmission Weight")
_COAT = ("Coat Weight", "Coat Roughness", "Specular IOR Level")


@dataclass(frozen=True, eq=False)
class Inputs:
    """Textures (H, W, 3), linear, row 0 at v = 0, gutter filled; (1, 1, 3) where an input is constant.

    `colour` is the base colour, `surface` metallic, roughness and transmission, `coat` the coat's weight and
    roughness, and the specular level; `ior` and `coat_ior` are numbers, and so are a thin film's thickness in
    nanometres and its index, those of the first material. `rays` is what the textures cost.
    """

    colour: Floats
    surface: Floats
    coat: Floats
    ior: float
    coat_ior: float
    film: float
    film_ior: float
    rays: int

    @property
    def textures(self) -> tuple[Floats, ...]:
        """Those of its maps that are textures, and no constants."""
        return tuple(image for image in (self.colour, self.surface, self.coat) if image.shape[0] > 1)


def read_inputs(
    scratch: bpy.types.Scene, item: bpy.types.Object, plan: CapturePlan, seed: int, folder: Path
) -> Inputs:
    """The inputs of the materials of a scratch scene's object, at the texels of a plan of one cell each.

    Raises InputError for an object with a material that is not of one Principled shader, BakeError where
    Cycles fails.
    """
    shaders = [_principled(material) for material in _materials(item)]
    images, rays = [], 0
    for names in (_COLOUR, _SURFACE, _COAT):
        constant = _constant(shaders, names)
        if constant is None:
            images.append(_baked(scratch, item, names, plan, seed, folder))
            rays += len(plan.texel)
        else:
            images.append(constant)
    numbers = ("IOR", "Coat IOR", "Thin Film Thickness", "Thin Film IOR")
    ior, coat_ior, film, film_ior = (shaders[0].inputs[name].default_value for name in numbers)
    colour, surface, coat = images
    return Inputs(colour, surface, coat, ior, coat_ior, film, film_ior, rays)


def _materials(item: bpy.types.Object) -> list[bpy.types.Material]:
    found = [slot.material for slot in item.material_slots if slot.material is not None]
    if not found:
        raise InputError(f"{item.name} has no material that an engine could read")
    return found


def _principled(material: bpy.types.Material) -> Any:
    shaders = [node for node in cast(Any, material.node_tree).nodes if node.type == "BSDF_PRINCIPLED"]
    if len(shaders) != 1:
        raise InputError(f"material {material.name} is not of one Principled shader")
    return shaders[0]


def _constant(shaders: list[Any], names: tuple[str, ...]) -> Floats | None:
    """The inputs' common value (1, 1, 3) where none is linked and all shaders agree."""
    if any(shader.inputs[name].is_linked for shader in shaders for name in names):
        return None
    values = {tuple(_numbers(shader, names)) for shader in shaders}
    if len(values) > 1:
        return None
    return np.array(values.pop(), dtype=np.float32).reshape(1, 1, 3)


def _numbers(shader: Any, names: tuple[str, ...]) -> list[float]:
    if names == _COLOUR:
        return list(shader.inputs[names[0]].default_value)[:3]
    return [shader.inputs[name].default_value for name in names]


def _baked(
    scratch: bpy.types.Scene,
    item: bpy.types.Object,
    names: tuple[str, ...],
    plan: CapturePlan,
    seed: int,
    folder: Path,
) -> Floats:
    aim = Aim(np.full((len(plan.texel), 2), 0.51))  # all but along the normal
    with scene_copied(scratch) as scene, _emitting(item, names):
        capture = PortalCapture(scene, plan, Kind.RADIANCE, 1, seed, folder, aim)
        first_hit_only(scene)
        passes = capture.render_passes(Tile(0, plan.rows))
        pixels = passes.whole if names == _COLOUR else passes.raw_whole
    values = pixels[..., :3].reshape(-1, 3)[: len(plan.texel)].astype(np.float32)
    return plan.placed(values, gutter=True)


@contextmanager
def _emitting(item: bpy.types.Object, names: tuple[str, ...]) -> Iterator[None]:
    """Let the object's materials emit some inputs of their Principled shaders, and put them back."""
    changed: list[tuple[Any, Any, Any, Any]] = []
    try:
        for material in _materials(item):
            tree: Any = material.node_tree
            output = tree.get_output_node("CYCLES").inputs["Surface"]
            before = output.links[0].from_socket if output.is_linked else None
            build = NodeBuilder(tree)
            sources = [_source(_principled(material).inputs[name]) for name in names]
            known = set(tree.nodes)
            emitted = sources[0] if names == _COLOUR else build.combine(*sources)
            emission = build.node("ShaderNodeEmission", emitted)
            tree.links.new(emission.outputs[0], output)
            changed.append((tree, output, before, [node for node in tree.nodes if node not in known]))
        yield
    finally:
        for tree, output, before, added in changed:
            for node in added:
                tree.nodes.remove(node)
            if before is not None:
                tree.links.new(before, output)


def _source(socket: Any) -> Operand:
    """What feeds an input: the socket linked to it, or its own value."""
    if socket.is_linked:
        return cast(Socket, socket.links[0].from_socket)
    value = socket.default_value
    return tuple(value) if socket.type == "RGBA" else float(value)
