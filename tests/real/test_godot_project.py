# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The exported project in a real Godot against the reference sampler's pictures, its mirror against Cycles'.

With RADTEX_FIGURES=docs/figures the pictures are kept: reference, Compatibility, Forward+, Mobile.
"""

from __future__ import annotations

import os
import shutil
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.ndimage import binary_dilation

from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import InputError
from radtex_addon.core.fragments import Fragments
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.exporting_scene import export_scene_steps
from radtex_addon.export.gltf import extension_in
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.formats.containers.ktx2 import write_ktx2
from radtex_addon.formats.containers.texture import PixelFormat, decode_texture, encode_texture
from radtex_addon.forms.layered.lookup.atlas import sample_layered
from radtex_addon.forms.layered.shader_values import FULL, shader_facts
from radtex_addon.report.metrics import Picture, display
from radtex_addon.textures.entry import Arranged, Container, TextureEntry
from radtex_addon.textures.export_spec import Arrangement, ExportSpec, Target, TextureFormat
from tests.layered_lookups import Case, case_of
from tests.real import mirror_scene
from tests.real.exhibit import CAMERAS, Bake, Camera, Exhibit, Form, decibels
from tests.real.godot import (
    ALL_RENDERERS,
    MOBILE,
    RENDERERS,
    Placed,
    Shot,
    imported,
    light_of,
    pictures,
    placed,
    run_godot,
)
from tests.real.mirror_scene import PLACES, RADIUS, SKY, Stage, keep_row
from tests.real.root import Root, screen
from tests.reference.textures import read_ktx2

LEAST = 38.0  # dB
LEAST_MADE_UP, MATERIAL = 48.0, 1
MODES = {kind: mode for mode, kind in enumerate(Filter)}
FRONT = CAMERAS[0]
DEFAULT = ExportSpec(Target.GODOT)
Opened = Callable[[Form, ExportSpec], Placed]
FIGURES = os.environ.get("RADTEX_FIGURES")
INSIDE = Path(__file__).parent / "inside" / "godot"
DRAG = """
set -e
godot --audio-driver Dummy --path . --rendering-method gl_compatibility --rendering-driver opengl3 \\
    --resolution 640x480 --position 0,0 > godot.log 2>&1 &
pixels() { import -window root "$1" && identify -format '%#' "$1"; }
# Keep a picture that is another than the last one that was kept, and stands still: four times the same.
kept=nothing
keep() {
    last=nothing
    same=0
    for attempt in $(seq 300); do
        now=$(pixels "$1.png")
        if [ "$now" = "$last" ]; then same=$((same + 1)); else same=0; fi
        last=$now
        if [ $same -ge 3 ] && [ "$now" != "$kept" ]; then kept=$now; return; fi
    done
}
for attempt in $(seq 60); do
    keep before
    [ "$(identify -format '%k' before.png)" -gt 1000 ] && break
done
xdotool mousemove 200 240 mousedown 1 mousemove_relative 120 0 mousemove_relative 120 30 mouseup 1
keep turned
xdotool click 5 click 5 click 5 click 5
keep farther
cp godot.log said.log
kill $!
wait
"""


def project(bake: Bake, folder: Path, spec: ExportSpec = DEFAULT) -> Path:
    """The exhibit's bake, exported."""
    deque(export_steps(bake.sidecar, spec, folder / "project"), maxlen=0)
    return folder / "project"


@pytest.fixture(scope="module")
def opened(exhibit: Exhibit, root: Root, tmp_path_factory: pytest.TempPathFactory) -> Opened:
    """Exports of the exhibit after Godot's import, which takes longer than a picture: each is made once."""

    @cache
    def imported_once(form: Form, spec: ExportSpec) -> Placed:
        return placed(root, project(getattr(exhibit, form), tmp_path_factory.mktemp("godot"), spec))

    return imported_once


def shots_of(form: Form) -> list[Shot]:
    """The exhibit's cameras, quadrilinear without mipmaps as the reference; the last one with all turned."""
    parameters = {"filtering": MODES[Filter.QUADRILINEAR]} if form is Form.PLAIN else {}
    return [*(Shot(camera, parameters) for camera in CAMERAS), Shot(FRONT, parameters, turn=70)]


@pytest.mark.parametrize("form", Form)
def test_godot_shows_the_reference(form: Form, exhibit: Exhibit, root: Root, opened: Opened) -> None:
    bake: Bake = getattr(exhibit, form)
    shots = shots_of(form)
    shown = {renderer: opened(form, DEFAULT).pictures(renderer, shots) for renderer in ALL_RENDERERS}
    for renderer, taken in shown.items():
        for shot, picture in zip(shots, taken, strict=True):
            reference, inside = bake.picture(shot.camera), bake.inside(shot.camera)
            found = decibels(picture, reference, bake.eroded(shot.camera))
            print(f"{renderer} {form}, {shot.camera.name}, turned by {shot.turn}: {found:.1f} dB")
            assert found > LEAST
            assert decibels(picture, reference, np.ones_like(inside)) > LEAST
    if FIGURES:
        strip = [bake.picture(FRONT), *(taken[0] for taken in shown.values())]
        _keep(Path(FIGURES, f"godot-{form}.png"), strip)


