# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the objects whose lookups are timed, and leave what the timing needs of them, without Blender.

    python -m tests.bench.gpu.bakes [convex rough film lights shared] [--scenes DIR]

Of each object: a default bake and one in layout buckets, 64 texels each, block-compressed as exports are; its
materials as an engine has them; a prefiltered probe in its middle; and its mesh. Pictures of the surroundings
are kept from the second level on, `subject` makes the first of it. Takes about two minutes for an object.
`--scenes` keeps the scenes, for other programs.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.octahedron import cell_directions, direction_to_octahedron, sample_octahedron
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.formats.containers.texture import PixelFormat, Texture, encode_texture
from radtex_addon.forms.layered.blocks import coded
from radtex_addon.forms.layered.files.arrangement import DISTANCES, OWN, REST, unpacked
from radtex_addon.forms.layered.files.layered_files import read_layer, read_layered
from radtex_addon.forms.layered.lookup.environment import Around
from radtex_addon.forms.layered.shader_values import DEFAULT, FULL, Stored, shader_facts
from radtex_addon.job import bake_object
from radtex_addon.report.finished_bake import Finished, find_bake, read_bake
from radtex_addon.settings.spec import BakeSpec, Layout

from ..baked_model import read_model
from ..fidelity.reflection_probe import prefiltered
from .scenes import SCENES, Staged
from .subject import CUBE, CUBE_LEVELS, DATA, cube_directions

TEXELS = 64
VARIANTS = {
    "layered": DEFAULT,
    "layered, all of it": FULL,
    "layered, no distances": replace(DEFAULT, steps=0),
    "layered, one lobe": replace(DEFAULT, second_lobe=False),
    "layered, one lobe, no distances": replace(DEFAULT, steps=0, second_lobe=False),
}
_PANORAMA = 512  # cells along the side of the probe's picture before it is blurred
Arrays = dict[str, Any]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="object", help=f"of {', '.join(SCENES)} (default: all)")
    parser.add_argument("--scenes", type=Path, help="folder to keep the scenes in, as .blend files")
    options = parser.parse_args()
    for name in options.names or SCENES:
        staged = SCENES[name]
        staged.build()
        if options.scenes:
            options.scenes.mkdir(parents=True, exist_ok=True)
            bpy.ops.wm.save_as_mainfile(filepath=str((options.scenes / f"{name}.blend").resolve()))
        with tempfile.TemporaryDirectory() as folder:
            kept = baked(name, staged, Path(folder))
        DATA.mkdir(exist_ok=True)
        path = DATA / f"{name}.npz"
        np.savez_compressed(path, **kept)
        print(f"{path}: {path.stat().st_size:,d} bytes", flush=True)


def baked(name: str, staged: Staged, folder: Path) -> Arrays:
    """Bake the open scene's object twice; returns all that `subject` reads."""
    of_layers = _bake(name, staged, Layout.LAYERED, folder)
    of_buckets = _bake(name, staged, Layout.BUCKETS, folder)
    facts: dict[str, Any] = {
        "view": {"place": staged.place, "target": staged.target, "half": staged.half},
        "box": staged.box,
        "materials": [_engine_material(item) for item in _materials(staged)],
    }
    kept: Arrays = {}
    for form, bake in (("layered", of_layers), ("buckets", of_buckets)):
        model = read_model(bake)
        points, index = np.unique(model.corners, axis=0, return_inverse=True)
        kept |= {f"{form} points": points, f"{form} index": index.ravel().astype(np.uint16)}
        facts[f"{form} parts"] = model.parts
    kept |= _layered(of_layers, facts)
    kept |= _buckets(of_buckets, facts)
    kept["facts"] = np.frombuffer(json.dumps(facts).encode(), np.uint8)
    return kept


def _bake(name: str, staged: Staged, layout: Layout, folder: Path) -> Finished:
    several = len(staged.objects) > 1
    spec = BakeSpec(
        layout=layout,
        texels=TEXELS,
        denoise=layout is Layout.BUCKETS,
        objects=staged.objects if several else (),
    )
    own = folder / layout
    atlas = name if several else staged.objects[0]
    bake_object(cast("bpy.types.Scene", bpy.context.scene), atlas, spec, own, preview=Filter.NEAREST)
    return read_bake(find_bake(own, None))


