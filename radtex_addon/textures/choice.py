# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How a bake's light is stored, and what of a specification the bake cannot be."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ..core.atlas import AtlasLayout
from ..core.errors import InputError
from ..formats.containers.texture import PixelFormat, most_levels
from .entry import Container
from .spec import Arrangement, ExportSpec, Target, TextureFormat
from .stream import Light

_STORED = {
    TextureFormat.EXR: (Container.EXR, PixelFormat.RGBA16F),
    TextureFormat.KTX2_RGBA16F: (Container.KTX2, PixelFormat.RGBA16F),
    TextureFormat.KTX2_RGB9E5: (Container.KTX2, PixelFormat.RGB9E5),
    TextureFormat.KTX2_BC6H: (Container.KTX2, PixelFormat.BC6H),
    TextureFormat.DDS_RGBA16F: (Container.DDS, PixelFormat.RGBA16F),
    TextureFormat.DDS_BC6H: (Container.DDS, PixelFormat.BC6H),
}
_BLOCK = PixelFormat.BC6H.side


def choice(
    source: Path, light: Callable[[], Light], spec: ExportSpec, container: Container, straddled: str | None
) -> PixelFormat:
    """How the `light` of the file `source` is stored; `straddled` says why BC6H does not suit it.

    By itself that is RGB9E5, or BC6H for what loads DDS, where alpha is 1 and nothing negative; else RGBA16F.
    Raises InputError for a format that `spec` asks for and the light cannot have.
    """
    if spec.format is not TextureFormat.AUTO:
        kind = _STORED[spec.format][1]
        lossless = f"choose --format {container}-rgba16f"
        if kind is not PixelFormat.RGBA16F and not light().opaque:
            raise InputError(f"{source} has an alpha that is not 1, which {kind} cannot hold: {lossless}")
        if kind is PixelFormat.BC6H and straddled:
            raise InputError(f"{source} cannot be BC6H: {straddled}, or {lossless}")
        return kind
    found = light()
    if not found.opaque or found.least < 0:
        return PixelFormat.RGBA16F
    if container is Container.KTX2:
        return PixelFormat.RGB9E5
    # Godot's Compatibility renderer may unpack BC6H to bytes; Unreal packs what it imports by itself.
    unpacked = straddled or spec.target in (Target.GODOT, Target.UNREAL)
    return PixelFormat.RGBA16F if unpacked else PixelFormat.BC6H


def container_of(source: Path, spec: ExportSpec, is_array: bool) -> Container:
    """What kind of file a texture is written to. Raises InputError for one that the target does not read."""
    container = _STORED[spec.format][0] if spec.format is not TextureFormat.AUTO else None
    if is_array and spec.target is Target.GODOT:  # its KTX2 loader knows no arrays
        if container is Container.KTX2:
            found = f"{source} would have slices or pages"
            raise InputError(f"{found}, which Godot reads from DDS only: choose --format dds-rgba16f")
        return Container.DDS
    engine = spec.target in (Target.UNITY, Target.UNREAL)
    return container or (Container.DDS if engine else Container.KTX2)


def straddled_layout(layout: AtlasLayout, spec: ExportSpec, container: Container) -> str | None:
    """Why blocks of 4 x 4 pixels do not suit a bucket matrix or its slices; None if they do."""
    if spec.arrangement is Arrangement.MATRIX:
        return straddled_bucket(layout.bucket)
    if container is Container.DDS and (layout.width % _BLOCK or layout.height % _BLOCK):
        return (
            f"slices of {layout.width} x {layout.height} are no whole blocks of 4 x 4, which Direct3D needs"
        )
    return None


def straddled_bucket(bucket: int, border: int = 0) -> str | None:
    """Why a block would hold pixels of two buckets, which have `border` more on each side; None if none."""
    if (bucket + 2 * border) % _BLOCK == 0:
        return None
    good = _BLOCK * 2 - 2 * border
    return f"blocks of 4 x 4 pixels would straddle buckets of {bucket} cells; bake with --bucket {good}"


def checked_levels(source: Path, layout: AtlasLayout, spec: ExportSpec) -> int | None:
    """The number of mip levels that `spec` asks for. Raises InputError for more than there can be."""
    most = most_levels(layout.width, layout.height)
    if spec.levels is not None and spec.levels > most:
        size = f"{layout.width} x {layout.height} texels"
        raise InputError(f"{source} has {size}, which make {most} levels at most: give --levels {most}")
    return spec.levels


def check_limit(source: Path, width: int, height: int, spec: ExportSpec) -> None:
    """Make sure that a texture of `width` x `height` pixels may be. Raises InputError, naming `source`."""
    if max(width, height) > spec.most_pixels:
        found = f"{source} would be a texture of {width} x {height} pixels, which cannot be split"
        raise InputError(f"{found}: raise the limit of {spec.most_pixels} by --limit, or bake fewer texels")