def test_each_filter_and_the_exposure_do_what_they_say(exhibit: Exhibit, root: Root, opened: Opened) -> None:
    bake = exhibit.plain
    shots = [*(Shot(FRONT, {"filtering": mode}) for mode in MODES.values()), Shot(FRONT, {"exposure": 0.25})]
    *taken, darker = opened(Form.PLAIN, DEFAULT).pictures("Compatibility", shots)
    for kind, picture in zip(MODES, taken, strict=True):
        found = {other: decibels(picture, bake.picture(FRONT, other), bake.eroded(FRONT)) for other in Filter}
        print(f"{kind}: {found[kind]:.1f} dB")
        assert found[kind] > LEAST
        assert max(found, key=lambda other: found[other]) is kind
    assert decibels(darker, bake.picture(FRONT) / 4, bake.eroded(FRONT)) > LEAST


def picture_of_file(bake: Bake, path: Path) -> Picture:
    """What the reference sampler sees of a bucket matrix that lost something when it was packed."""
    (image,) = decode_texture(read_ktx2(path))
    buffer, facts = bake.buffer(FRONT), bake.finished.sidecar
    layout = AtlasLayout(facts.width, facts.height, facts.bucket)
    pixels = image[0, : layout.pixel_height, : layout.pixel_width, :3].astype(float)
    seen = sample(pixels, layout, buffer.uv[buffer.hit], buffer.incidence[buffer.hit], Filter.QUADRILINEAR)
    return buffer.resolve(buffer.spread(seen))


def test_far_away_mipmaps_show_what_more_samples_show(exhibit: Exhibit, root: Root, opened: Opened) -> None:
    """From afar, against the mean of 8 x 8 lookups a pixel: with levels it is nearer to that than without."""
    bake = exhibit.plain
    large = replace(FRONT, place=(11.0, -24.0, 6.0), pixels=512)
    small = replace(large, pixels=64)
    mean = bake.picture(large).reshape(64, 8, 64, 8, 3).mean(axis=(1, 3))
    whole = bake.inside(large).reshape(64, 8, 64, 8).all(axis=(1, 3))
    shots = [Shot(small, {"filtering": mode}) for mode in (3, 2)]
    by_levels, plain = opened(Form.PLAIN, DEFAULT).pictures("Compatibility", shots)
    assert decibels(by_levels, mean, whole) > decibels(plain, mean, whole) + 0.5


def test_dragging_turns_it_and_the_wheel_moves_it(exhibit: Exhibit, root: Root, tmp_path: Path) -> None:
    folder, inside = imported(root, project(exhibit.plain, tmp_path))
    ended = root.run(screen(["sh", "-c", DRAG], 640, 480), cwd=inside, timeout=240)
    said = (folder / "said.log").read_text(encoding="utf-8")
    assert ended.returncode == 0, ended.stderr
    assert "ERROR" not in said, said
    before, turned, farther = (light_of(folder / f"{name}.png") for name in ("before", "turned", "farther"))
    sizes = [np.count_nonzero(picture.max(axis=2) > 0.01) for picture in (before, turned, farther)]
    print(f"pixels of it: {sizes}")
    assert np.mean(np.abs(turned - before)[before.max(axis=2) > 0.01]) > 0.02
    assert sizes[2] < 0.75 * sizes[1]


def test_without_our_extension_the_mesh_shows_the_flat_lightmap(
    exhibit: Exhibit, root: Root, tmp_path: Path
) -> None:
    bake = exhibit.plain
    exported = project(bake, tmp_path)
    (mesh,), (flat,) = exported.glob("*.glb"), exported.glob("*.flat.png")
    bare = tmp_path / "bare"
    bare.mkdir()
    for file in (INSIDE / "project.godot", INSIDE / "open.gd"):
        shutil.copy(file, bare)
    shutil.copy(mesh, bare / "mesh.glb")
    place = imported(root, bare)
    run_godot(root, ["--headless", "--path", place[1], "--script", "res://open.gd"])
    (picture,) = pictures(root, place, "Forward+", [Shot(FRONT)])
    found = decibels(picture, flat_picture(bake, flat), bake.eroded(FRONT))
    print(f"{found:.1f} dB")
    assert found > LEAST


