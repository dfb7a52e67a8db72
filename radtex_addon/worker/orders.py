# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be ordered of a worker, as data that `bake.py work` reads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..bake.progress import Stage
from ..core.sampler import Filter
from ..farm.farm_progress import FarmTask
from ..job.variants import Bake, variant_of
from ..report.report_progress import ReportTask
from ..settings.bake_names import own_name
from ..settings.estimate import BakeWork, Estimate, estimate
from ..settings.kinds import is_default_kind
from ..settings.spec import BakeSpec, facts_of
from ..textures.export_spec import ExportSpec, ExportStep, ExportTask, Target, export_facts
from .order import Handover, Order, Work, parts

if TYPE_CHECKING:
    from ..report.side_by_side import ComparisonSpec
    from ..report.viewpoint import Viewpoint

_TRIANGLES = 16_000  # of a usual object
MEASURING = "measure"  # the stage of an estimate, in objects
EXPORTING = "export"  # the stage of an export of several bakes, in bakes
_EXPORT_SECONDS = 4.0  # of a usual export
_EXPORT = {ExportTask.TEXTURES: 6, ExportTask.FLAT: 2, ExportTask.MESH: 1, ExportTask.PACK: 1}
_COMPARISON = {ReportTask.REFERENCE: 20, ReportTask.COMPARE: 1}
_PREPARATION_SECONDS = 10.0  # of a usual scene
_ASSEMBLY = {
    FarmTask.CHECK: 2,
    Stage.EVALUATE: 1,
    Stage.UNWRAP: 3,
    Stage.RASTER: 1,
}  # the last three of previews


def order_bake(
    handover: Handover,
    name: str,
    spec: BakeSpec,
    out: Path,
    preview: Filter | None = None,
    *,
    overwrite: bool = False,
    overwrite_any: bool = False,
    resume: bool = False,
    exports: Sequence[Target] = (),
    picture: Path | None = None,
    expected: Estimate | None = None,
) -> Order:
    """A bake of the object `name`, or of `spec.objects` by that name, as in `job.bake_steps`.

    `expected` is how long it takes, where that is known better than by its settings alone.

    What is done so far is shown in the file `picture`, a PNG, and the UV map beside it, in a `.map.png`.
    """
    if expected is None:
        expected = _typical(spec, preview is not None, len(exports))
    return Order(
        work=Work.BAKE,
        object=name,
        about=kind_of(spec),
        part=spec.part or "",
        variant=variant_of(spec),
        shared=spec.objects,
        called=own_name(spec.bake_name, name),
        folder=handover.folder,
        out=out,
        blend=handover.blend,
        facts={
            **_of_scene(handover),
            "name": name,
            "spec": facts_of(_on_device(spec, handover.device)),
            "folder": str(out.absolute()),
            "preview": None if preview is None else str(preview),
            "overwrite": overwrite,
            "overwrite_any": overwrite_any,
            "of_blend": str(handover.original) if handover.original.name else "",
            "resume": resume,
            "exports": [str(target) for target in exports],
            "picture": None if picture is None else str(picture),
        },
        stages=parts({stage: expected.seconds.get(str(stage), 0.0) for stage in Stage}),
        seconds=expected.total,
        expected=expected.unsure() if resume or spec.incremental else expected,
        remedy="bake again, if memory ran out with fewer texels, cells or samples",
    )


def kind_of(spec: BakeSpec) -> str:
    """The kind, which tells bakes of one object apart; empty for the default kind."""
    return "" if is_default_kind(spec.kind) else str(spec.kind)


def order_export(
    folder: Path, bakes: Sequence[tuple[str, Path, Path]], spec: ExportSpec, *, overwrite: bool = False
) -> Order:
    """An export of bakes: of each the object's name, the sidecar and the folder to make, all in one folder.

    `folder` is the worker's own.
    """
    return _export(folder, bakes, spec, overwrite, scene=None)


def order_scene_export(
    folder: Path, sidecars: Sequence[Path], name: str, spec: ExportSpec, out: Path, *, overwrite: bool = False
) -> Order:
    """An export of the bakes with these sidecars as the scene `name`; the rest is as of `order_export`."""
    return _export(folder, [(name, sidecar, out) for sidecar in sidecars], spec, overwrite, scene=name)


def _export(
    folder: Path,
    bakes: Sequence[tuple[str, Path, Path]],
    spec: ExportSpec,
    overwrite: bool,
    scene: str | None,
) -> Order:
    names, sidecars, outs = zip(*bakes, strict=True)
    return Order(
        work=Work.EXPORT,
        object=", ".join(dict.fromkeys(names)),
        about=spec.target,
        folder=folder,
        out=outs[0].parent,
        facts={
            "sidecars": [str(sidecar.absolute()) for sidecar in sidecars],
            "scene": scene,
            "spec": export_facts(spec),
            "folders": [str(out.absolute()) for out in outs],
            "overwrite": overwrite,
        },
        stages=parts(_EXPORT) if len(set(outs)) == 1 else {EXPORTING: 1.0},
        seconds=_EXPORT_SECONDS * len(set(outs)),
        remedy="export again",
    )


