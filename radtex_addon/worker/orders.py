# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be ordered, in the words in which `bake.py` understands it.

A value is joined to its option, for names may begin with a dash.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..bake.kinds import is_usual
from ..bake.progress import Stage
from ..bake.spec import BakeSpec
from ..core.sampler import Filter
from ..job.variants import variant_of
from ..report.progress import Task
from ..textures.progress import Task as ExportTask
from ..textures.spec import Arrangement, ExportSpec
from .order import Handover, Order, Work, parts

if TYPE_CHECKING:
    from ..report.eye import Eye
    from ..report.side_by_side import ComparisonSpec

# How long stages take, in parts of the whole: roughly, for a bar that runs evenly enough.
_BAKE = {
    Stage.EVALUATE: 1,
    Stage.UNWRAP: 5,
    Stage.RASTER: 2,
    Stage.PROBE: 4,
    Stage.CAPTURE: 80,
    Stage.FILL: 2,
    Stage.FIT: 30,
    Stage.CONDENSE: 60,
    Stage.WRITE: 3,
    Stage.PREVIEW: 2,
}
_EXPORT = {ExportTask.TEXTURES: 6, ExportTask.FLAT: 2, ExportTask.MESH: 1, ExportTask.PACK: 1}
_COMPARISON = {Task.REFERENCE: 20, Task.COMPARE: 1}

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
    "content": "--content",
    "view": "--view",
    "source": "--from",
    "extrusion": "--extrusion",
    "cage": "--cage",
    "ao_distance": "--ao-distance",
    "split": "--split",
    "part": "--part",
    "frame": "--frames",
    "unwrap_at": "--unwrap-at",
    "where": "--where",
    "sheet": "--sheet",
}


def order_bake(
    handover: Handover,
    name: str,
    spec: BakeSpec,
    out: Path,
    preview: Filter | None = None,
    *,
    overwrite: bool = False,
    extra: Sequence[str] = (),
) -> Order:
    """A bake of the object `name`, or of `spec.objects` by that name.

    Without a `preview` filter none is saved. `extra` are more arguments.
    """
    return Order(
        work=Work.BAKE,
        object=name,
        about=kind_of(spec),
        part=spec.part or "",
        variant=variant_of(spec),
        shared=spec.objects,
        folder=handover.folder,
        out=out,
        blend=handover.blend,
        arguments=(
            *(f"--object={each}" for each in spec.objects or (name,)),
            *((f"--together={name}",) if spec.objects else ()),
            *_of_scene(handover),
            *_of_spec(spec, handover.device),
            f"--out={out.absolute()}",
            *(("--save-preview", f"--filter={preview}") if preview is not None else ()),
            *(("--overwrite",) if overwrite else ()),
            *_SPOKEN,
            *extra,
        ),
        stages=_stages(spec, preview is not None),
        remedy="bake again, if memory ran out with fewer texels, cells or samples",
    )


def kind_of(spec: BakeSpec) -> str:
    """What tells a bake from others of the same object: its kind, unless it is the usual one."""
    return "" if is_usual(spec.kind) else str(spec.kind)


def order_export(
    folder: Path, sidecar: Path, name: str, spec: ExportSpec, out: Path, *, overwrite: bool = False
) -> Order:
    """The folder `out` made of the bake of `name`, which has that sidecar; the worker works in `folder`."""
    return Order(
        work=Work.EXPORT,
        object=name,
        about=spec.target,
        folder=folder,
        out=out.parent,
        command="export",
        arguments=(
            f"--to={spec.target}",
            f"--format={spec.format}",
            *(() if spec.zstd else ("--no-zstd",)),
            *(() if spec.arrangement is Arrangement.MATRIX else (f"--arrangement={spec.arrangement}",)),
            *(() if spec.levels is None else (f"--levels={spec.levels}",)),
            *(() if spec.limit is None else (f"--limit={spec.limit}",)),
            *(f"--layer={layer}" for layer in spec.layers),
            f"--out={out.absolute()}",
            *(("--overwrite",) if overwrite else ()),
            *_SPOKEN,
            str(sidecar.absolute()),
        ),
        stages=parts(_EXPORT),
        remedy="export again",
    )


def order_comparison(
    handover: Handover,
    names: Sequence[str],
    bake: Path | None,
    eye: Eye,
    spec: ComparisonSpec,
    out: Path,
) -> Order:
    """Objects and their bakes seen by `eye`, as pictures in `out`.

    `bake` is the folder of the bakes or a sidecar, None where all previews are on.
    """
    view, window = eye.rows
    return Order(
        work=Work.COMPARISON,
        object=", ".join(names),
        folder=handover.folder,
        out=out,
        command="compare",
        blend=handover.blend,
        arguments=(
            *(f"--object={name}" for name in names),
            *_of_scene(handover),
            *(() if bake is None else (f"--bake={bake.absolute()}",)),
            f"--view={_numbers(view)}",
            f"--window={_numbers(window)}",
            f"--pixels={spec.pixels}",
            f"--samples={spec.samples}",
            f"--device={handover.device if spec.device == 'auto' else spec.device}",
            f"--out={out.absolute()}",
            *_SPOKEN,
        ),
        stages=parts(_COMPARISON),
        remedy="compare again, if memory ran out with fewer pixels",
    )


_SPOKEN = ("--progress=json", "--parent-pipe")


def _of_scene(handover: Handover) -> Iterator[str]:
    yield f"--in-scene={handover.scene}"
    if handover.images is not None:
        yield f"--unsaved-images={handover.images}"


def _of_spec(spec: BakeSpec, device: str) -> Iterator[str]:
    for field, flag in _FLAGS.items():
        value = getattr(spec, field)
        if field == "device" and value == "auto":
            value = device
        if value is not None:
            yield f"{flag}={value}"
    yield from (f"--layer={layer}" for layer in spec.layers)
    if spec.lights:
        yield f"--lights={_comma_separated(spec.lights)}"
    if spec.accumulate:
        yield "--accumulate"
    if spec.refresh:
        yield "--refresh"
    if not spec.half:
        yield "--float"


def _comma_separated(names: Sequence[str]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="").writerow(names)
    return text.getvalue()


def _stages(spec: BakeSpec, preview: bool) -> dict[str, float]:
    """The part of each stage of such a bake; together 1."""
    absent = {Stage.FILL} if spec.form.by_paths else {Stage.FIT}
    if not spec.condensed:
        absent.add(Stage.CONDENSE)
    if not preview:
        absent.add(Stage.PREVIEW)
    return parts({stage: 0 if stage in absent else share for stage, share in _BAKE.items()})


def _numbers(matrix: Sequence[float]) -> str:
    return ",".join(map(repr, matrix))
