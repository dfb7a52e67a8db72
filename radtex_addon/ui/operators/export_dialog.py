# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the export dialog shows: the bakes, the folders to make, what is in the way, and the settings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from ...bake.bake_title import bake_title, variant_title
from ...settings.menu_items import KINDS
from ...settings.targets import Target
from ..panel.fitting import draw_wrapped
from ..panel.labels import iface_, remark, size

if TYPE_CHECKING:
    from ...core.messages import Message
    from ...export.exporting import ExportSource
    from ...textures.export_spec import ExportSpec

WIDTH = 440  # of the dialog, in pixels at UI scale 1
_ROOM = WIDTH - 60.0  # for text: without margins and icon
_KTX2 = "ktx2"
_NAMED = 3  # objects whose names are shown; of more the number
_KINDS = {identifier: name for identifier, name, _ in KINDS}


@dataclass(frozen=True)
class Plan:
    """What pressing OK would do with the current settings.

    `outs` are the folders that the bakes go to, only one if they are one scene, `existing` those of them that
    an earlier export wrote. `errors` would be met even if these were overwritten; `texture_bytes` is rough,
    None if unknown.
    """

    sources: tuple[ExportSource, ...]
    outs: tuple[Path, ...]
    existing: tuple[Path, ...] = ()
    errors: tuple[Message, ...] = ()
    texture_bytes: float | None = None


def planned(
    sources: Sequence[ExportSource], spec: ExportSpec, outs: tuple[Path, ...], scene: bool = False
) -> Plan:
    """The plan for an export with valid settings into the folders `outs`, one for each bake.

    One folder if all are exported as one `scene`.
    """
    from ...export.exporting import about_texture_bytes, check_export, check_folders_differ
    from ...export.exporting_scene import check_scene
    from ...export.folder import is_export

    if scene:
        errors = _errors_of([partial(check_scene, sources, spec, outs[0], overwrite=True)])
    else:
        checks = [
            partial(check_export, source, spec, out, overwrite=True)
            for source, out in zip(sources, outs, strict=True)
        ]
        errors = _errors_of([partial(check_folders_differ, outs), *checks])
    return Plan(
        sources=tuple(sources),
        outs=outs,
        existing=tuple(out for out in outs if is_export(out)),
        errors=tuple(dict.fromkeys(errors)),
        texture_bytes=sum(about_texture_bytes(source, spec) for source in sources),
    )


def _errors_of(checks: Iterable[Callable[[], object]]) -> list[Message]:
    """The errors that these checks raise."""
    from ...core.errors import RadTexError

    errors = []
    for check in checks:
        try:
            check()
        except RadTexError as error:
            errors.append(error.message)
    return errors


def applicable(
    sources: Sequence[ExportSource], target: str, form: str, scene: bool = False
) -> frozenset[str]:
    """The names of the settings that all these bakes take, for this target and this format.

    `scene` is whether they are exported as one scene.
    """
    from ...settings.kinds import KINDS as TABLE

    traits, names = Target(target).traits, {"limit"}
    forms = [source.form.traits for source in sources]
    if not any(form.bits for form in forms):
        names.add("format")
    takes_ktx2 = any(taken.startswith(_KTX2) for taken in traits.formats)
    if takes_ktx2 and (form == "auto" or form.startswith(_KTX2)):
        names.add("zstd")
    if len(traits.meshes) > 1:
        names.add("mesh")
    if all(form.arranges for form in forms):
        names |= {"arrangement", "levels"}
    mirrored = {kind for kind, row in TABLE.items() if row.looks_at_surface}
    if not scene and traits.mirror and all(source.bake.kind in mirrored for source in sources):
        names.add("mirror")
    return frozenset(names)


def dialog_title(sources: Sequence[ExportSource]) -> str:
    """The title: what is exported."""
    if len(sources) == 1:
        return iface_("Export Bake of {}").format(_title_of(sources[0]))
    return iface_("Export {} Bakes").format(len(sources))


def told_bakes(sources: Sequence[ExportSource]) -> list[str]:
    """Lines on what is exported: kind, texels, folder, and when it was baked."""
    folders = sorted({shortened(source.sidecar.path.parent) for source in sources})
    if len(sources) > 1:
        names = ", ".join(_title_of(source) for source in sources[:_NAMED])
        more = iface_(" and {} more").format(len(sources) - _NAMED) if len(sources) > _NAMED else ""
        return [f"{names}{more}", iface_("Baked in {}").format(", ".join(folders))]
    bake = sources[0].bake
    kind = iface_(_KINDS.get(bake.kind, bake.kind))
    lines = [iface_("{}, {} x {} texels").format(kind, bake.width, bake.height)]
    when = _baked_at(sources[0].sidecar.path)
    lines.append(iface_("Baked {} in {}").format(when, folders[0]))
    return lines


