# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The specification of a bake: what to bake, and how; checked once, when it is made.

Then as JSON, for farms and background workers, and what of it tells bakes apart.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from enum import StrEnum
from math import ceil, sqrt
from types import UnionType
from typing import Any, Union, cast, get_args, get_origin, get_type_hints

from ..bake.denoising import denoising_bytes
from ..bake.layers import OF_LAYER, WHOLE, Layer, captured
from ..bake.plan import MAX_IMAGE_SIDE
from ..core.errors import FormatError, RadTexError
from ..formats.containers.compression import Compression
from ..formats.json_reader import Facts
from .choices import CaptureMethod, Unwrap, View, parse
from .forms import FormTraits
from .kinds import Kind, Layout, form_of
from .option import Option
from .options import MARKED, OPTIONS, BakeOptions
from .parts import Split
from .rays import CLEAR_SAMPLES, LayeredRays, coarser, finer
from .spec_checks import check
from .texel_density import MOST_TEXELS, STEP

__all__ = [
    "BakeSpec",
    "CaptureMethod",
    "Compression",
    "Kind",
    "Layer",
    "Layout",
    "Split",
    "Unwrap",
    "View",
    "as_json",
    "facts_of",
    "fingerprint_texts",
    "impossible",
    "key_facts",
    "spec_in",
]

_BYTES_PER_CHANNEL = 8  # float32, twice: as cells, and joined to an image (measured: RGBA 33 to 35)
_BYTES_PER_TEXEL = 256  # points and frames, once as a map and once packed (measured: 180 to 240)
_BYTES_OF_BANDS = 160 << 20  # cells in memory while an atlas is written, and the writer (measured)
_TILE_MB = 1024  # the most that one render may take
_BYTES_OF_PANORAMAS = 800 << 20  # a layered bake's renders, of panoramas or of tiles (measured)
_BYTES_PER_FINER_TEXEL = 100  # of the layered layout's maps of the material (measured)
_BYTES_PER_BUCKET = 11_000  # of the layered layout's, while they are fitted (measured)
_BYTES_PER_EARLIER_TEXEL, _BYTES_PER_EARLIER_BUCKET = 40, 4_000  # of a bake to accumulate on, float32
_BYTES_PER_LAYERED_RAY = 20  # single paths in float16, and what the fit says of them; 60 % of texels covered
_IN_MEMORY = 4 << 30  # bytes: a layered bake that would take more has its arrays in files
# Of such a bake: what stays in memory, of each fine texel, bucket and texel …
_BYTES_PER_FINER_IN_FILES, _BYTES_PER_BUCKET_IN_FILES, _BYTES_PER_TEXEL_IN_FILES = 30, 2_000, 500
# … and what lies in files, of each fine texel, bucket, and ray.
_FILE_BYTES_PER_FINER, _FILE_BYTES_PER_BUCKET, _FILE_BYTES_PER_RAY = 150, 15_000, 24
_PIECE_BYTES_PER_RAY = 11  # of finished captures, for each ray; 60 % of texels covered
# Names in keys that differ from the field's, as that is also the name of a digest of the scene.
_IN_KEYS = {"objects": "objects that share the atlas", "lights": "lamps that are lit"}
_MOST_FLOAT = 1e300  # of numbers in a specification: larger ones and NaN are refused


