# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A farm's file is whole and still, or what keeps it from that is named; then nothing is left behind."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.farm.prepare_farm import Farm
from radtex_addon.settings.spec import BakeSpec
from tests.blender import stage
from tests.blender.farming import BOX, prepared

SPEC = BakeSpec(texels=8, bucket=4, samples=1, sheet=16, padding=1, uv_layer="UVMap")


@pytest.fixture
def scene() -> bpy.types.Scene:
    """A box under a bright sky, at frame 5."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.world()
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.name = BOX
    found: Any = bpy.context.scene
    found.frame_set(5)
    made: bpy.types.Scene = found
    return made


def _other(**place: Any) -> Any:
    bpy.ops.mesh.primitive_cube_add(size=0.5, location=(0, 0, 3), **place)
    bpy.context.object.name = "Other"
    return bpy.context.object


def _particles(kind: str) -> Any:
    other = _other()
    other.modifiers.new("dust", "PARTICLE_SYSTEM")
    system = other.particle_systems[0]
    system.settings.type = kind
    return system


def _emit() -> None:
    _particles("EMITTER")


def _grow() -> None:
    _particles("HAIR").use_hair_dynamics = True


def _show(kind: str, **settings: Any) -> Any:
    worn = stage.material("worn", "ShaderNodeBsdfDiffuse")
    _other().data.materials.append(worn)
    node = worn.node_tree.nodes.new(kind)
    for name, value in settings.items():
        setattr(node, name, value)
    diffuse = next(each for each in worn.node_tree.nodes if each.type == "BSDF_DIFFUSE")
    worn.node_tree.links.new(node.outputs["Color"], diffuse.inputs["Color"])
    return node


def _film() -> None:
    image = bpy.data.images.new("film", 2, 2)
    image.source = "MOVIE"
    _show("ShaderNodeTexImage", image=image)


def _lost_sequence() -> None:
    image: Any = bpy.data.images.new("frames", 2, 2)
    image.source, image.filepath = "SEQUENCE", "/nowhere/frame0001.png"
    _show("ShaderNodeTexImage", image=image)


def _clock() -> None:
    _show("ShaderNodeAttribute", attribute_type="VIEW_LAYER", attribute_name="frame_current")


def _painted() -> None:
    image: Any = bpy.data.images.new("painted", 2, 2)
    image.pixels = [0.5] * 16
    _show("ShaderNodeTexImage", image=image)


def _smoke_file() -> None:
    cloud: Any = bpy.data.volumes.new("cloud")
    cloud.filepath, cloud.is_sequence = "/nowhere/cloud0001.vdb", True
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Cloud", cloud))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (_emit, "'Other' emits particles"),
        (_grow, "'Other': the hair '.*' is simulated"),
        (_film, "'film' is a movie"),
        (_lost_sequence, "frame0005.png is not there, which image 'frames' shows at frame 5"),
        (_clock, "reads the scene's frame_current"),
        (_painted, "'painted' has unsaved changes"),
        (_smoke_file, "'cloud' is a sequence"),
    ],
)
def test_what_cannot_be_held_is_named(
    make: Callable[[], None], words: str, scene: bpy.types.Scene, out: Path
) -> None:
    make()
    with pytest.raises(InputError, match=words):
        prepared(scene, SPEC, out)
    assert list(out.iterdir() if out.exists() else ()) == []


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (
            {"kind": "shadow"},
            "frames for machines without RadTex are of radiance, incident, reflection, proxy, not shadow",
        ),
        (
            {"layout": "layered", "bucket": 14},
            "not layered, whose captures build on one another: prepare tasks, with frames for most",
        ),
        ({"kind": "incident", "capture": "panoramic"}, "leave the capture method out"),
        ({"accumulate": True}, "leave the accumulating and the refreshing out"),
        ({"seed": 2**23 + 1}, "give one below 8388608"),
    ],
)
def test_what_no_farm_bakes_is_refused(
    settings: dict[str, Any], words: str, scene: bpy.types.Scene, out: Path
) -> None:
    small: dict[str, Any] = {"texels": 16, "bucket": 4, "samples": 1, "sheet": 16, "uv_layer": "UVMap"}
    spec = BakeSpec(**small | settings)
    with pytest.raises(InputError, match=words):
        prepared(scene, spec, out)


def test_linked_things_fonts_and_volumes_come_along(
    scene: bpy.types.Scene, out: Path, tmp_path: Path
) -> None:
    library = tmp_path / "library.blend"
    _make_library(library)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.world()
    _link(library, objects="Linked")
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.name = BOX
    for item in (bpy.data.objects["Linked"], _text(), _volume(tmp_path)):
        bpy.context.scene.collection.objects.link(item)
    shown: Any = bpy.context.scene
    farm = prepared(shown, SPEC, out)
    (cloud,) = farm.beside
    assert (farm.files.folder / cloud).read_bytes().endswith(b"no grids")
    carried = [(each.user, Path(each.path).name, each.how) for each in farm.carried]
    assert carried[0] == ("library 'library.blend'", "library.blend", "what is linked from it")
    assert carried[1][1:] == (carried[1][1], "in the .blend")
    assert carried[1][0].startswith("font ")
    assert carried[2] == ("volume 'cloud'", "cloud.vdb", "beside the .blend")
    assert farm.carried[2].bytes == 16
    listed = json.loads(farm.files.manifest.read_text())["carried"]
    assert [each["path"] for each in listed] == [each.path for each in farm.carried]
    _open(farm)
    assert bpy.data.libraries[:] == []
    linked: Any = bpy.data.objects["Linked"]
    assert linked.library is None
    assert linked.data.library is None
    fonts = [font for font in bpy.data.fonts if font.filepath != "<builtin>"]
    assert [font.packed_file is not None for font in fonts] == [True]
    paths = bpy.utils.blend_paths(absolute=True, packed=False)
    assert paths == [str(farm.files.folder / cloud)]


def test_an_object_that_would_lose_its_name_is_named(
    scene: bpy.types.Scene, out: Path, tmp_path: Path
) -> None:
    library = tmp_path / "library.blend"
    _make_library(library)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    _link(library, objects="Linked")
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.name = BOX
    shown: Any = bpy.context.scene
    for item in (bpy.data.objects["Linked"], bpy.data.objects.new("Linked", None)):
        shown.collection.objects.link(item)
    with pytest.raises(
        InputError, match="object 'Linked' has the name of another object, one of which is linked"
    ):
        prepared(shown, SPEC, out)
    assert not list(out.iterdir())


@pytest.mark.parametrize("overridden", [False, True])
def test_a_linked_collection_keeps_its_names(
    scene: bpy.types.Scene, out: Path, tmp_path: Path, overridden: bool
) -> None:
    """Parents are linked, too: an override has its reference's name, a child keeps its parent."""
    library = tmp_path / "library.blend"
    parent, child = _other(), _other()
    parent.name, child.name, child.parent = "Ball", "Knob", parent
    things = bpy.data.collections.new("Things")
    for item in (parent, child):
        things.objects.link(item)
    bpy.data.libraries.write(str(library), {things})
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.world()
    _link(library, collections="Things")
    shown: Any = bpy.context.scene
    linked: Any = bpy.data.collections["Things"]
    shown.collection.children.link(linked)
    if overridden:
        linked.override_hierarchy_create(shown, bpy.context.view_layer)
        shown.collection.children.unlink(linked)  # as the command in the Outliner does
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.name = BOX
    farm = prepared(shown, SPEC, out)
    _open(farm)
    assert {"Ball", "Knob"} < {item.name for item in bpy.context.scene.objects}
    assert bpy.context.scene.objects["Knob"].parent is not None


