# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How wide a surface spreads what it mirrors, evaluated exactly: the roughness of its shaders, a ray a texel.

Materials are replaced by copies in which each shader that mirrors emits its lobe's width² for its roughness,
and all others are black. So mixes, sums and groups of shaders blend widths as they blend light.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ....bake.plan import CapturePlan
from ....core import large_arrays
from ....core.arrays import Floats, Ints
from ....core.moved_points import moved_points
from ....core.surface import SurfaceMesh
from ....cycles.capture_settings import first_hit_only
from ....cycles.path_ends import Body, path_ends
from ....cycles.portal import Aim, PortalCapture
from ....cycles.sampling import straight_shifts, tiles_of
from ....scene.nodes import NodeBuilder, Operand, Socket
from ....scene.scratch import scene_copied
from ....settings.spec import Kind
from ..lookup.lobes import SATURATION
from .own_rays import dark_world

OCTAVES = 20.0  # of width²: what is narrower than 2^-20 is as good as a mirror
_BLENDS = frozenset({"MIX_SHADER", "ADD_SHADER", "GROUP", "GROUP_INPUT", "REROUTE"})
_MIRRORS = frozenset({"BSDF_PRINCIPLED", "BSDF_GLOSSY", "BSDF_METALLIC", "BSDF_GLASS"})
_UNKNOWN = frozenset(  # they mirror, or may do so, by no roughness of GGX's
    {"SCRIPT", "BSDF_TOON", "BSDF_HAIR", "BSDF_HAIR_PRINCIPLED", "EEVEE_SPECULAR", "BSDF_RAY_PORTAL"}
)
_QUARTERS = tuple((x, y) for x in (-0.25, 0.25) for y in (-0.25, 0.25))  # four points tell a texel's mean
_SHARPEST = 0.01  # quantile of widths that vary
_DIELECTRIC = 0.04  # of a Principled shader's light, what it mirrors where it is no metal


def width_of(roughness: Floats) -> Floats:
    """The width² of the lobe that spreads what a GGX surface of such roughnesses mirrors.

    2 a² / (1 + 5 a²) with a = roughness². For small ones it is that of `lookup.lobes.lobe`; the cut at the
    horizon makes wide ones narrower. Fitted to paths at N.V = 0.8, where it is right within 5 %.
    """
    squared = np.clip(roughness, 0, 1) ** 4
    width: Floats = np.maximum(2 * squared / (1 + SATURATION * squared), 2.0**-OCTAVES)
    return width


def is_known(material: bpy.types.Material) -> bool:
    """Whether all of a material's shaders that mirror do so by a roughness."""
    return all(node.type not in _UNKNOWN for node in _shaders(material.node_tree, set()))


def may_vary(material: bpy.types.Material) -> bool:
    """Whether the roughness of a material may differ from place to place, and is known."""
    mirrors = [node for node in _shaders(material.node_tree, set()) if node.type in _MIRRORS]
    varied = len(mirrors) > 1 or any(node.inputs["Roughness"].is_linked for node in mirrors)
    return varied and is_known(material)


def within_texels(
    surface: SurfaceMesh, triangle: Ints, plan: CapturePlan, places: Iterable[tuple[float, float]] = _QUARTERS
) -> Iterator[CapturePlan]:
    """Plans of points within each of a plan's texels, which lie on triangles (K,) of the surface.

    One for each of the `places`, in texels from the texel's middle.
    """
    for x, y in places:
        step = x / plan.layout.width, y / plan.layout.height
        yield plan.moved_to(moved_points(surface, triangle, plan.points, step))


def sharpest_width(bodies: Sequence[Body], evaluated: Floats | None) -> float:
    """The width² of the sharpest lobe by which bodies mirror, 0 where it is not known; infinite if none.

    `evaluated` is what `capture_gloss` found, which tells of roughness that varies.
    """
    found = float("inf")
    for material in _used(bodies):
        for node in _shaders(material.node_tree, set()):
            if node.type in _UNKNOWN:
                return 0.0
            if node.type in _MIRRORS:
                found = min(found, _width(node.inputs["Roughness"], evaluated))
            coat = node.inputs.get("Coat Weight")
            if coat is not None and (coat.is_linked or coat.default_value > 0):
                found = min(found, _width(node.inputs["Coat Roughness"], None))
    return found


def _used(bodies: Sequence[Body]) -> set[bpy.types.Material]:
    return {material for body in bodies for material in body.mesh.materials if material is not None}


def _width(roughness: Any, evaluated: Floats | None) -> float:
    if not roughness.is_linked:
        return float(width_of(np.array(roughness.default_value)))
    known = None if evaluated is None else evaluated[np.isfinite(evaluated)]
    return 0.0 if known is None or not len(known) else float(2.0 ** np.quantile(known, _SHARPEST))


