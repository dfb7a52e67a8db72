# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A folder for Unreal: the code of a Custom node with the bake's numbers in it, and a script for its editor.

A Custom node's code is the body of a function, and includes need a C++ module that maps their folder. So the
includes are written into the body, as the methods of a struct; what they have outside functions becomes
members of it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ...core.arrays import Floats
from ...core.quoting import in_comment, python_string
from ...formats.containers.glb import Glb
from ...forms.hlsl_lookup import (
    ARGUMENTS,
    IMAGE_TEXTURES,
    SAMPLER,
    HlslLookup,
    Number,
    keeps_levels,
    numbers,
)
from ...settings.kinds import Kind
from ...settings.targets import Target
from ..engines import file_lines
from ..image_files import EXTEND, MIRROR, NO_IMAGES, REPEAT, ImageFiles, every, lines_of, move_images
from ..pack import SHADERS, Pack, filled, write_text_file
from ..unity_unreal import (
    apply_turn_and_scale,
    attributes_line,
    baked_matrix,
    carry_frame,
    define_lines,
    identifier,
    indented,
    is_clear,
    material_numbers,
    texture_type,
)
from . import Writer

TEMPLATES = SHADERS / "unreal"
SCRIPT = "import_radtex.py.template"
_OF_IMAGES = {"RADTEX_IMAGES": "1", "RADTEX_IMAGE_SAMPLER(name)": "name##_sampler"}
_WRAPS = {REPEAT: "WRAP", EXTEND: "CLAMP", MIRROR: "MIRROR"}
_CENTIMETRES = 0.01
# To glTF's axes, places (4, 4): Unreal's importer swaps y and z, and multiplies by a hundred.
_FROM_UNREAL = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]) * [
    *(_CENTIMETRES,) * 3,
    1,
]
_FRAME = "float3(UV{2}.xy, UV{3}.x), float3(UV{0}.xy, UV{1}.x), UV{1}.y"
_COMMENT = re.compile(r"\s*//.*$", re.MULTILINE)
_GUARD = re.compile(r"#ifndef (\w+_HLSL)\n#define \1\n(.*)#endif\s*\Z", re.DOTALL)
_INCLUDE = re.compile(r"^#include .*\n", re.MULTILINE)
_STRUCT = re.compile(r"^struct \w+ \{.*?^\};\n", re.MULTILINE | re.DOTALL)
_CONSTANT = re.compile(r"^static const int (\w+) = (\d+);", re.MULTILINE)
_DEFINED = re.compile(r"^\s*#define (\w+)", re.MULTILINE)
_EMPTY = re.compile(r"\n{2,}")


def write_unreal(pack: Pack, folder: Path) -> None:
    """Make a pack's folder one for Unreal: a Custom node's code for each material, a script, a README.txt."""
    manifest, name = pack.manifest, pack.name
    glb = Glb.read(folder / manifest.mesh)
    lookup = manifest.form.hlsl(manifest.bake, manifest.textures, Target.UNREAL, manifest.images)
    numbered = material_numbers(glb)
    images = move_images(glb, numbered, lookup.of_images, folder / name)
    carry_frame(glb)
    apply_turn_and_scale(glb)
    baked = baked_matrix(glb)
    glb.write(folder / manifest.mesh)
    kind = manifest.bake["kind"]
    script = f"import_{identifier(name, kind)}.py"
    codes = {}
    for place, (material, number) in enumerate(numbered.items()):
        codes[material] = f"{name}.custom{f'-{place}' if place else ''}.hlsl"
        write_text_file(folder / codes[material], custom_text(name, script, lookup, baked, number))
    culled = manifest.culled or Kind(kind).traits.content
    words = script_words(name, kind, manifest.mesh, lookup, codes)
    words |= image_words(images, numbered)
    words |= {"CLEAR": str(is_clear(glb, lookup)), "TWO_SIDED": str(not culled)}
    write_text_file(folder / script, filled(TEMPLATES / SCRIPT, words))
    lines = file_lines(manifest, attributes_line(bool(images)))
    files = "\n".join([*lines, *lines_of(images)])
    readme = {
        "NAME": in_comment(name),
        "SCRIPT": script,
        "IDENTIFIER": identifier(name, kind),
        "FILES": files,
    }
    write_text_file(folder / "README.txt", filled(TEMPLATES / "README.txt", readme))
    write_text_file(folder / "LICENSE.txt", (SHADERS / "LICENSE").read_text(encoding="utf-8"))