def flat_picture(bake: Bake, flat: Path) -> Picture:
    """The bake with the PNG of its flat lightmap, as the front camera sees it."""
    buffer, light = bake.buffer(FRONT), light_of(flat)[::-1]
    layout = AtlasLayout(light.shape[1], light.shape[0], 1)
    seen = sample(light, layout, buffer.uv[buffer.hit], buffer.incidence[buffer.hit], Filter.QUADRILINEAR)
    return buffer.resolve(buffer.spread(seen))


def test_what_godot_does_not_load_is_refused(exhibit: Exhibit, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="godot does not read it: choose from"):
        ExportSpec(Target.GODOT, format=TextureFormat.EXR)
    spec = ExportSpec(Target.GODOT, TextureFormat.KTX2_RGBA16F, arrangement=Arrangement.SLICES)
    with pytest.raises(InputError, match="choose DDS RGBA16F"):
        project(exhibit.plain, tmp_path, spec)
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize("form", Form)
def test_an_object_in_a_scene_looks_as_the_reference(
    form: Form, exhibit: Exhibit, room: list[Path], root: Root, tmp_path: Path
) -> None:
    bake: Bake = getattr(exhibit, form)
    sidecars = [room[-3], bake.sidecar, *room[-2:]]
    made = finished(export_scene_steps(sidecars, ExportSpec(Target.GODOT), "Room", tmp_path / "project"))
    project = placed(root, made.folder)
    parameters = {"filtering": 2.0} if form is Form.PLAIN else {}
    shots = [Shot(camera, parameters) for camera in CAMERAS]
    for shot, picture in zip(shots, project.pictures("Compatibility", shots), strict=True):
        found = decibels(picture, bake.picture(shot.camera), bake.eroded(shot.camera))
        print(f"{form}, {shot.camera.name}: {found:.1f} dB")
        assert found > LEAST
        beside = picture[~binary_dilation(bake.inside(shot.camera), iterations=2)]
        assert (beside.max() > 0.1) == (shot.camera.name == "left"), "behind the head are the trees, once"


@pytest.mark.parametrize("form", Form)
def test_the_ball_shows_what_cycles_shows(
    form: Form, stages: dict[Form, Stage], root: Root, tmp_path: Path
) -> None:
    stage = stages[form]
    spec = ExportSpec(Target.GODOT, mirror=True, sky=SKY)
    deque(export_steps(stage.bake.sidecar, spec, tmp_path / "project"), maxlen=0)
    project = placed(root, tmp_path / "project")
    shots = [Shot(mirror_scene.CAMERA, mirror=(*place, RADIUS)) for place in PLACES]
    shots.append(Shot(mirror_scene.CAMERA, turn=70, mirror=(*PLACES[0], RADIUS)))
    for renderer in ALL_RENDERERS:
        taken = project.pictures(renderer, shots)
        keep_row(f"mirror-godot-{form}-{renderer}", [*stage.pictures], taken[: len(PLACES)])
        for number, picture in enumerate(taken):
            which = number % len(PLACES)
            found = decibels(picture, stage.reference(which), stage.inside[which])
            print(
                f"{renderer} {form}, ball at {PLACES[which]}, turned by {shots[number].turn}: {found:.1f} dB"
            )
            assert found >= mirror_scene.LEAST
            other = (which + 1) % len(PLACES)
            assert decibels(picture, stage.reference(other), stage.inside[which]) < mirror_scene.LEAST


# A made-up bake in the layered layout, on the exhibit's head, so that wrong places are seen.
STEADY = "const STEADY := 0.16"


def texture(layer: str, levels: list[Floats], folder: Path) -> TextureEntry:
    """Write a layer's texture; its entry.

    Godot wants all mip levels or none: those after the last are never seen.
    """
    filled, levels = [], list(levels)
    while len(levels) > 1 and len(levels[-1]) > 1:
        levels.append(levels[-1][::2, ::2])
    for level in levels:
        four = np.ones((1, *level.shape[:2], 4), np.float32)
        four[0, ..., : level.shape[2]] = level
        filled.append(four)
    name = f"Head.{layer}.ktx2"
    write_ktx2(folder / name, encode_texture(filled, PixelFormat.RGBA16F), zstd=False, premultiplied=False)
    size = (levels[0].shape[1], levels[0].shape[0])
    kind, arranged = PixelFormat.RGBA16F, Arranged.IMAGE
    return TextureEntry(
        name, Container.KTX2, kind, False, arranged, size, 1, size, size, len(levels), (1, 1), size
    )


