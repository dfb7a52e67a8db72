# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The baked copy as binary glTF: the exact frame of the bake, our extension, and a fallback for any viewer.

Blender's own exporter writes the mesh and its node. It rounds normals and tangents to four digits, so these
are replaced by the bake's. In glTF y points up and v runs down: (x, y, z) becomes (x, z, -y), v becomes
1 - v.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias, cast
from urllib.parse import quote

import addon_utils
import bpy
import numpy as np

from ..core.arrays import Floats
from ..core.errors import BakeError, InputError
from ..core.frame import normalised
from ..formats.containers.glb import Glb
from ..formats.disk.temporary import temporary_folder
from ..scene.mesh.copy import MATERIAL, NORMAL, OBJECT, SIGN, TANGENT, face_numbers, material_numbers
from ..settings.kinds import Kind
from ..settings.targets import TargetTraits
from .export_manifest import Manifest
from .gltf_images import GltfImages, kept_layers, set_coordinates
from .material_images import MaterialPictures, Picture
from .quantised import compress, quantise

EXTENSION = "RADTEX_radiance_texture"
UNLIT = "KHR_materials_unlit"
OPAQUE = "radtex_opaque"  # in a material's extras: it hides what lies behind, beside others that are clear
_EXPORTER = "io_scene_gltf2"
_CARRIED = {NORMAL: "_RADTEX_NORMAL", TANGENT: "_RADTEX_TANGENT", SIGN: "_RADTEX_SIGN"}
_PLACE = "RadTex "  # how temporary materials' names begin, before the place of their slot
Pictures: TypeAlias = Mapping[int, MaterialPictures]  # of materials, by their numbers
NO_PICTURES: Pictures = {}


@dataclass(frozen=True, eq=False)
class BakedMesh:
    """A baked copy as glTF without materials: a node with its mesh, or one for each of joined objects.

    A mesh has a primitive for each of its `numbers`, by which shaders tell a bake's materials apart. The
    primitive's `material` is a place among the `numbers` of all.
    """

    glb: Glb
    numbers: tuple[int, ...]


def write_gltf(
    scene: bpy.types.Scene,
    copy: bpy.types.Object,
    uv_layer: str,
    flat: bytes,
    manifest: Manifest,
    path: Path,
    traits: TargetTraits,
    clear: bool = False,
    names: Sequence[str] = (),
    pictures: Pictures = NO_PICTURES,
    compressed: bool = False,
) -> None:
    """Write the baked copy, which is alone in `scene` and is changed, to `path`, for a target's loaders.

    If it joins the copies of several objects with these `names`, each gets a node. `flat` is the PNG of
    materials without `pictures` of their own; if `clear`, its alpha is blended. The material of a hull is
    single-sided. If `compressed`, the mesh is so by EXT_meshopt_compression. Raises BakeError if Blender's
    exporter fails.
    """
    names = names or (manifest.bake["object"],)
    mesh = baked_mesh(scene, copy, uv_layer, manifest, names, traits, pictures, compressed)
    glb = mesh.glb
    glb.document["scenes"][0]["name"] = manifest.name
    images = GltfImages(glb)
    plain = any(number not in pictures for number in mesh.numbers)
    texture = add_flat(images, flat, manifest.flat) if plain else None
    add_materials(images, texture, manifest, mesh.numbers, manifest.name, clear, pictures)
    glb.compact()
    if compressed:
        compress(glb)
    glb.write(path)


def baked_mesh(
    scene: bpy.types.Scene,
    copy: bpy.types.Object,
    uv_layer: str,
    manifest: Manifest,
    names: Sequence[str],
    traits: TargetTraits,
    pictures: Pictures = NO_PICTURES,
    compressed: bool = False,
) -> BakedMesh:
    """The baked copy, which is alone in `scene` and is changed, as glTF for a target with these `traits`.

    Its node and mesh get the only one of the `names`, or if it joins several copies each gets its own.
    Materials with `pictures` of their own have these on TEXCOORD_0, and the bake on TEXCOORD_1. The mesh is
    made ready for `compress` if it is to be `compressed`. Raises BakeError if Blender's exporter fails.
    """
    layers: tuple[str, ...] = (uv_layer,)
    if pictures:
        own = {number: each.facts.uv_map for number, each in pictures.items()}
        set_coordinates(copy.data, uv_layer, own)
        layers = kept_layers(uv_layer)
    slots = _split(copy, by_material=manifest.shader is not None, by_object=len(names) > 1)
    numbers = sorted({slot.material for slot in slots})
    _strip(copy, layers, several=len(slots) > 1)
    with temporary_folder() as folder:
        file = folder / "mesh.glb"
        _export(scene, file, several=len(slots) > 1)
        glb = Glb.read(file)
    document = glb.document
    (mesh,), (node,) = document["meshes"], document["nodes"]
    primitives: dict[int, list[Any]] = {}
    for primitive in mesh["primitives"]:
        _set_frame(glb, primitive["attributes"])
        slot = slots[_place_of(document, primitive) if len(slots) > 1 else 0]
        primitive["material"] = numbers.index(slot.material)
        primitives.setdefault(slot.object, []).append(primitive)
    shown = sorted(primitives)
    document["meshes"] = [{**mesh, "name": names[one], "primitives": primitives[one]} for one in shown]
    document["nodes"] = [{**node, "name": names[one], "mesh": place} for place, one in enumerate(shown)]
    document["scenes"][0]["nodes"] = list(range(len(shown)))
    document["materials"] = []
    width, height = manifest.bake["texels"]
    quantise(glb, traits, (width, height), compressed)
    document["asset"]["generator"] = f"{manifest.tool}, {document['asset']['generator']}"
    return BakedMesh(glb, tuple(numbers))


