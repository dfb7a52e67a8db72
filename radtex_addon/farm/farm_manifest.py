# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The manifest of a farm: what its frames show, and the bake that they are assembled to."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np

from ..bake.hidden_cells import HiddenCells
from ..bake.plan import CapturePlan
from ..core.atlas import AtlasLayout
from ..core.errors import FormatError, InputError
from ..core.messages import Setting, do, leave_out
from ..core.sampler import Filter
from ..formats.containers.numpy_files import read_npz
from ..formats.disk.memory import check_memory
from ..formats.disk.regular import digest
from ..formats.json_reader import Facts, json_text
from ..formats.sidecar import Sidecar
from ..formats.sidecar_file import read_text
from ..settings.kinds import KINDS
from ..settings.options import OPTIONS
from ..settings.spec import BakeSpec, CaptureMethod, Layout, as_json, facts_of, impossible, spec_in
from ..store import checkpoint_files
from .farm_files import FarmFiles
from .self_contained import Carried

VERSION = 1
_WHAT = "farm's manifest"
MOST_FRAMES = 1048574  # of an animation in Blender


@dataclass(frozen=True)
class Copies:
    """The baked copies in the preview's file: names of objects and meshes; all `parts` of the object."""

    objects: tuple[str, ...]
    meshes: tuple[str, ...]
    scene: str
    view_layer: str | None
    parts: tuple[str, ...]
    filter: Filter


@dataclass(frozen=True)
class FarmManifest:
    """One farm: frames 1 to `sheets` of the `job` are sheets of `columns` x `sheet_rows` buckets.

    The plan has `rows` rows of buckets; sheets have about `sheet_side`² pixels. `facts` are the atlas's,
    without `clamped` and `layers`. `digests` are of the files in the folder that assembling reads. `carried`
    lists the files of the preparing machine that are in the folder: for people, assembling ignores it.
    """

    job: str
    name: str
    spec: BakeSpec
    facts: Sidecar
    sheets: int
    columns: int
    rows: int
    sheet_rows: int
    sheet_side: int
    device: str
    islands: int | None
    digests: dict[str, str]
    copies: Copies | None = None
    carried: tuple[Carried, ...] = ()

    @property
    def note(self) -> str:
        """The text in the header of every frame."""
        return f"RadTex job {self.job}"

    @property
    def bucket(self) -> int:
        return self.spec.bucket

    @property
    def pixels(self) -> tuple[int, int]:
        """A frame's height and width."""
        return self.sheet_rows * self.bucket, self.columns * self.bucket

    def to_json(self) -> str:
        """The manifest's text."""
        copies = self.copies
        return json_text(
            {
                "version": VERSION,
                "pieces": checkpoint_files.PIECE_FORMAT,
                "job": self.job,
                "name": self.name,
                "frames": [1, self.sheets],
                "sheet": [self.columns, self.sheet_rows],
                "rows": self.rows,
                "sheet_side": self.sheet_side,
                "device": self.device,
                "islands": self.islands,
                "spec": facts_of(self.spec),
                "sidecar": self.facts.facts(),
                "digests": self.digests,
                "preview": None
                if copies is None
                else {field.name: as_json(getattr(copies, field.name)) for field in fields(Copies)},
                "carried": [asdict(each) for each in self.carried],
            }
        )


def _check_frames_format(files: FarmFiles, facts: Facts) -> None:
    """Raises FormatError for a farm whose frames hold other rays than this program's, or in another order."""
    found = facts.whole_number("pieces", 1)
    if found != checkpoint_files.PIECE_FORMAT:
        raise FormatError(
            f"the frames of {files.folder} are of format {found}, this RadTex joins those of format "
            f"{checkpoint_files.PIECE_FORMAT}: assemble with the RadTex that prepared it, or prepare it anew"
        )


