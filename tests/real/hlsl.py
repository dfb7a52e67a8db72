# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""HLSL by two compilers, to SPIR-V, which wgpu executes: many lookups at once, one a pixel.

glslang translates the text itself; vkd3d compiles it for shader model 5, to Direct3D's byte code, and
translates that.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cache

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
_NAME, _BINDING = re.compile(r'OpName (%\w+) "(\w+)"'), re.compile(r"OpDecorate (%\w+) Binding (\d+)")


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
    _said(root, [*COMPILERS[compiler], *options, "-o", binary, f"{inside}/shader.hlsl"])
    _said(root, ["spirv-val", "--target-env", "vulkan1.0", binary])
    listing = _said(root, ["spirv-dis", binary])
    names, bindings = dict(_NAME.findall(listing)), _BINDING.findall(listing)
    if compiler == "vkd3d":  # calls them t0, s0, cb0_0
        registers = {names[variable].removeprefix("c").split("_")[0]: int(k) for variable, k in bindings}
    else:  # calls them as we do, but numbers them by their kind
        registers = {f"{KINDS[int(k) // 32]}{int(k) % 32}": int(k) for _, k in bindings}
    return (host / "shader.spv").read_bytes(), registers


def looked_up(root: Root, compiler: str, source: str, resources: Mapping[str, Resource], side: int) -> Floats:
    """What the pixel shader `main` returns for each pixel, (side², 4) float32; `resources` by register."""
    code, registers = compiled(root, compiler, source)
    return drawn(root, code, {number: resources[name] for name, number in registers.items()}, side)


def _said(root: Root, argv: Sequence[str]) -> str:
    run = root.run(argv, cwd=SHADERS)
    if run.returncode:
        raise ValueError(f"{argv[0]}: {run.stdout}{run.stderr}")
    return run.stdout
