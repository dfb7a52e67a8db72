# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every form keeps to the interface: what it bakes is found, read, measured, exported, or refused."""

from __future__ import annotations

import json
from dataclasses import replace
from math import prod
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.errors import FormatError
from radtex_addon.core.fragments import Fragments
from radtex_addon.formats.containers.exr import read_whole
from radtex_addon.formats.sidecar_file import SidecarFile
from radtex_addon.forms import cost_of, form_for, form_in
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, Kind, Layout
from radtex_addon.store.bake_folder import BakeFolder
from radtex_addon.store.output_files import images_of
from radtex_addon.textures.export_spec import ExportSpec, Target, TextureFormat
from tests.blender import stage

pytestmark = pytest.mark.one_blender
context: Any = bpy.context  # to the stubs, every pointer may be None

PLAIN = BakeSpec(texels=16, bucket=4, samples=2, uv_layer="UVMap")
SPECS = {
    "buckets": PLAIN,
    "bits": replace(PLAIN, kind=Kind.SHADOW),
    "ambient": replace(PLAIN, kind=Kind.AO),
    "sphere": replace(PLAIN, kind=Kind.TRANSFER, bucket=3),
    "layered": replace(PLAIN, layout=Layout.LAYERED, samples=1, bucket=14),
}


@pytest.fixture(autouse=True)
def scene() -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.world((0.4, 0.6, 1.0))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6)
    context.object.name = "Ball"


@pytest.mark.usefixtures("whole_surroundings")
@pytest.mark.parametrize("name", SPECS)
def test_a_form_keeps_to_the_interface(name: str, tmp_path: Path) -> None:
    spec = SPECS[name]
    form = form_for(spec)
    assert form.traits.name == name
    result = bake_object(context.scene, "Ball", spec, tmp_path)
    images, sidecar = result.files.images, SidecarFile.read(result.files.sidecar)
    facts = sidecar.facts
    # found again, as what it is and nothing else
    assert form_in(facts) is form
    assert BakeFolder("Ball", spec, tmp_path).is_finished()
    assert not BakeFolder("Ball", replace(spec, texels=8), tmp_path).is_finished()
    assert set(images) <= set(form.images(spec, sidecar.path)) & images_of(sidecar.path)
    assert all(path.is_file() for path in images)
    # no dearer than was said before
    cost = cost_of(spec)
    assert result.paths <= cost.paths
    assert sum(path.stat().st_size for path in images) <= 1.1 * cost.disk + 4096 * len(images)
    assert cost.side == max(max(shape[:2]) for shape in form.shapes(sidecar).values())
    # its images are of the sizes that it tells
    shapes = form.shapes(sidecar)
    for path, (width, height, _) in zip(images, shapes.values(), strict=True):
        if path.suffix == ".exr":
            assert read_whole(path)[0].shape[:2] == (height, width)
    assert prod(next(iter(form.shapes(sidecar, texels=2).values()))[:2]) == 4 * prod(
        next(iter(shapes.values()))[:2]
    )
    # an export has the textures, includes and words that it tells
    assert form.export_bytes(sidecar) > 0
    folder = tmp_path / "export"
    folder.mkdir()
    entries = form.write_textures(sidecar, ExportSpec(Target.RAW, format=TextureFormat.AUTO), folder)
    assert tuple(entries) == form.textures_of(facts, entries)
    assert all((folder / entry.file).is_file() for entry in entries.values())
    shaders = Path(__file__).resolve().parents[2] / "shaders"
    assert all((shaders / f"{stem}.glsl").is_file() for stem in form.includes(facts.values))
    assert form.usage(facts.values, entries)
    if name in ("buckets", "layered"):
        check_lookup(form, sidecar)
    # what is damaged is refused
    images[0].write_bytes(images[0].read_bytes()[:64])
    with pytest.raises(FormatError, match=images[0].name):
        form.write_textures(sidecar, ExportSpec(Target.RAW), folder)


def check_lookup(form: Any, sidecar: SidecarFile) -> None:
    """Light is found at any texel, for any viewer."""
    opened = form.open(sidecar)
    up = np.tile([[0.0, 0.0, 1.0]], (3, 1))
    uv, across = np.array([[0.3, 0.5], [0.5, 0.5], [0.7, 0.6]]), np.tile([[1.0, 0.0, 0.0]], (3, 1))
    along = np.cross(up, across)
    light = opened.lookup(Fragments(uv, up, up, up, np.zeros(3, dtype=np.int32), across, along))
    assert light.shape == (3, 3)
    assert np.isfinite(light).all()
    assert (light > 0).all()
    height, width = opened.sidecar.height, opened.sidecar.width
    coarse = form.traits.name == "layered" and np.ptp(opened.texels) > 0 and len(opened.texels) < height
    side = 2 if coarse else 1  # an even irradiance tells nothing: then it is the buckets, of fewer texels
    assert tuple(side * count for count in opened.texels.shape[:2]) == (height, width)


def test_a_bake_of_the_former_shared_layout_is_refused_and_overwritten(tmp_path: Path) -> None:
    layers = ["colour", "irradiance", "surroundings", "mirror_gain", "through_ends_xy"]
    path = tmp_path / "Ball.radiance.json"
    path.write_text(json.dumps({"layout": "shared", "layers": layers, "tool": "RadTex 0.9.2"}))
    former = {tmp_path / f"Ball.radiance.{layer}.{ending}" for layer in layers for ending in ("exr", "dds")}
    for image in former:
        image.touch()
    words = (
        r"Ball\.radiance\.json is in the shared layout, made by 'RadTex 0\.9\.2', which this RadTex no "
        "longer reads: bake the object anew, in the layered layout, or use that version"
    )
    with pytest.raises(FormatError, match=words):
        form_in(SidecarFile.read(path).facts)
    assert former < images_of(path)
    files = bake_object(context.scene, "Ball", PLAIN, tmp_path, overwrite=True).files
    assert set(tmp_path.iterdir()) == {files.sidecar, *files.images}
