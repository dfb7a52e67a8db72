# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ten thousand lookups of each form, to be asked of engines' shaders through a mesh as they import it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from radtex_addon.core.arrangements import fitting_pages
from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import normalised, orthonormal_frame, to_frame
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.export.image_files import BUMP
from radtex_addon.forms.buckets.hlsl import buckets_lookup
from radtex_addon.forms.hlsl_lookup import HlslLookup
from radtex_addon.forms.layered.files.arrangement import OF_IMAGES
from radtex_addon.forms.layered.hlsl import layered_lookup
from radtex_addon.forms.layered.shader_values import FULL, shader_facts
from radtex_addon.forms.sphere.hlsl import sphere_lookup
from radtex_addon.textures.entry import Arranged
from radtex_addon.textures.export_spec import Target
from tests.layered_lookups import Case, ImageCase, case_of, image_case, off
from tests.lookups import COUNT, LAYOUT, random_atlas, random_lookups, relative_error
from tests.real.engines import Mesh, entry, mesh_of
from tests.real.webgpu import Texture, image
from tests.reference.pages import page_chain
from tests.reference.relighting import sample_transfer
from tests.transfer_lookups import IRRADIANCE, Way, questions

SUN = normalised(np.array([0.3, -0.5, 0.8]))  # of relit bakes, in the bake's world
NEAR_IN_BITS = 0.02  # of the brightest: the sampler's weights have 8 bits


Error = Callable[[list[Floats]], tuple[float, float]]
Images = Mapping[int, tuple[Texture, ...]]


@dataclass(frozen=True, eq=False)
class Asked:
    """A lookup, its textures in their order, a mesh, and towards the viewers, in the bake's world.

    `error` says how far off what was found with each material is, (K, 4), on average and at most; both must
    be below `within`. `images` are those that materials are shown by, by number, as the engine has them.
    """

    lookup: HlslLookup
    textures: list[Texture]
    mesh: Mesh
    viewers: Floats
    materials: int
    error: Error
    within: tuple[float, float]
    images: Images = field(default_factory=dict)

    def textures_of(self, material: int) -> list[Texture]:
        """Those that are read for a material."""
        read = self.lookup.textures_of(material)
        known = zip(self.lookup.textures, self.textures, strict=True)
        return [*(texture for name, texture in known if name in read), *self.images.get(material, ())]

    @property
    def uv_sets(self) -> int:
        """How many sets of uv the mesh has."""
        return sum(name.startswith("TEXCOORD") for name in self.mesh.attributes)


def buckets(target: Target, paged: bool = False) -> Asked:
    """A matrix of buckets, in one texture, whose cells the sampler blends, or in pages, by float32."""
    atlas, lookups = random_atlas(), random_lookups()
    size = (LAYOUT.pixel_width, LAYOUT.pixel_height)
    texels = (LAYOUT.width, LAYOUT.height)
    texture, about = image(atlas), entry(size, arranged=Arranged.MATRIX, texels=texels)
    if paged:
        pages = fitting_pages(LAYOUT, 50, 1)
        stored = page_chain(atlas, LAYOUT, pages, 1)[0].astype(np.float16)
        texture = image(stored)
        about = entry(
            (stored.shape[2], stored.shape[1]),
            layers=len(stored),
            arranged=Arranged.MATRIX,
            texels=texels,
            pages=(pages.columns, pages.rows),
            page_texels=(pages.width, pages.height),
        )
    facts = {"kind": "radiance", "bucket": LAYOUT.bucket, "texels": list(texels)}
    wanted = sample(
        atlas.astype(float), LAYOUT, lookups.uv.astype(float), lookups.incidence, Filter.QUADRILINEAR
    )

    def error(found: list[Floats]) -> tuple[float, float]:
        wrong = relative_error(found[0], wanted) if paged else np.abs(found[0] - wanted).max(axis=1)
        return float(wrong.mean()), float(wrong.max()) / (1 if paged else float(atlas.max()))

    return Asked(
        buckets_lookup(facts, {"radiance": about}, target),
        [texture],
        mesh_of(lookups.uv, _places(), lookups.normal, lookups.tangent, lookups.sign, target),
        lookups.viewer,
        1,
        error,
        (1e-3, 2e-3) if paged else (0.05, NEAR_IN_BITS),
    )


