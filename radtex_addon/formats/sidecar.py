# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidecar: the facts that a reader needs about an atlas, as JSON beside the image and in its header.

Its keys are a contract with other programs: version 1 is in docs/format.md.
"""

from __future__ import annotations

import hashlib
import json
import re
import unicodedata
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..core.errors import FormatError, InputError
from .disk.atomic import write_text
from .fingerprint import KEY, Fingerprint, fingerprint_in
from .json_reader import Facts, excess, json_text, shown
from .sidecar_file import AnySidecar, read_facts

VERSION = 1
LAYOUT = "buckets"
TANGENTS = "mikktspace; Bt = sign * cross(N, T)"
COLOR_SPACE = "Linear Rec.709"
ALPHA = "premultiplied"

_NAME_BYTES = 100  # leaves room for .kind.layer.exr in 143 bytes, the smallest limit of a filesystem in use
_OF_FACTS = 0.5  # of what a sidecar may hold, the share of the facts that all layouts have
_UNSAFE = re.compile(r'[<>:"/\\|?*]')
_UNSAFE_CATEGORIES = {"Cc", "Cf", "Cs", "Zl", "Zp"}  # control, invisible, lone surrogates, line separators
_RESERVED = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|com[0-9¹²³]|lpt[0-9¹²³]) *(\.|$)", re.IGNORECASE)


@dataclass(frozen=True)
class Source:
    """The object whose light was baked, if it is not the object with the atlas (a bake from one to another).

    Rays looked for it within the `extrusion`, in scene units, or from a `cage`, whose greatest distance is
    then the `extrusion`; `missed` is the number of texels whose rays did not hit it.
    """

    object_name: str
    extrusion: float
    missed: int
    cage: str | None = None


@dataclass(frozen=True)
class Part:
    """The part of an object that an atlas covers, if each part has an atlas of its own.

    `name` is the part's name, `index` its number among the parts; `by` tells how the object was split.
    """

    by: str
    name: str
    index: int


@dataclass(frozen=True)
class Content:
    """What a hull shows: the `objects` of a collection; if `collection` is "", those within the hull.

    If `collection` is "*" the hull shows everything, and `objects` is empty.
    """

    collection: str
    objects: tuple[str, ...]


@dataclass(frozen=True)
class TexelDensity:
    """Texels per metre of surface: `asked` for, and `reached` in the mean over the surface."""

    asked: float
    reached: float


@dataclass(frozen=True)
class Sidecar:
    """Facts about one atlas: `width` x `height` texels of `bucket` x `bucket` cells.

    `kind` and `capture` are plain strings, so that readers accept kinds that they do not know; `clamped`
    counts the values that were beyond the file's range; `layers` are the bake's images besides the first.
    `mesh` is a digest of the baked copy's shape and UVs, empty if unknown. If several `objects` share the
    atlas, `object_name` is the atlas's name. Anything farther than the `ao_distance` does not occlude. If
    `texel_samples` (`formats.bucket_files`) is given, `samples` is its smallest number. The UV layer has so
    many `islands`, which cover a share of the atlas, the `coverage`; both are None if unknown. The
    `texel_density` is given if the atlas's size follows from a density. `wasteful` says why the map wastes
    its atlas, to go on after "the map …", and is empty if it does not. The `fingerprint` tells what was
    baked, None if unknown. `marks`: keys that are there, and true, such as "alone" (`settings.option.Mark`).
    `blend` is the name of the .blend that was baked, without its folder, empty if it was never saved.
    `texel_weights` is the vertex group that told the unwrap where more or fewer texels go, empty if none did.
    `backs` says which faces that are seen from behind could get texels of their own, empty if none could or
    that is not known. `called` is what its files are called, before frame, lamps, part and kind, empty if as
    the `object_name`.
    """

    object_name: str
    kind: str
    width: int
    height: int
    bucket: int
    uv_map: str
    samples: int
    seed: int
    capture: str
    tool: str
    blender: str
    layers: tuple[str, ...] = ()
    clamped: int = 0
    mesh: str = ""
    source: Source | None = None
    frame: int | None = None
    lights: tuple[str, ...] = ()
    objects: tuple[str, ...] = ()
    part: Part | None = None
    ao_distance: float | None = None
    texel_samples: str = ""
    content: Content | None = None
    denoised: bool = False
    islands: int | None = None
    coverage: float | None = None
    texel_density: TexelDensity | None = None
    wasteful: str = ""
    fingerprint: Fingerprint | None = None
    marks: tuple[str, ...] = ()
    blend: str = ""
    texel_weights: str = ""
    backs: str = ""
    called: str = ""

    @property
    def surfaces(self) -> tuple[str, ...]:
        """The objects that the atlas covers."""
        return self.objects or (self.object_name,)

    def to_json(self) -> str:
        """The sidecar's JSON, in ASCII and with a newline at its end."""
        return json_text(self.facts())

    def facts(self, layout: str = LAYOUT) -> dict[str, Any]:
        """The JSON's keys and values, in order, for an atlas in the given layout."""
        facts: dict[str, Any] = {
            "version": VERSION,
            "kind": self.kind,
            "layout": layout,
            "texels": [self.width, self.height],
            "bucket": self.bucket,
            "object": self.object_name,
            "uv_map": self.uv_map,
            "tangents": TANGENTS,
            "color_space": COLOR_SPACE,
            "alpha": ALPHA,
            "samples": self.samples,
            "seed": self.seed,
            "capture": self.capture,
            "layers": list(self.layers),
            "clamped": self.clamped,
            "tool": self.tool,
            "blender": self.blender,
        } | ({"mesh": self.mesh} if self.mesh else {})
        if self.source is not None:
            source = self.source
            facts["source"] = {
                "object": source.object_name,
                "extrusion": source.extrusion,
                "missed": source.missed,
            } | ({"cage": source.cage} if source.cage is not None else {})
        part, content, density = self.part, self.content, self.texel_density
        optional: dict[str, Any] = {
            "frame": self.frame,
            "lights": list(self.lights) or None,
            "objects": list(self.objects) or None,
            "ao_distance": self.ao_distance,
            "part": part and {"by": part.by, "name": part.name, "index": part.index},
            "texel_samples": self.texel_samples or None,
            "denoised": self.denoised or None,
            **dict.fromkeys(self.marks, True),
            "islands": self.islands,
            "coverage": self.coverage,
            "texel_density": density and {"asked": density.asked, "reached": density.reached},
            "texel_weights": self.texel_weights or None,
            "backs": self.backs or None,
            "wasteful": self.wasteful or None,
            "blend": self.blend or None,
            "bake_name": self.called or None,
            "content": content and {"collection": content.collection, "objects": list(content.objects)},
            KEY: self.fingerprint and self.fingerprint.to_facts(),
        }
        facts |= {key: value for key, value in optional.items() if value is not None}
        return facts

    @classmethod
    def from_json(cls, text: str, source: str = "the sidecar") -> Sidecar:
        """Read the text of `to_json`; `source` names it in errors. Unknown keys are ignored.

        Raises FormatError if it is no JSON object, for another version, and for a missing or mistyped key.
        """
        return cls.from_facts(Facts.parse(text, source))

    @classmethod
    def from_facts(cls, facts: Facts, layout: str = LAYOUT) -> Sidecar:
        """Inverse of `facts`. Raises FormatError as `from_json` does, and for another layout."""
        version = facts.whole_number("version", 1)
        if version != VERSION:
            raise FormatError(
                f"{facts.source} is of version {version}, this RadTex reads {VERSION}: update RadTex"
            )
        for key, value in {"layout": layout, **_CONSTANTS}.items():
            facts.constant(key, value)
        width, height = facts.size("texels")
        return cls(
            object_name=facts.text("object"),
            kind=facts.text("kind"),
            width=width,
            height=height,
            bucket=facts.whole_number("bucket", 1),
            uv_map=facts.text("uv_map"),
            samples=facts.whole_number("samples", 1),
            seed=facts.whole_number("seed", 0),
            capture=facts.text("capture"),
            tool=facts.text("tool"),
            blender=facts.text("blender"),
            layers=facts.texts("layers"),
            clamped=facts.whole_number("clamped", 0),
            mesh=facts.text("mesh") if "mesh" in facts.values else "",
            source=_source(facts.inner("source")) if "source" in facts.values else None,
            frame=facts.whole_number("frame", 0) if "frame" in facts.values else None,
            lights=facts.texts("lights") if "lights" in facts.values else (),
            objects=facts.texts("objects") if "objects" in facts.values else (),
            part=part_in(facts),
            ao_distance=facts.positive("ao_distance") if "ao_distance" in facts.values else None,
            texel_samples=facts.text("texel_samples") if "texel_samples" in facts.values else "",
            content=content_in(facts),
            denoised=facts.values.get("denoised") is True,
            islands=facts.whole_number("islands", 0) if "islands" in facts.values else None,
            coverage=facts.number("coverage") if "coverage" in facts.values else None,
            texel_density=density_in(facts),
            wasteful=facts.text("wasteful") if "wasteful" in facts.values else "",
            fingerprint=fingerprint_in(facts),
            marks=tuple(key for key, value in facts.values.items() if value is True and key != "denoised"),
            blend=blend_in(facts),
            texel_weights=facts.text("texel_weights") if "texel_weights" in facts.values else "",
            backs=facts.text("backs") if "backs" in facts.values else "",
            called=called_in(facts),
        )


