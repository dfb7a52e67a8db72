# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of a bake of kind `transfer`: `<name>.transfer.exr`, and its sidecar beside it.

The layout has a name of its own ("sphere"), so that readers of hemispherical buckets refuse it.

A lookup gives a texel's radiance under a light from any direction. A bucket is an octahedral map
(`core.octahedron`) of the directions to the light in the texel's frame: its middle is the normal, its
corners are the direction opposite to it. A cell holds the radiance that leaves the texel under a directional
light that gives an irradiance of 1 on a plane facing it. Light is linear: the contributions of several lights
add up.

A texel captured from k x k views has k x k buckets, and the atlas has W k x H k: the bucket of view (a, b) is
number (i k + a, j k + b). Views are arranged in a square like the cells of a bucket of radiance.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..core.arrays import Floats
from ..core.atlas import AtlasLayout
from ..core.errors import ShapeError
from .containers.exr import Compression, header_text, read_pixels, stored_rows, write_rows
from .containers.exr_rows import ImageRows, open_rows
from .disk.atomic import replacing
from .json_reader import Facts, json_text
from .sidecar import Sidecar
from .sidecar_file import AnySidecar, mismatch_error, opened, read_facts

LAYOUT = "sphere"
NORMAL, CAMERA, AROUND = VIEWS = ("normal", "camera", "around")  # where texels were captured from
_MOST_VIEWS = 16


def with_views(layout: AtlasLayout, views: int) -> AtlasLayout:
    """The layout of the stored atlas, whose texels have `views` x `views` buckets each."""
    return AtlasLayout(layout.width * views, layout.height * views, layout.bucket)


@dataclass(frozen=True)
class TransferSidecar:
    """Facts about one bake: those of every layout, and the number of `suns` it was captured under.

    `view` is the viewpoint: along the normals; from a camera at `eye`, (x, y, z, 1) in the bake's world, or
    (x, y, z, 0) for the direction to a camera at infinity; or from all around, by `views` x `views` views.
    """

    bake: Sidecar
    suns: int
    view: str = NORMAL
    eye: tuple[float, float, float, float] | None = None
    views: int = 1

    @property
    def layout(self) -> AtlasLayout:
        """The atlas's layout with one view."""
        return AtlasLayout(self.bake.width, self.bake.height, self.bake.bucket)

    @property
    def stored(self) -> AtlasLayout:
        """The image's layout, with the buckets of all views."""
        return with_views(self.layout, self.views)

    def facts(self) -> dict[str, Any]:
        """The JSON's keys and values, in order."""
        transfer: dict[str, Any] = {"view": self.view, "suns": self.suns}
        if self.eye is not None:
            transfer["eye"] = list(self.eye)
        if self.view == AROUND:
            transfer["views"] = self.views
        return self.bake.facts(LAYOUT) | {"transfer": transfer}

    def to_json(self) -> str:
        """The sidecar's JSON, in ASCII and with a newline at its end."""
        return json_text(self.facts())

    @classmethod
    def from_facts(cls, facts: Facts) -> TransferSidecar:
        """Inverse of `facts`; unknown keys are ignored.

        Raises FormatError for another version or layout, a missing or mistyped key, and an unknown view.
        """
        bake, transfer = Sidecar.from_facts(facts, LAYOUT), facts.inner("transfer")
        view = transfer.choice("view", VIEWS)
        eye = transfer.point("eye") if view == CAMERA else None
        views = transfer.whole_number("views", 2, _MOST_VIEWS) if view == AROUND else 1
        return cls(bake, transfer.whole_number("suns", 1), view, eye, views)


def write_transfer(
    path: Path,
    pixels: Floats,
    sidecar: TransferSidecar,
    half: bool = True,
    compression: Compression = Compression.ZIP,
) -> TransferSidecar:
    """Write the sidecar to `path` and the atlas, row 0 at the bottom, beside it; both or none.

    Values beyond the file's range are clamped to it and counted in the returned sidecar. Raises ShapeError if
    pixels and sidecar differ in size, BakeError for values that are not numbers and where the system refuses.
    """
    expected = (sidecar.stored.pixel_height, sidecar.stored.pixel_width, 4)
    if pixels.shape != expected:
        raise ShapeError(f"transfer atlas: expected shape {expected}, got {pixels.shape}")
    image = path.with_suffix(".exr")
    rows, clamped = stored_rows(image, pixels, half)
    sidecar = replace(sidecar, bake=replace(sidecar.bake, clamped=clamped))
    with ExitStack() as files:  # entered first, left last: the sidecar is renamed after the image
        files.enter_context(replacing(path)).write_text(sidecar.to_json(), encoding="utf-8", newline="\n")
        write_rows(files.enter_context(replacing(image)), rows, sidecar.to_json(), compression)
    return sidecar


def read_transfer(sidecar: AnySidecar) -> tuple[Floats, TransferSidecar]:
    """Read a bake: pixels in the layout `stored`, row 0 at the bottom.

    Raises FormatError, with the path, for a sidecar or an image that is missing, damaged, not ours, of a
    newer version, of another bake, or not of the size that the sidecar says.
    """
    image, facts = open_transfer(sidecar)
    return read_pixels(image.path, image.width, image.height, [4]), facts


def open_transfer(sidecar: AnySidecar) -> tuple[ImageRows, TransferSidecar]:
    """`read_transfer` for reading in bands of rows. Raises as that does."""
    file = opened(sidecar)
    facts, image = read_transfer_sidecar(file), file.path.with_suffix(".exr")
    inner = TransferSidecar.from_facts(Facts.parse(header_text(image), f"the header of {image}"))
    if inner != facts:
        raise mismatch_error(image, file)
    layout = facts.stored
    return open_rows(image, layout.pixel_width, layout.pixel_height, [4]), facts


def read_transfer_sidecar(sidecar: AnySidecar) -> TransferSidecar:
    """Read a sidecar's file. Raises FormatError, with the path, if it is missing or not of this layout."""
    return TransferSidecar.from_facts(read_facts(sidecar))
