# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A folder for Unity: a shader with the bake's numbers, and a script for its editor that sets all up."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ...core.arrays import Floats
from ...core.quoting import csharp_string, in_comment, shaderlab_string
from ...formats.containers.glb import Glb
from ...forms.hlsl_lookup import ARGUMENTS, IMAGE_TEXTURES, HlslLookup, numbers
from ...settings.kinds import Kind
from ...settings.targets import Target
from ..engines import file_lines
from ..image_files import (
    BASE,
    BUMP,
    EXTEND,
    METAL,
    MIRROR,
    NO_IMAGES,
    REPEAT,
    ImageFiles,
    lines_of,
    move_images,
)
from ..pack import SHADERS, Pack, filled, write_text_file
from ..unity_unreal import (
    IMAGE_SETS,
    attributes_line,
    baked_matrix,
    carry_frame,
    constant_lines,
    define_lines,
    identifier,
    indented,
    is_clear,
    material_numbers,
    texture_type,
)
from . import Writer

TEMPLATES = SHADERS / "unity"
SHARED = "radtex_unity.hlsl"  # the one file of TEMPLATES that is copied as it is
_FROM_UNITY = np.diag([-1.0, 1.0, 1.0, 1.0])  # to glTF's axes, places (4, 4): importers of glTF negate x
_WRAPS = {REPEAT: "Repeat", EXTEND: "Clamp", MIRROR: "Mirror"}
_IMAGE_PROPERTIES = (
    f'[NoScaleOffset] {BASE} ("Base colour", 2D) = "white" {{}}',
    f'[NoScaleOffset] {METAL} ("Roughness (green), metal (blue)", 2D) = "white" {{}}',
    f'[NoScaleOffset] [Normal] {BUMP} ("Normal map", 2D) = "bump" {{}}',
)
_TEMPORAL = '[Toggle(RADTEX_TEMPORAL)] _RadtexTemporal ("Cheaper, for temporal antialiasing", Float) = 0'
_SUN = """_RadtexSunDirection ("Towards the sun", Vector) = (0.3, 0.8, 0.5, 0)
[HDR] _RadtexSunIrradiance ("The sun's irradiance", Color) = (1, 1, 1, 1)
"""


def write_unity(pack: Pack, folder: Path) -> None:
    """Make a pack's folder one for Unity's Assets: shader, includes, a script, and a README.txt."""
    manifest, name = pack.manifest, pack.name
    glb = Glb.read(folder / manifest.mesh)
    baked, numbered = baked_matrix(glb), material_numbers(glb)
    lookup = manifest.form.hlsl(manifest.bake, manifest.textures, Target.UNITY, manifest.images)
    images = move_images(glb, numbered, lookup.of_images, folder / name)
    carry_frame(glb)
    glb.write(folder / manifest.mesh)
    clear = is_clear(glb, lookup)
    write_text_file(folder / f"{name}.hlsl", object_text(name, lookup, baked, clear))
    title = title_of(name, manifest.bake["kind"])
    culled = manifest.culled or Kind(manifest.bake["kind"]).traits.content
    write_text_file(folder / f"{name}.shader", shader_text(name, title, lookup, clear, culled))
    (folder / "Editor").mkdir()
    script = script_text(name, manifest.bake["kind"], manifest.mesh, lookup, numbered, images)
    write_text_file(folder / "Editor" / f"_{identifier(name, manifest.bake['kind'])}.cs", script)
    lines = file_lines(manifest, attributes_line(bool(images)))
    files = "\n".join([*lines, *lines_of(images)])
    readme = {"NAME": in_comment(name), "TITLE": in_comment(title), "FILES": files}
    write_text_file(folder / "README.txt", filled(TEMPLATES / "README.txt", readme))
    (folder / "shaders").mkdir()
    for source in (*(f"{stem}.hlsl" for stem in lookup.includes), f"unity/{SHARED}", "LICENSE"):
        shutil.copyfile(SHADERS / source, folder / "shaders" / Path(source).name)


def object_text(name: str, lookup: HlslLookup, baked: Floats, clear: bool) -> str:
    """The text of NAME.hlsl: the bake's numbers, and how it is looked up.

    `baked` (3, 4) transforms places of the mesh, in glTF's axes, to Blender's world.
    """
    defines = dict(lookup.defines)
    defines |= dict.fromkeys([*["RADTEX_CLEAR"] * clear, *["RADTEX_RELIT"] * lookup.relit], 1)
    if lookup.of_images:
        defines |= {IMAGE_SETS: 1, "RADTEX_IMAGE_SAMPLER(name)": "sampler##name"}  # as Unity calls them
    words = {
        "NAME": in_comment(name),
        "DEFINES": define_lines(defines),
        "TEXTURES": "\n".join([*_textures(lookup), *_image_textures(lookup)]),
        "CONSTANTS": "\n".join(filter(None, [constant_lines(lookup.constants), _of_materials(lookup)])),
        "BAKED": numbers(baked @ _FROM_UNITY),
        "INCLUDES": "\n".join(f'#include "shaders/{stem}.hlsl"' for stem in lookup.includes),
        "ARGUMENTS": ARGUMENTS,
        "LOOKUP": indented(lookup.body),
    }
    return filled(TEMPLATES / "object.hlsl", words)


