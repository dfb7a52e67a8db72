# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the exports again that the scene keeps, once the bakes that were asked for together have ended."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...textures.kept_exports import KeptExport, kept_exports, real

if TYPE_CHECKING:
    import bpy

    from ...export.exporting import Exported
    from ...job.bake_plan import BakePlan
    from ...textures.export_spec import ExportSpec
    from ...worker.order import Order


@dataclass(eq=False)
class RepeatedExports:
    """The exports that are `kept` for bakes that were asked for together.

    `made` has the names of the objects whose bakes are done, by the files of these.
    """

    kept: tuple[KeptExport, ...]
    made: dict[Path, str] = field(default_factory=dict)

    @classmethod
    def of(cls, scene: bpy.types.Scene, plans: Sequence[BakePlan]) -> RepeatedExports | None:
        """Those that the scene keeps of the bakes in these plans; None if there are none.

        Raises InputError for a bake without the preview that its export is made from.
        """
        from ...core.errors import InputError
        from ...core.messages import Setting, do
        from ...job.variants import title_of

        every = kept_exports(scene)
        known = {real(path) for export in every for path in export.sidecars}
        asked: set[Path] = set()
        for plan in plans if known else ():
            for bake in plan.wanted:
                sidecar = real(plan.request.place(bake).files.sidecar)
                if sidecar in known and not plan.request.saves_preview:
                    raise InputError(
                        f"'{title_of(*bake)}' is exported after each bake, from its preview",
                        do("switch Preview on", Setting.SAVE_PREVIEW),
                        do("take that export off the list in Output"),
                    )
                asked.add(sidecar)
        kept = tuple(export for export in every if export.is_of(asked))
        return cls(kept) if kept else None

    @classmethod
    def of_facts(cls, facts: Mapping[str, Any]) -> RepeatedExports:
        """What `facts` told to an earlier session. Exports whose settings cannot be read are left out."""
        kept = (KeptExport.of(row) for row in facts.get("kept", ()))
        made = {Path(path): str(name) for path, name in facts.get("made", {}).items()}
        return cls(tuple(each for each in kept if each is not None), made)

    def facts(self) -> dict[str, Any]:
        """The exports and the bakes that were made, in JSON's types, for a session after this one."""
        made = {str(path): name for path, name in self.made.items()}
        return {"kept": [each.row() for each in self.kept], "made": made}

    def note(self, name: str, files: Sequence[Path]) -> None:
        """A bake of the object `name` is done, and made these files."""
        self.made |= dict.fromkeys(map(real, files), name)

    @property
    def due(self) -> tuple[KeptExport, ...]:
        """Those of which a bake was made."""
        return tuple(each for each in self.kept if each.is_of(self.made.keys()))

    def orders(self, cache: Path | None) -> list[Order]:
        """Orders for the exports that are due.

        Single bakes with the same settings in the same folder are one order, each scene is one. Raises
        BakeError if no work folder can be made below `cache`.
        """
        from ...worker.handover import work_folder
        from ...worker.orders import order_export, order_scene_export

        due = self.due
        folder = work_folder(cache) if due else Path()
        alike: dict[tuple[ExportSpec, Path], list[tuple[str, Path, Path]]] = {}
        orders = []
        for each in due:
            if each.scene is not None:
                orders.append(
                    order_scene_export(folder, each.sidecars, each.scene, each.spec, each.out, overwrite=True)
                )
            else:
                (sidecar,) = each.sidecars
                place = self.made[real(sidecar)], sidecar, each.out
                alike.setdefault((each.spec, each.out.parent), []).append(place)
        singles = (order_export(folder, group, spec, overwrite=True) for (spec, _), group in alike.items())
        return [*singles, *orders]

    def export_here(self) -> Iterator[Exported]:
        """Make the exports that are due in this process, and yield each. Raises RadTexError."""
        from ...bake.progress import finished
        from ...export.exporting_scene import export_again_steps

        for each in self.due:
            yield finished(export_again_steps(each))
