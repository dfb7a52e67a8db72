# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Check a specification: refuse settings that contradict each other, or cannot be baked."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..bake.plan import MAX_IMAGE_SIDE
from ..core.errors import InputError
from ..core.messages import Setting, do, leave_out
from ..formats.containers.compression import Compression
from .bake_names import check_pattern
from .choices import CaptureMethod
from .forms import NOT_REFRESHED, FormTraits
from .kinds import KINDS, Light, form_in
from .options import OPTIONS
from .parts import Split
from .texel_density import checked_density, told_density

if TYPE_CHECKING:
    from .spec import BakeSpec

_BUCKETS = do("choose layout buckets", Setting.LAYOUT, value="buckets")
_PORTAL = do("capture by portal", Setting.CAPTURE, value="portal")
_NEAREST, _FARTHEST = 1e-18, 1e18  # scene units: the squares of others are no numbers in float32
_MOST_SAMPLES_BY_PATHS = 2**12  # 117 thousand paths per texel


def check(spec: BakeSpec) -> None:
    """Raises InputError for what cannot be baked; enums and the number of cells must be set before.

    No check depends on the machine: see `memory_limits` for checks of memory.
    """
    for name, option in OPTIONS.items():
        if option.limits is None or (option.default is None and getattr(spec, name) is None):
            continue
        _check_whole_number(option.word or name, getattr(spec, name), *option.limits)
    if spec.unwrap_at is not None and (spec.frame is None or spec.uv_layer is not None):
        raise InputError(f"unwrap at frame {spec.unwrap_at} is for frames without a UV layer: leave it out")
    if spec.uv_layer == "":
        raise InputError("the UV layer's name is empty: name one of the object's, or none to unwrap anew")
    check_pattern(spec.bake_name)
    _check_weights(spec)
    _check_kind(spec)
    if _asked(spec).by_paths:
        _check_by_paths(spec)
    if spec.density is None:
        _check_size(spec)
    else:
        checked_density(spec.density, f"density {spec.density:g}")


def _asked(spec: BakeSpec) -> FormTraits:
    """The form of the layout that is asked for, even if the kind has a form of its own."""
    return form_in(spec.layout)


def _check_weights(spec: BakeSpec) -> None:
    if spec.texel_weights == "":
        raise InputError("the vertex group of texel weights has no name: name one, or leave it out")
    if spec.texel_weights is not None and spec.uv_layer is not None:
        raise InputError(
            f"texel weights '{spec.texel_weights}' are for a new unwrap, not for UV layer '{spec.uv_layer}'",
            leave_out(Setting.UV),
            leave_out(Setting.TEXEL_WEIGHTS),
        )


def _check_kind(spec: BakeSpec) -> None:
    kind = spec.kind.traits
    if spec.capture is CaptureMethod.PANORAMIC and kind.light is Light.LEAVING:
        raise InputError(
            f"capture panoramic only looks outwards and cannot bake {spec.kind}",
            _PORTAL,
            do("bake incident or reflection"),
        )
    if spec.layers and not kind.layers:
        raise InputError(f"{spec.kind} has no layers", do("bake radiance"), leave_out(Setting.LAYER))
    if spec.incremental:
        _check_earlier(spec)
    if spec.where is not None:
        _check_where(spec)
    _check_applies(spec)
    if kind.light is Light.RESPONSE:
        _check_transfer(spec)
    _check_source(spec)
    _check_lights(spec)
    _check_surfaces(spec)
    _check_distance(spec)
    if kind.light is Light.OCCLUSION:
        _check_occlusion(spec)


def _check_applies(spec: BakeSpec) -> None:
    """Check options that have a refusal in their row."""
    for name, option in OPTIONS.items():
        value = getattr(spec, name, option.default)
        if option.refusal and value != option.default and not option.applies(spec.kind.traits, spec.form):
            instead = (do(option.instead),) if option.instead else ()
            raise InputError(
                option.refusal.format(kind=spec.kind, value=value), *instead, leave_out(option.called)
            )


