# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The specification of a bake: what to bake, and how; checked once, when it is made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

from ..formats.containers.compression import Compression
from .choices import CaptureMethod, Unwrap, View, parse, parse_capture, parse_kind, parse_layer, parse_layout
from .kinds import Kind, Layout
from .layers import Layer
from .options import OPTIONS
from .parts import Split
from .spec_checks import check
from .spec_fields import SpecFields

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
    "parse_capture",
    "parse_kind",
    "parse_layer",
    "parse_layout",
]


@dataclass(frozen=True)
class BakeSpec(SpecFields):
    """One bake: `texels` on the atlas's longer side, `bucket` cells on a bucket's side, `samples` per cell.

    Enums may be given as text. Raises InputError for what cannot be baked. Fields for which their row in
    `bake.options` says enough are not told of here.

    * `density`: texels per metre of surface, from which the atlas's size follows; `texels` is then what is
      known of it, an estimate until the unwrap (`job.about_texels`). None: the atlas has `texels`.

    * `layout`: in the layered layout, which bakes radiance by the portal, a texel takes about 64 paths per
      sample, however many cells it has (`LayeredRays.of`). Default of `bucket`: `layout.cells`, but 9 for
      kind `transfer`.
    * `uv_layer`: the object's layer to bake on; without one, `unwrap` makes a layer, with `padding` texels
      between islands. `device`: see `cycles.device.use_device`. `memory_mb`: limit for the bake's memory,
      without the scene's. `half`, `compression`: the format of the files.
    * `layers`: parts of the radiance that become atlases beside it. `content`: what a proxy shows, a
      collection's name, `"*"` for everything, or None for what lies inside it.
    * `accumulate` adds the samples to the existing atlas; `refresh` bakes only its changed texels again, with
      as many samples as it has; `where` limits both to the faces of a vertex group, a boolean face attribute
      or a material.
    * `source`: the atlas holds what this other object shows, found along the baked object's normals; the
      baked object itself is invisible. `extrusion`: how far it is searched for, in scene units; None for a
      few per cent of the size. `cage`: an object with the same vertices and faces further out; the search
      starts there and goes as far inwards.
    * Kind `transfer`: buckets are octahedral maps of directions to the light; each of the bucket² suns that
      it is captured under takes `samples` paths per texel and `view`.
    * Kind `ao`: what is farther than `ao_distance`, in scene units, counts as open.
    * `frame`: the frame at which the scene is baked; `unwrap_at`: the frame at which its mesh is unwrapped.
    * `lights`: names of lamps, and of collections with lamps, that alone are lit; "world" is all light that
      comes from no lamp.
    * `objects`: two or more that share the atlas; the bake's name is then only the atlas's. `split`: the
      atlas is of one `part`, a material's name or a UDIM tile's number; None for an atlas of each.
    * `denoise`: cells of light, and transfer, are denoised; not in the layered layout, whose fit has no such
      noise, nor where samples are added to an atlas. The command line and the panel have it on.
    * `sheet`: cells of the plain layout are rendered in sheets of about `sheet`² pixels, each with its seed.
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
        if not self.can_denoise:
            object.__setattr__(self, "denoise", False)
        if not self.kind.traits.samples:  # always one ray per cell
            object.__setattr__(self, "samples", 1)
