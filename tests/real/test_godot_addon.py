# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The addon for Godot in an empty project, into which the files of an export are dropped: what it shows.

With RADTEX_FIGURES=docs/figures pictures are kept: Compatibility, Forward+, Mobile.
"""

from __future__ import annotations

import os
import shutil
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.frame import normalised
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.gltf import extension_in
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.report.metrics import Picture, display
from radtex_addon.settings.spec import Kind
from radtex_addon.textures.export_spec import Arrangement, ExportSpec, MeshPacking, Target, TextureFormat
from tests.gltf_schema import EXTENSION_FOLDER
from tests.real.exhibit import CAMERAS, Camera, Exhibit, Form, decibels
from tests.real.godot import ALL_RENDERERS, MOBILE, Placed, Shot, filled, pictures, placed, said_by_godot
from tests.real.kinds import KindBake, Sun
from tests.real.root import Root
from tests.real.test_godot_project import flat_picture, picture_of_file
from tests.real.web import build_page

FRONT = CAMERAS[0]
LEAST = 38.0  # dB
LEAST_LIT = (
    32.0  # Mobile has 10 bits for light, in even steps; Compatibility encodes dark light by a rough curve
)
LEAST_BENT = 30.0  # Godot's ambient light is blurred otherwise than by the cosine
QUADRILINEAR = {"filtering": list(Filter).index(Filter.QUADRILINEAR)}
FIGURES = os.environ.get("RADTEX_FIGURES")
KTX2 = TextureFormat.KTX2_RGBA16F
DROPPED = {  # and how many decibels there must be at least
    "web": (Form.PLAIN, ExportSpec(Target.WEB, mesh=MeshPacking.PLAIN), LEAST),
    "web, layered": (Form.LAYERED, ExportSpec(Target.WEB, mesh=MeshPacking.PLAIN), LEAST),
    "gltf": (Form.PLAIN, ExportSpec(Target.GLTF), LEAST),
    "gltf, layered": (Form.LAYERED, ExportSpec(Target.GLTF), LEAST),
    "few levels": (Form.PLAIN, ExportSpec(Target.GLTF, KTX2, levels=3), LEAST),
    "pages": (Form.PLAIN, ExportSpec(Target.GODOT, levels=1, limit=256), LEAST),
    "slices": (Form.PLAIN, ExportSpec(Target.GODOT, levels=1, arrangement=Arrangement.SLICES), LEAST),
    "OpenEXR": (Form.PLAIN, ExportSpec(Target.GLTF, TextureFormat.EXR, levels=1), LEAST),
    "half floats": (Form.PLAIN, ExportSpec(Target.GODOT, KTX2, levels=1), LEAST),
    "BC6H": (Form.PLAIN, ExportSpec(Target.GODOT, TextureFormat.KTX2_BC6H, levels=1), LEAST),
    "DDS, layered": (Form.LAYERED, ExportSpec(Target.GLTF, TextureFormat.DDS_BC6H), LEAST),
    "half floats, layered": (Form.LAYERED, ExportSpec(Target.GODOT, KTX2), 40.0),
    "BC6H, layered": (Form.LAYERED, ExportSpec(Target.GODOT, TextureFormat.KTX2_BC6H), LEAST),
}
SUNS = (Sun(-40, 45), Sun(-40, 45, 30), Sun(110, 20, 8))
LIGHTS = (Sun(-40, 45, strength=3), Sun(180, 10, strength=5, colour="#ffc080"), Sun(90, -30, strength=2))


def exported(sidecar: Path, spec: ExportSpec, folder: Path) -> Path:
    if spec.target is Target.WEB:
        build_page()
    deque(export_steps(sidecar, spec, folder / "export"), maxlen=0)
    return folder / "export"


@pytest.mark.parametrize("name", DROPPED)
def test_a_dropped_export_shows_what_the_reference_does(
    name: str, exhibit: Exhibit, root: Root, tmp_path: Path
) -> None:
    """In all renderers; of other textures than the targets' own choice in one of each family."""
    form, spec, least = DROPPED[name]
    bake = exhibit.layered if form is Form.LAYERED else exhibit.plain
    place = placed(root, exported(bake.sidecar, spec, tmp_path))
    filtering = QUADRILINEAR if form is Form.PLAIN and name != "slices" else {}
    shots = [Shot(FRONT, filtering), Shot(FRONT, filtering, turn=70)]
    own = name.removesuffix(", layered") in (Target.WEB, Target.GLTF)
    reference = bake.picture(FRONT)
    if name == "BC6H":
        reference = picture_of_file(bake, next(place.folder.glob("*.ktx2")))
    for renderer in ALL_RENDERERS if own else ("Compatibility", MOBILE):
        for shot, picture in zip(shots, place.pictures(renderer, shots), strict=True):
            found = decibels(picture, reference, bake.eroded(FRONT))
            print(f"{name}, {renderer}, turned by {shot.turn}: {found:.1f} dB")
            assert found > least


