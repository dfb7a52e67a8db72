# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Save the preview of a finished bake: a .blend whose materials show it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Protocol

import bpy
import numpy as np

from ..core.arrays import Ints
from ..core.errors import FormatError
from ..core.near_digest import is_same
from ..core.sampler import Filter
from ..formats.json_reader import Facts
from ..formats.sidecar_file import read_facts
from ..formats.transfer_files import LAYOUT as TRANSFER
from ..formats.transfer_files import TransferSidecar
from ..forms import form_for
from ..forms.form import PreviewOf
from ..prepare.prepared import BakedCopy
from ..preview.save import MATERIAL_PREFIX, StandIn, save_preview
from ..preview.swap import previews_off
from ..scene.image_materials import image_materials, numbers_of_slots
from ..scene.mesh.backs import lift_twins, twin_numbers
from ..scene.mesh.copy import copy_object
from ..scene.mesh.watertight import is_closed
from ..scene.proxy_content import EVERYTHING, find_content
from ..scene.scratch import find_view_layer
from ..settings.spec import BakeSpec
from ..store.output_files import OutputFiles


class PreviewNeeds(Protocol):
    """What a preview needs of a bake: see `Prepared`."""

    @property
    def name(self) -> str: ...

    @property
    def pieces(self) -> tuple[BakedCopy, ...]: ...

    @property
    def uv_layer(self) -> str: ...

    @property
    def digest(self) -> str: ...

    @property
    def parts(self) -> tuple[str, ...]: ...


def save_preview_of(
    scene: bpy.types.Scene,
    spec: BakeSpec,
    files: OutputFiles,
    prepared: PreviewNeeds,
    preview: Filter,
    view_layer: str | None,
) -> None:
    """Write `<name>.preview.blend`, in which the `prepared` objects show their bake.

    A split object shows all parts that have atlases of this kind and layout so far; the other parts keep
    their materials. Other objects whose previews are on are shown themselves. Raises BakeError
    if it cannot be written.
    """
    assert files.preview is not None  # set if there is a filter
    shown = {
        number: _preview_of(title, spec, there, prepared, preview, scene)
        for number, (title, there) in _baked(spec, files, prepared).items()
    }
    form = form_for(spec)
    by_number: dict[int, bpy.types.Material] = {}
    if spec.split is None and spec.source is None:
        sets = image_materials((piece.original, piece.mesh) for piece in prepared.pieces)
        by_number = form.materials(shown[None], sets) if sets else {}
    used = {number for piece in prepared.pieces for number in numbers_of_slots(piece.mesh).values()}
    materials = {number: form.material(of) for number, of in shown.items() if not used <= by_number.keys()}
    stand_ins = []
    for piece, name in zip(prepared.pieces, spec.objects or (prepared.name,), strict=True):
        slots: tuple[bpy.types.Material | None, ...] = (materials.get(None),)
        if by_number:
            slots = _own_slots(piece.mesh, by_number, materials.get(None))
        if piece.part is not None:
            slots = tuple(materials.get(number, own) for number, own in _slots(piece.mesh, piece.part))
        if piece.single is not None:
            lift_twins(piece.mesh)
        original = scene.objects[name]
        stand_ins.append(StandIn(original, copy_object(original, piece.mesh), slots))
    hidden: tuple[bpy.types.Object, ...] = ()
    if spec.kind.traits.content and spec.content != EVERYTHING:
        hull = scene.objects[prepared.name]
        hidden = find_content(find_view_layer(scene, view_layer), hull, spec.content)
    if spec.source is not None:
        hidden = (scene.objects[spec.source],)
    with previews_off(scene):
        save_preview(scene, stand_ins, files.preview.absolute(), hidden)


def _baked(
    spec: BakeSpec, files: OutputFiles, prepared: PreviewNeeds
) -> dict[int | None, tuple[str, OutputFiles]]:
    """Material name and files of each baked part, by its number; None is the number if nothing is split."""
    title = f"{MATERIAL_PREFIX}{prepared.name}"
    if spec.split is None:
        return {None: (title, files)}
    found: dict[int | None, tuple[str, OutputFiles]] = {}
    own = _reading(read_facts(files.sidecar))
    for number, part in enumerate(prepared.parts):
        there = OutputFiles.of(prepared.name, replace(spec, part=part), files.sidecar.parent, preview=True)
        if part == spec.part or _is_of(there.sidecar, prepared, own):
            found[number] = (f"{title} {part}", there)
    return found


def _is_of(sidecar: Path, prepared: PreviewNeeds, reading: tuple[str, int]) -> bool:
    """Whether the file is the sidecar of a bake of the same mesh that is read in the same way."""
    try:
        facts = read_facts(sidecar)
        return is_same(facts.text("mesh"), prepared.digest) and _reading(facts) == reading
    except FormatError:
        return False


def _reading(facts: Facts) -> tuple[str, int]:
    """How a bake is read: its layout, and the views along a bucket's side. Raises FormatError."""
    layout = facts.text("layout")
    return layout, TransferSidecar.from_facts(facts).views if layout == TRANSFER else 1


def _slots(mesh: bpy.types.Mesh, part: Ints) -> list[tuple[int, bpy.types.Material | None]]:
    """Give a mesh a slot for each part and material; returns, for each, the part's number and the material.

    `part` (F,) numbers the parts of the triangles.
    """
    index = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("material_index", index)
    pairs, slot = np.unique(np.stack([part, index], axis=1), axis=0, return_inverse=True)
    own = [*mesh.materials] or [None]
    found = [(int(number), own[min(place, len(own) - 1)]) for number, place in pairs]
    mesh.materials.clear()
    for _, material in found:
        mesh.materials.append(material)
    mesh.polygons.foreach_set("material_index", np.ascontiguousarray(slot.reshape(-1), dtype=np.int32))
    return found


def _own_slots(
    mesh: bpy.types.Mesh, own: Mapping[int, bpy.types.Material], other: bpy.types.Material | None
) -> tuple[bpy.types.Material | None, ...]:
    """The materials of a mesh's slots: their `own`, by number, or the `other`."""
    numbers = numbers_of_slots(mesh)
    count = max(len(mesh.materials), 1)
    return tuple(own.get(numbers.get(slot, -1), other) for slot in range(count))


def _preview_of(
    title: str,
    spec: BakeSpec,
    files: OutputFiles,
    prepared: PreviewNeeds,
    preview: Filter,
    scene: bpy.types.Scene,
) -> PreviewOf:
    clear = spec.kind.traits.looks_at_surface and scene.render.film_transparent
    closed = clear and all(is_closed(piece.mesh) for piece in prepared.pieces)
    # backs are faces of their own, or clear
    doubled = any(twin_numbers(piece.mesh) is not None for piece in prepared.pieces)
    hull = spec.kind.traits.content or closed or doubled  # only fronts are shown
    sidecar = files.sidecar.absolute()
    return PreviewOf(title, spec, sidecar, prepared.uv_layer, scene, preview, hull)
