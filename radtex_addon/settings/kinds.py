# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of kinds: what a bake can hold, which options each kind has, and where it can be exported to.

The panel's choices, the checks of a specification, the refusals and the documentation's matrix come from it.
A new kind is a member of `Kind` and a row in `KINDS`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, StrEnum, auto

from .forms import AMBIENT, BITS, BUCKETS, LAYERED, SPHERE, FormTraits


class Kind(StrEnum):
    """What a bucket holds."""

    RADIANCE = "radiance"
    INCIDENT = "incident"
    REFLECTION = "reflection"
    PROXY = "proxy"
    SHADOW = "shadow"
    AO = "ao"
    TRANSFER = "transfer"

    @property
    def traits(self) -> KindTraits:
        """The kind's row in the table."""
        return KINDS[self]


class Layout(StrEnum):
    """How an atlas stores light, for kinds that leave the choice: see `KindTraits.form`."""

    BUCKETS = "buckets"
    LAYERED = "layered"

    @property
    def cells(self) -> int:
        """The default bucket size: cells along a side."""
        return form_in(self).cells


class Light(Enum):
    """Which light a kind records."""

    LEAVING = auto()  # what a viewer sees, of the object or through it
    ARRIVING = auto()  # what reaches the surface
    OCCLUSION = auto()  # no light, only what is blocked
    RESPONSE = auto()  # how the object responds to light from each direction


class Rays(Enum):
    """Where a cell's rays go from their texel."""

    INWARDS = auto()  # against the cell's direction, at the surface, as a viewer looks
    OUTWARDS = auto()  # in the cell's direction
    MIRRORED = auto()  # along the mirror reflection of a viewer's ray
    COSINE = auto()  # outwards, distributed by the cosine: each cell gets rays by its share of ambient light


class Lit(Enum):
    """What lights an exported bake of a kind where it is shown."""

    BY_ITSELF = auto()  # the light is in the bake
    BY_LAMPS = auto()  # by lamps of the program that shows it
    BY_SKY = auto()  # by its environment


@dataclass(frozen=True)
class KindTraits:
    """One row: facts about a kind.

    * `title`, `tooltip`: what the panel calls it. `light`, `rays`: what it records, and how it is captured.
    * `form`: how its atlas is stored; None where the specification's layout decides.
    * Options that it can be baked with: `layers`; a `source` (from another object); single `lamps`;
      `accumulates` (and refreshes); on a `farm`; several objects in a `shared_atlas`; by the `panoramic`
      capture; in `full_floats`; with `lossy` compression.
    * Settings that few kinds have: `content` (of a hull), `views`, `ao_distance`; or that some lack:
      `samples`, `cells`.
    * `needs_camera_rays`: the baked object must be visible to cameras. `needs_light`: a scene without light
      is worth a warning. `looks_at_surface`: records the light of the object's own surface, so that cells
      that nobody can see are skipped. `judged`: a path-traced picture can be compared with its preview.
    * Where it is exported: `hlsl`: its form writes a lookup with the bake's numbers, which engines need;
      `lit`: by what it is lit there.
    """

    title: str
    tooltip: str
    light: Light
    rays: Rays
    form: FormTraits | None = BUCKETS
    layers: bool = False
    source: bool = False
    lamps: bool = False
    accumulates: bool = False
    farm: bool = False
    shared_atlas: bool = True
    panoramic: bool = False
    full_floats: bool = True
    lossy: bool = True
    content: bool = False
    views: bool = False
    ao_distance: bool = False
    samples: bool = True
    cells: bool = True
    needs_camera_rays: bool = False
    needs_light: bool = True
    looks_at_surface: bool = False
    judged: bool = True
    hlsl: bool = True
    lit: Lit = Lit.BY_ITSELF


KINDS: dict[Kind, KindTraits] = {
    Kind.RADIANCE: KindTraits(
        title="Radiance",
        tooltip="The light that leaves the surface, as a viewer in each direction sees it",
        light=Light.LEAVING,
        rays=Rays.INWARDS,
        form=None,
        layers=True,
        source=True,
        lamps=True,
        accumulates=True,
        farm=True,
        needs_camera_rays=True,
        looks_at_surface=True,
    ),
    Kind.INCIDENT: KindTraits(
        title="Incident",
        tooltip="The light that arrives at the surface from each direction",
        light=Light.ARRIVING,
        rays=Rays.OUTWARDS,
        form=None,
        source=True,
        lamps=True,
        accumulates=True,
        farm=True,
        panoramic=True,
        judged=False,
    ),
    Kind.REFLECTION: KindTraits(
        title="Reflection",
        tooltip="The light that arrives from where a mirror would send each view",
        light=Light.ARRIVING,
        rays=Rays.MIRRORED,
        form=None,
        source=True,
        lamps=True,
        accumulates=True,
        farm=True,
        panoramic=True,
        judged=False,
    ),
    Kind.PROXY: KindTraits(
        title="Proxy",
        tooltip="What is inside a hull, such as fur or leaves, or the room behind a window, "
        "drawn in its place",
        light=Light.LEAVING,
        rays=Rays.INWARDS,
        layers=True,
        lamps=True,
        accumulates=True,
        farm=True,
        shared_atlas=False,
        content=True,
    ),
    Kind.SHADOW: KindTraits(
        title="Shadow",
        tooltip="Which directions are blocked, in one bit each: real-time lamps cast shadows with it, "
        "soft ones too",
        light=Light.OCCLUSION,
        rays=Rays.OUTWARDS,
        form=BITS,
        source=True,
        full_floats=False,
        lossy=False,
        samples=False,
        needs_light=False,
        judged=False,
        hlsl=False,
        lit=Lit.BY_LAMPS,
    ),
    Kind.AO: KindTraits(
        title="Ambient Occlusion",
        tooltip="How much of the sky each place sees, and in which direction most of it lies",
        light=Light.OCCLUSION,
        rays=Rays.COSINE,
        form=AMBIENT,
        source=True,
        lossy=False,
        ao_distance=True,
        cells=False,
        needs_light=False,
        judged=False,
        hlsl=False,
        lit=Lit.BY_SKY,
    ),
    Kind.TRANSFER: KindTraits(
        title="Transfer",
        tooltip="How the object answers to light from each direction: lamps that move light it, "
        "even through wax",
        light=Light.RESPONSE,
        rays=Rays.INWARDS,
        form=SPHERE,
        views=True,
        needs_camera_rays=True,
        needs_light=False,
        lit=Lit.BY_LAMPS,
    ),
}


DEFAULT_KIND = Kind.RADIANCE  # the default


def is_default_kind(kind: str) -> bool:
    """Whether a bake's kind is the default one, which needs no mention and comes first in lists."""
    return kind == DEFAULT_KIND


def form_of(kind: Kind, layout: Layout) -> FormTraits:
    """The form of a bake; the `layout` is used only if the kind has no form of its own."""
    return kind.traits.form or form_in(layout)


def form_in(layout: Layout) -> FormTraits:
    """The form of a bake in a layout, for kinds without a form of their own."""
    return LAYERED if layout is Layout.LAYERED else BUCKETS