def _check_source(spec: BakeSpec) -> None:
    if spec.source is None:
        for setting, given in ((Setting.EXTRUSION, spec.extrusion), (Setting.CAGE, spec.cage)):
            if given is not None:
                raise InputError(
                    f"{setting} {given} is for what another object shows",
                    do("name that object", Setting.FROM),
                    leave_out(setting),
                )
        return
    if not spec.source:
        raise InputError("the name of the object to bake from is empty: name one, or none")
    if not spec.kind.traits.source:
        raise InputError(f"{spec.kind} is not baked from another object", leave_out(Setting.FROM))
    if spec.capture is not CaptureMethod.PORTAL:
        raise InputError(f"capture {spec.capture} bakes from no other object", _PORTAL)
    _check_reach(spec)


def _check_reach(spec: BakeSpec) -> None:
    """Check how far from the surface the source is searched for."""
    if spec.extrusion is not None:
        _check_finite("extrusion", spec.extrusion, "a distance")
    if spec.cage == "":
        raise InputError("the cage's name is empty: name an object, or none")
    if spec.cage is not None and spec.extrusion is not None:
        raise InputError("a cage and an extrusion contradict each other: give one of them")


def _check_lights(spec: BakeSpec) -> None:
    if not spec.lights:
        return
    if not all(spec.lights):
        raise InputError("a light's name is empty: name lamps, or collections of lamps")
    for asked, wrong, remedy in (
        (f"kind {spec.kind}", not spec.kind.traits.lamps, do("bake radiance")),
        ("layers", bool(spec.layers), leave_out(Setting.LAYER)),
        ("capture panoramic", spec.capture is not CaptureMethod.PORTAL, _PORTAL),
    ):
        if wrong:
            raise InputError(
                f"{asked} cannot be baked for some lamps alone", remedy, leave_out(Setting.LIGHTS)
            )


def _check_surfaces(spec: BakeSpec) -> None:
    """Check which objects share the atlas, and which part of the surface it is of."""
    if spec.objects:
        if len(spec.objects) < 2:
            raise InputError(f"object '{spec.objects[0]}' is alone: name others to share its atlas")
        for asked, wrong, remedy in (
            (f"a {spec.kind}", not spec.kind.traits.shared_atlas, do("bake hulls one by one")),
            ("what another object shows", spec.source is not None, do("bake these one by one")),
        ):
            if wrong:
                raise InputError(f"{asked} is not baked for several objects in one atlas", remedy)
    if spec.split is Split.UDIM and spec.uv_layer is None:
        raise InputError("UDIM tiles are a UV layer's", do("name the layer", Setting.UV))
    if spec.part is not None and spec.split is None:
        ways = " or ".join(Split)
        raise InputError(
            f"part '{spec.part}' is for an object that is split: split it by {ways}, or leave the part out"
        )


def _check_distance(spec: BakeSpec) -> None:
    if spec.ao_distance is None:
        return
    if not spec.kind.traits.ao_distance:
        raise InputError(f"{spec.kind} looks at any distance", do("bake ao"), leave_out(Setting.AO_DISTANCE))
    _check_finite("ao distance", spec.ao_distance, "one")


def _check_transfer(spec: BakeSpec) -> None:
    for asked, wrong, remedy in (
        (_asked(spec).title, _asked(spec).by_paths, _BUCKETS),
        ("capture panoramic", spec.capture is not CaptureMethod.PORTAL, _PORTAL),
    ):
        if wrong:
            raise InputError(f"kind transfer does not go with {asked}", remedy)


def _check_occlusion(spec: BakeSpec) -> None:
    kind = spec.kind
    if _asked(spec).by_paths:
        raise InputError(f"{_asked(spec).title} holds light, not {kind}", _BUCKETS)
    if spec.capture is not CaptureMethod.PORTAL:
        raise InputError(f"capture {spec.capture} cannot bake {kind}", _PORTAL)
    if spec.compression is Compression.DWAA and not kind.traits.lossy:
        raise InputError(f"compression dwaa is for light and spoils {kind}: choose zip or piz")
    if not (spec.half or kind.traits.full_floats):
        raise InputError("shadow holds bits, not floats", leave_out(Setting.FLOAT))


