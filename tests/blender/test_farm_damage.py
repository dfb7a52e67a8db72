# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A farm that was edited on its way: refused in one line by a name, never believed."""

from __future__ import annotations

import json
import os
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import OpenEXR
import pytest

from radtex_addon.core.errors import BakeError, FormatError, RadTexError
from radtex_addon.formats.disk.regular import digest
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, Layer
from tests.blender import stage
from tests.blender.farming import assembled, prepared, render, rewrite_frame

pytestmark = pytest.mark.one_blender

SPEC = BakeSpec(texels=16, bucket=4, samples=1, sheet=24)
_BOX = "Box"


def _build() -> Any:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.world()
    bpy.ops.mesh.primitive_cube_add(size=1)
    bpy.context.object.name = _BOX
    return bpy.context.scene


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A farm with a preview, all of whose frames are there."""
    farm = prepared(_build(), SPEC, tmp_path_factory.mktemp("farm"), preview=True).files.folder
    last = json.loads((farm / "farm.json").read_text())["frames"][1]
    render(farm, f"1..{last}")
    return farm


@pytest.fixture
def farm(whole: Path, tmp_path: Path) -> Path:
    """A copy to do harm to."""
    return Path(shutil.copytree(whole, tmp_path / whole.name))


Facts = dict[str, Any]


def _edit(farm: Path, change: Callable[[Facts], None]) -> None:
    """Change the manifest; digests then fit what lies there."""
    facts = json.loads((farm / "farm.json").read_text())
    facts["digests"] = {name: digest(farm / name) for name in facts["digests"]}
    change(facts)
    (farm / "farm.json").write_text(json.dumps(facts))


def _set(*keys: str, to: Any) -> Callable[[Facts], None]:
    def change(facts: Facts) -> None:
        for key in keys[:-1]:
            facts = facts[key]
        facts[keys[-1]] = to

    return change


@pytest.mark.parametrize(
    "change",
    [
        _set("name", to="Nobody"),
        _set("name", to="\ud800"),
        _set("preview", "meshes", to=[]),
        _set("preview", "meshes", to=["Nobody"]),
        _set("preview", "meshes", to=["Bo\ud800"]),
        _set("preview", "objects", to=["Nobody"]),
        _set("preview", "scene", to="Nowhere"),
        _set("spec", "kind", to="transfer"),
        _set("spec", "layout", to="layered"),
        _set("spec", "kind", to="proxy"),
        _set("spec", "split", to="material"),
        _set("spec", "source", to="Nobody"),
        _set("spec", "objects", to=["Box", "Nobody"]),
        _set("spec", "lights", to=[1]),
        _set("spec", "compression", to=7),
        _set("spec", "accumulate", to=True),
        _set("digests", to={}),
        _set("digests", to={"../../../etc/passwd": "0"}),
        _set("frames", to=[1, 2**40]),
        _set("rows", to=2**40),
        _set("sidecar", "kind", to="incident"),
        _set("sidecar", "texels", to=[8, 2**30]),
    ],
)
def test_an_edited_manifest_is_refused_in_one_line(
    change: Callable[[Facts], None], farm: Path, out: Path
) -> None:
    _edit(farm, change)
    with pytest.raises(RadTexError) as caught:
        assembled(farm, out)
    said = str(caught.value)
    assert str(farm) in said, said
    assert "\n" not in said


def _plan(**arrays: Any) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        with np.load(path) as found:
            before = dict(found)
        np.savez_compressed(path, **(before | arrays))

    return write


def _bomb(path: Path) -> None:
    """An array of 256 MiB of zeros in a few hundred KB."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        with archive.open("texel.npy", "w", force_zip64=True) as file:
            cast(Any, np.lib.format).write_array_header_1_0(
                file, {"descr": "<i8", "fortran_order": False, "shape": (1 << 25,)}
            )
            for _ in range(4):
                file.write(bytes(1 << 26))
        archive.writestr("hidden.npy", b"")


