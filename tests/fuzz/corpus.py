# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small valid files of every kind that RadTex reads, written by its own writers: what fuzzing begins with."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

from radtex_addon.core.arrays import Floats
from radtex_addon.core.sampler import Filter
from radtex_addon.export.export_manifest import Manifest, write_manifest
from radtex_addon.farm.farm_files import FarmFiles
from radtex_addon.farm.farm_manifest import Copies, FarmManifest
from radtex_addon.formats.bucket_files import write_buckets
from radtex_addon.formats.containers.exr import Compression, write_atlas
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.formats.containers.texture import PixelFormat
from radtex_addon.formats.disk.regular import digest
from radtex_addon.formats.shadow_files import write_shadow
from radtex_addon.formats.sidecar import Content, Part, Sidecar, Source, write_sidecar
from radtex_addon.formats.transfer_files import TransferSidecar, write_transfer
from radtex_addon.forms.layered.files.layered_files import write_layered
from radtex_addon.settings.spec import BakeSpec, facts_of
from radtex_addon.store.checkpoint import Checkpoint
from radtex_addon.textures.entry import Arranged, Container, TextureEntry
from tests.layered.made_up import made_up_atlas
from tests.layered_lookups import everything

PAINTED = "Painted"  # the image of the open file
_LAYERED = 4  # texels
FACTS = {"scene": "a digest", "spec": "texels 8"}  # of the checkpoint's key
_BAKE = Sidecar("Vase", "radiance", 3, 2, 4, "UVMap", 16, 0, "portal", "RadTex 1", "5.2.0")
_RICH = replace(
    _BAKE,
    mesh="a digest",
    source=Source("Détail", 0.5, 2, "Cage"),
    frame=7,
    lights=("Key", "Fill"),
    objects=("Vase", "Lamp"),
    part=Part("material", "Gold", 1),
    ao_distance=2.5,
    texel_samples="16x4 24x2",
    content=Content("Inside", ("Ball",)),
)
_OTHERS = ("ZIPS", "RLE", "PXR24", "B44", "B44A", "DWAB", "NO")  # compressions that we read and do not write


# What a worker reads: `worker.orders` writes it, in a Blender.
_SCENE = {"blend": "/a.blend", "scene": "Scene", "images": None, "folder": "/out"}
_VIEW = {"view": [float(number) for number in range(16)], "window": [0.5] * 16}
_ORDERS: tuple[dict[str, Any], ...] = (
    {
        "work": "bake",
        **_SCENE,
        "name": "Vase",
        "spec": facts_of(BakeSpec(lights=("Key",), frame=3)),
        "preview": "linear",
        "overwrite": False,
        "overwrite_any": False,
        "of_blend": "/a.blend",
        "resume": True,
        "exports": ["web"],
        "picture": "/a.png",
    },
    {
        "work": "export",
        "sidecars": ["/Vase.radiance.json"],
        "scene": "Room",
        "spec": {"target": "raw", "format": "exr", "zstd": True, "arrangement": "slices", "layers": ["base"]},
        "folder": "/out",
        "overwrite": True,
    },
    {
        "work": "comparison",
        **_SCENE,
        "objects": ["Vase"],
        "bake": None,
        **_VIEW,
        "pixels": 64,
        "samples": 4,
        "device": "cpu",
    },
)


def make_corpus(folder: Path) -> None:
    """Write all files into `folder`: the sets that readers need whole, and seeds in folders `*.seeds`."""
    folder.mkdir(parents=True, exist_ok=True)
    _write_sets(folder)
    _write_images(folder / "exr.seeds")
    _write_orders(folder / "order.seeds")
    _write_rest(folder)
    _write_farm(folder / "Vase.radiance.radtex-farm")


def _pixels(height: int, width: int, channels: int, seed: int = 1) -> Floats:
    return np.random.default_rng(seed).random((height, width, channels)).astype(np.float32)


def _write_sets(folder: Path) -> None:
    layers = {"base": _pixels(2, 3, 3), "rest": _pixels(8, 12, 3)}
    write_buckets(folder / "Vase.radiance.json", _pixels(8, 12, 4), layers, _BAKE)
    write_sidecar(folder / "Rich.radiance.json", _RICH)
    coat = replace(_BAKE, object_name="Coat", width=_LAYERED, height=_LAYERED, bucket=14)
    write_layered(folder / "Coat.radiance.json", everything(made_up_atlas(_LAYERED, 16)), coat)
    sphere = TransferSidecar(replace(_BAKE, object_name="Wax", kind="transfer"), suns=16)
    write_transfer(folder / "Wax.transfer.json", _pixels(8, 12, 4), sphere)
    seen = replace(sphere, view="camera", eye=(1.0, 2.0, 3.0, 1.0))
    write_transfer(folder / "Seen.transfer.json", _pixels(8, 12, 4), seen)
    shade = replace(_BAKE, object_name="Shade", kind="shadow", bucket=8)
    words = np.random.default_rng(2).integers(0, 2**32, (2, 3, 2), dtype=np.uint32)
    write_shadow(folder / "Shade.shadow.exr", words, shade)
    write_sidecar(folder / "Shade.shadow.json", shade)