def _source(facts: Facts) -> Source:
    return Source(
        facts.text("object"),
        facts.positive("extrusion"),
        facts.whole_number("missed", 0),
        facts.text("cage") if "cage" in facts.values else None,
    )


def part_in(facts: Facts) -> Part | None:
    """The part of an object in a sidecar's `facts`, None if it is all of it. Raises FormatError."""
    if "part" not in facts.values:
        return None
    found = facts.inner("part")
    return Part(found.text("by"), found.text("name"), found.whole_number("index", 0))


def blend_in(facts: Facts) -> str:
    """The name of the .blend in a sidecar's `facts`, empty if it is not known. Raises FormatError."""
    return facts.text("blend") if "blend" in facts.values else ""


def called_in(facts: Facts) -> str:
    """What the files of a sidecar's bake are called; empty if as the object. Raises FormatError."""
    return facts.text("bake_name") if "bake_name" in facts.values else ""


def density_in(facts: Facts) -> TexelDensity | None:
    """The texel density in a sidecar's `facts`, None if none was asked for. Raises FormatError."""
    if "texel_density" not in facts.values:
        return None
    found = facts.inner("texel_density")
    return TexelDensity(found.positive("asked"), found.positive("reached"))


def content_in(facts: Facts) -> Content | None:
    """The content of a hull in a sidecar's `facts`, None for other kinds. Raises FormatError."""
    if "content" not in facts.values:
        return None
    found = facts.inner("content")
    return Content(found.text("collection"), found.texts("objects"))


