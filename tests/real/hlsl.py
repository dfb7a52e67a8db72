# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""HLSL by two compilers, to SPIR-V, which wgpu executes: many lookups at once, one a pixel.

glslang translates the text itself; vkd3d compiles it for shader model 5, to Direct3D's byte code, and
translates that.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from functools import cache

import numpy as np

from radtex_addon.core.arrays import Floats
from tests.real.root import Root
from tests.real.webgpu import Resource, drawn

SHADERS = "/repository/shaders"  # where programs in the root run, so that they find what is included
KINDS = "tsb"  # registers of textures, samplers and constants
COMPILERS = {
    "glslang": ["glslangValidator", "-D", "-V", "-I.", "--stb", "0", "--ssb", "32", "--scb", "64"],
    "vkd3d": ["vkd3d-compiler", "-x", "hlsl", "-b", "spirv-binary"],
}
STAGES = {
    "glslang": {"pixel": ["-S", "frag"], "vertex": ["-S", "vert"]},
    "vkd3d": {"pixel": ["-p", "ps_5_0"], "vertex": ["-p", "vs_5_0"]},
}
_OP_NAME, _OP_DECORATE, _DECORATED_BINDING = 5, 71, 33  # of SPIR-V


@cache
def compiled(
    root: Root, compiler: str, source: str, stage: str = "pixel", entry: str = "main"
) -> tuple[bytes, dict[str, int]]:
    """Valid SPIR-V of a shader, and the binding of each register that it uses ("t0", "s0", "b0").

    `source` may include what lies in shaders/. Raises ValueError with what the compiler or spirv-val says.
    """
    host, inside = root.shared("hlsl")
    (host / "shader.hlsl").write_text(source, encoding="utf-8")
    binary = f"{inside}/shader.spv"
    options = [*STAGES[compiler][stage], "-e", entry]
    compiling = shlex.join([*COMPILERS[compiler], *options, "-o", binary, f"{inside}/shader.hlsl"])
    run = root.run(["sh", "-c", f"{compiling} && spirv-val --target-env vulkan1.0 {binary}"], cwd=SHADERS)
    if run.returncode:
        raise ValueError(f"{compiler}: {run.stdout}{run.stderr}")
    code = (host / "shader.spv").read_bytes()
    if compiler == "vkd3d":  # calls them t0, s0, cb0_0
        registers = {name.removeprefix("c").split("_")[0]: k for name, k in bindings_of(code)}
    else:  # calls them as we do, but numbers them by their kind
        registers = {f"{KINDS[k // 32]}{k % 32}": k for _, k in bindings_of(code)}
    return code, registers


def bindings_of(code: bytes) -> list[tuple[str, int]]:
    """The names and bindings of a module's variables."""
    words = np.frombuffer(code, "<u4")
    names: dict[int, str] = {}
    found, at = [], 5  # after the header
    while at < len(words):
        length, operation = int(words[at] >> 16), int(words[at] & 0xFFFF)
        operands = words[at + 1 : at + length]
        if operation == _OP_NAME:
            names[int(operands[0])] = operands[1:].tobytes().partition(b"\0")[0].decode()
        if operation == _OP_DECORATE and operands[1] == _DECORATED_BINDING:
            found.append((int(operands[0]), int(operands[2])))
        at += length
    return [(names.get(variable, ""), binding) for variable, binding in found]


def looked_up(root: Root, compiler: str, source: str, resources: Mapping[str, Resource], side: int) -> Floats:
    """What the pixel shader `main` returns for each pixel, (side², 4) float32; `resources` by register."""
    code, registers = compiled(root, compiler, source)
    return drawn(root, code, {number: resources[name] for name, number in registers.items()}, side)