def custom_text(name: str, script: str, lookup: HlslLookup, baked: Floats, material: int = 0) -> str:
    """The code of the Custom node for one of the bake's materials.

    `baked` (3, 4) transforms places of the mesh, in glTF's axes, to Blender's world.
    """
    constants = (*lookup.constants, *lookup.materials[material])
    structs, functions = _inlined(lookup.includes)
    textures = lookup.textures_of(material)
    shown = IMAGE_TEXTURES if material in lookup.of_images else ()
    defines = define_lines({**lookup.defines, **(_OF_IMAGES if shown else {})})
    template = (TEMPLATES / "custom.hlsl").read_text(encoding="utf-8")
    known = dict.fromkeys(_DEFINED.findall(f"{template}\n{defines}\n{functions}"))
    members = [f"{texture_type(entry)} {texture};" for texture, entry in textures.items()]
    members += [f"Texture2D {each}; SamplerState {each}_sampler;" for each in shown]
    members += [f"SamplerState {SAMPLER};", *(_member(each) for each in constants)]
    values = [f"radtex.{texture} = {texture_input(texture)};" for texture in (*textures, *shown)]
    values += [f"radtex.{each}_sampler = {texture_input(each)}Sampler;" for each in shown]
    values.append(f"radtex.{SAMPLER} = {texture_input(next(iter(textures)))}Sampler;")
    sets = uv_sets(lookup)
    words = {
        "NAME": in_comment(name),
        "SCRIPT": in_comment(script),
        "SETS": f"UV0 to UV{sets - 1}",
        "MORE": _more_inputs(lookup, material),
        "LIGHT_UV": f"UV{sets - 5}",
        "FRAME": _FRAME.format(*range(sets - 4, sets)),
        "DEFINES": defines,
        "STRUCTS": structs,
        "MEMBERS": indented("\n".join(members)),
        "FUNCTIONS": functions,
        "ARGUMENTS": ARGUMENTS,
        "LOOKUP": indented(lookup.body),
        "VALUES": "\n".join([*values, *(_assigned(each) for each in constants)]),
        "BAKED": numbers(baked @ _FROM_UNREAL),
        "PLACE": "Place" if reads_places(lookup) else "0.0, 0.0, 0.0",
        "SUN": "mul((float3x3)radtex_baked, Sun), Irradiance"
        if lookup.relit
        else "float3(0.0, 0.0, 1.0), float3(0.0, 0.0, 0.0)",
        "UNDEFINES": "\n".join(f"#undef {each}" for each in known),
    }
    return _EMPTY.sub("\n", filled(TEMPLATES / "custom.hlsl", words))


def uv_sets(lookup: HlslLookup) -> int:
    """How many uv sets the mesh has: the frame's four, the bake's, and that of materials' own images."""
    return 6 if lookup.of_images else 5


def reads_places(lookup: HlslLookup) -> bool:
    """Whether the light depends on the place on the surface beside uv."""
    return "radtex_layered" in lookup.includes


def texture_input(texture: str) -> str:
    """The input of the Custom node for a texture: Atlas, or Colour, ThroughRest and the like."""
    words = texture.removeprefix("radtex_").removesuffix("_map").split("_")
    return "".join(word.capitalize() for word in words)


def script_words(
    name: str, kind: str, mesh: str, lookup: HlslLookup, codes: Mapping[str, str]
) -> dict[str, str]:
    """The words of the script, but CLEAR and TWO_SIDED; `codes` are files by the mesh's materials."""
    textures = [
        (texture_input(each), entry.file, keeps_levels(entry, Target.UNREAL))
        for each, entry in lookup.textures.items()
    ]
    return {
        "NAME": in_comment(name).replace('"', "'").replace("\\", "/"),  # in a docstring
        "IDENTIFIER": identifier(name, kind),
        "MESH": python_string(mesh),
        "TEXTURES": repr(textures),
        "MATERIALS": repr(list(codes.items())),
        "PLACES": str(reads_places(lookup)),
        "RELIT": str(lookup.relit),
        "UV_SETS": str(uv_sets(lookup)),
        "REPLACED": repr([texture_input(each) for each in lookup.replaced]),
        **image_words(NO_IMAGES, {}),
    }


def image_words(images: ImageFiles, numbers: Mapping[str, int]) -> dict[str, str]:
    """The words of the script on images that materials are shown by; `numbers` are the materials' by name."""
    own = {
        material: {texture_input(each.texture): each.name for each in images[number]}
        for material, number in numbers.items()
        if number in images
    }
    rows = [(each.name, each.file, texture_input(each.texture), _WRAPS[each.wrap]) for each in every(images)]
    return {"IMAGES": repr(rows), "OWN_IMAGES": repr(own)}


def _inlined(stems: tuple[str, ...]) -> tuple[str, str]:
    """The structs and the functions of includes, without comments and what guards them."""
    structs, functions = "", ""
    for stem in stems:
        text = _COMMENT.sub("", (SHADERS / f"{stem}.hlsl").read_text(encoding="utf-8"))
        inside = _GUARD.search(text)
        text = _INCLUDE.sub("", inside[2] if inside else text)
        text = _CONSTANT.sub(r"#define \1 \2", text)
        structs += "".join(_STRUCT.findall(text))
        functions += _STRUCT.sub("", text)
    return structs, functions


def _member(constant: Number) -> str:
    return f"{constant.kind} {constant.name}" + (f"[{constant.count}];" if constant.count else ";")


def _assigned(constant: Number) -> str:
    """Statements that set a member; a struct's arrays are set one by one."""
    if not constant.count:
        return f"radtex.{constant.name} = {constant.rows[0]};"
    rows = enumerate(constant.rows)
    return "\n".join(f"radtex.{constant.name}[{k}] = {row};" for k, row in rows)


def _more_inputs(lookup: HlslLookup, material: int) -> str:
    shown = IMAGE_TEXTURES if material in lookup.of_images else ()
    textures = ", ".join(texture_input(name) for name in (*lookup.textures_of(material), *shown))
    place = ", Place (Absolute World\n// Position, transformed likewise)" if reads_places(lookup) else ""
    sun = ", Sun (towards it, transformed likewise), Irradiance" if lookup.relit else ""
    return f"{place}{sun}, and Texture Objects:\n// {textures}"


WRITER = Writer(write_unreal)