def read_manifest(files: FarmFiles) -> FarmManifest:
    """Read a farm's manifest.

    Raises InputError if there is none, FormatError for a file that is no manifest, or of another version.
    """
    if not files.manifest.is_file():
        raise InputError(f"{files.folder} holds no farm: name the folder that bake.py prepare wrote")
    facts = Facts.parse(read_text(files.manifest), str(files.manifest), _WHAT)
    version = facts.whole_number("version", 1)
    if version != VERSION:
        raise FormatError(
            f"{files.manifest} is of version {version}, this RadTex reads {VERSION}: assemble with "
            "the RadTex that prepared it"
        )
    _check_frames_format(files, facts)
    columns, sheet_rows = facts.size("sheet")
    _, sheets = facts.size("frames")
    preview = None if facts.values.get("preview") is None else facts.inner("preview")
    made = FarmManifest(
        job=facts.text("job"),
        name=facts.text("name"),
        spec=_spec(facts.inner("spec")),
        facts=Sidecar.from_facts(facts.inner("sidecar")),
        sheets=sheets,
        columns=columns,
        rows=facts.whole_number("rows", 1),
        sheet_rows=sheet_rows,
        sheet_side=facts.whole_number("sheet_side", 1),
        device=facts.text("device"),
        islands=None if facts.values.get("islands") is None else facts.whole_number("islands", 0),
        digests={key: facts.inner("digests").text(key) for key in facts.inner("digests").values},
        copies=None if preview is None else _copies(preview),
    )
    if not _is_possible(made):
        raise FormatError(f"{files.manifest} tells of sheets that no bake has: prepare the farm anew")
    if not _is_whole(made, files):
        raise FormatError(f"{files.manifest} tells of a farm that no bake has: prepare it anew")
    return made


