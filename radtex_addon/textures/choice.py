# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Choose how a bake's textures are stored, and check a specification against the bake."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ..core.atlas import AtlasLayout
from ..core.errors import InputError
from ..core.messages import Message, Remedy, Setting, do, leave_out
from ..formats.containers.texture import PixelFormat, most_levels
from ..formats.image_files import Shapes
from .entry import Container
from .export_spec import Arrangement, ExportSpec, TextureFormat
from .stream import LightRange

_STORED = {
    TextureFormat.EXR: (Container.EXR, PixelFormat.RGBA16F),
    TextureFormat.KTX2_RGBA16F: (Container.KTX2, PixelFormat.RGBA16F),
    TextureFormat.KTX2_RGB9E5: (Container.KTX2, PixelFormat.RGB9E5),
    TextureFormat.KTX2_BC6H: (Container.KTX2, PixelFormat.BC6H),
    TextureFormat.DDS_RGBA16F: (Container.DDS, PixelFormat.RGBA16F),
    TextureFormat.DDS_BC6H: (Container.DDS, PixelFormat.BC6H),
}
_BLOCK = PixelFormat.BC6H.side


def choose(form: TextureFormat) -> Remedy:
    """The remedy to choose another format."""
    return do(f"choose {form.label}", Setting.FORMAT, value=str(form))


def choice(
    source: Path,
    light: Callable[[], LightRange],
    spec: ExportSpec,
    container: Container,
    straddled: Message | None,
) -> PixelFormat:
    """The pixel format for the `light` of the file `source`.

    `straddled` is the reason why BC6H does not fit, None if it does. If `spec` names no format: RGB9E5 in
    KTX2, BC6H in DDS where it fits and is safe, but RGBA16F if alpha is not 1 or a value is negative. Raises
    InputError if `spec` names a format that cannot hold the light.
    """
    if spec.format is not TextureFormat.AUTO:
        kind = _STORED[spec.format][1]
        lossless = choose(TextureFormat(f"{container}-rgba16f"))
        if kind is not PixelFormat.RGBA16F and not light().opaque:
            raise InputError(f"{source} has an alpha that is not 1, which {kind} cannot hold", lossless)
        if kind is PixelFormat.BC6H and straddled:
            raise InputError(f"{source} cannot be BC6H ({straddled.problem})", *straddled.remedies, lossless)
        return kind
    found = light()
    if not found.opaque or found.least < 0:
        return PixelFormat.RGBA16F
    if container is Container.KTX2:
        return PixelFormat.RGB9E5
    return PixelFormat.BC6H if light_in_blocks(spec) and not straddled else PixelFormat.RGBA16F


def in_blocks(spec: ExportSpec) -> bool:
    """Whether images that are no plain light are compressed in blocks, each in a range of its own."""
    if spec.format is TextureFormat.AUTO:
        return spec.target.traits.blocks
    return _STORED[spec.format][1] is PixelFormat.BC6H


def light_in_blocks(spec: ExportSpec) -> bool:
    """Whether light is BC6H, too."""
    return in_blocks(spec) and (spec.format is not TextureFormat.AUTO or spec.target.traits.light_blocks)


def _stored(spec: ExportSpec) -> tuple[Container, PixelFormat]:
    """How plain, opaque light is stored, where nothing is in the way."""
    return _STORED[spec.target.traits.auto if spec.format is TextureFormat.AUTO else spec.format]


def pixel_bytes(spec: ExportSpec, *, by_paths: bool = False) -> float:
    """About how many bytes a pixel of opaque light has; `by_paths`: of a layered bake's images."""
    kind = _stored(spec)[1]
    if by_paths:
        kind = PixelFormat.BC6H if in_blocks(spec) else PixelFormat.RGBA16F
    return kind.block_bytes / kind.side**2


def container_of(source: Path, spec: ExportSpec, is_array: bool) -> Container:
    """The kind of file to write a texture to. Raises InputError for one that the target does not read."""
    traits, container = spec.target.traits, _stored(spec)[0]
    if container is not Container.KTX2 or not is_array or traits.ktx2_arrays:
        return container
    if spec.format is not TextureFormat.AUTO:
        found = f"{source} would have slices or pages, which {traits.title} reads from DDS only"
        raise InputError(found, choose(TextureFormat.DDS_RGBA16F))
    return Container.DDS


def straddled_layout(layout: AtlasLayout, spec: ExportSpec, container: Container) -> Message | None:
    """The reason why blocks of 4 x 4 pixels do not fit a bucket matrix or its slices; None if they do."""
    if spec.arrangement is Arrangement.MATRIX:
        return straddled_bucket(layout.bucket)
    if container is Container.DDS and (layout.width % _BLOCK or layout.height % _BLOCK):
        return Message(
            f"slices of {layout.width} x {layout.height} are no whole blocks of 4 x 4, which Direct3D needs"
        )
    return None


def straddled_bucket(bucket: int, border: int = 0) -> Message | None:
    """The reason why a block of 4 x 4 pixels would contain pixels of two buckets; None if none would.

    Buckets have `border` additional pixels on each side.
    """
    if (bucket + 2 * border) % _BLOCK == 0:
        return None
    good = _BLOCK * 2 - 2 * border
    return Message(
        f"blocks of 4 x 4 pixels would straddle buckets of {bucket} cells",
        (do(f"bake with {good} cells", Setting.BUCKET, value=str(good)),),
    )


def checked_levels(source: Path, layout: AtlasLayout, spec: ExportSpec) -> int | None:
    """The number of mip levels in `spec`, None if not given. Raises InputError for too many."""
    most = most_levels(layout.width, layout.height)
    if spec.levels is not None and spec.levels > most:
        size = f"{layout.width} x {layout.height} texels"
        raise InputError(
            f"{source} has {size}, which make {most} levels at most",
            do(f"give {most}", Setting.LEVELS, value=str(most)),
        )
    return spec.levels


def check_limit(source: Path, width: int, height: int, spec: ExportSpec) -> None:
    """Raise InputError, naming `source`, if a texture of `width` x `height` pixels is over the limit."""
    if max(width, height) > spec.most_pixels:
        found = f"{source} would be a texture of {width} x {height} pixels, which cannot be split"
        raise InputError(
            found, do(f"raise the limit of {spec.most_pixels}", Setting.LIMIT), do("bake fewer texels")
        )


def check_importable(bake: Path | str, spec: ExportSpec, shapes: Shapes) -> None:
    """Raise InputError, naming the `bake`, if the target's importer cannot take its textures.

    One without arrays keeps none of their mip levels, by which slices are filtered; and pages are arrays,
    too. `shapes` are of the bake's images.
    """
    traits = spec.target.traits
    if traits.arrays:
        return
    if spec.arrangement is Arrangement.SLICES:
        found = f"{bake} in slices would be a texture array, whose mip levels {traits.title} does not import"
        raise InputError(found, leave_out(Setting.ARRANGEMENT))
    width, height = max((shape[:2] for shape in shapes.values()), key=max)
    if max(width, height) > spec.most_pixels:
        size = f"{width} x {height} pixels"
        raise InputError(
            f"{bake} would be a texture of {size}, and {traits.title} takes none cut into pages",
            do(f"raise the limit of {spec.most_pixels}", Setting.LIMIT),
            do("bake fewer texels"),
        )