def _layered(bake: Finished, facts: dict[str, Any]) -> Arrays:
    atlas, sidecar = read_layered(bake.file)
    if len(sidecar.materials) != len(facts["materials"]):
        raise ValueError(f"{len(sidecar.materials)} materials baked, {len(facts['materials'])} in the scene")
    kept: Arrays = {}
    stored, textures = {}, {}
    for layer in sidecar.shapes:
        image = read_layer(bake.file.path, sidecar, layer).astype(np.float32)
        levels: tuple[Floats, ...] = (image,)
        picture = sidecar.pictures.get(layer)
        if picture is not None:
            levels = unpacked(image, picture.size, picture.levels)
        found = coded(layer, levels)
        width, height = found.texture.width, found.texture.height
        part = (found.texels[0] / width, found.texels[1] / height)
        stored[layer] = Stored(
            found.scale, found.offset, part, sidecar.nearness if layer == DISTANCES else 0.0
        )
        texture = found.texture
        if picture is not None:
            texture = Texture(texture.format, width // 2, height // 2, texture.levels[1:])
        textures[layer] = _texture_facts(texture) | {
            "cells": {OWN: sidecar.own_cells, REST: sidecar.rest_cells}.get(layer, 1),
            "halved": picture is not None,
        }
        kept |= _blocks(layer, texture)
    facts["textures"] = textures
    facts["variants"] = {name: shader_facts(sidecar, stored, cost) for name, cost in VARIANTS.items()}
    facts["middle"] = sidecar.middle.tolist()
    facts["lamps"] = [
        {"place": lamp.place.tolist(), "irradiance": lamp.irradiance.tolist()} for lamp in sidecar.lamps
    ]
    probe = probe_of(atlas.around)
    facts["textures"]["probe"] = _texture_facts(probe)
    return kept | _blocks("probe", probe)


def probe_of(around: Around) -> Texture:
    """What is seen from the middle but for lamps, as a cube's faces, in levels blurred by roughness."""
    direction = cell_directions(_PANORAMA)
    sharp = np.full(len(direction), 1e-9, np.float32)
    seen = replace(around, lamps=()).look(np.zeros_like(direction), direction, sharp)
    image: Floats = np.ascontiguousarray(seen.T.reshape(_PANORAMA, _PANORAMA, 3))
    wanted = [(number / (CUBE_LEVELS - 1), 2 * CUBE >> number) for number in range(CUBE_LEVELS)]
    faces = []
    for number, level in enumerate(prefiltered(image, wanted)):
        place = direction_to_octahedron(cube_directions(CUBE >> number))
        faces.append(sample_octahedron(level, place).astype(np.float32))
    return encode_texture(faces, PixelFormat.BC6H, is_array=True)


def _buckets(bake: Finished, facts: dict[str, Any]) -> Arrays:
    image, sidecar = read_atlas(bake.images[0])
    texture = encode_texture([image[None].astype(np.float32)], PixelFormat.BC6H)
    facts["textures"]["buckets"] = _texture_facts(texture) | {"cells": sidecar.bucket}
    return _blocks("buckets", texture)


def _texture_facts(texture: Texture) -> dict[str, Any]:
    levels = len(texture.levels)
    return {"format": texture.format, "size": (texture.width, texture.height), "levels": levels}


def _blocks(name: str, texture: Texture) -> Arrays:
    return {f"{name} {number}": level for number, level in enumerate(texture.levels)}


def _materials(staged: Staged) -> list[Any]:
    """The materials of all objects, one after the other."""
    return [slot.material for name in staged.objects for slot in bpy.data.objects[name].material_slots]


def _engine_material(material: Any) -> dict[str, Any]:
    """A Principled shader's inputs as engines have them; "base" is None where it is a texture."""
    inputs = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED").inputs
    base = inputs["Base Color"]
    numbers = {
        "metallic": "Metallic",
        "roughness": "Roughness",
        "ior": "IOR",
        "coat": "Coat Weight",
        "coat_roughness": "Coat Roughness",
        "film": "Thin Film Thickness",
        "film_ior": "Thin Film IOR",
    }
    found: dict[str, Any] = {key: float(inputs[name].default_value) for key, name in numbers.items()}
    return found | {"base": None if base.is_linked else list(base.default_value)[:3]}


if __name__ == "__main__":
    main()