def _make_library(path: Path) -> None:
    linked = _other()
    linked.name = "Linked"
    linked.keyframe_insert("location", frame=1)
    linked.location.x = 9
    linked.keyframe_insert("location", frame=9)
    bpy.data.libraries.write(str(path), {linked})


def _link(library: Path, **wanted: str) -> None:
    """Link one data-block of each kind, by its name, from a file."""
    libraries: Any = bpy.data.libraries
    with libraries.load(str(library), link=True) as (_, found):
        for kind, name in wanted.items():
            setattr(found, kind, [name])


def _text() -> bpy.types.Object:
    fonts = Path(bpy.utils.resource_path("LOCAL")) / "datafiles" / "fonts"
    curve: Any = bpy.data.curves.new("text", "FONT")
    curve.body, curve.font = "x", bpy.data.fonts.load(str(next(fonts.glob("*.woff2"))))
    return bpy.data.objects.new("Text", curve)


def _volume(folder: Path) -> bpy.types.Object:
    (folder / "cloud.vdb").write_bytes(b" BDV\0\0\0\0no grids")
    cloud = bpy.data.volumes.new("cloud")
    cloud.filepath = str(folder / "cloud.vdb")
    return bpy.data.objects.new("Cloud", cloud)


def test_a_falling_body_hangs_where_it_was(scene: bpy.types.Scene, out: Path) -> None:
    other = _other(rotation=(0.3, 0.2, 0.1))
    scene.frame_set(1)
    bpy.ops.rigidbody.object_add()
    scene.rigidbody_world.point_cache.frame_end = 8
    context: Any = bpy.context
    with context.temp_override(point_cache=scene.rigidbody_world.point_cache):
        bpy.ops.ptcache.bake(bake=True)
    scene.frame_set(5)
    expected = np.array(other.matrix_world)
    assert expected[2, 3] < 2.99
    farm = prepared(scene, SPEC, out)
    assert farm.manifest.sheets > 1
    _open(farm)
    for frame in (1, farm.manifest.sheets):
        bpy.context.scene.frame_set(frame)
        layer: Any = bpy.context.view_layer
        hung = bpy.data.objects["Other"].evaluated_get(layer.depsgraph)
        np.testing.assert_array_equal(np.array(hung.matrix_world), expected)


def _open(farm: Farm) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(farm.files.blend))