_CONSTANTS = {"tangents": TANGENTS, "color_space": COLOR_SPACE, "alpha": ALPHA}


def write_sidecar(path: Path, sidecar: Sidecar) -> None:
    """Write the sidecar's file atomically. Raises BakeError where the system refuses."""
    write_text(path, sidecar.to_json())


def read_sidecar(sidecar: AnySidecar) -> Sidecar:
    """Read a sidecar's file. Raises FormatError, with the path, if it is missing or not one of ours."""
    return Sidecar.from_facts(read_facts(sidecar))


def check_readable(sidecar: Sidecar) -> None:
    """Make sure before a bake that its sidecar can be read after it, whatever its layout adds.

    Raises InputError.
    """
    said = excess(json.dumps(sidecar.facts(), indent=2), _OF_FACTS)
    if said:
        raise InputError(
            f"the sidecar of '{shown(sidecar.object_name)}' could not be read, it {said}: bake fewer "
            "objects, or less of their surface, together"
        )


def preview_path(path: Path, kind: str, part: Part | None = None) -> Path:
    """The path of the preview, if one was saved, of the bake whose sidecar is the file `path`.

    All parts of an object share one preview.
    """
    stem = path.name.removesuffix(f".{kind}.json")
    if part is not None:
        stem = f"{stem.removesuffix(f'.{safe_name(part.name)}')}.{safe_name(part.by)}"
    return path.with_name(f"{stem}.preview.blend")


def file_name(
    object_name: str, kind: str, extension: str, layer: str | None = None, part: str | None = None
) -> str:
    """The contract's `<name>.<kind>.<extension>`: a part's name comes before the kind, a layer's after it."""
    words = [object_name, part, kind, layer]
    return ".".join([*(safe_name(word) for word in words if word is not None), extension])


def safe_name(name: str) -> str:
    """Make `name` valid in every filesystem, in Unicode's form NFC; a valid name stays as it is.

    A changed name gets a hash of the original, so that two names hardly ever become the same. Names that
    differ only in case stay different, though some filesystems treat them as the same.
    """
    name = unicodedata.normalize("NFC", name)
    cleaned = "".join("_" if unicodedata.category(c) in _UNSAFE_CATEGORIES else c for c in name)
    cleaned = _UNSAFE.sub("_", cleaned).strip(" .")
    if _RESERVED.match(cleaned):
        cleaned = f"_{cleaned}"
    if cleaned == name and cleaned and len(cleaned.encode()) <= _NAME_BYTES:
        return cleaned
    mark = hashlib.sha256(name.encode("utf-8", "surrogatepass")).hexdigest()[:8]
    stem = cleaned.encode()[: _NAME_BYTES - len(mark) - 1].decode(errors="ignore").rstrip(" .")
    return f"{stem or 'object'}-{mark}"
