# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""glTF materials that are shown by their own images, on TEXCOORD_0; the bake is on TEXCOORD_1."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..core.arrays import Floats
from ..formats.containers.glb import Glb
from ..scene.mesh.backs import fronts, twin_numbers
from ..scene.mesh.copy import NORMAL, SIGN, TANGENT, calc_tangents, material_numbers
from ..scene.mesh.joined import values_in
from .material_images import MaterialPictures, Picture

_WRAPS = {"REPEAT": 10497, "EXTEND": 33071, "MIRROR": 33648}
_LINEAR, _LINEAR_MIPMAPPED = 9729, 9987
_FIRST = "RadTex images"  # the name of the layer that becomes TEXCOORD_0


class GltfImages:
    """The images, samplers and textures of a glTF, each once."""

    def __init__(self, glb: Glb) -> None:
        self._glb = glb
        self._known: dict[Any, int] = {}

    @property
    def document(self) -> dict[str, Any]:
        """The glTF's JSON."""
        return self._glb.document

    def material(self, pictures: MaterialPictures, base_facts: Mapping[str, Any]) -> dict[str, Any]:
        """A material's keys, but for its name; `base_facts` are the base colour texture's extensions."""
        own = pictures.facts
        base = {"index": self.texture(pictures.base), "texCoord": 0, "extensions": dict(base_facts)}
        shading: dict[str, Any] = {
            "baseColorFactor": [*own.base, 1.0],
            "baseColorTexture": base,
            "metallicFactor": min(own.metallic, 1.0),
            "roughnessFactor": min(own.roughness, 1.0),
        }
        if pictures.metal is not None:
            shading["metallicRoughnessTexture"] = {"index": self.texture(pictures.metal), "texCoord": 0}
        facts: dict[str, Any] = {"pbrMetallicRoughness": shading}
        if pictures.normal is not None:
            index = self.texture(pictures.normal)
            facts["normalTexture"] = {"index": index, "texCoord": 0, "scale": own.strength}
        if own.clear and own.base_alpha:
            facts["alphaMode"] = "BLEND"
        return facts

    def texture(self, picture: Picture) -> int:
        """The index of an image's texture."""
        sampler = self._index("samplers", (picture.wrap,), _sampler(picture.wrap))
        image = self._known.get(("images", picture.data))
        if image is None:
            view = self._glb.add_view(picture.data)
            facts = {"bufferView": view, "mimeType": picture.mime, "name": picture.name}
            image = self._index("images", picture.data, facts)
        return self._index("textures", (image, sampler), {"source": image, "sampler": sampler})

    def _index(self, name: str, key: Any, facts: dict[str, Any]) -> int:
        """The index in a list of the document, to which the facts are added if the key is new."""
        if (name, key) not in self._known:
            found: list[Any] = self._glb.document.setdefault(name, [])
            found.append(facts)
            self._known[name, key] = len(found) - 1
        return self._known[name, key]


def set_coordinates(mesh: Any, uv_layer: str, layers: Mapping[int, str]) -> None:
    """Give a baked copy's mesh two UV layers: that of images, in `layers` by number, and the `uv_layer`.

    Materials that are not in `layers` have the `uv_layer` in both. Tangents of the others become those of the
    first. Of a face that others have for their back they are turned, since a normal map lies on it as seen
    through these.
    """
    number = material_numbers(mesh)
    light = _uv(mesh, uv_layer)
    first = light.copy()
    for each, layer in layers.items():
        some = number == each
        if some.any():  # a mesh that shares its atlas may lack the layers of others
            first[some] = _uv(mesh, layer)[some]
    shown = np.isin(number, list(layers))
    place = values_in(mesh.vertices, "co", 3)
    corner = values_in(mesh.loops, "vertex_index", 1, np.int32).reshape(-1, 3)
    normal = values_in(mesh.attributes[NORMAL].data, "vector", 3).reshape(-1, 3, 3)
    tangent = values_in(mesh.attributes[TANGENT].data, "vector", 3).reshape(-1, 3, 3)
    sign = values_in(mesh.attributes[SIGN].data, "value", 1).reshape(-1, 3)
    found, signs = calc_tangents(place, corner, normal, first)
    twin = twin_numbers(mesh)
    turned = np.ones(len(corner), np.float32) if twin is None else np.where(fronts(twin), 1, -1)
    tangent[shown] = (found * turned[:, None, None])[shown]
    sign[shown] = np.where(signs < 0, -1.0, 1.0)[shown]  # with the tangent, the bitangent turns, too
    mesh.attributes[TANGENT].data.foreach_set("vector", np.ascontiguousarray(tangent, np.float32).ravel())
    mesh.attributes[SIGN].data.foreach_set("value", np.ascontiguousarray(sign, np.float32).ravel())
    for name in [layer.name for layer in mesh.uv_layers]:
        mesh.uv_layers.remove(mesh.uv_layers[name])
    for name, values in ((_FIRST, first), (uv_layer, light)):
        made = mesh.attributes.new(name, "FLOAT2", "CORNER")
        made.data.foreach_set("vector", np.ascontiguousarray(values, np.float32).ravel())


def kept_layers(uv_layer: str) -> tuple[str, str]:
    """The names of the layers that `set_coordinates` makes."""
    return _FIRST, uv_layer


def _uv(mesh: Any, layer: str) -> Floats:
    found: Floats = values_in(mesh.attributes[layer].data, "vector", 2).reshape(-1, 3, 2)
    return found


def _sampler(wrap: str) -> dict[str, int]:
    mode = _WRAPS[wrap]
    return {"magFilter": _LINEAR, "minFilter": _LINEAR_MIPMAPPED, "wrapS": mode, "wrapT": mode}