@pytest.mark.parametrize("cells", [5, 8, 12])
def test_lights_of_the_scene_cast_baked_shadows(
    cells: int, kind_bake: Callable[..., KindBake], root: Root, tmp_path: Path
) -> None:
    made = kind_bake(Kind.SHADOW, cells)
    target = Target.GODOT if cells == 8 else Target.GLTF
    place = placed(root, exported(made.sidecar, ExportSpec(target), tmp_path))
    shots = [
        Shot(camera, {"sun_angle": sun.size}, sun=sun) for camera, sun in zip(CAMERAS, SUNS, strict=True)
    ]
    renderers = {5: ("Compatibility",), 8: tuple(ALL_RENDERERS), 12: (MOBILE,)}[cells]
    _compare(made, place, [*shots, _by_its_own_sun(SUNS[0])], [*SUNS, SUNS[0]], renderers)


def test_lights_of_the_scene_ask_for_transfer(
    kind_bake: Callable[..., KindBake], root: Root, tmp_path: Path
) -> None:
    made = kind_bake(Kind.TRANSFER)
    place = placed(root, exported(made.sidecar, ExportSpec(Target.GODOT), tmp_path))
    shots = [Shot(camera, sun=sun) for camera, sun in zip(CAMERAS, LIGHTS, strict=True)]
    _compare(made, place, [*shots, _by_its_own_sun(LIGHTS[0])], [*LIGHTS, LIGHTS[0]])


def _by_its_own_sun(sun: Sun) -> Shot:
    """By the material's parameters, without a light in the scene."""
    towards: list[float] = sun.towards.tolist()
    own: dict[str, float | list[float]] = {"sun_direction": towards, "sun_strength": sun.strength}
    return Shot(FRONT, {**own, "sun_angle": sun.size}, sun=Sun(0, 45, strength=0))


def _compare(
    made: KindBake,
    place: Placed,
    shots: list[Shot],
    suns: list[Sun],
    renderers: Sequence[str] = tuple(ALL_RENDERERS),
) -> None:
    strip = []
    for renderer in renderers:
        taken = place.pictures(renderer, shots)
        strip.append(taken[0])
        for shot, sun, picture in zip(shots, suns, taken, strict=True):
            wanted = made.seen(shot.camera, sun)[..., :3]
            found = decibels(picture, wanted, made.eroded(shot.camera))
            print(f"{made.kind}, {renderer}, {shot.camera.name}, {sun}: {found:.1f} dB")
            assert found > LEAST_LIT
    if len(strip) == len(ALL_RENDERERS):
        _keep(f"godot-{made.kind}", strip)


def test_ambient_light_comes_along_the_bent_normal(
    kind_bake: Callable[..., KindBake], root: Root, tmp_path: Path
) -> None:
    """A white sky shows the openness; of one that is white above alone, half as much comes to what faces
    aside, by the cosine of its bent normal: the plain normal gives another picture."""
    made = kind_bake(Kind.AO)
    place = placed(root, exported(made.sidecar, ExportSpec(Target.GODOT), tmp_path))
    shots = [Shot(FRONT, sky=(1, 1)), *(Shot(camera, sky=(1, 0)) for camera in CAMERAS)]
    mask, strip = made.eroded(FRONT), []
    for renderer in ALL_RENDERERS:
        white, *half = place.pictures(renderer, shots)
        strip.append(half[0])
        found = decibels(white, made.seen(FRONT)[..., :3], mask)
        print(f"ao, {renderer}, white: {found:.1f} dB")
        assert found > LEAST
        for camera, picture in zip(CAMERAS, half, strict=True):
            bent, plain = (_under_half_a_sky(made, camera, bent=way) for way in (True, False))
            near, far = (decibels(picture, wanted, made.eroded(camera)) for wanted in (bent, plain))
            print(f"ao, {renderer}, {camera.name}: {near:.1f} dB, by the plain normal {far:.1f} dB")
            assert near > LEAST_BENT
            assert near > far + 1
    _keep("godot-ao", strip)


def _under_half_a_sky(made: KindBake, camera: Camera, *, bent: bool) -> Picture:
    """White light from above the horizon alone, (H, W, 3): (1 + the normal's height) / 2 of the openness."""
    pixels, facts = read_buckets(made.sidecar)
    buffer = made.buffer(camera)
    layout, hit = AtlasLayout(facts.width, facts.height, facts.bucket), buffer.hit
    incidence = buffer.incidence[hit]
    stored = sample(pixels.astype(np.float32), layout, buffer.uv[hit], incidence, Filter.QUADRILINEAR)
    frame = np.stack([buffer.tangent[hit], buffer.bitangent[hit], buffer.normal[hit]], axis=1)
    way = normalised(np.einsum("kc,kcx->kx", stored[:, :3], frame)) if bent else buffer.normal[hit]
    light = stored[:, 3] * (1 + way[:, 2]) / 2
    return buffer.resolve(buffer.spread(np.repeat(light[:, None], 3, axis=1)))