def shader_text(name: str, title: str, lookup: HlslLookup, clear: bool, culled: bool) -> str:
    """The text of NAME.shader, which Unity calls by its `title`."""
    properties = [
        f'{texture} ("{texture}", {texture_type(entry).removeprefix("Texture")}) = "" {{}}'
        for texture, entry in lookup.textures.items()
    ]
    properties += [*_IMAGE_PROPERTIES] * bool(lookup.of_images)
    of_materials = " ".join(f"RADTEX_MATERIAL_{number}" for number in range(1, len(lookup.materials)))
    keywords = [of_materials] * bool(of_materials)
    if "radtex_layered" in lookup.includes:
        properties.append(_TEMPORAL)
        keywords.append("RADTEX_TEMPORAL")
    words = {
        "NAME": in_comment(name),
        "TITLE": shaderlab_string(f"RadTex/{title}"),
        "NUMBERS": shaderlab_string(f"{name}.hlsl"),
        "PROPERTIES": indented("\n".join(properties), 8),
        "SUN": indented(_SUN, 8) + "\n" if lookup.relit else "",
        "KEYWORDS": indented(
            "\n".join(f"#pragma shader_feature_local _ {each}" for each in keywords), 8
        ).strip(),
        "TYPE": "Transparent" if clear else "Opaque",
        "QUEUE": "Transparent" if clear else "Geometry",
        "CULL": "Back" if culled else "Off",
        "BLEND": "Blend One OneMinusSrcAlpha" if clear else "Blend Off",
    }
    return filled(TEMPLATES / "object.shader", words)


def _textures(lookup: HlslLookup) -> list[str]:
    return [f"{texture_type(entry)} {texture};" for texture, entry in lookup.textures.items()]


def _image_textures(lookup: HlslLookup) -> list[str]:
    """Materials' own images, which are filtered and repeated as they were imported."""
    declared = [f"Texture2D {each}; SamplerState sampler{each};" for each in IMAGE_TEXTURES]
    return declared if lookup.of_images else []


def _of_materials(lookup: HlslLookup) -> str:
    """The constants of each material, chosen by a keyword."""
    if len(lookup.materials) == 1:
        return _of_material(lookup, 0)
    lines = ["#if 0"]
    for number in range(1, len(lookup.materials)):
        lines += [f"#elif defined(RADTEX_MATERIAL_{number})", _of_material(lookup, number)]
    return "\n".join([*lines, "#else", _of_material(lookup, 0), "#endif"])


def _of_material(lookup: HlslLookup, number: int) -> str:
    shown = ["#define RADTEX_IMAGES"] if number in lookup.of_images else []
    return "\n".join([*shown, constant_lines(lookup.materials[number])])


def script_text(
    name: str,
    kind: str,
    mesh: str,
    lookup: HlslLookup,
    materials: Mapping[str, int],
    images: ImageFiles = NO_IMAGES,
) -> str:
    """The text of the script for Unity's editor; `materials` are the mesh's by name, with their numbers.

    `images` are those that materials are shown by, by number.
    """
    files = (
        f"{{ {csharp_string(each)}, {csharp_string(entry.file)} }},"
        for each, entry in lookup.textures.items()
    )
    listed = (f"{{ {csharp_string(each)}, {number} }}," for each, number in materials.items())
    shown = (
        f"new OwnImage({number}, {csharp_string(each.texture)}, {csharp_string(each.file)}, "
        f"TextureWrapMode.{_WRAPS[each.wrap]}),"
        for number, row in images.items()
        for each in row
    )
    words = {
        "NAME": _inside_quotes(name),
        "TITLE": _inside_quotes(title_of(name, kind)),
        "MESH": _inside_quotes(mesh),
        "IDENTIFIER": f"_{identifier(name, kind)}",  # of a namespace, so that exports may lie side by side
        "TEXTURE_FILES": indented("\n".join(files), 12),
        "MATERIAL_NUMBERS": indented("\n".join(listed), 12),
        "BASE": BASE,
        "BUMP": BUMP,
        "OWN_IMAGES": indented("\n".join(shown), 12),
        "FIRST_NUMBER": str(next(iter(materials.values()))),
    }
    return filled(TEMPLATES / "RadTexSetup.cs", words)


def title_of(name: str, kind: str) -> str:
    """What Unity's menus call the bake."""
    return f"{name} ({kind})"


def _inside_quotes(text: str) -> str:
    return csharp_string(text)[1:-1]


WRITER = Writer(write_unity)
