# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of a bake: their names, what a finished bake came to, and how it is deleted."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

from ..core.atlas import AtlasLayout
from ..core.errors import BakeError, FormatError, InputError, ShapeError
from ..core.messages import Setting, do
from ..export.exporting import ExportSource, earlier_manifest
from ..export.folder import remove_export
from ..formats.image_files import layer_path
from ..formats.json_reader import Facts
from ..formats.sidecar import Sidecar, file_name, part_in, preview_path
from ..formats.sidecar_file import read_facts
from ..forms import form_for
from ..forms.layered.files.arrangement import CHANNELS as LAYERED
from ..forms.outcome import Outcome
from ..settings.bake_names import filled
from ..settings.spec import BakeSpec, Layer
from ..textures.export_spec import Target
from .checkpoint_files import ANEW, is_unfinished

_UNFINISHED = ".radtex-unfinished"
_FORMER = (  # of the layouts that this RadTex no longer reads
    "surroundings",
    *(
        f"{lobe}_{part}"
        for lobe in ("mirror", "through")
        for part in ("weights", "ends", "ends_xy", "ends_zs", "gain", "rest")
    ),
)
_LAYERS = frozenset((*Layer, *LAYERED, *_FORMER))


@dataclass(frozen=True)
class OutputFiles:
    """The paths of a bake's files; `preview` is None if none is wanted.

    `images` are all images that a bake of the specification's form can write. `preview_is_own` is False if
    the parts of an object share one preview.
    """

    images: tuple[Path, ...]
    sidecar: Path
    preview: Path | None
    preview_is_own: bool = True

    @classmethod
    def of(cls, object_name: str, spec: BakeSpec, folder: Path, preview: bool = False) -> OutputFiles:
        """The files of a bake in `folder`, named as in docs/format.md, plus its frame and lamps.

        All parts of an object share one preview. Raises InputError if a token of the name is not known yet.
        """
        object_name = filled(spec.bake_name, object_name)
        if spec.frame is not None:
            object_name = f"{object_name}-{spec.frame:04d}"
        if spec.lights:
            object_name = f"{object_name}-{'+'.join(spec.lights)}"
        sidecar = folder / file_name(object_name, spec.kind, "json", part=spec.part)
        images = form_for(spec).images(spec, sidecar)
        shown = folder / file_name(object_name, "preview", "blend", part=spec.split)
        return cls(images, sidecar, shown if preview else None, spec.split is None)

    @property
    def unfinished(self) -> Path:
        """The folder of the checkpoint while the bake is unfinished: `<name>.<kind>.radtex-unfinished`."""
        return self.sidecar.with_suffix(_UNFINISHED)

    def export(self, target: str) -> Path:
        """The default folder of this bake's export for `target`: `<name>.<target>`."""
        return self.sidecar.with_suffix("").with_suffix(f".{target}")

    @property
    def atlas(self) -> Path:
        """The image of the plain layout, or the first one of the layered layout."""
        return self.images[0]

    @property
    def own(self) -> tuple[Path, ...]:
        """The files that only this bake writes: all, except for a preview that parts share."""
        return self.all if self.preview_is_own else (*self.images, self.sidecar)

    @property
    def all(self) -> tuple[Path, ...]:
        return (*self.images, self.sidecar, *((self.preview,) if self.preview else ()))


@dataclass(frozen=True)
class BakeOutput:
    """The result of a bake: its `files` on disk, and what it cost; `paths` are camera paths.

    Its UV layer has so many `islands`, which cover a share of it, the `coverage`; `wasteful` says why the map
    wastes its atlas, empty if it does not. `density` is the texels per metre that it has, if its size follows
    from a density.
    """

    files: OutputFiles
    layout: AtlasLayout
    covered_texels: int
    paths: int
    clamped: int
    device: str = ""
    islands: int | None = None
    density: float | None = None
    coverage: float | None = None
    wasteful: str = ""

    @classmethod
    def by(cls, outcome: Outcome, files: OutputFiles, device: str, facts: Sidecar) -> BakeOutput:
        """From a form's `outcome`, which says which of the images in `files` were written."""
        density = facts.texel_density
        return cls(
            files=replace(files, images=outcome.images),
            layout=outcome.layout,
            covered_texels=outcome.covered_texels,
            paths=outcome.paths,
            clamped=outcome.clamped,
            device=device,
            islands=facts.islands,
            density=None if density is None else density.reached,
            coverage=facts.coverage,
            wasteful=facts.wasteful,
        )

    @property
    def outcome(self) -> Outcome:
        """The result of the form's bake alone."""
        return Outcome(self.files.images, self.layout, self.covered_texels, self.paths, self.clamped)

    def told(self, earlier: Collection[Path] = ()) -> dict[str, Any]:
        """The result as JSON values: of `files` and the `earlier` bake's images only the names."""
        names = {
            "replaced": sorted(path.name for path in earlier),
            "images": [path.name for path in self.files.images],
        }
        values = {one.name: getattr(self, one.name) for one in fields(BakeOutput)[1:]}
        return names | values | {"layout": asdict(self.layout)}

    @classmethod
    def of(cls, told: Mapping[str, Any], files: OutputFiles) -> BakeOutput:
        """Inverse of `told`, for a bake with these `files`. Raises InputError for malformed values."""
        try:
            layout = told["layout"]
            return cls(
                files=replace(files, images=tuple(files.sidecar.with_name(name) for name in told["images"])),
                layout=AtlasLayout(int(layout["width"]), int(layout["height"]), int(layout["bucket"])),
                covered_texels=int(told["covered_texels"]),
                paths=int(told["paths"]),
                clamped=int(told["clamped"]),
                device=str(told["device"]),
                islands=None if told["islands"] is None else int(told["islands"]),
                density=None if told.get("density") is None else float(told["density"]),
                coverage=None if told.get("coverage") is None else float(told["coverage"]),
                wasteful=str(told.get("wasteful", "")),
            )
        except (IndexError, KeyError, TypeError, ValueError, ShapeError) as error:
            raise InputError(f"{files.unfinished} is damaged", ANEW) from error

    @classmethod
    def known(cls, files: OutputFiles) -> BakeOutput:
        """The result of a bake that was finished earlier, by its sidecar; paths and covered texels are 0.

        Raises FormatError as `read_facts` does.
        """
        facts = read_facts(files.sidecar)
        return cls(
            files=replace(files, images=tuple(path for path in files.images if path.is_file())),
            layout=AtlasLayout(*facts.size("texels"), facts.whole_number("bucket", 1)),
            covered_texels=0,
            paths=0,
            clamped=facts.whole_number("clamped", 0),
            islands=facts.whole_number("islands", 0) if "islands" in facts.values else None,
            coverage=facts.number("coverage") if "coverage" in facts.values else None,
            wasteful=facts.text("wasteful") if "wasteful" in facts.values else "",
        )


