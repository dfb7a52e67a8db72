# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How wide a surface spreads what it mirrors, evaluated exactly: the roughness of its shaders, a ray a texel.

Materials are replaced by copies in which each shader that mirrors emits its lobe's width² for its roughness,
and all others are black. So mixes, sums and groups of shaders blend widths as they blend light. Along what
metal is brushed is asked likewise: shaders emit their tangents.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
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
_BRUSHED = frozenset({"BSDF_PRINCIPLED", "BSDF_GLOSSY", "BSDF_METALLIC"})
_ANISOTROPY = ("Anisotropic", "Anisotropy")
_LEAST_BRUSHED = 0.02  # anisotropy
_LEAST_LENGTH = 0.1  # of the mean of unit tangents, below which they tell of no direction
_QUARTERS = tuple((x, y) for x in (-0.25, 0.25) for y in (-0.25, 0.25))  # four points tell a texel's mean
_BLURRED = 4.0  # times a light's width²: that of lobes in which its shape hardly shows
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
    return min((_sharpest(material, evaluated) for material in _used(bodies)), default=float("inf"))


def widest_blur(bodies: Sequence[Body], evaluated: Floats | None) -> float:
    """The most width² that a round blur may have in place of a light of another shape.

    So wide that no lobe by which bodies mirror shows that it is round; brushed metal, which draws it out, may
    be as sharp as the blur. `evaluated` as for `sharpest_width`.
    """
    return min(
        (_sharpest(one, evaluated) / (1 if is_brushed(one) else _BLURRED) for one in _used(bodies)),
        default=float("inf"),
    )


def _sharpest(material: bpy.types.Material, evaluated: Floats | None) -> float:
    """`sharpest_width` of one material."""
    found = float("inf")
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
    """The materials that faces of the bodies have, not those of slots without faces."""
    return {one for body in bodies for one in body.shown_materials if one is not None}


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
    coded, light, _ = _emitted(scene, bodies, plans, _shows_width, seed, folder).T
    width = np.full((len(light), 1), np.nan, dtype=np.float32)
    known = light > 0
    width[known, 0] = (np.clip(coded[known] / light[known], 0, 1) - 1) * OCTAVES
    return width


def is_brushed(material: bpy.types.Material) -> bool:
    """Whether a material may be brushed metal: its shaders that mirror are anisotropic, or may be so.

    Not under a coat, and not where shaders are added: what they emit would not be the mean of their tangents.
    """
    nodes = list(_shaders(material.node_tree, set()))
    if any(node.type in _UNKNOWN or _is_above(node.inputs.get("Coat Weight"), 0) for node in nodes):
        return False
    added = any(node.type == "ADD_SHADER" for node in _nodes(material.node_tree, set()))
    return not added and any(map(_is_anisotropic, nodes))


def may_be_brushed(bodies: Sequence[Body]) -> bool:
    """Whether any material of the bodies may be brushed metal."""
    return any(map(is_brushed, _used(bodies)))


def capture_tangents(
    scene: bpy.types.Scene, bodies: Sequence[Body], plan: CapturePlan, seed: int, folder: Path
) -> Floats | None:
    """Along what the bodies are brushed, at a plan of one cell: unit vectors in world space, (K, 3) float32.

    0 where they are not; None if no material is. Raises BakeError where Cycles fails.
    """
    if not may_be_brushed(bodies):
        return None
    found = 2 * _emitted(scene, bodies, [plan], _shows_tangent, seed, folder) - 1
    length = np.linalg.norm(found, axis=1, keepdims=True)
    known = (length > _LEAST_LENGTH) & (length < 2 - _LEAST_LENGTH)  # no ray that misses, which sees -1
    known &= (found > -1 + 1e-6).any(axis=1, keepdims=True)
    tangent: Floats = np.where(known, found / np.maximum(length, _LEAST_LENGTH), 0)
    return tangent.astype(np.float32)


def _emitted(
    scene: bpy.types.Scene,
    bodies: Sequence[Body],
    plans: Iterable[CapturePlan],
    shows: Callable[[bpy.types.Material], bpy.types.Material],
    seed: int,
    folder: Path,
) -> Floats:
    """The sums of what the plans' rays see, (K, 3), with each material replaced by what it `shows`."""
    with path_ends(scene, bodies, (), np.zeros(3, np.float32)) as ends:
        shown = {material: shows(material) for material in _used(bodies)}
        for body, copy in zip(bodies, ends.copies, strict=True):
            for index, material in enumerate(body.mesh.materials):
                if material in shown:
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
    return total


def _seen(scene: bpy.types.Scene, plan: CapturePlan, seed: int, folder: Path) -> Floats:
    """What a plan's rays see: (K, 3)."""
    with scene_copied(scene) as copy:
        aim = Aim(straight_shifts(len(plan.texel)))
        capture = PortalCapture(copy, plan, Kind.RADIANCE, 1, seed, folder, aim)
        parts = [
            large_arrays.copied(capture.render_passes(tile).raw_whole[..., :3].reshape(-1, 3))
            for tile in tiles_of(plan)
        ]
    return large_arrays.concatenated(parts)