@pytest.mark.parametrize(
    "damage",
    [
        lambda path: path.write_bytes(b"no archive"),
        lambda path: path.write_bytes(path.read_bytes()[:-30]),
        lambda path: np.savez(path, texel=np.arange(3)),
        _plan(texel=np.zeros(0, dtype=np.int64)),
        _plan(texel=np.array([[1, 2]])),
        _plan(texel=np.array([7.5])),
        _plan(texel=np.array(["a"])),
        _plan(texel=np.array([{}], dtype=object)),
        _plan(texel=np.arange(10**6)),
        _plan(texel=np.arange(64)[::-1]),
        _plan(texel=np.arange(-3, 40)),
        _plan(normal=np.zeros((1, 3), dtype=np.float32)),
        _plan(normal=np.full((64, 3), np.nan, dtype=np.float32)),
        _plan(hidden=np.zeros((1, 1), dtype=np.uint8)),
        _plan(hidden=np.zeros((0, 3), dtype=np.int64)),
        _bomb,
    ],
)
def test_a_plan_whose_digest_fits_is_looked_at_nonetheless(
    damage: Callable[[Path], None], farm: Path, out: Path
) -> None:
    damage(farm / "plan.npz")
    _edit(farm, lambda _: None)
    with pytest.raises(FormatError, match=r"plan\.npz|farm\.json"):
        assembled(farm, out)
    assert not out.exists()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes")
@pytest.mark.parametrize(
    "name", ["plan.npz", "preview.blend", "farm.json", "frames/0001.exr", "frames/x.exr"]
)
def test_a_pipe_in_a_farm_is_not_waited_for(name: str, farm: Path, out: Path) -> None:
    (farm / name).unlink(missing_ok=True)
    os.mkfifo(farm / name)
    with pytest.raises(RadTexError):
        assembled(farm, out)


@pytest.mark.parametrize("stamp", ["9" * 5000, "-1", "1e9", "٣", "²", "1" * 40])
def test_a_stamp_that_is_no_frames_number_is_another_frames(stamp: str, farm: Path, out: Path) -> None:
    rewrite_frame(farm / "frames" / "0001.exr", Frame=stamp)
    shutil.copy(farm / "frames" / "0001.exr", farm / "frames" / "copy.exr")
    with pytest.raises(BakeError, match=r"1 of \d frames? cannot be used: 1 another frame's picture"):
        assembled(farm, out)


@pytest.mark.parametrize("value", [float("inf"), float("-inf")])
def test_infinite_light_in_a_frame_is_taken_with_a_warning(
    value: float, farm: Path, out: Path, caplog: pytest.LogCaptureFixture
) -> None:
    rewrite_frame(farm / "frames" / "0001.exr", value=value)
    assert assembled(farm, out).result.clamped > 0
    assert "frames 1 show infinite light: the greatest value that the file holds" in caplog.text
    pixels = OpenEXR.File(str(out / f"{_BOX}.radiance.exr")).channels()["RGBA"].pixels
    assert np.isfinite(pixels).all()
    assert np.abs(pixels.astype(np.float32)).max() == 65504


@pytest.mark.parametrize("layers", [(), (Layer.EMISSION,)])
def test_a_farm_of_infinite_light_makes_what_one_machine_does(
    layers: tuple[Layer, ...], tmp_path: Path
) -> None:
    scene = _build()
    spec = BakeSpec(texels=16, bucket=4, samples=1, sheet=24, layers=layers)
    glow = stage.material("glow", "ShaderNodeEmission", Color=(9e29, 1, 1, 1), Strength=9e29)
    bpy.context.object.data.materials.append(glow)
    try:
        bake_object(scene, _BOX, spec, tmp_path / "here")
        local = ""
    except BakeError as error:
        local = str(error)
    farm = prepared(scene, spec, tmp_path / "far").files.folder
    render(farm, f"1..{json.loads((farm / 'farm.json').read_text())['frames'][1]}")
    if local:
        with pytest.raises(BakeError, match="not numbers"):
            assembled(farm, tmp_path / "joined")
        return
    assembled(farm, tmp_path / "joined")
    for path in (tmp_path / "here").iterdir():
        assert path.read_bytes() == (tmp_path / "joined" / path.name).read_bytes()
    facts = json.loads((tmp_path / "here" / f"{_BOX}.radiance.json").read_text())
    assert facts["clamped"] > 0
