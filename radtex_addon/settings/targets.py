# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of targets: what finished bakes are exported for, and what each of them reads.

Menus, the command line, checks, refusals and the choice of formats come from it. What a target writes is in
its module of `export.targets`. A new target is a member of `Target`, a row in `TARGETS`, and that module.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from ..core.errors import InputError
from .kinds import KINDS, Kind


class Target(StrEnum):
    """The program or engine that loads the folder."""

    WEB = "web"
    GODOT = "godot"
    GLTF = "gltf"
    UNITY = "unity"
    UNREAL = "unreal"
    RAW = "raw"

    @property
    def traits(self) -> TargetTraits:
        """The target's row in the table."""
        return TARGETS[self]


DEFAULT_TARGET = Target.GLTF  # the panel's


class TextureFormat(StrEnum):
    """A container and a format in it; AUTO is the target's own choice."""

    AUTO = "auto"
    EXR = "exr"
    KTX2_RGBA16F = "ktx2-rgba16f"
    KTX2_RGB9E5 = "ktx2-rgb9e5"
    KTX2_BC6H = "ktx2-bc6h"
    DDS_BC6H = "dds-bc6h"
    DDS_RGBA16F = "dds-rgba16f"

    @property
    def label(self) -> str:
        """As the panel shows it."""
        return self.upper().replace("-", " ")


class MeshPacking(StrEnum):
    """How a .glb stores its mesh: by EXT_meshopt_compression or plain; AUTO is the target's choice."""

    AUTO = "auto"
    MESHOPT = "meshopt"
    PLAIN = "plain"


EVERY_FORMAT = frozenset(TextureFormat)
_IMPORTED = frozenset((TextureFormat.AUTO, TextureFormat.EXR, TextureFormat.DDS_RGBA16F))  # by engines
MOST_PIXELS = 16384  # along a side, for targets without a limit of their own


@dataclass(frozen=True)
class TargetTraits:
    """One row: facts about a target.

    * `title`, `tooltip`: what the panel calls it; `called`: its name in sentences, if not `title`. `help`:
      for --to; targets with the same text share it. `next_step`: what to do with the folder.
    * `auto`: the format of plain, opaque light by default. `formats`: all that it reads.
    * `most_pixels`: along a texture's side. `mirror`: it shows a mirror ball.
    * `languages`: the endings of the shader includes in the folder, where a program of the user's shows it.
      `needs_hlsl`: the bake's lookup is written into its shader; not all kinds have one.
    * `images`: it shows materials by their own images where they are texture sets.
    * `short_coordinates`: its loaders read texture coordinates of 16 bits, which are core glTF; `quantised`:
      also normals and tangents, by KHR_mesh_quantization, without which a loader refuses the file.
    * `meshes`: how a mesh may be stored, first the choice of AUTO.
    * `blocks`: other images than plain light are compressed by default, each in a range of its own, and
      `light_blocks`: light is, too.
    * What loaders lack: `arrays` (with mip levels: no slices, no pages), those in KTX2 (`ktx2_arrays`),
      `srgb` formats of blocks, mip levels where a side is no power of two (`odd_levels`). Or want:
      `all_levels`, down to one pixel. `turns_exr`: the importer puts an EXR's bottom row first.
    """

    title: str
    tooltip: str
    help: str
    next_step: str
    called: str = ""
    auto: TextureFormat = TextureFormat.KTX2_RGB9E5
    formats: frozenset[TextureFormat] = EVERY_FORMAT
    most_pixels: int = MOST_PIXELS
    mirror: bool = False
    languages: tuple[str, ...] = ()
    needs_hlsl: bool = False
    images: bool = False
    short_coordinates: bool = False
    quantised: bool = False
    meshes: tuple[MeshPacking, ...] = (MeshPacking.PLAIN,)
    blocks: bool = True
    light_blocks: bool = True
    arrays: bool = True
    ktx2_arrays: bool = True
    srgb: bool = True
    odd_levels: bool = True
    all_levels: bool = False
    turns_exr: bool = False


_ENGINE_HELP = "a shader, and a script for the editor"

# As messages list them; menus have the order of `Target`.
# fmt: off
TARGETS: dict[Target, TargetTraits] = {
    Target.WEB: TargetTraits(
        "Web", "A page that shows the object in a browser, by three.js",
        help="a page for any static server", called="the web",
        next_step="Show in Browser opens it. On a site of your own, any web server will do",
        formats=frozenset((TextureFormat.AUTO, TextureFormat.KTX2_RGBA16F, TextureFormat.KTX2_RGB9E5)),
        most_pixels=8192, mirror=True, images=True, short_coordinates=True, quantised=True,
        meshes=(MeshPacking.MESHOPT, MeshPacking.PLAIN)),
    Target.GODOT: TargetTraits(
        "Godot", "A project that opens and runs, and the addon by which any project shows bakes",
        help="a project", next_step="Open project.godot in Godot 4, and press F5",
        formats=EVERY_FORMAT - {TextureFormat.EXR}, mirror=True, images=True,
        short_coordinates=True,  # without the addon, 4.6 refuses a file that says it is quantised
        light_blocks=False,  # its Compatibility renderer may decompress BC6H to 8 bits
        ktx2_arrays=False, srgb=False, all_levels=True),
    Target.RAW: TargetTraits(
        "Raw", "A mesh, textures and all shader includes, for an engine of your own",
        help="the same with the includes of all languages",
        next_step="For an engine of your own: take the shader include of its language",
        languages=("glsl", "hlsl", "wgsl", "gdshaderinc", "osl"), blocks=False),
    Target.GLTF: TargetTraits(
        "glTF", "A .glb whose material names the textures",
        help="mesh, textures and shader includes", languages=("glsl",), images=True,
        short_coordinates=True, meshes=(MeshPacking.PLAIN, MeshPacking.MESHOPT),  # any program opens PLAIN
        next_step="Every viewer shows the flat lightmap; the light of each direction needs the shader beside "
        "it"),
    Target.UNITY: TargetTraits(
        "Unity", "A mesh, DDS textures, a shader, and a script that sets all up", help=_ENGINE_HELP,
        next_step="Copy the folder into Assets without .unity in its name, then Assets > RadTex > Set up",
        auto=TextureFormat.DDS_BC6H, formats=_IMPORTED | {TextureFormat.DDS_BC6H}, needs_hlsl=True,
        images=True, turns_exr=True),
    Target.UNREAL: TargetTraits(
        "Unreal", "A mesh, DDS textures, and a script that imports them and makes the material",
        help=_ENGINE_HELP, next_step="In the editor: Tools > Execute Python Script, the .py of the folder",
        auto=TextureFormat.DDS_RGBA16F, formats=_IMPORTED, needs_hlsl=True, images=True,
        blocks=False,  # it compresses what it imports itself
        arrays=False, odd_levels=False),
}
# fmt: on


def targets_of(kind: Kind) -> list[Target]:
    """The targets that show bakes of a kind."""
    return [target for target, traits in TARGETS.items() if KINDS[kind].hlsl or not traits.needs_hlsl]


def check_target(bake: Path | str, kind: str, target: Target) -> None:
    """Raise InputError, naming the `bake`, if the target cannot show bakes of its kind."""
    if kind not in tuple(Kind):
        raise InputError(f"{bake} is of kind {kind}, which this RadTex does not export: update RadTex")
    if target not in (takers := targets_of(Kind(kind))):
        words = ", ".join(takers)
        raise InputError(f"{bake} is of kind {kind}, which {target} does not show: choose {words}")