@dataclass(frozen=True)
class BakeSpec(BakeOptions):
    """One bake: what is baked, how, and the course of this run.

    Enums may be given as text. Raises InputError for what cannot be baked. Fields for which their row in
    `settings.options` says enough are not told of here.

    What is baked:

    * `objects`: two or more that share the atlas; the bake's name is then only the atlas's. `split`: the
      atlas is of one `part`, a material's name or a UDIM tile's number; None for an atlas of each.
    * `uv_layer`: the object's layer to bake on; without one, `unwrap` makes a layer, with `padding` texels
      between islands.
    * `source`: the atlas holds what this other object shows, found along the baked object's normals; the
      baked object itself is invisible. `extrusion`: how far it is searched for, in scene units; None for a
      few per cent of the size. `cage`: an object with the same vertices and faces further out; the search
      starts there and goes as far inwards.
    * `texel_weights`: the objects' vertex group that says where a new unwrap gives more or fewer texels.
    * `backs`: which faces that are seen from behind get a twin with texels of its own, in forms that do so.
    * `content`: what a proxy shows, a collection's name, `"*"` for everything, or None for what lies inside.
    * `frame`: the frame at which the scene is baked; `unwrap_at`: the frame at which its mesh is unwrapped.
    * `lights`: names of lamps, and of collections with lamps, that alone are lit; "world" is all light that
      comes from no lamp.

    How:

    * `texels` on the atlas's longer side, `bucket` cells on a bucket's side, `samples` per cell. `density`:
      texels per metre of surface, from which the atlas's size follows; `texels` is then what is known of it,
      an estimate until the unwrap (`job.about_texels`). None: the atlas has `texels`.
    * `layout`: in the layered layout, which bakes radiance by the portal, a texel takes about 64 paths per
      sample, however many cells it has (`LayeredRays.of`). Default of `bucket`: `layout.cells`, but 9 for
      kind `transfer`.
    * `layers`: parts of the radiance that become atlases beside it. `half`, `compression`: the format of the
      files.
    * Kind `transfer`: buckets are octahedral maps of directions to the light; each of the bucket² suns that
      it is captured under takes `samples` paths per texel and `view`.
    * Kind `ao`: what is farther than `ao_distance`, in scene units, counts as open.
    * `denoise`: cells of light, and transfer, are denoised; the layered layout decides
      for itself; nor where samples are added to an atlas. The command line and the panel have it on.
    * `sheet`: cells of the plain layout are rendered in sheets of about `sheet`² pixels, each with its seed.

    What its files are called: `bake_name` (`settings.bake_names`).

    The course of this run, the fields that are not `of_atlas` in the table:

    * `device`: see `cycles.device.use_device`. `memory_mb`: limit for the bake's memory, without the scene's.
    * `accumulate` adds the samples to the existing atlas; `refresh` bakes only its changed texels again, with
      as many samples as it has; `where` limits both to the faces of a vertex group, a boolean face attribute
      or a material.
    """

    def __post_init__(self) -> None:
        for name, option in OPTIONS.items():
            value = getattr(self, name, None)
            if option.choices is None or value is None:
                continue
            words = value if option.many else (value,)
            found = tuple(dict.fromkeys(parse(option.choices, option.word or name, each) for each in words))
            object.__setattr__(self, name, found if option.many else found[0])
        if cast(int | None, self.bucket) is None:
            object.__setattr__(self, "bucket", self.form.cells)
        for name in ("lights", "objects"):
            object.__setattr__(self, name, tuple(dict.fromkeys(getattr(self, name))))
        check(self)
        if self.incremental or not OPTIONS["denoise"].applies(self.kind.traits, self.form):
            object.__setattr__(self, "denoise", False)
        if not self.kind.traits.samples:  # always one ray per cell
            object.__setattr__(self, "samples", 1)

    @property
    def form(self) -> FormTraits:
        """How the atlas is stored."""
        return form_of(self.kind, self.layout)

    @property
    def marks(self) -> tuple[str, ...]:
        """The options that its sidecar names because they are on."""
        return tuple(name for name in MARKED if getattr(self, name))

    @property
    def channels(self) -> int:
        """Channels of a cell while it is baked: four and three for each captured layer; one for occlusion."""
        if self.form.channels is not None:
            return self.form.channels
        return WHOLE + OF_LAYER * len(captured(self.layers))

    @property
    def layered_rays(self) -> LayeredRays:
        """The numbers of paths in the layered layout."""
        return LayeredRays.of(self.samples)

    @property
    def pixels_a_side(self) -> int:
        """Pixels of the atlas's longer side."""
        return self.texels * self.view.along * self.bucket

    @property
    def most_texels(self) -> int:
        """The most texels along a side that a density may ask for: a multiple of `STEP`."""
        storable = MAX_IMAGE_SIDE // (self.view.along * self.bucket)
        return min(MOST_TEXELS, max(storable // STEP, 1) * STEP)

    @property
    def pixel_count(self) -> int:
        """The most pixels that the atlas can have: those of a square one."""
        return self.pixels_a_side**2

    @property
    def path_count(self) -> int:
        """The most camera paths that the bake can take."""
        if self.form.by_paths:
            return self.layered_rays.most(self.texels**2)
        return self.pixel_count * self._rays_of_cell

    @property
    def _rays_of_cell(self) -> int:
        """The most rays of a cell; with a distance they are a square number."""
        if not self.kind.traits.samples:
            return CLEAR_SAMPLES
        return self.samples if self.ao_distance is None else ceil(sqrt(self.samples)) ** 2

    @property
    def incremental(self) -> bool:
        """Whether it adds to the atlas that is there: it accumulates, or refreshes."""
        return self.accumulate or self.refresh

    @property
    def streams(self) -> bool:
        """Whether cells are on disk during the bake, with only bands of the atlas in memory."""
        return self.form.streams and not self.incremental

    @property
    def tile_mb(self) -> int:
        """MiB that one render may take: the allowed memory minus the atlas's."""
        if self.memory_mb is None:
            return _TILE_MB
        return max(1, min(_TILE_MB, self.memory_mb - self.atlas_bytes // 2**20))

    @property
    def atlas_bytes(self) -> int:
        """The most memory that the atlas can take during the bake, in bytes.

        In the layered layout what a bake takes beside the scene, of an object that covers about 60 % of the
        texels.
        """
        if self.streams:
            of_bands = min(_BYTES_OF_BANDS, 2 * _BYTES_PER_CHANNEL * self.pixel_count * self.channels)
            if self.denoise:
                of_bands = max(of_bands, denoising_bytes(self.texels, self.bucket, self.channels))
            return self.texels**2 * (_BYTES_PER_TEXEL + self.bucket**2 // 8) + of_bands
        if self.form.by_paths:
            if not self.array_bytes:
                return self._layered_bytes
            fine, buckets = self._layered_sides
            beside = fine**2 * _BYTES_PER_FINER_IN_FILES + buckets**2 * _BYTES_PER_BUCKET_IN_FILES
            if self.accumulate:
                beside += self._earlier_bytes
            return _BYTES_OF_PANORAMAS + int(beside) + self.texels**2 * _BYTES_PER_TEXEL_IN_FILES
        return self.pixel_count * self.channels * _BYTES_PER_CHANNEL

    @property
    def array_bytes(self) -> int:
        """The most bytes of files in which a layered bake's arrays lie, 0 where all is in memory.

        They lie in files where they would take more memory than is allowed, _IN_MEMORY if nothing is said.
        """
        allowed = _IN_MEMORY if self.memory_mb is None else self.memory_mb << 20
        if not self.form.by_paths or self._layered_bytes <= allowed:
            return 0
        fine, buckets = self._layered_sides
        of_maps = fine**2 * _FILE_BYTES_PER_FINER + buckets**2 * _FILE_BYTES_PER_BUCKET
        return int(of_maps) + self.texels**2 * self.layered_rays.of_texel * _FILE_BYTES_PER_RAY

    @property
    def disk_bytes(self) -> int:
        """The most that a layered bake whose arrays lie in files has on disk, its finished pieces included.

        0 where all is in memory: pieces are as on the disk of any bake.
        """
        if not self.array_bytes:
            return 0
        return self.array_bytes + self.texels**2 * self.layered_rays.of_texel * _PIECE_BYTES_PER_RAY

    @property
    def _layered_bytes(self) -> int:
        """What a layered bake takes with all its arrays in memory."""
        fine, buckets = self._layered_sides
        of_maps = fine**2 * _BYTES_PER_FINER_TEXEL + buckets**2 * _BYTES_PER_BUCKET
        if self.accumulate:
            of_maps += self._earlier_bytes
        of_rays = self.texels**2 * self.layered_rays.of_texel * _BYTES_PER_LAYERED_RAY
        return _BYTES_OF_PANORAMAS + int(of_maps) + of_rays

    @property
    def _earlier_bytes(self) -> float:
        """What a layered bake takes to which samples are added."""
        fine, buckets = self._layered_sides
        return fine**2 * _BYTES_PER_EARLIER_TEXEL + buckets**2 * _BYTES_PER_EARLIER_BUCKET

    @property
    def _layered_sides(self) -> tuple[float, float]:
        """Texels along a side of a layered bake's fine maps, and its buckets."""
        return self.texels * finer(self.texels), self.texels / coarser(self.texels)


def facts_of(spec: BakeSpec) -> dict[str, Any]:
    """The fields of a specification as JSON's types."""
    return {field.name: as_json(getattr(spec, field.name)) for field in fields(BakeSpec)}


def as_json(value: Any) -> Any:
    """A field's value as JSON's types: enums as their text, tuples as lists."""
    if isinstance(value, StrEnum):
        return str(value)
    return [as_json(each) for each in value] if isinstance(value, tuple) else value


def key_facts(spec: BakeSpec) -> dict[str, str]:
    """What a bake must share with the unfinished one that it resumes, by its name in messages."""
    return {
        _IN_KEYS.get(name, name.replace("_", " ")): str(value)
        for name, value, option in _known(spec)
        if not option.resumes
    }


def fingerprint_texts(spec: BakeSpec) -> list[str]:
    """What the pixels of an atlas depend on, as text; numbers to six digits: the panel's are rounded."""
    return [
        f"{name} {f'{value:.6g}' if isinstance(value, float) else value}"
        for name, value, option in _known(spec)
        if option.of_atlas and not (option.added and value == option.default)
    ]


def _known(spec: BakeSpec) -> list[tuple[str, Any, Option]]:
    """Each field with its value and its row, but for the texels of a density, which are an estimate."""
    return [
        (field.name, getattr(spec, field.name), OPTIONS.get(field.name) or Option(field.name))
        for field in fields(spec)
        if spec.density is None or field.name != "texels"
    ]


def spec_in(facts: Facts) -> BakeSpec:
    """Inverse of `facts_of`. Raises FormatError for unknown, mistyped or impossible fields."""
    known = {field.name for field in fields(BakeSpec)}
    if unknown := sorted(facts.values.keys() - known):
        raise FormatError(
            f'{facts.source} has "{unknown[0]}", which this RadTex does not know: update RadTex'
        )
    values: dict[str, Any] = {
        key: tuple(value) if isinstance(value, list) else value for key, value in facts.values.items()
    }
    hints = get_type_hints(BakeSpec)
    for key, value in values.items():
        if not _fits(value, hints[key]):
            raise FormatError(f'{facts.source} has a "{key}" of another type: prepare it anew')
    try:
        return BakeSpec(**values)
    except (RadTexError, TypeError, ValueError, LookupError, AttributeError, ArithmeticError) as error:
        raise impossible(facts, error) from error


def impossible(facts: Facts, error: Exception) -> FormatError:
    """The error for facts from which no bake can be made."""
    return FormatError(
        f"{facts.source} is of a bake that cannot be ({json.dumps(str(error))}): prepare it anew"
    )


def _fits(value: Any, hint: Any) -> bool:
    """Whether a value from JSON is of a field's type; for enums any text, which BakeSpec parses."""
    if get_origin(hint) in (Union, UnionType):
        return any(_fits(value, each) for each in get_args(hint))
    if get_origin(hint) is tuple:
        return isinstance(value, tuple) and all(_fits(each, get_args(hint)[0]) for each in value)
    if issubclass(hint, StrEnum):
        return isinstance(value, str)
    if hint is float:
        return type(value) in (int, float) and abs(value) <= _MOST_FLOAT
    return type(value) is hint
