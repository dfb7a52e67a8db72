# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What reads files in RadTex, and how each reader is given a damaged one."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import struct
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from itertools import islice
from pathlib import Path

from radtex_addon.bake.progress import finished
from radtex_addon.core.errors import BakeError, FormatError, InputError, RadTexError
from radtex_addon.export.export_manifest import read_manifest
from radtex_addon.farm.farm_files import FarmFiles
from radtex_addon.farm.farm_manifest import read_manifest as read_farm_manifest
from radtex_addon.farm.farm_manifest import read_plan
from radtex_addon.formats.bucket_files import open_buckets, read_counts, read_layer
from radtex_addon.formats.containers.exr import (
    ATTRIBUTE,
    read_atlas,
    read_buckets,
    read_render,
    read_stamps,
    read_whole,
    stored_compression,
)
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.formats.disk.regular import digest
from radtex_addon.formats.shadow_files import read_shadow, visible_buckets
from radtex_addon.formats.sidecar import preview_path, read_sidecar
from radtex_addon.formats.sidecar_file import read_facts
from radtex_addon.formats.transfer_files import read_transfer, read_transfer_sidecar
from radtex_addon.forms.layered.files.layered_files import read_layered, read_layered_sidecar
from radtex_addon.forms.layered.textures import own_texels
from radtex_addon.store.checkpoint import Checkpoint, replaced_by
from radtex_addon.store.checkpoint_files import KEY

from .corpus import FACTS, PAINTED
from .mutate import Mutator
from .mutate_binary import mutate_glb, mutate_npy, mutate_npz, mutate_piece
from .mutate_exr import mutate_exr, put_text
from .mutate_json import mutate_json


@dataclass(frozen=True)
class Reader:
    """A way to read the file `target` of the corpus, which is damaged before.

    It begins with what `seeds` match, or the target itself. `way` knows the format. `follow` gives the
    target's companions what they must say so that the damage is not noticed by them alone. `raises` is what
    `read` may raise. `weight` is its part of all executions. What loads `blender`, which may print when it
    likes, comes last.
    """

    target: str
    way: Mutator
    read: Callable[[Path], object]
    weight: int = 1
    follow: Callable[[Path], None] | None = None
    seeds: str = ""
    raises: type[RadTexError] = FormatError
    blender: bool = False


def _facts(path: Path) -> None:
    """Whatever asks a sidecar of any layout."""
    facts = read_facts(path)
    for read in (read_sidecar, read_layered_sidecar, read_transfer_sidecar):
        try:
            read(path)
        except FormatError as error:
            named(error, path)
    sidecar = read_sidecar(path)
    preview_path(path, facts.text("kind"), sidecar.part)
    if sidecar.texel_samples and sidecar.width * sidecar.height < 1 << 20:
        read_counts(sidecar.texel_samples, sidecar.width, sidecar.height, str(path))


def _json(path: Path) -> Path:
    return path.with_suffix(".json")


def _rows(path: Path) -> None:
    """All bands of rows, if they are not too many."""
    image, _ = open_buckets(_json(path))
    for _ in islice(image.bands(), 20):
        pass


def _layered(path: Path) -> None:
    sidecar = path.with_name("Coat.radiance.json")
    atlas, _ = read_layered(sidecar)
    own_texels(sidecar, atlas)


def _piece(path: Path) -> None:
    """Never raises: a damaged piece is made again."""
    kept = Checkpoint(path.parent, resume=True)
    kept.set_facts(FACTS)
    kept.found(path.stem)


def _piece_rows(path: Path) -> None:
    """Rows of a piece that was whole when it was found, and has been damaged since."""
    kept = Checkpoint(path.parent, resume=True)
    kept.set_facts(FACTS)
    for name in ("some", "cells", "rows"):
        with suppress(BakeError):
            kept.rows(path.stem, name, 0, 1)
    kept.rows(path.stem, "cells", 1, 2)


def _accessors(path: Path) -> None:
    """All values of a mesh."""
    glb = Glb.read(path)
    accessors = glb.document.get("accessors")
    count = len(accessors) if isinstance(accessors, list) else 1
    for index in range(min(count, 20)):
        glb.accessor(index)


def _plan(path: Path) -> None:
    files = FarmFiles(path.parent)
    read_plan(files, read_farm_manifest(files))


def _assembled(path: Path) -> None:
    """All of a farm, whose plan and frames are as they were, but for the preview."""
    from radtex_addon.farm.assemble_farm import assemble_steps  # noqa: PLC0415  # it loads Blender

    out = path.parent / "out"
    shutil.rmtree(out, ignore_errors=True)
    finished(assemble_steps(path.parent, out))


def _unsaved_images(path: Path) -> None:
    """Pixels that are handed over for an image of the open file."""
    import bpy  # noqa: PLC0415  # here alone is it needed

    from radtex_addon.worker.unsaved_images import load_unsaved  # noqa: PLC0415  # it loads Blender

    for image in list(bpy.data.images):
        bpy.data.images.remove(image)
    bpy.data.images.new(PAINTED, 2, 2)
    load_unsaved(path.parent)


def _order(path: Path) -> None:
    """What a worker is ordered."""
    from radtex_addon.cli.run_work import parse_work, read_order  # noqa: PLC0415  # it loads Blender

    read_order(parse_work([str(path)], inside_blender=False))


def _as_frame(path: Path) -> None:
    """Put the damaged picture where the farm's first frame is."""
    shutil.copy(path, FarmFiles(path.parent).frame(1))