def relit(target: Target) -> Asked:
    """A bake of kind transfer from all around, in the light of one sun."""
    question = next(each for each in questions() if each.way is Way.AROUND)
    views, lookups = question.views, question.lookups
    texels = (LAYOUT.width, LAYOUT.height)
    size = (LAYOUT.pixel_width * views, LAYOUT.pixel_height * views)
    about = entry(size, arranged=Arranged.MATRIX, texels=(texels[0] * views, texels[1] * views))
    facts = {"kind": "transfer", "bucket": LAYOUT.bucket, "texels": list(texels)}
    lookup = sphere_lookup({**facts, "transfer": {"views": views}}, {"transfer": about}, target)
    frame = (lookups.normal.astype(float), lookups.tangent.astype(float), lookups.sign.astype(float))
    direction = to_frame(np.broadcast_to(SUN, (COUNT, 3)), *orthonormal_frame(*frame))
    uv, stored = lookups.uv.astype(float), question.atlas.astype(float)
    wanted = sample_transfer(stored, LAYOUT, uv, direction, lookups.incidence, views) * [*IRRADIANCE, 1]

    def error(found: list[Floats]) -> tuple[float, float]:
        wrong = relative_error(found[0], wanted)
        return float(wrong.mean()), float(wrong.max())

    return Asked(
        lookup,
        [image(question.atlas)],
        mesh_of(lookups.uv, _places(), lookups.normal, lookups.tangent, lookups.sign, target),
        lookups.viewer,
        1,
        error,
        (1e-3, 2e-3),
    )


def layered(target: Target, name: str) -> Asked:
    """A made-up bake in the layered layout, of several materials."""
    case = case_of(name)
    facts = shader_facts(case.sidecar, case.stored, FULL)
    about = {layer: entry(_size(levels)) for layer, levels in case.textures.items()}
    lookup = layered_lookup(facts, about, target)
    fields = {name: values.astype(float) for name, values in case.fields.items()}
    side = np.ones(COUNT)
    mesh = mesh_of(
        fields["uvs"],
        fields["positions"],
        fields["normals"],
        fields["tangents"],
        side,
        target,
        (1.2, -0.8, 1.5),
    )
    return _asked(case, lookup, mesh, lambda found: _layered_error(case, found), {})


def by_images(target: Target, name: str) -> Asked:
    """The same, its materials shown by images: Unity has the rows from the bottom, Unreal from the top."""
    shown = image_case(name, packed=True)
    case = shown.case
    facts = shader_facts(case.sidecar, case.stored, FULL)
    for number, each in enumerate(facts["materials"]):
        each["radtex_images"] = shown.looks[number].rows
    facts["layers"] = [layer for layer in facts["layers"] if layer not in OF_IMAGES]  # none is left to read
    about = {layer: entry(_size(levels)) for layer, levels in case.textures.items()}
    fields = {name: values.astype(float) for name, values in case.fields.items()}
    normal, tangent = fields["normals"], fields["tangents"]
    side = np.sign((fields["bitangents"] * np.cross(normal, tangent)).sum(axis=1))
    mesh = mesh_of(
        *(fields["uvs"], fields["positions"], normal, tangent, side, target, (1.2, -0.8, 1.5), shown.place)
    )
    lookup = layered_lookup(facts, about, target)
    images = dict.fromkeys(lookup.of_images, tuple(imported(*each, target) for each in shown.images.items()))
    return _asked(case, lookup, mesh, lambda found: _image_error(shown, found), images)


def _asked(case: Case, lookup: HlslLookup, mesh: Mesh, error: Error, images: Images) -> Asked:
    """What is asked of a case in the layered layout."""
    layers = [texture.removeprefix("radtex_").removesuffix("_map") for texture in lookup.textures]
    textures = [image(*case.textures[layer]) for layer in layers]
    viewers = case.fields["viewers"].astype(float)
    return Asked(lookup, textures, mesh, viewers, len(case.sidecar.materials), error, (3e-3, 0.05), images)


def imported(texture: str, pixels: Floats, target: Target) -> Texture:
    """An image (H, W, 3), linear, row 0 below, as an engine has it: a normal map in DXT5nm or in BC5."""
    rows = pixels if target is Target.UNITY else pixels[::-1]
    if texture != BUMP:
        return image(rows.astype(np.float16))
    x, y = rows[..., 0], rows[..., 1]
    none, full = np.zeros_like(x), np.ones_like(x)
    channels = (full, y, none, x) if target is Target.UNITY else (x, y, none, full)
    return image(np.stack(channels, axis=-1).astype(np.float16))


def _image_error(shown: ImageCase, found: list[Floats]) -> tuple[float, float]:
    wrong = off(shown.case.by_material(lambda number: found[number]), shown.answers())
    return float(wrong.mean()), float(wrong.max())


def _places() -> Floats:
    """Where the vertices of a mesh are whose light does not depend on it, (K, 3)."""
    return np.random.default_rng(4).uniform(-1, 1, (COUNT, 3))


def _layered_error(case: Case, found: list[Floats]) -> tuple[float, float]:
    wrong = off(case.by_material(lambda number: found[number]), case.answers())
    return float(wrong.mean()), float(wrong.max())


def _size(levels: list[Floats]) -> tuple[int, int]:
    return levels[0].shape[1], levels[0].shape[0]


FORMS: dict[str, Callable[[Target], Asked]] = {
    "buckets": buckets,
    "buckets in pages": lambda target: buckets(target, paged=True),
    "transfer": relit,
    "layered": lambda target: layered(target, "made up"),
    "layered, by images": lambda target: by_images(target, "everything, in ranges"),
    "layered, light comes through": lambda target: layered(target, "everything, in ranges"),
    "layered, closed glass": lambda target: layered(target, "glass ball"),
}