def exported_part(step: ExportStep) -> float:
    """The fraction of one export's time until this step, 0 to 1."""
    shares = parts(_EXPORT)
    before = sum(shares[task] for task in list(ExportTask)[: list(ExportTask).index(step.stage)])
    return before + shares[step.stage] * (step.done / step.total if step.total else 1.0)


def order_comparison(
    handover: Handover,
    names: Sequence[str],
    bake: Path | None,
    eye: Viewpoint,
    spec: ComparisonSpec,
    out: Path,
    sidecars: Sequence[Path | None] = (),
) -> Order:
    """A comparison of objects with their bakes, seen by `eye`; its pictures go to `out`.

    `bake` is the folder of the bakes, or a sidecar; None if all previews are on. `sidecars`: of each object
    that of its bake, None if its preview is on, where the folder alone does not tell them.
    """
    view, window = eye.rows
    return Order(
        work=Work.COMPARISON,
        object=", ".join(dict.fromkeys(names)),
        folder=handover.folder,
        out=out,
        blend=handover.blend,
        facts={
            **_of_scene(handover),
            "objects": list(names),
            "bake": None if bake is None else str(bake.absolute()),
            "sidecars": ["" if one is None else str(one.absolute()) for one in sidecars],
            "view": view,
            "window": window,
            "pixels": spec.pixels,
            "samples": spec.samples,
            "device": handover.device if spec.device == "auto" else spec.device,
            "folder": str(out.absolute()),
        },
        stages=parts(_COMPARISON),
        seconds=float(sum(_COMPARISON.values())),
        remedy="compare again, if memory ran out with fewer pixels",
    )


def order_estimate(handover: Handover, bakes: Sequence[Bake]) -> Order:
    """A measurement of a small part of each of the `bakes`: see `job.probes`."""
    return Order(
        work=Work.ESTIMATE,
        object=", ".join(name for name, _ in bakes),
        folder=handover.folder,
        out=handover.folder,
        blend=handover.blend,
        facts={
            **_of_scene(handover),
            **_of_bakes(bakes, handover.device),
        },
        stages={MEASURING: 1.0},
        remedy="estimate again, if memory ran out with fewer texels, cells or samples",
    )


def order_preparation(
    handover: Handover,
    bakes: Sequence[Bake],
    farm: Path,
    preview: Filter | None = None,
    *,
    overwrite: bool = False,
) -> Order:
    """The folder `farm` of tasks for these bakes, whose files go beside it: see `farm.prepare_tasks`."""
    return Order(
        work=Work.PREPARATION,
        object=", ".join(dict.fromkeys(name for name, _ in bakes)),
        folder=handover.folder,
        out=farm.parent,
        blend=handover.blend,
        facts={
            **_of_scene(handover),
            **_of_bakes(bakes),
            "farm": str(farm.absolute()),
            "folder": str(farm.parent.absolute()),
            "preview": None if preview is None else str(preview),
            "overwrite": overwrite,
            "of_blend": str(handover.original) if handover.original.name else "",
        },
        stages=parts({FarmTask.HOLD: 1}),
        seconds=_PREPARATION_SECONDS,
        remedy="prepare the farm again",
    )


def order_assembly(
    folder: Path,
    farm: Path,
    names: Sequence[str],
    out: Path,
    *,
    overwrite: bool = False,
    overwrite_any: bool = False,
) -> Order:
    """The bakes `names` of the folder `farm` are to be put together, and to go to `out`.

    `folder` is the worker's own.
    """
    return Order(
        work=Work.ASSEMBLY,
        object=", ".join(dict.fromkeys(names)),
        folder=folder,
        out=out,
        facts={
            "farm": str(farm.absolute()),
            "folder": str(out.absolute()),
            "names": list(names),
            "overwrite": overwrite,
            "overwrite_any": overwrite_any,
        },
        stages=parts(_ASSEMBLY),
        seconds=float(sum(_ASSEMBLY.values())) * len(names),
        remedy="assemble the farm again",
    )


def _of_bakes(bakes: Sequence[Bake], device: str = "auto") -> dict[str, Any]:
    """Names and specifications, with the `device` in the place of `auto`."""
    return {
        "names": [name for name, _ in bakes],
        "specs": {str(number): facts_of(_on_device(spec, device)) for number, (_, spec) in enumerate(bakes)},
    }


def _of_scene(handover: Handover) -> dict[str, Any]:
    """The name of the scene, and the folder of unsaved images."""
    images = None if handover.images is None else str(handover.images)
    return {"scene": handover.scene, "images": images}


def _on_device(spec: BakeSpec, device: str) -> BakeSpec:
    """The specification, with the session's device in the place of `auto`."""
    return replace(spec, device=device) if spec.device == "auto" else spec


def _typical(spec: BakeSpec, preview: bool, exports: int) -> Estimate:
    """How long a bake of a usual object takes, on a machine of which nothing is known."""
    work = BakeWork.of(spec, _TRIANGLES, preview=preview, exports=exports, device=spec.device)
    return estimate(work, "", "", ())