def _shaders(tree: Any, seen: set[Any]) -> Iterator[Any]:
    """The shader nodes of a tree and its groups that are not muted, each tree's once."""
    for node in _nodes(tree, seen):
        if node.type not in _BLENDS and any(socket.type == "SHADER" for socket in node.outputs):
            yield node


def _nodes(tree: Any, seen: set[Any]) -> Iterator[Any]:
    """The nodes of a tree and its groups that are not muted, but the groups, each tree's once."""
    if tree is None or tree in seen:
        return
    seen.add(tree)
    for node in tree.nodes:
        if node.mute:
            continue
        if node.type == "GROUP":
            yield from _nodes(node.node_tree, seen)
        else:
            yield node


def _is_anisotropic(node: Any) -> bool:
    """Whether a shader mirrors more widely along its tangent, or across it."""
    return node.type in _BRUSHED and _is_above(_of(node, *_ANISOTROPY), _LEAST_BRUSHED)


def _is_above(socket: Any, least: float) -> bool:
    """Whether a socket, if there is one, may have a value of more than that, or less than minus that."""
    return socket is not None and (socket.is_linked or abs(socket.default_value) > least)


def _of(node: Any, *names: str) -> Any:
    """The first of a node's inputs that it has; None without any."""
    return next((node.inputs[name] for name in names if name in node.inputs), None)


def _shows_width(material: bpy.types.Material) -> bpy.types.Material:
    """A copy that emits, as red, the coded width² times the light that it is of, as green."""
    return _shows(material, is_known(material), _width_shown)


def _shows_tangent(material: bpy.types.Material) -> bpy.types.Material:
    """A copy that emits half of its unit tangent and a half; of what is not brushed the tangent is 0."""
    return _shows(material, is_brushed(material), _tangent_shown)


_Emits = Callable[[NodeBuilder, Any], Operand | None]


def _shows(material: bpy.types.Material, known: bool, emits: _Emits) -> bpy.types.Material:
    """A copy in which each shader emits what is asked of it; if that is not `known`, none does."""
    copy = cast(bpy.types.Material, material.copy())
    if copy.node_tree is not None:
        if known:
            _show(copy.node_tree, {}, emits)
        else:
            copy.node_tree.nodes.clear()
    cast(Any, copy).cycles.emission_sampling = "NONE"
    return copy


def _show(tree: Any, copied: dict[Any, Any], emits: _Emits) -> None:
    """Let the shaders of a tree, and of its groups, which are copied, each once, emit what `emits` says."""
    build = NodeBuilder(tree)
    for node in list(tree.nodes):
        if node.type == "GROUP" and node.node_tree is not None:
            if node.node_tree not in copied:
                copy = copied[node.node_tree] = node.node_tree.copy()
                _show(copy, copied, emits)
            node.node_tree = copied[node.node_tree]
        elif node.type not in _BLENDS:
            _replace(build, node, emits)


def _replace(build: NodeBuilder, node: Any, emits: _Emits) -> None:
    """Put the emission of what is asked of a shader, or nothing, where the shader goes."""
    links = [link for socket in node.outputs if socket.type == "SHADER" for link in socket.links]
    fed = [link.to_socket for link in links]
    for link in links:
        build.tree.links.remove(link)
    shown = None if not fed or node.mute else emits(build, node)
    if shown is None:
        return
    emission = build.node("ShaderNodeEmission", shown, 1.0).outputs[0]
    for socket in fed:
        build.feed(socket, emission)


def _width_shown(build: NodeBuilder, node: Any) -> Operand | None:
    """A shader's coded width² times light, and light; None where it mirrors nothing."""
    if node.type not in _MIRRORS:
        return None
    light = _share_mirrored(build, node)
    coded = build.math("MULTIPLY", _coded_width(build, _value(node.inputs["Roughness"])), light)
    return build.combine(coded, light)


def _tangent_shown(build: NodeBuilder, node: Any) -> Operand | None:
    """Half of a shader's unit tangent, turned as it says, and a half, which is all of what has none."""
    if not any(socket.type == "SHADER" for socket in node.outputs):
        return None
    if not _is_anisotropic(node):
        return (0.5, 0.5, 0.5, 1.0)
    given = node.inputs["Tangent"]
    tangent = cast(Socket, given.links[0].from_socket) if given.is_linked else build.geometry("Tangent")
    turns = _of(node, "Anisotropic Rotation", "Rotation")
    if _is_above(turns, 0):
        angle = build.math("MULTIPLY", _value(turns), 2 * math.pi)
        turn = build.node("ShaderNodeVectorRotate", rotation_type="AXIS_ANGLE")
        for name, operand in (
            ("Vector", tangent), ("Axis", build.geometry("Normal")), ("Angle", angle)
        ):  # fmt: skip
            build.feed(turn.inputs[name], operand)
        tangent = turn.outputs[0]
    unit = build.vector("NORMALIZE", tangent)
    brush = _of(node, *_ANISOTROPY)
    if brush.is_linked:  # it may be none at places
        size = build.math("ABSOLUTE", _value(brush))
        unit = build.vector("SCALE", unit, build.math("GREATER_THAN", size, _LEAST_BRUSHED))
    return build.vector("MULTIPLY_ADD", unit, (0.5, 0.5, 0.5), (0.5, 0.5, 0.5))


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