def told_folders(plan: Plan) -> list[str]:
    """Lines on what is made, and on what is there already."""
    if len(plan.outs) == 1:
        out = plan.outs[0]
        return [iface_("Makes the folder {} in {}").format(out.name, shortened(out.parent))]
    names = ", ".join(out.name for out in plan.outs[:_NAMED])
    more = ", …" if len(plan.outs) > _NAMED else ""
    homes = ", ".join(sorted({shortened(out.parent) for out in plan.outs}))
    return [iface_("Makes {} folders in {}: {}").format(len(plan.outs), homes, names + more)]


def told_existing(plan: Plan, overwrite: bool) -> str:
    """A line on the earlier exports in these folders; empty if there are none."""
    found, all_of_them = len(plan.existing), len(plan.outs)
    if not found:
        return ""
    there = iface_("It is there already")
    if all_of_them > 1:
        there = iface_("{} of {} are there already").format(found, all_of_them)
    if overwrite:
        return iface_("{}: will be replaced. Files that no export wrote stay").format(there)
    if all_of_them > 1:
        return iface_("{}: tick Overwrite to replace them").format(there)
    return iface_("{}: tick Overwrite to replace it, or choose another folder").format(there)


def draw_dialog(layout: Any, settings: Any, plan: Plan) -> None:
    """Draw the dialog; `settings` is the operator."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    for number, line in enumerate(told_bakes(plan.sources)):
        _draw_text(layout, line, "TEXTURE" if number == 0 else "BLANK1")
    layout.separator()
    layout.prop(settings, "target")
    _draw_text(layout, iface_(Target(settings.target).traits.next_step), "BLANK1")
    several = len(plan.sources) > 1
    if several:
        layout.prop(settings, "as_scene")
    if several and settings.as_scene:
        layout.prop(settings, "scene_name")
    layout.prop(settings, "into")
    for line in told_folders(plan):
        _draw_text(layout, line, "FILE_FOLDER")
    if existing := told_existing(plan, settings.overwrite):
        _draw_text(layout, existing, "FILE_REFRESH" if settings.overwrite else "ERROR")
        layout.prop(settings, "overwrite")
    layout.prop(settings, "again")
    if plan.texture_bytes is not None:
        _draw_text(layout, iface_("Textures of roughly {}").format(size(plan.texture_bytes)), "BLANK1")
    for message in plan.errors:
        _draw_text(layout, remark(message), "ERROR")
    shown = applicable(plan.sources, settings.target, settings.format, several and settings.as_scene)
    if "mirror" in shown:
        layout.prop(settings, "mirror")
    _draw_advanced(layout, settings, shown)


def _draw_advanced(layout: Any, settings: Any, shown: frozenset[str]) -> None:
    """Draw how textures are stored, folded away below an arrow."""
    row = layout.row()
    row.use_property_split = False
    row.alignment = "LEFT"
    icon = "DOWNARROW_HLT" if settings.advanced else "RIGHTARROW"
    row.prop(settings, "advanced", icon=icon, emboss=False)
    if settings.advanced:
        column = layout.column()
        for name in ("format", "zstd", "arrangement", "levels", "limit", "mesh"):
            if name in shown:
                column.prop(settings, name)


def _draw_text(layout: Any, text: str, icon: str) -> None:
    draw_wrapped(layout, text, icon, _ROOM)


def shortened(path: Path) -> str:
    """A path relative to the open .blend, as Blender writes it, or to the user's home; else whole."""
    roots = [("//", Path(bpy.data.filepath).parent)] if bpy.data.filepath else []
    for sign, root in (*roots, ("~/", Path.home())):
        if path.is_relative_to(root):
            rest = path.relative_to(root).as_posix()
            return sign if rest == "." else f"{sign}{rest}"
    return str(path)


def _title_of(source: ExportSource) -> str:
    """The title of a finished bake."""
    bake = source.bake
    part = "" if bake.part is None else bake.part.name
    return bake_title(
        bake.called or bake.object_name, part=part, variant=variant_title(bake.frame, bake.lights)
    )


def _baked_at(sidecar: Path) -> str:
    try:
        when = datetime.fromtimestamp(sidecar.stat().st_mtime).astimezone()
    except OSError:  # it is gone meanwhile
        return ""
    return f"{when:%d %b %Y, %H:%M},"
