# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders on a real WebGPU, in WGSL or SPIR-V: many lookups at once, one a pixel.

inside/webgpu.py runs them, in the root of real programs.
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from radtex_addon.core.arrays import Floats
from tests.real.root import Root, ServerEndedError

RUNNER = "/repository/tests/real/inside/webgpu.py"
Values = npt.NDArray[Any]
_FORMATS = {"f2": "16float", "f4": "32float", "u1": "8unorm", "u4": "32uint"}
_BINDING = re.compile(r"@group\(0\)\s*@binding\((\d+)\)\s*var(?:<\w+>)?\s+(\w+)")


@dataclass(frozen=True)
class Texture:
    """A texture as WebGPU takes it; each of `levels` is (layers, rows, bytes of a row) uint8."""

    format: str
    size: tuple[int, int]  # width and height of level 0, in pixels
    levels: tuple[npt.NDArray[np.uint8], ...]
    array: bool = False


@dataclass(frozen=True)
class Sampler:
    """How a texture is filtered: "nearest" or "linear", clamped to its edge."""

    kind: str = "linear"
    anisotropy: int = 1


Resource = Texture | Sampler | Values


def image(*levels: Values) -> Texture:
    """A texture of its mip levels: (H, W, C), or (layers, H, W, C) for an array texture.

    float16, float32, uint8 (0 to 1) or whole numbers, uint32; of three channels, the fourth is filled with
    ones.
    """
    filled = [np.ascontiguousarray(_four(level)) for level in levels]
    *_, height, width, channels = filled[0].shape
    kind = "r" if channels == 1 else "rg" if channels == 2 else "rgba"
    rows = [level.view(np.uint8) for level in filled]
    return Texture(
        kind + _FORMATS[filled[0].dtype.str[1:]],
        (width, height),
        tuple(level.reshape(-1, *(level.shape[-3], level.shape[-2] * level.shape[-1])) for level in rows),
        levels[0].ndim == 4,
    )


def blocks(kind: str, size: tuple[int, int], data: bytes) -> Texture:
    """A texture of blocks of 4 x 4 pixels, 16 bytes each; `kind` is "bc5-rg-unorm" or another of WebGPU's."""
    rows = np.frombuffer(data, np.uint8).reshape(1, -(-size[1] // 4), -(-size[0] // 4) * 16)
    return Texture(kind, size, (rows,))


def fields(side: int, *values: Floats) -> Texture:
    """Values for each pixel of a picture, (side², C) with C up to 4, as layers of one array texture."""
    rows = [np.pad(some, ((0, 0), (0, 4 - some.shape[1]))) for some in values]
    return image(np.stack(rows).astype(np.float32).reshape(-1, side, side, 4))


def _four(values: Values) -> Values:
    if values.shape[-1] != 3:
        return values
    one = np.array(255 if values.dtype.kind == "u" else 1, values.dtype)
    return np.concatenate([values, np.broadcast_to(one, (*values.shape[:-1], 1))], axis=-1)


def drawn(
    root: Root,
    shader: str | bytes,
    resources: Mapping[int | str, Resource],
    side: int,
    entry: str = "main",
    constants: Mapping[str, float] | None = None,
    vertices: Sequence[Floats] = (),
) -> Floats:
    """What the fragment shader `entry` returns for each pixel of a picture, (side², 4) float32.

    `shader` is WGSL or SPIR-V. `resources` stand at the bindings of group 0, by number, or in WGSL by name:
    textures, samplers, and arrays that are the bytes of uniform buffers. All must be in use. `constants` are
    the overrides' values. Triangles of `vertices`, attributes (K, 2 to 4) in the order of their locations,
    are drawn by the shader's own `vertex`; without them one triangle covers the picture. Row 0 is where the
    fragment's y is 0, the top. Raises ValueError with what wgpu says of a bad shader.
    """
    numbers = {} if isinstance(shader, bytes) else {name: int(k) for k, name in _BINDING.findall(shader)}
    facts: dict[str, Any] = {
        "size": [side, side],
        "entry": entry,
        "constants": dict(constants or {}),
        "attributes": [attribute.shape[1] for attribute in vertices],
        "bindings": {},
    }
    code = shader if isinstance(shader, bytes) else shader.encode()
    corners = np.concatenate(vertices, axis=1) if vertices else np.empty((0, 0))
    job: dict[str, Values] = {
        "shader": np.frombuffer(code, np.uint8),
        "vertices": corners.astype(np.float32),
    }
    for name, resource in resources.items():
        binding = str(name if isinstance(name, int) else numbers[name])
        facts["bindings"][binding] = _described(resource)
        job |= _fields(binding, resource)
    host, inside = root.shared("webgpu")
    job["facts"] = np.array(json.dumps(facts))
    np.savez(host / "job.npz", allow_pickle=False, **job)
    try:
        said = root.ask(["python3", RUNNER], f"{inside}/job.npz {inside}/answers.npy")
    except ServerEndedError as error:  # of what is very wrong
        said = str(error)
    if not (host / "answers.npy").exists():
        raise ValueError(f"wgpu refused the shader:\n{said}")
    answers: Floats = np.load(host / "answers.npy").reshape(-1, 4)
    shutil.rmtree(host)
    return answers


def _described(resource: Resource) -> dict[str, Any]:
    if isinstance(resource, Texture):
        about = {"format": resource.format, "size": resource.size, "levels": len(resource.levels)}
        return {"kind": "texture", "dimension": "2d-array" if resource.array else "2d", **about}
    if isinstance(resource, Sampler):
        filters = dict.fromkeys(("mag_filter", "min_filter", "mipmap_filter"), resource.kind)
        return {"kind": "sampler", "settings": {**filters, "max_anisotropy": resource.anisotropy}}
    return {"kind": "uniform"}


def _fields(binding: str, resource: Resource) -> dict[str, Values]:
    if isinstance(resource, Texture):
        return {f"{binding}.{level}": data for level, data in enumerate(resource.levels)}
    return {} if isinstance(resource, Sampler) else {binding: np.ascontiguousarray(resource)}