def _plan_with_digest(path: Path) -> None:
    """Let the farm's manifest name the damaged plan's digest."""
    manifest = path.with_name("farm.json")
    facts = json.loads(manifest.read_text())
    facts["digests"]["plan.npz"] = digest(path)
    manifest.write_text(json.dumps(facts))


def _key(path: Path) -> None:
    kept = Checkpoint(path.parent, resume=True)
    replaced_by(path.parent)
    kept.set_facts(FACTS)
    kept.names()


LONGEST = 5010  # characters of a message
UNSEEN = re.compile("[\0-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")  # what ends a line or drives a terminal


def named(error: RadTexError, path: Path) -> None:
    """An error is one line of moderate length that names a file, beside `path`. Raises AssertionError."""
    said = str(error)
    assert not UNSEEN.search(said), f"not one line: {said!r}"
    assert str(path.parent) in said, f"names no file: {said!r}"
    assert "alloc" not in said, f"memory was asked for in vain: {said!r}"
    assert len(said) <= LONGEST, f"of {len(said)} characters: {said!r}"


def _sidecar_as_header(path: Path) -> None:
    """Let the sidecar say what the damaged image's header says."""
    data = path.read_bytes()
    place = data.find(ATTRIBUTE.encode() + b"\0string\0")
    if place >= 0:
        begin = place + len(ATTRIBUTE) + 8
        (size,) = struct.unpack_from("<I", data[begin : begin + 4].ljust(4, b"\0"))
        path.with_suffix(".json").write_bytes(data[begin + 4 :][:size])


def _headers_as_sidecar(path: Path) -> None:
    """Let the images' headers say what the damaged sidecar says."""
    text = path.read_bytes()
    for image in path.parent.glob(f"{path.stem}.*.exr"):
        data = bytearray(image.read_bytes())
        put_text(data, text)
        image.write_bytes(data)


_SHADE, _VASE, _COAT = "Shade.shadow.exr", "Vase.radiance.exr", "Coat.radiance"
_FARM = "Vase.radiance.radtex-farm/farm.json"
_ALONE = "Alone.radiance.radtex-farm"
_BAKE = "bake.radtex-unfinished"
_PIECE = f"{_BAKE}/tile-0000.piece"
_exr = partial(Reader, "exr.seeds/zip4.exr", mutate_exr, seeds="exr.seeds/*.exr")
_with_blender = partial(Reader, raises=RadTexError, blender=True)

READERS = {
    "atlas": _exr(read_atlas, 8),
    "render": _exr(read_render, 8),
    "whole": _exr(read_whole, 3),
    "compression": _exr(stored_compression),
    "stamps": _exr(read_stamps),
    "shadow": Reader(_SHADE, mutate_exr, read_shadow, 3),
    "visible": Reader(_SHADE, mutate_exr, lambda path: visible_buckets(_json(path)), 1, _sidecar_as_header),
    "buckets": Reader(_VASE, mutate_exr, lambda path: read_buckets(_json(path)), 3, _sidecar_as_header),
    "rows": Reader(_VASE, mutate_exr, _rows, 4, _sidecar_as_header),
    "layer": Reader(
        "Vase.radiance.base.exr",
        mutate_exr,
        lambda path: read_layer(path.with_name("Vase.radiance.json"), "base"),
    ),
    "transfer": Reader(
        "Wax.transfer.exr", mutate_exr, lambda path: read_transfer(_json(path)), 2, _sidecar_as_header
    ),
    "layered-sidecar": Reader(f"{_COAT}.json", mutate_json, _layered, 4, _headers_as_sidecar),
    "layered-irradiance": Reader(f"{_COAT}.irradiance.exr", mutate_exr, _layered),
    "layered-own": Reader(f"{_COAT}.own.exr", mutate_exr, _layered),
    "layered-exit": Reader(f"{_COAT}.exit_direction.exr", mutate_exr, _layered),
    "layered-things": Reader(f"{_COAT}.things.exr", mutate_exr, _layered),
    "sidecar": Reader("Rich.radiance.json", mutate_json, _facts, 8, seeds="*.json"),
    "manifest": Reader("manifest.seeds/0.json", mutate_json, read_manifest, 6, seeds="manifest.seeds/*.json"),
    "farm": Reader(_FARM, mutate_json, lambda path: read_farm_manifest(FarmFiles(path.parent)), 3),
    "plan": Reader(f"{_ALONE}/plan.npz", mutate_npz, _plan, 3, _plan_with_digest),
    "glb": Reader("mesh.glb", mutate_glb, Glb.read, 4),
    "accessors": Reader("mesh.glb", mutate_glb, _accessors, 4),
    "piece": Reader(_PIECE, mutate_piece, _piece, 5),
    "piece-rows": Reader(_PIECE, mutate_piece, _piece_rows, 4, raises=BakeError),
    "key": Reader(f"{_BAKE}/{KEY}", mutate_json, _key, 2, raises=InputError),
    "assemble-manifest": _with_blender(f"{_ALONE}/farm.json", mutate_json, _assembled, 2),
    "assemble-frame": _with_blender(f"{_ALONE}/frame.exr", mutate_exr, _assembled, 2, _as_frame),
    "order": _with_blender("order.seeds/0.json", mutate_json, _order, 2, seeds="order.seeds/*.json"),
    "images-list": _with_blender("images/images.json", mutate_json, _unsaved_images, raises=InputError),
    "images-pixels": _with_blender("images/0.npy", mutate_npy, _unsaved_images, raises=InputError),
}


def fingerprint(data: bytes) -> str:
    """What a kept input is called."""
    return hashlib.sha256(data).hexdigest()[:12]
