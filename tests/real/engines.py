# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders and scripts for game engines, held to compilers and to what importers make of a mesh.

Microsoft's HLSL compiler and a C# compiler run in a root of their own, `COMPILERS`. Shaders are handed over
with what they include written into them.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.export.unity_unreal import apply_turn_and_scale, baked_matrix, carry_frame
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.formats.containers.texture import PixelFormat
from radtex_addon.textures.entry import Arranged, Container, TextureEntry
from radtex_addon.textures.export_spec import Target
from tests.real.hlsl import KINDS, bindings_of, compiled
from tests.real.root import DXC, Root
from tests.real.webgpu import Resource, drawn
from tests.reference.importers import attributes_of

REPOSITORY = Path(__file__).parents[2]
HEADERS = Path(__file__).parent / "unity"  # stand for Unity's
SHADERS = REPOSITORY / "shaders"
DXC_RUNNER = "/repository/tests/real/inside/dxc.py"
PROFILES = {"pixel": "ps_6_0", "vertex": "vs_6_0"}
TO_SPIRV = ("-spirv", "-fvk-t-shift", "0", "0", "-fvk-s-shift", "32", "0", "-fvk-b-shift", "64", "0")
_INCLUDE = re.compile(r'^[ \t]*#include "([^"]+)"[^\n]*$', re.MULTILINE)
_TURN = (0.18257, 0.36515, 0.54772, 0.73030)  # a node's rotation, a unit quaternion


@dataclass(frozen=True)
class Compilers:
    """The `tools` that engines use: Microsoft's compiler and Mono's; `programs` has all others."""

    tools: Root
    programs: Root


def inlined(source: str, folders: Sequence[Path], seen: tuple[str, ...] = ()) -> str:
    """A shader with the files that it includes in it, each from the first folder that has it."""

    def text_of(found: re.Match[str]) -> str:
        path = next(folder / found[1] for folder in folders if (folder / found[1]).is_file())
        assert str(path) not in seen, path
        text = path.read_text(encoding="utf-8")
        return inlined(text, [path.parent, *folders], (*seen, str(path)))

    return _INCLUDE.sub(text_of, source)


@cache
def by_dxc(
    compilers: Compilers, source: str, stage: str = "pixel", entry: str = "main", spirv: bool = False
) -> bytes:
    """A shader's binary, DXIL or SPIR-V. Raises ValueError with what Microsoft's compiler says."""
    host, inside = compilers.tools.shared("dxc")
    (host / "shader.hlsl").write_text(source, encoding="utf-8")
    arguments = ["-T", PROFILES[stage], "-E", entry, *(TO_SPIRV if spirv else ())]
    asked = json.dumps([f"{inside}/shader.hlsl", f"{inside}/shader.bin", *arguments])
    said = compilers.tools.ask(["python3", DXC_RUNNER, DXC], asked)
    if not (host / "shader.bin").exists():
        raise ValueError(f"dxc: {said}")
    return (host / "shader.bin").read_bytes()


def compiled_by(compilers: Compilers, compiler: str, source: str, stage: str, entry: str) -> None:
    """Compile a shader by "dxc", or by one of `tests.real.hlsl`. Raises ValueError with what it says."""
    if compiler == "dxc":
        by_dxc(compilers, source, stage, entry)
    else:
        compiled(compilers.programs, compiler, source, stage, entry)


def shown(
    compilers: Compilers, compiler: str, source: str, resources: dict[str, Resource], side: int
) -> Floats:
    """What the pixel shader `main` returns for each pixel, (side², 4) float32; `resources` by register."""
    programs = compilers.programs
    if compiler != "dxc":
        code, registers = compiled(programs, compiler, source)
        return drawn(programs, code, {number: resources[name] for name, number in registers.items()}, side)
    code = by_dxc(compilers, source, spirv=True)
    bound = (number for _, number in bindings_of(code))
    return drawn(programs, code, {n: resources[f"{KINDS[n // 32]}{n % 32}"] for n in bound}, side)


@dataclass(frozen=True, eq=False)
class Mesh:
    """A mesh in glTF, one vertex for each lookup, as RadTex exports it for an engine.

    `baked` (3, 4) transforms its places to the world of the bake; `attributes` are those of its file.
    """

    baked: Floats
    attributes: dict[str, Floats]


def mesh_of(
    uv: Floats,
    position: Floats,
    normal: Floats,
    tangent: Floats,
    side: Floats,
    target: Target,
    scale: tuple[float, float, float] = (1.2, 0.8, 1.5),
    image_uv: Floats | None = None,
) -> Mesh:
    """A mesh whose vertices have these values in the world of the bake, and v growing upwards.

    With `image_uv`, materials are shown by their own images, at these coordinates.
    Its node is turned, moved and scaled, so that none of these is in the space of the file.
    """
    node = {"mesh": 0, "rotation": list(_TURN), "scale": list(scale), "translation": [0.3, -0.7, 1.1]}
    document: dict[str, Any] = {"nodes": [node], "meshes": [{"primitives": [{"attributes": {}}]}]}
    glb = Glb(document, bytearray())
    baked = baked_matrix(glb)
    turned, mirrored = np.linalg.inv(baked[:, :3]), np.sign(np.linalg.det(baked[:, :3]))
    values = {
        "POSITION": (position - baked[:, 3]) @ turned.T,
        "NORMAL": normal @ baked[:, :3],  # the inverse's inverse, transposed
        "TANGENT": np.column_stack([tangent @ turned.T, side * mirrored]),
    }
    sets = [uv] if image_uv is None else [image_uv, uv]
    for number, each in enumerate(sets):
        values[f"TEXCOORD_{number}"] = np.column_stack([each[:, 0], 1 - each[:, 1]])
    (primitive,) = document["meshes"][0]["primitives"]
    primitive["attributes"] = {name: glb.add_vertices(array) for name, array in values.items()}
    triangles = np.arange(len(uv) // 3 * 3, dtype="<u4")
    view = glb.add_view(triangles.tobytes())
    facts = {"bufferView": view, "componentType": 5125, "count": len(triangles), "type": "SCALAR"}
    document["accessors"].append(facts)
    primitive["indices"] = len(document["accessors"]) - 1
    carry_frame(glb)
    if target is Target.UNREAL:
        apply_turn_and_scale(glb)
    return Mesh(baked_matrix(glb), attributes_of(glb))


def entry(
    size: tuple[int, int], levels: int = 1, layers: int = 1, arranged: Arranged = Arranged.IMAGE, **facts: Any
) -> TextureEntry:
    """A DDS of half floats."""
    known: dict[str, Any] = {"texels": size, "stored": size, "pages": (1, 1), "page_texels": size}
    return TextureEntry(
        file="Made.up.dds",
        container=Container.DDS,
        format=PixelFormat.RGBA16F,
        zstd=False,
        arrangement=arranged,
        size=size,
        layers=layers,
        levels=levels,
        **(known | facts),
    )