def _write_images(folder: Path) -> None:
    for channels, half in ((4, True), (3, False), (1, True)):
        for compression in Compression:
            name = f"{compression}{channels}.exr"
            write_atlas(folder / name, _pixels(8, 12, channels), _BAKE, half, compression)
    for name in _OTHERS:
        header = {"compression": getattr(OpenEXR, f"{name}_COMPRESSION"), "type": OpenEXR.scanlineimage}
        _save(folder / f"{name}.exr", [(header, {"RGB": _pixels(9, 11, 3).astype(np.float16)}, "")])
    tiles = {"type": OpenEXR.tiledimage, "tiles": OpenEXR.TileDescription()}
    _save(folder / "tiles.exr", [(tiles, {"RGBA": _pixels(9, 11, 4)}, "")])
    flat = {"type": OpenEXR.scanlineimage}
    combined = {f"ViewLayer.Combined.{name}": _pixels(6, 5, 1)[..., 0] for name in "RGBA"}
    _save(folder / "parts.exr", [(flat, combined, "a"), (flat, {"Depth.Z": _pixels(6, 5, 1)[..., 0]}, "b")])


def _save(path: Path, parts: list[tuple[dict[str, object], dict[str, Floats], str]]) -> None:
    if len(parts) == 1:
        header, channels, _ = parts[0]
        OpenEXR.File(header, channels).write(str(path))
    else:  # the module writes names into the headers
        OpenEXR.File([OpenEXR.Part(dict(header), *rest) for header, *rest in parts]).write(str(path))


def _write_rest(folder: Path) -> None:
    for number, (facts, entry) in enumerate(_exports(folder)):
        bake = json.loads(facts.read_text())
        textures = dict.fromkeys(bake["layers"] or [bake["kind"]], entry)
        manifest = Manifest("RadTex 1", "Vase", "Vase.glb", "Vase.flat.png", bake, textures, 0.25)
        write_manifest(folder / "manifest.seeds" / f"{number}.json", manifest)
    glb = Glb({"asset": {"version": "2.0"}}, bytearray())
    attributes = {"POSITION": glb.add_vertices(_pixels(4, 3, 1)[..., 0], bounds=True)}
    indices = glb.add_view(np.arange(6, dtype="<u2").tobytes())
    glb.document["accessors"].append(
        {"bufferView": indices, "componentType": 5123, "count": 6, "type": "SCALAR"}
    )
    glb.document["meshes"] = [{"primitives": [{"attributes": attributes, "indices": 1}]}]
    glb.write(folder / "mesh.glb")
    kept = Checkpoint(folder / "bake.radtex-unfinished", resume=False, replaces=[folder / "a.exr"])
    kept.set_facts(FACTS)
    kept.keep("tile-0000", {"cells": _pixels(4, 4, 4), "rows": np.arange(3), "some": np.array([True])})
    images = folder / "images"
    images.mkdir()
    np.save(images / "0.npy", (255 * _pixels(4, 5, 4)).astype(np.uint8))
    painted = {"name": PAINTED, "library": None, "file": "0.npy", "tiled": False}
    (images / "images.json").write_text(json.dumps([painted]))


def _write_farm(folder: Path) -> None:
    files = FarmFiles(folder)
    copies = Copies(("Vase",), ("Mesh",), "Scene", None, (), Filter.QUADRILINEAR)
    folder.mkdir(exist_ok=True)
    plan, hidden = np.array([0, 1, 2, 4, 5]), np.full((5, 2), 3, dtype=np.uint8)
    normal = np.zeros((len(plan), 3), dtype=np.float32)
    np.savez_compressed(files.plan, texel=plan, normal=normal, hidden=hidden)
    farm = FarmManifest(
        job="a job",
        name="Vase",
        spec=BakeSpec(texels=3, bucket=4, uv_layer="UVMap", lights=("Key", "Fill"), sheet=16),
        facts=_BAKE,
        sheets=1,
        columns=2,
        rows=3,
        sheet_rows=3,
        sheet_side=16,
        device="CPU",
        islands=1,
        digests={"plan.npz": digest(files.plan), "preview.blend": "a digest"},
        copies=copies,
    )
    files.manifest.write_text(farm.to_json(), encoding="utf-8")
    alone = folder.with_name("Alone.radiance.radtex-farm")
    alone.mkdir()
    (alone / "plan.npz").write_bytes(files.plan.read_bytes())
    farm = replace(farm, copies=None, digests={"plan.npz": digest(files.plan)})
    FarmFiles(alone).manifest.write_text(farm.to_json(), encoding="utf-8")
    FarmFiles(alone).frames.mkdir()
    header = {"type": OpenEXR.scanlineimage, "Note": farm.note, "Frame": "1"}
    channels = {f"ViewLayer.Combined.{name}": _pixels(12, 8, 1)[..., 0] for name in "RGBA"}
    _save(FarmFiles(alone).frame(1), [(header, channels, "")])
    (alone / "frame.exr").write_bytes(FarmFiles(alone).frame(1).read_bytes())


def _exports(folder: Path) -> Iterator[tuple[Path, TextureEntry]]:
    entry = TextureEntry(
        file="Vase.radiance.ktx2",
        container=Container.KTX2,
        format=PixelFormat.RGB9E5,
        zstd=True,
        arrangement=Arranged.MATRIX,
        size=(12, 8),
        layers=1,
        texels=(3, 2),
        stored=(3, 2),
        levels=1,
        pages=(1, 1),
        page_texels=(3, 2),
    )
    for name in ("Rich.radiance", "Wax.transfer"):
        yield folder / f"{name}.json", entry
    whole = replace(entry, arrangement=Arranged.IMAGE, texels=(12, 8), stored=(12, 8), page_texels=(12, 8))
    yield folder / "Coat.radiance.json", whole


def _write_orders(folder: Path) -> None:
    folder.mkdir()
    for number, order in enumerate(_ORDERS):
        (folder / f"{number}.json").write_text(json.dumps(order, indent=2), encoding="utf-8")