def extension_facts(manifest: Manifest, material: int | None = None) -> dict[str, Any]:
    """The JSON of our extension: the manifest's, with each texture's file also as a relative `uri`.

    `material` is the material's number where the bake's shader tells materials apart.
    """
    facts = manifest.facts()
    mirror = [facts["mirror"]] if "mirror" in facts else []
    for texture in (*facts["textures"].values(), *mirror):
        texture["uri"] = quote(texture["file"])
    if material is not None:
        facts["material"] = material
    return facts


def extension_in(material: Mapping[str, Any]) -> dict[str, Any]:
    """Our extension in a material of a document: its base colour texture's, which the extension refines."""
    facts: dict[str, Any] = material["pbrMetallicRoughness"]["baseColorTexture"]["extensions"][EXTENSION]
    return facts


def to_gltf(vectors: Floats) -> Floats:
    """Vectors (..., 3) from Blender's axes to glTF's: (x, z, -y)."""
    turned: Floats = np.stack([vectors[..., 0], vectors[..., 2], -vectors[..., 1]], axis=-1)
    return turned


class _Slot(NamedTuple):
    """What the faces of a temporary material are of: a joined object and a material, by their numbers."""

    object: int
    material: int


def _split(copy: bpy.types.Object, *, by_material: bool, by_object: bool) -> list[_Slot]:
    """Give the copy's mesh a slot for each object and each material that are to be told apart."""
    mesh: Any = copy.data
    none = np.zeros(len(mesh.polygons), dtype=np.int32)
    owners = face_numbers(mesh, OBJECT) if by_object else none
    numbers = material_numbers(mesh) if by_material else none
    found, place = np.unique(np.stack([owners, numbers]), axis=1, return_inverse=True)
    slots = [_Slot(int(owner), int(number)) for owner, number in found.T]
    mesh.materials.clear()
    if len(slots) > 1:
        for index in range(len(slots)):
            mesh.materials.append(bpy.data.materials.new(f"{_PLACE}{index}"))
        mesh.polygons.foreach_set("material_index", place.ravel().astype(np.int32))
    return slots


def _place_of(document: dict[str, Any], primitive: dict[str, Any]) -> int:
    """The place of the slot, of those of `_split`, that a primitive is of."""
    name: str = document["materials"][primitive["material"]]["name"]
    return int(name.removeprefix(_PLACE).partition(".")[0])


def _strip(copy: bpy.types.Object, layers: Sequence[str], several: bool) -> None:
    """Keep only the copy's triangles, these UV layers, and frame, under names that the exporter keeps.

    If it has `several` materials, these stay.
    """
    mesh: Any = copy.data
    mesh.animation_data_clear()
    copy.vertex_groups.clear()
    if not several:
        mesh.materials.clear()
    for name in [layer.name for layer in mesh.uv_layers if layer.name not in layers]:
        mesh.uv_layers.remove(mesh.uv_layers[name])
    for name in [layer.name for layer in mesh.color_attributes]:
        mesh.color_attributes.remove(mesh.color_attributes[name])
    foreign = [each.name for each in mesh.attributes if each.name.startswith(("_", "KHR_"))]
    for name in foreign if several else [*foreign, "material_index"]:
        if name in mesh.attributes:
            mesh.attributes.remove(mesh.attributes[name])
    for ours, carried in _CARRIED.items():
        mesh.attributes[ours].name = carried


def _export(scene: bpy.types.Scene, path: Path, several: bool) -> None:
    wanted = {
        "export_format": "GLB",
        "use_active_scene": True,
        "export_attributes": True,
        "export_normals": False,
        "export_tangents": False,
        "export_texcoords": True,
        "export_materials": "EXPORT" if several else "NONE",
        "export_animations": False,
        "export_current_frame": True,
        "export_morph": False,
        "export_skins": False,
        "export_cameras": False,
        "export_lights": False,
        "export_extras": False,
        "export_yup": True,
    }
    with _exporter_enabled(), _shown(scene):
        try:
            cast(Any, bpy.ops).export_scene.gltf(filepath=str(path), check_existing=False, **wanted)
        except RuntimeError as error:
            reason = " ".join(str(error).split())
            raise BakeError(f"Blender's glTF exporter failed: {reason}; export by another Blender") from error
    if not path.is_file():
        raise BakeError("Blender's glTF exporter wrote nothing; export by another Blender")