def _check_earlier(spec: BakeSpec) -> None:
    if spec.accumulate and spec.refresh:
        raise InputError("to accumulate and to refresh contradict each other: choose one of them")
    done = "accumulated" if spec.accumulate else "refreshed"
    form = _asked(spec)
    if spec.refresh and form.accumulates and not form.refreshes:
        raise InputError(
            f"{form.title} cannot be refreshed, {NOT_REFRESHED}",
            do("bake again only the objects that have changed", Setting.CHANGED, without=(Setting.REFRESH,)),
            _BUCKETS,
        )
    for asked, wrong, remedy in (
        (f"kind {spec.kind}", not spec.kind.traits.accumulates, do("bake it anew")),
        (_asked(spec).title, not (form.accumulates if spec.accumulate else form.refreshes), _BUCKETS),
        ("layers", bool(spec.layers), leave_out(Setting.LAYER)),
        ("capture panoramic", spec.capture is not CaptureMethod.PORTAL, _PORTAL),
    ):
        if wrong:
            raise InputError(f"{asked} cannot be {done}", remedy)


def _check_where(spec: BakeSpec) -> None:
    if not spec.where:
        raise InputError("the name of where is empty: name a vertex group, an attribute or a material")
    if not spec.incremental:
        raise InputError(
            f"where '{spec.where}' is for what is accumulated or refreshed",
            do("choose one of them", Setting.ACCUMULATE, Setting.REFRESH),
            do("leave it out"),
        )
    if not _asked(spec).accumulates_parts:
        raise InputError(f"{_asked(spec).title} is accumulated as a whole", do("leave where out"), _BUCKETS)


def _check_by_paths(spec: BakeSpec) -> None:
    form = _asked(spec)
    if not spec.kind.traits.looks_at_surface:
        only = ", ".join(kind for kind, traits in KINDS.items() if traits.looks_at_surface)
        raise InputError(f"{form.title} knows kind {only} only, not {spec.kind}", _BUCKETS)
    if spec.capture is not CaptureMethod.PORTAL:
        raise InputError(
            f"{form.title} knows capture {CaptureMethod.PORTAL} only, not {spec.capture}", _BUCKETS
        )
    if spec.layers:
        raise InputError(
            f"{form.title} has no layers, since its images hold diffuse and mirrored light apart", _BUCKETS
        )
    if spec.bucket != form.cells and not form.any_cells:
        raise InputError(
            f"{form.title} chooses its cells itself, {form.cells} or fewer, not {spec.bucket}",
            _BUCKETS,
            leave_out(Setting.BUCKET),
        )
    _check_whole_number(f"samples in {form.title}", spec.samples, 1, _MOST_SAMPLES_BY_PATHS)


def _check_size(spec: BakeSpec) -> None:
    side = spec.pixels_a_side
    if side > MAX_IMAGE_SIDE:
        raise InputError(
            f"{size_of(spec)} makes {side} pixels a side, {MAX_IMAGE_SIDE} is the most: lower one"
        )


def size_of(spec: BakeSpec) -> str:
    """The settings that make an atlas large, for messages."""
    size = f"a side of {spec.texels} texels with {spec.bucket} cells"
    return size if spec.density is None else f"{told_density(spec.density)}, {size},"


def _check_finite(name: str, distance: float, what: str) -> None:
    """Check a distance that float32 computes with."""
    if not distance > 0:
        raise InputError(f"{name} {distance:g}: give {what} above 0, in scene units")
    if not _NEAREST <= distance <= _FARTHEST:
        raise InputError(
            f"{name} {distance:g}: give {what} from {_NEAREST:g} to {_FARTHEST:g}, in scene units"
        )


def _check_whole_number(name: str, value: object, least: int, most: int) -> None:
    if isinstance(value, int) and not isinstance(value, bool) and least <= value <= most:
        return
    raise InputError(f"{name} {value}: give a whole number from {least} to {most}")