def test_a_game_loads_a_file_while_it_runs(exhibit: Exhibit, root: Root, tmp_path: Path) -> None:
    """From a folder that Godot's editor never saw, and with the autoload that enabling the plugin adds."""
    bake = exhibit.plain
    export = exported(bake.sidecar, ExportSpec(Target.GLTF), tmp_path)
    place = placed(root, export, at_run_time=True)
    (picture,) = place.pictures("Forward+", [Shot(FRONT, QUADRILINEAR)])
    found = decibels(picture, bake.picture(FRONT), bake.eroded(FRONT))
    print(f"loaded at run time: {found:.1f} dB")
    assert found > LEAST


def test_what_it_cannot_load_it_names_and_the_flat_lightmap_shows(
    exhibit: Exhibit, root: Root, tmp_path: Path
) -> None:
    bake = exhibit.plain
    whole = exported(bake.sidecar, ExportSpec(Target.GLTF), tmp_path)
    names = ("scaled", "cut", "missing", "newer")
    exports = {name: Path(shutil.copytree(whole, tmp_path / name)) for name in names}
    exports["compressed"] = exported(
        bake.sidecar, ExportSpec(Target.GLTF, mesh=MeshPacking.MESHOPT), tmp_path / "packed"
    )
    (texture,), (mesh,) = whole.glob("*.ktx2"), whole.glob("*.glb")
    (exports["cut"] / texture.name).write_bytes(texture.read_bytes()[:50])
    (exports["missing"] / texture.name).unlink()
    glb = Glb.read(mesh)
    extension_in(glb.document["materials"][0])["version"] = 2
    glb.write(exports["newer"] / mesh.name)
    place = filled(root, exports, {"scaled": {"nodes/root_scale": 2.0}})
    said = said_by_godot(root, ["--headless", "--path", place[1], "--import"])
    assert f"cut/{texture.name} is no KTX2 file: copy all files" in said
    missing = f"missing/{texture.name} is missing: copy all files of the export's folder, side by side"
    assert missing in said
    assert "was exported in version 2" in said
    assert f"{mesh.name.removesuffix('.glb')} is compressed by EXT_meshopt_compression" in said.replace(
        ".glb", ""
    )
    assert "Root Scale 2" in said
    (picture,) = pictures(root, place, "Forward+", [Shot(FRONT)], "missing")
    found = decibels(picture, flat_picture(bake, next(whole.glob("*.flat.png"))), bake.eroded(FRONT))
    print(f"the flat lightmap: {found:.1f} dB")
    assert found > LEAST


def test_the_editor_makes_no_levels_of_detail(root: Root) -> None:
    """Nor does it where the Import dock's Materials: Extract makes files of the materials."""
    settings = {
        name: {"materials/extract": extract, "materials/extract_format": 0, "materials/extract_path": ""}
        for extract, name in enumerate(("kept", "extracted"))
    }
    folder, inside = filled(root, dict.fromkeys(settings, EXTENSION_FOLDER / "example"), settings)
    said_by_godot(root, ["--headless", "--path", inside, "--import"])
    assert [len(list((folder / name).glob("*.tres"))) for name in settings] == [0, 1]
    shutil.copy(Path(__file__).parent / "inside/godot/lods.gd", folder)
    said = said_by_godot(root, ["--headless", "--path", inside, "--script", "res://lods.gd"])
    assert said.count("Ball: 1 surface, 0 levels of detail, of radtex/surfaces") == 2


@pytest.mark.parametrize("form", Form)
def test_an_extracted_material_of_another_export_is_warned_of(
    form: Form, exhibit: Exhibit, root: Root, tmp_path: Path
) -> None:
    """Godot goes on to use it. That of this export is no reason to warn, however often it is imported."""
    export = EXTENSION_FOLDER / "example"
    if form is Form.LAYERED:
        export = exported(exhibit.layered.sidecar, ExportSpec(Target.GLTF), tmp_path)
    settings = {"materials/extract": 1, "materials/extract_format": 0, "materials/extract_path": ""}
    folder, inside = filled(root, {"own": export}, {"own": settings})
    said = [said_by_godot(root, ["--headless", "--path", inside, "--import"])]
    (mesh,) = (folder / "own").glob("*.glb")
    assert list((folder / "own").glob("*.tres"))
    glb = Glb.read(mesh)
    for change in ("none", "another export"):
        glb.document["asset"]["generator"] = change  # another file, which is imported again
        if change != "none":
            for material in glb.document["materials"]:
                _change(extension_in(material))
        glb.write(mesh)
        said.append(said_by_godot(root, ["--headless", "--path", inside, "--import"]))
    warned = ["is the material of another export" in each for each in said]
    print(warned, said[-1][-2000:])
    assert warned == [False, False, True]


def _change(facts: dict[str, Any]) -> None:
    """Let the JSON say another value, such as another export has."""
    if "shader" in facts:
        for material in facts["shader"]["materials"]:
            name, found = next(iter(material.items()))
            material[name] = [[0.5] * 4] * len(found) if isinstance(found[0], list) else [0.5] * 4
    else:
        facts["textures"]["radiance"]["levels"] -= 1


def _keep(name: str, strip: list[Picture]) -> None:
    if FIGURES:
        shown = display(np.concatenate(strip, axis=1))
        image = Image.fromarray((shown * 255 + 0.5).astype(np.uint8))
        image.save(Path(FIGURES, f"{name}.png"), optimize=True)