def made_up_project(bake: Bake, case: Case, folder: Path) -> Path:
    """The exhibit's plain bake, exported; what its .glb says of the bake replaced by a layered one's."""
    place = folder / "project"
    deque(export_steps(bake.sidecar, ExportSpec(Target.GODOT), place), maxlen=0)
    (path,) = place.glob("*.glb")
    (script,) = place.rglob("materials.gd")
    code = script.read_text(encoding="utf-8")
    assert STEADY in code
    script.write_text(code.replace(STEADY, "const STEADY := 0.0"), encoding="utf-8")  # lookups are compared
    glb = Glb.read(path)
    (material,) = glb.document["materials"]
    facts = extension_in(material)
    facts["shader"] = shader_facts(case.sidecar, case.stored, FULL)
    entries = {layer: texture(layer, levels, place) for layer, levels in case.textures.items()}
    facts["textures"] = {layer: entry.facts() for layer, entry in entries.items()}
    facts["material"] = MATERIAL
    glb.write(path)
    return place


def made_up_picture(bake: Bake, case: Case, camera: Camera) -> Picture:
    """What the reference sampler sees, (H, W, 3)."""
    buffer = bake.buffer(camera)
    hit = buffer.hit
    fields = (buffer.uv, buffer.normal, buffer.incoming, buffer.position, buffer.tangent, buffer.bitangent)
    uv, normal, viewer, position, tangent, bitangent = (field[hit].astype(np.float32) for field in fields)
    material = np.full(len(uv), MATERIAL)
    seen = sample_layered(case.atlas, Fragments(uv, normal, viewer, position, material, tangent, bitangent))
    return buffer.resolve(buffer.spread(seen))


@pytest.mark.parametrize("name", ["made up", "opaque, in ranges"])
def test_godot_shows_a_layered_bake(name: str, exhibit: Exhibit, root: Root, tmp_path: Path) -> None:
    bake, case = exhibit.plain, case_of(name)
    project = imported(root, made_up_project(bake, case, tmp_path))
    shots = [*(Shot(camera) for camera in CAMERAS), Shot(FRONT, turn=70), Shot(FRONT, {"exposure": 0.25})]
    for renderer in RENDERERS:
        for shot, picture in zip(shots, pictures(root, project, renderer, shots), strict=True):
            exposure = 0.25 if shot.parameters else 1.0
            wanted = made_up_picture(bake, case, shot.camera) * exposure
            found = decibels(picture, wanted, bake.eroded(shot.camera))
            print(f"{renderer} {name}, {shot.camera.name}, turned by {shot.turn}: {found:.1f} dB")
            assert found > LEAST_MADE_UP
    wrong = replace(case.atlas, around=replace(case.atlas.around, middle=case.atlas.around.middle + 0.5))
    elsewhere = made_up_picture(bake, replace(case, atlas=wrong), FRONT)
    assert decibels(elsewhere, made_up_picture(bake, case, FRONT), bake.eroded(FRONT)) < LEAST_MADE_UP


def test_a_project_asks_for_cheaper_lookups(exhibit: Exhibit, root: Root, tmp_path: Path) -> None:
    bake, case = exhibit.plain, case_of("made up")
    place = made_up_project(bake, case, tmp_path)
    with (place / "project.godot").open("a", encoding="utf-8") as settings:
        settings.write("\n[radtex]\n\nlookups/temporal=true\n")
    (noisy,) = pictures(root, imported(root, place), next(iter(RENDERERS)), [Shot(FRONT)])
    found = decibels(noisy, made_up_picture(bake, case, FRONT), bake.eroded(FRONT))
    print(f"drawn by chance: {found:.1f} dB")
    assert 15 < found < LEAST_MADE_UP


@pytest.mark.parametrize("form", Form)
def test_a_project_lets_opaque_bakes_fade(form: Form, exhibit: Exhibit, root: Root, tmp_path: Path) -> None:
    """In the renderers without Godot's own transparency: whole as ever, and clear by half and by all."""
    bake: Bake = getattr(exhibit, form)
    place = project(bake, tmp_path)
    with (place / "project.godot").open("a", encoding="utf-8") as settings:
        settings.write("\n[radtex]\n\nmaterials/fading=true\n")
    imported_once = imported(root, place)
    shots = [
        replace(shots_of(form)[0], parameters={**shots_of(form)[0].parameters, "material_opacity": share})
        for share in (1.0, 0.5, 0.0)
    ]
    mask = bake.eroded(FRONT)
    for renderer in ("Compatibility", MOBILE):
        whole, half, none = pictures(root, imported_once, renderer, shots)
        found, ratio = decibels(whole, bake.picture(FRONT), mask), half[mask].mean() / whole[mask].mean()
        print(f"{renderer} {form}: {found:.1f} dB, by half {ratio:.2f} of the light")
        assert found > LEAST
        assert 0.2 < ratio < 0.8
        assert none.max() < 0.01


def _keep(path: Path, taken: list[Picture]) -> None:
    strip = display(np.concatenate(taken, axis=1))
    Image.fromarray((strip * 255 + 0.5).astype(np.uint8)).save(path, optimize=True)