def capture_gloss(
    scene: bpy.types.Scene, bodies: Sequence[Body], plans: Iterable[CapturePlan], seed: int, folder: Path
) -> Floats | None:
    """log2 of the width² of what the bodies mirror, (K, 1), at plans of one cell for the same texels.

    NaN where it is not known or nothing is mirrored; None if no roughness may vary. Of shaders that are
    mixed, and of the plans' points, it is the mean by their light, of the logarithm: the likeliest single
    lobe. Raises BakeError where Cycles fails.
    """
    used = _used(bodies)
    if not any(map(may_vary, used)):
        return None
    with path_ends(scene, bodies, (), np.zeros(3, np.float32)) as ends:
        shown = {material: _shows_width(material) for material in used}
        for body, copy in zip(bodies, ends.copies, strict=True):
            for index, material in enumerate(body.mesh.materials):
                if material is not None:
                    cast(Any, copy.data).materials[index] = shown[material]
        ends.scene.world = dark_world()
        first_hit_only(ends.scene)
        cycles = cast(Any, ends.scene).cycles
        cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
        with ends.named_alike():
            seen = (_seen(ends.scene, plan, seed, folder) for plan in plans)
            total = next(seen)
            for each in seen:
                total += each
    coded, light = total.T
    width = np.full((len(light), 1), np.nan, dtype=np.float32)
    known = light > 0
    width[known, 0] = (np.clip(coded[known] / light[known], 0, 1) - 1) * OCTAVES
    return width


def _seen(scene: bpy.types.Scene, plan: CapturePlan, seed: int, folder: Path) -> Floats:
    """The coded widths times light, and light, that a plan's rays see: (K, 2)."""
    with scene_copied(scene) as copy:
        aim = Aim(straight_shifts(len(plan.texel)))
        capture = PortalCapture(copy, plan, Kind.RADIANCE, 1, seed, folder, aim)
        parts = [
            large_arrays.copied(capture.render_passes(tile).raw_whole[..., :2].reshape(-1, 2))
            for tile in tiles_of(plan)
        ]
    return large_arrays.concatenated(parts)


def _shaders(tree: Any, seen: set[Any]) -> Iterator[Any]:
    """The shader nodes of a tree and its groups that are not muted, each tree's once."""
    if tree is None or tree in seen:
        return
    seen.add(tree)
    for node in tree.nodes:
        if node.mute:
            continue
        if node.type == "GROUP":
            yield from _shaders(node.node_tree, seen)
        elif node.type not in _BLENDS and any(socket.type == "SHADER" for socket in node.outputs):
            yield node


def _shows_width(material: bpy.types.Material) -> bpy.types.Material:
    """A copy that emits, as red, the coded width² times the light that it is of, as green."""
    copy = cast(bpy.types.Material, material.copy())
    if copy.node_tree is not None:
        if is_known(material):
            _show_widths(copy.node_tree, {})
        else:
            copy.node_tree.nodes.clear()
    cast(Any, copy).cycles.emission_sampling = "NONE"
    return copy


def _show_widths(tree: Any, copied: dict[Any, Any]) -> None:
    """Let the shaders of a tree, and of its groups, which are copied, each once, emit their widths."""
    build = NodeBuilder(tree)
    for node in list(tree.nodes):
        if node.type == "GROUP" and node.node_tree is not None:
            if node.node_tree not in copied:
                copy = copied[node.node_tree] = node.node_tree.copy()
                _show_widths(copy, copied)
            node.node_tree = copied[node.node_tree]
        elif node.type not in _BLENDS:
            _show_width(build, node)


def _show_width(build: NodeBuilder, node: Any) -> None:
    """Put the emission of a shader's width, or nothing where it mirrors nothing, where the shader goes."""
    links = [link for socket in node.outputs if socket.type == "SHADER" for link in socket.links]
    fed = [link.to_socket for link in links]
    for link in links:
        build.tree.links.remove(link)
    if not fed or node.mute or node.type not in _MIRRORS:
        return
    light = _share_mirrored(build, node)
    coded = build.math("MULTIPLY", _coded_width(build, _value(node.inputs["Roughness"])), light)
    emission = build.node("ShaderNodeEmission", build.combine(coded, light), 1.0).outputs[0]
    for socket in fed:
        build.feed(socket, emission)


def _share_mirrored(build: NodeBuilder, node: Any) -> Operand:
    """About how much of the light a shader mirrors: of Principled ones, metal mirrors more."""
    if node.type != "BSDF_PRINCIPLED":
        return 1.0
    metal = build.node("ShaderNodeClamp", _value(node.inputs["Metallic"])).outputs[0]
    return build.math("MULTIPLY_ADD", metal, 1 - _DIELECTRIC, _DIELECTRIC)


def _coded_width(build: NodeBuilder, roughness: Operand) -> Socket:
    """`width_of` a roughness, as 1 + log2(width²) / OCTAVES."""
    held = build.node("ShaderNodeClamp", roughness).outputs[0]
    squared = build.math("POWER", held, 4.0)
    cut = build.math("MULTIPLY_ADD", squared, SATURATION, 1.0)
    width = build.math("DIVIDE", build.math("MULTIPLY", squared, 2.0), cut)
    octaves = build.math("LOGARITHM", build.math("MAXIMUM", width, 2.0**-OCTAVES), 2.0)
    return build.math("MULTIPLY_ADD", octaves, 1 / OCTAVES, 1.0)


def _value(socket: Any) -> Operand:
    """What feeds an input: the socket linked to it, or its own value."""
    return cast(Socket, socket.links[0].from_socket) if socket.is_linked else float(socket.default_value)