def _is_possible(made: FarmManifest) -> bool:
    facts, texels = made.facts, made.spec.texels
    fits = max(facts.width, facts.height) <= texels and facts.bucket == made.spec.bucket
    filled = (made.rows - 1) * made.columns < facts.width * facts.height
    divided = made.sheets == -(-made.rows // made.sheet_rows) and made.sheets <= MOST_FRAMES
    return fits and filled and divided


def _is_whole(made: FarmManifest, files: FarmFiles) -> bool:
    """Whether the files that it names are those that such a farm has."""
    spec, copies = made.spec, made.copies
    needed = {files.plan.name}
    if copies is not None:
        needed.add(files.preview.name)
        if spec.split is not None:
            needed.add(files.parts.name)
        if copies.objects != (spec.objects or (made.name,)) or len(copies.meshes) != len(copies.objects):
            return False
    return set(made.digests) == needed and made.facts.kind == spec.kind


def check_files(files: FarmFiles, manifest: FarmManifest) -> None:
    """Raises FormatError if a file that assembling needs is missing or was changed."""
    for name, known in manifest.digests.items():
        path = files.folder / name
        if not path.is_file() or digest(path) != known:
            lost = "is missing" if not path.is_file() else "is damaged"
            raise FormatError(f"{path} {lost}: copy it from where the farm was prepared, or prepare it anew")


def write_plan(path: Path, plan: CapturePlan, hidden: HiddenCells | None) -> None:
    """Write what assembling needs of a plan, normals for the denoiser included, and its `hidden` cells."""
    bits = np.zeros((0, 0), dtype=np.uint8) if hidden is None else hidden.bits
    normal = plan.normals.astype(np.float32)
    np.savez_compressed(path, texel=plan.texel, normal=normal, hidden=bits)


def read_plan(files: FarmFiles, manifest: FarmManifest) -> tuple[CapturePlan, HiddenCells | None]:
    """The plan of a farm and its hidden cells; of its rays, which were traced already, it has normals alone.

    Raises FormatError for a file that is damaged or of another farm.
    """
    n, count = manifest.bucket, manifest.facts.width * manifest.facts.height
    row = -(-n * n // 8)  # bytes of a texel's hidden cells
    check_memory(str(files.plan), count * (row + 8 + 12))
    wanted = {"texel": "iu", "normal": "f", "hidden": "u"}
    found = read_npz(files.plan, wanted, count * max(row, 12))
    texel, normal, bits = found["texel"], found["normal"], found["hidden"]
    least, most = (manifest.rows - 1) * manifest.columns, manifest.rows * manifest.columns
    ascends = texel.ndim == 1 and least < len(texel) <= most and bool((texel[1:] > texel[:-1]).all())
    if not ascends or texel[0] < 0 or texel[-1] >= count or texel.dtype.itemsize > 8:
        raise FormatError(f"{files.plan} tells of texels that the atlas has not: prepare the farm anew")
    if bits.dtype != np.uint8 or bits.shape not in ((0, 0), (len(texel), row)):
        raise FormatError(f"{files.plan} tells of hidden cells that the atlas has not: prepare the farm anew")
    if normal.dtype != np.float32 or normal.shape != (len(texel), 3) or not np.isfinite(normal).all():
        raise FormatError(f"{files.plan} tells of normals that no surface has: prepare the farm anew")
    texel = texel.astype(np.int64)
    filled = np.minimum(np.arange(manifest.rows * manifest.columns), len(texel) - 1)
    normal = normal[filled].reshape(manifest.rows, manifest.columns, 3)
    nowhere = np.broadcast_to(np.float32(0), (manifest.rows, manifest.columns, 3))
    layout = AtlasLayout(manifest.facts.width, manifest.facts.height, n)
    fields = (nowhere, nowhere, nowhere, normal, nowhere)
    plan = CapturePlan(layout, texel, *fields, sheet=manifest.sheet_side)
    if (plan.sheets, plan.sheet_rows) != (manifest.sheets, manifest.sheet_rows):
        raise FormatError(f"{files.manifest} tells of other sheets than this RadTex makes: prepare it anew")
    return plan, HiddenCells(bits, n) if len(bits) else None


def _spec(facts: Facts) -> BakeSpec:
    spec = spec_in(facts)
    try:
        check_farmable(spec)
    except InputError as error:
        raise impossible(facts, error) from error
    return spec


def _copies(facts: Facts) -> Copies:
    layer = facts.values.get("view_layer")
    return Copies(
        objects=facts.texts("objects"),
        meshes=facts.texts("meshes"),
        scene=facts.text("scene"),
        view_layer=None if layer is None else facts.text("view_layer"),
        parts=facts.texts("parts"),
        filter=Filter(facts.choice("filter", tuple(Filter))),
    )


def check_frame_count(count: int) -> None:
    """Raises InputError for more frames than an animation in Blender, and so a manifest, can have."""
    if count > MOST_FRAMES:
        raise InputError(
            f"the farm would have {count} frames, Blender has {MOST_FRAMES} at most",
            do("take larger pictures", Setting.SHEET),
        )


def renders_as_frames(spec: BakeSpec) -> bool:
    """Whether machines without RadTex can render a bake, as frames of a .blend."""
    try:
        check_farmable(spec)
    except InputError:
        return False
    return True


def check_farmable(spec: BakeSpec) -> None:
    """Raises InputError, with what to do instead, for a specification that frames cannot bake."""
    if not spec.kind.traits.farm:
        fit = ", ".join(kind for kind, traits in KINDS.items() if traits.farm)
        raise InputError(
            f"frames for machines without RadTex are of {fit}, not {spec.kind}: "
            "that takes machines with RadTex"
        )
    if not spec.form.farm:
        raise InputError(
            f"frames that hold a whole bake are of layout {Layout.BUCKETS}, not {spec.layout}, "
            "whose captures build on one another: prepare tasks, with frames for most of their paths"
        )
    if spec.incremental:
        raise InputError(
            "a farm bakes anew", leave_out(Setting.ACCUMULATE, Setting.REFRESH), do("bake without a farm")
        )
    for name, option in OPTIONS.items():
        if option.no_farm and getattr(spec, name) != option.default:
            raise InputError(option.no_farm, leave_out(option.called), do("bake without a farm"))
    if spec.capture is not CaptureMethod.PORTAL:
        raise InputError("a farm's frames are taken by the portal", leave_out(Setting.CAPTURE))