def earlier_images(told: Mapping[str, Any], files: OutputFiles) -> frozenset[Path]:
    """The earlier bake's images in what `BakeOutput.told`, to be deleted once all files are in their places.

    Names that no image of this bake could have are ignored.
    """
    names = told.get("replaced")
    stem = f"{files.sidecar.stem}."
    return frozenset(
        files.sidecar.with_name(name)
        for name in (names if isinstance(names, list) else ())
        if isinstance(name, str) and name.startswith(stem) and not {"/", "\\", "\0"} & set(name)
    )


def images_of(sidecar: Path) -> frozenset[Path]:
    """The images that the existing bake with this sidecar may have; none if it cannot be read.

    Layers in the sidecar that RadTex does not write are ignored.
    """
    try:
        layers = set(read_facts(sidecar).texts("layers")) & _LAYERS
    except FormatError:
        return frozenset()
    named = (layer_path(sidecar, layer) for layer in layers)
    textures = (sidecar.with_name(f"{sidecar.stem}.{layer}.dds") for layer in layers)  # of former layouts
    return frozenset((sidecar.with_suffix(".exr"), *named, *textures))


@dataclass(frozen=True)
class BakeFiles:
    """What there is of a bake: `sidecar`, images and preview, and the folders of its `exports` beside it."""

    sidecar: Path
    files: tuple[Path, ...]
    exports: tuple[Path, ...]

    @property
    def all(self) -> tuple[Path, ...]:
        """All of them, the sidecar first."""
        return (self.sidecar, *self.files, *self.exports)


def files_of_bakes(bakes: Iterable[ExportSource]) -> list[BakeFiles]:
    """What there is of each bake. A preview that is also that of a bake which stays is left out.

    Raises InputError for a bake that is not finished.
    """
    sources = {source.sidecar.path: source for source in bakes}
    found = []
    for sidecar, source in sources.items():
        if is_unfinished(sidecar.with_suffix(_UNFINISHED)):
            raise InputError(
                f"the bake of '{source.bake.object_name}' is not finished",
                do("go on with it", Setting.RESUME),
                do("bake it anew", Setting.OVERWRITE),
            )
        files = sorted(path for path in images_of(sidecar) if path.is_file())
        others = others_with_preview(sidecar, source.preview).keys() - sources.keys()
        if source.preview.is_file() and not others:
            files.append(source.preview)
        folders = (source.folder(target) for target in Target)
        exports = tuple(folder for folder in folders if _is_export_of(source, folder))
        found.append(BakeFiles(sidecar, tuple(files), exports))
    return found


def delete_bake(files: BakeFiles) -> list[Path]:
    """Delete a bake. The sidecar goes first: what is left after an interruption is no bake any more.

    Files in the exports' folders that no export wrote stay, and those that were changed after the export,
    which are returned. Raises BakeError where the system refuses.
    """
    try:
        for path in (files.sidecar, *files.files):
            path.unlink(missing_ok=True)
        return [path for folder in files.exports for path in remove_export(folder)]
    except OSError as error:
        raise BakeError(
            f"{error.filename} cannot be deleted ({error.strerror}): close what uses it, and try again"
        ) from error


def others_with_preview(sidecar: Path, preview: Path) -> dict[Path, Facts | None]:
    """The other bakes whose preview is the same file, which are parts and other kinds, by their sidecars.

    A file of such a name that cannot be read is among them, without facts: it may be of a newer RadTex.
    """
    found: dict[Path, Facts | None] = {}
    stem = preview.name.removesuffix("preview.blend")
    beginning = stem[:-1].rpartition(".")[0] or stem  # the preview of parts also names the split
    for path in sorted(sidecar.parent.glob("*.json")):
        if path == sidecar or not path.name.startswith(beginning):
            continue
        try:
            facts = read_facts(path)
            if preview_path(path, facts.text("kind"), part_in(facts)) == preview:
                found[path] = facts
        except FormatError:
            if path.name.startswith(stem):
                found[path] = None
    return found


def _is_export_of(source: ExportSource, folder: Path) -> bool:
    """Whether a folder is an export of a bake by this name and of this kind."""
    manifest = earlier_manifest(source, folder)
    return manifest is not None and manifest.bake.get("kind") == source.bake.kind
