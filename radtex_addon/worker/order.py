# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a worker is asked for, and the words in which `bake.py` understands it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ..bake.spec import BakeSpec
from ..core.sampler import Filter

_BAKE = Path(__file__).resolve().parents[2] / "bake.py"
_FLAGS = {
    "kind": "--kind",
    "texels": "--texels",
    "bucket": "--bucket",
    "samples": "--samples",
    "uv_layer": "--uv",
    "capture": "--capture",
    "seed": "--seed",
    "device": "--device",
    "compression": "--compression",
    "unwrap": "--unwrap",
    "padding": "--padding",
    "memory_mb": "--memory",
    "layout": "--layout",
    "budget": "--budget",
    "target": "--target",
}


@dataclass(frozen=True)
class Program:
    """What runs `bake.py`: Blender, or a Python that has the bpy module.

    `paths` are folders of modules that Blender does not find by itself, as those of an extension's wheels.
    """

    binary: str
    is_blender: bool
    paths: tuple[str, ...] = ()


@dataclass(frozen=True)
class Handover:
    """A scene as it was at one moment, in a folder of its own.

    `images` holds the pixels that were painted and not saved, if there are any; `device` is what `auto`
    means in the session; `stalled` is how long the session stood still, in seconds.
    """

    folder: Path
    blend: Path
    scene: str
    images: Path | None
    device: str
    stalled: float


@dataclass(frozen=True)
class Order:
    """One bake of a scene that was handed over; without a `preview` filter none is saved.

    `extra` are further arguments for `bake.py`.
    """

    handover: Handover
    object: str
    spec: BakeSpec
    out: Path
    preview: Filter | None = None
    overwrite: bool = False
    extra: tuple[str, ...] = ()


def command(program: Program, order: Order) -> list[str]:
    """The command line of the worker, which runs no script that lies in the .blend."""
    blend = str(order.handover.blend)
    if not program.is_blender:
        return [program.binary, str(_BAKE), blend, *arguments(order)]
    find = f"import sys; sys.path += [path for path in {program.paths!a} if path not in sys.path]"
    options = [
        "--background",
        "--factory-startup",
        "--disable-autoexec",
        "-noaudio",
        "--python-exit-code",
        "1",
    ]
    return [
        program.binary,
        *options,
        blend,
        "--python-expr",
        find,
        "--python",
        str(_BAKE),
        "--",
        *arguments(order),
    ]


def arguments(order: Order) -> list[str]:
    """What follows the .blend; a value is joined to its option, for names may begin with a dash."""
    return [*_arguments(order), *order.extra]


def _arguments(order: Order) -> Iterator[str]:
    handover, spec = order.handover, order.spec
    yield f"--object={order.object}"
    yield f"--in-scene={handover.scene}"
    if handover.images is not None:
        yield f"--unsaved-images={handover.images}"
    for field, flag in _FLAGS.items():
        value = getattr(spec, field)
        if field == "device" and value == "auto":
            value = handover.device
        if value is not None:
            yield f"{flag}={value}"
    if not spec.half:
        yield "--float"
    yield f"--out={order.out.absolute()}"
    if order.preview is not None:
        yield "--save-preview"
        yield f"--filter={order.preview}"
    if order.overwrite:
        yield "--overwrite"
    yield "--progress=json"
    yield "--parent-pipe"