def check_exporter() -> None:
    """Raise InputError if this Blender has no glTF exporter."""
    if find_spec(_EXPORTER) is None:
        raise InputError(f"this Blender has no glTF exporter (the add-on {_EXPORTER}): install it again")


@contextmanager
def _exporter_enabled() -> Iterator[None]:
    """Within the context, enable Blender's exporter, an add-on that users may have disabled."""
    _, enabled = addon_utils.check(_EXPORTER)
    if enabled:
        yield
        return
    if cast(Any, addon_utils).enable(_EXPORTER, default_set=False, persistent=False) is None:
        raise BakeError("this Blender has no glTF exporter (the add-on io_scene_gltf2): install it again")
    try:
        yield
    finally:
        addon_utils.disable(_EXPORTER, default_set=False)


@contextmanager
def _shown(scene: bpy.types.Scene) -> Iterator[None]:
    """Within the context, make `scene` the window's scene, which is the one that the exporter writes."""
    manager = bpy.context.window_manager
    window = cast(Any, manager).windows[0]
    before, layer = window.scene, window.view_layer
    window.scene = scene
    try:
        with cast(Any, bpy.context).temp_override(
            window=window, scene=scene, view_layer=scene.view_layers[0]
        ):
            yield
    finally:
        window.scene, window.view_layer = before, layer


def _set_frame(glb: Glb, attributes: dict[str, int]) -> None:
    """Turn the _CARRIED attributes into NORMAL and TANGENT; only normalising changes their values."""
    normal, tangent, sign = (glb.accessor(attributes.pop(name)) for name in _CARRIED.values())
    attributes["NORMAL"] = glb.add_vertices(_unit(to_gltf(normal), (0.0, 1.0, 0.0)))
    frame = np.column_stack([_unit(to_gltf(tangent), (1.0, 0.0, 0.0)), np.where(sign < 0, -1.0, 1.0)])
    attributes["TANGENT"] = glb.add_vertices(frame)


def _unit(vectors: Floats, otherwise: tuple[float, float, float]) -> Floats:
    """Normalise vectors; zero vectors, which triangles without area have, become `otherwise`."""
    unit = normalised(vectors.astype(np.float64))
    lost = np.sum(unit * unit, axis=1) < 0.5
    unit[lost] = otherwise
    return unit


def add_flat(images: GltfImages, flat: bytes, name: str) -> int:
    """Add the PNG of a flat lightmap; returns the index of its texture."""
    return images.texture(Picture(flat, "image/png", name, "EXTEND"))


def add_materials(
    images: GltfImages,
    texture: int | None,
    manifest: Manifest,
    numbers: Sequence[int],
    name: str,
    clear: bool,
    pictures: Pictures = NO_PICTURES,
) -> None:
    """Add a material for each of these `numbers`, as `BakedMesh` has them. `name` begins their names.

    `texture` is the flat lightmap's, for those without `pictures`; if `clear`, its alpha is blended.
    Where the bake has an alpha, materials of pictures that hide what lies behind them are marked OPAQUE.
    """
    document = images.document
    layered = manifest.shader is not None
    culled = manifest.culled or Kind(manifest.bake["kind"]).traits.content
    for place, number in enumerate(numbers):
        facts = {EXTENSION: extension_facts(manifest, number if layered else None)}
        own = pictures.get(number)
        shown = _flat_material(texture, facts, clear) if own is None else images.material(own, facts)
        extras: dict[str, Any] = {MATERIAL: number} if number or len(numbers) > 1 else {}
        if "alpha" in manifest.textures and own is not None and not own.facts.clear:
            extras[OPAQUE] = True
        document["materials"].append(
            {
                "name": f"{name} radiance" + (f" {place}" if place else ""),
                "doubleSided": not culled,
                **shown,
                **({"extras": extras} if extras else {}),
            }
        )
    unlit = any(number not in pictures for number in numbers)
    used = {*document.get("extensionsUsed", []), EXTENSION, *([UNLIT] if unlit else [])}
    document["extensionsUsed"] = sorted(used)


def _flat_material(texture: int | None, extensions: dict[str, Any], clear: bool) -> dict[str, Any]:
    """The keys of a material that shows the flat lightmap, where no shader shows the bake."""
    return {
        **({"alphaMode": "BLEND"} if clear else {}),
        "pbrMetallicRoughness": {
            "baseColorTexture": {"index": texture, "texCoord": 0, "extensions": extensions},
            "metallicFactor": 0.0,
            "roughnessFactor": 1.0,
        },
        "extensions": {UNLIT: {}},
    }
