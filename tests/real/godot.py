# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders in a real Godot: many lookups at once, one a pixel, and projects as a player sees them."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path

import numpy as np
import PIL.Image

from radtex_addon.core.arrays import Floats
from radtex_addon.export.export_manifest import read_manifest
from radtex_addon.export.targets.godot import copy_addon
from radtex_addon.report.metrics import Picture
from tests.lookups import SIDE
from tests.real.exhibit import Camera
from tests.real.kinds import Sun
from tests.real.root import REPOSITORY, Root, screen

RENDERERS = {  # of Godot, on Mesa's software drivers
    "Compatibility": ("--rendering-method", "gl_compatibility", "--rendering-driver", "opengl3"),
    "Forward+": ("--rendering-method", "forward_plus", "--rendering-driver", "vulkan"),
}
MOBILE = "Mobile"  # looks up as Forward+ does: pictures are enough
ALL_RENDERERS = {**RENDERERS, MOBILE: ("--rendering-method", "mobile", "--rendering-driver", "vulkan")}
SHADERS = REPOSITORY / "shaders"
_TO_GODOT = np.array(
    [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]]
)  # Blender's axes, as glTF does
_PROJECT = Path(__file__).parent / "inside" / "godot"
# Godot draws bytes, so a float is a pixel of four bytes, and four pictures side by side hold R, G, B and A.
_FRAGMENT = f"""
void fragment() {{
    ivec2 pixel = ivec2(UV * vec2({4 * SIDE}.0, {SIDE}.0));
    vec4 result = answer(ivec2(pixel.x % {SIDE}, pixel.y));
    uint bits = floatBitsToUint(result[pixel.x / {SIDE}]);
    COLOR = vec4(uvec4(bits, bits >> 8u, bits >> 16u, bits >> 24u) & uvec4(255u)) / 255.0;
}}
"""
_ENABLED = """
[autoload]

RadTex="*res://addons/radtex/runtime.gd"

[editor_plugins]

enabled=PackedStringArray("res://addons/radtex/plugin.cfg")
"""  # as the editor writes it when one enables the plugin
_IMPORTER = """[plugin]

name="Importer"
description=""
author=""
version=""
script="importer.gd"
"""
_IMPORT = """[remap]

importer="scene"
importer_version=1
type="PackedScene"

[deps]

source_file="res://{mesh}"

[params]

"""
_PLACED = ('[ext_resource type="PackedScene" path="{mesh}" id="1"]', 'instance=ExtResource("1")]')
_LOADED = (
    '[ext_resource type="Script" path="res://loads.gd" id="1"]',
    'type="Node3D"]\nscript = ExtResource("1")',
)
_SCENE = """[gd_scene format=3]

{head}

[sub_resource type="Environment" id="2"]
background_mode = 1
background_color = Color(0, 0, 0, 1)

[node name="Main" type="Node3D"]

[node name="Environment" type="WorldEnvironment" parent="."]
environment = SubResource("2")

[node name="Object" parent="." {node}

[node name="Camera" type="Camera3D" parent="."]
"""
Image = Floats | list[Floats] | Path


@dataclass(frozen=True)
class Job:
    """What to draw: `code` defines `vec4 answer(ivec2 here)`, after the `includes` of shaders/.

    `textures` are, by their uniforms: arrays (H, W, C), or of layers (L, H, W, C), float16 or float32; lists
    of their mip levels, each half as wide and high as the one before; or files. `hints` say how they are
    filtered, linearly unless told otherwise, and repeated. `values` are vectors of four numbers, or arrays of
    such. The includes declare the uniforms whose names begin with `declared`.
    """

    code: str
    textures: Mapping[str, Image]
    includes: Sequence[str] = ("radtex",)
    defines: str = ""
    hints: Mapping[str, str] = field(default_factory=dict)
    values: Mapping[str, object] = field(default_factory=dict)
    declared: str = " "

    @property
    def shader(self) -> str:
        includes = "".join(f'#include "{name}.gdshaderinc"\n' for name in self.includes)
        head = "shader_type canvas_item;\nrender_mode blend_disabled;\n"
        uniforms = "".join(
            f"uniform {_sampler(image)} {name} : {self.hints.get(name, 'filter_linear')};\n"
            for name, image in self.textures.items()
            if not name.startswith(self.declared)
        )
        return head + self.defines + includes + uniforms + self.code + _FRAGMENT


def answers(root: Root, renderer: str, jobs: Sequence[Job]) -> list[Floats]:
    """Each job's answers, (SIDE², 4) float32, by the renderer's Godot that stays open."""
    gallery = gallery_of(root)
    folder, place = gallery.new_folder()
    for path in SHADERS.glob("*.gdshaderinc"):
        shutil.copy(path, folder)
    described = []
    for number, job in enumerate(jobs):
        (folder / f"{number}.gdshader").write_text(job.shader, encoding="utf-8")
        textures = {
            name: _stored(folder, place, f"{number}.{name}", image) for name, image in job.textures.items()
        }
        described.append(
            {
                "shader": f"{place}/{number}.gdshader",
                "textures": textures,
                "values": dict(job.values),
                "size": [4 * SIDE, SIDE],
                "output": f"{place}/{number}.answers",
            }
        )
    (folder / "asked.json").write_text(json.dumps({"jobs": described}), encoding="utf-8")
    _ask(root, gallery.inside, renderer, f"{place}/asked.json")
    found = [_answered(folder / f"{number}.answers") for number in range(len(jobs))]
    shutil.rmtree(folder)
    return found


@dataclass(frozen=True)
class Shot:
    """A picture that a project's main scene shall show: by a camera, its shader's `parameters` set.

    `turn` is by how many degrees the camera and the scene are turned together about the vertical. `mirror` is
    the place of the mirror ball, in Blender's world, and its radius. `behind` names a PNG in the project that
    fills the picture behind the scene, and behind those of later shots. `sun`, if any, is a
    DirectionalLight3D of this and later shots; `sky` the grey levels above and below the horizon of a sky
    that gives ambient light. `copies` are matrices (4, 4), in Godot's axes: the mesh is shown at each of
    them, and not where it stood, by a MultiMesh, or by a node each. `values` are parameters of these nodes,
    one mapping each, `colours` (r, g, b, a) of the MultiMesh's instances. `hidden` are names of nodes of the
    main scene.
    """

    camera: Camera
    parameters: Mapping[str, float | list[float] | str] = field(default_factory=dict)
    turn: float = 0.0
    mirror: tuple[float, float, float, float] | None = None
    behind: str | None = None
    sun: Sun | None = None
    sky: tuple[float, float] | None = None
    copies: Sequence[Floats] = ()
    as_nodes: bool = False
    values: Sequence[Mapping[str, float | str]] = ()
    colours: Sequence[Sequence[float]] = ()
    hidden: Sequence[str] = ()

    def facts(self, output: str) -> dict[str, object]:
        """What serve.gd must know; matrices are Godot's, rows of four."""
        angle = np.radians(self.turn)
        turned = np.eye(4)
        turned[0, 0] = turned[2, 2] = np.cos(angle)
        turned[0, 2] = np.sin(angle)
        turned[2, 0] = -turned[0, 2]
        matrix = _TO_GODOT @ np.array(self.camera.matrix)
        x, y, z, radius = self.mirror or (0.0, 0.0, 0.0, 0.0)
        return {
            "mirror": [x, z, -y, radius],
            "matrix": matrix.tolist(),
            "turn": turned.tolist(),
            "fovy": self.camera.fovy,
            "parameters": dict(self.parameters),
            "behind": "" if self.behind is None else f"res://{self.behind}",
            "sun": None if self.sun is None else {**asdict(self.sun), "towards": self.sun.towards.tolist()},
            "sky": self.sky,
            "copies": [matrix.tolist() for matrix in self.copies],
            "as_nodes": self.as_nodes,
            "values": [dict(each) for each in self.values],
            "colours": [list(each) for each in self.colours],
            "hidden": list(self.hidden),
            "output": output,
        }


@dataclass
class Gallery:
    """A project with the addon, enabled, for all exports of a run, each in a folder of its own.

    One editor imports them, and one Godot for each renderer shows them: these stay open.
    """

    root: Root
    folder: Path
    inside: str
    count: int = 0
    new: list[str] = field(default_factory=list)  # meshes that are not imported

    def new_folder(self) -> tuple[Path, str]:
        """A folder of the project, and its path there."""
        self.count += 1
        folder = self.folder / str(self.count)
        folder.mkdir()
        return folder, f"res://{self.count}"

    def import_all(self) -> None:
        """Have the editor import what is new."""
        if self.new:
            argv = ["godot", "--audio-driver", "Dummy", "--headless", "--editor", "--path", self.inside]
            _unless_error(self.root.ask(screen(argv), " ".join(self.new)))
            self.new.clear()


@cache
def gallery_of(root: Root) -> Gallery:
    """The root's gallery, empty at first."""
    folder, inside = root.shared("gallery")
    enabled = '"res://addons/radtex/plugin.cfg"'
    facts = (_PROJECT / "project.godot").read_text(encoding="utf-8") + _ENABLED
    facts = facts.replace(enabled, f'{enabled}, "res://addons/importer/plugin.cfg"')
    (folder / "project.godot").write_text(facts, encoding="utf-8")
    copy_addon(folder)
    importer = folder / "addons" / "importer"
    importer.mkdir()
    (importer / "plugin.cfg").write_text(_IMPORTER, encoding="utf-8")
    for name, place in (("importer.gd", importer), ("serve.gd", folder), ("loads.gd", folder)):
        shutil.copy(_PROJECT / name, place)
    return Gallery(root, folder, inside)


@dataclass(frozen=True)
class Placed:
    """An export in the gallery: its `folder` here, and `place` there."""

    gallery: Gallery
    folder: Path
    place: str

    def pictures(self, renderer: str, shots: Sequence[Shot]) -> list[Picture]:
        """Linear light (H, W, 3) of each shot of its scene, rows from the top, clipped to 0..1."""
        self.gallery.import_all()
        return _shown(self.gallery.root, self.gallery.inside, self.folder, self.place, renderer, shots)


def placed(root: Root, export: Path, *, at_run_time: bool = False) -> Placed:
    """The files of an export in the gallery, as one drops them into a project that has the addon.

    A project's scene comes along, others get one. `at_run_time`: the editor does not see the files, the scene
    loads them.
    """
    gallery = gallery_of(root)
    folder, place = gallery.new_folder()
    mesh = _fill(folder, place, export, at_run_time=at_run_time)
    if not at_run_time:
        gallery.new.append(f"{place}/{mesh}")
    return Placed(gallery, folder, place)


def filled(
    root: Root, exports: Mapping[str, Path], settings: Mapping[str, Mapping[str, object]] | None = None
) -> tuple[Path, str]:
    """A project of its own with the addon, and the files of each export in a folder of that name.

    `settings` are the Import dock's of the meshes in those folders.
    """
    folder, inside = root.shared("dropped")
    facts = (_PROJECT / "project.godot").read_text(encoding="utf-8")
    (folder / "project.godot").write_text(facts + _ENABLED, encoding="utf-8")
    copy_addon(folder)
    for name, export in exports.items():
        place = folder / name
        place.mkdir()
        mesh = _fill(place, f"res://{name}", export)
        if settings and name in settings:
            lines = [f"{key}={json.dumps(value)}" for key, value in settings[name].items()]
            text = _IMPORT.format(mesh=f"{name}/{mesh}") + "\n".join(lines)
            (place / f"{mesh}.import").write_text(text, encoding="utf-8")
    return folder, inside


def _fill(folder: Path, place: str, export: Path, *, at_run_time: bool = False) -> str:
    """Copy a project's files, or those that an export names, and a scene; returns the mesh's name."""
    scene = export / "main.tscn"
    names = [path.name for path in export.iterdir() if path.is_file() and path.name != "project.godot"]
    mesh = next(name for name in names if name.endswith(".glb"))
    if not scene.exists():
        manifest = read_manifest(next(export.glob("*.export.json")))
        named = {mesh, *(entry.file for entry in manifest.textures.values())}
        names = [name for name in names if name in named]
    files = folder / "files" if at_run_time else folder
    files.mkdir(exist_ok=True)
    for name in names:
        shutil.copy(export / name, files)
    if at_run_time:
        (files / ".gdignore").touch()
    head, node = _LOADED if at_run_time else _PLACED
    text = _SCENE.format(head=head.format(mesh=f"{place}/{mesh}"), node=node)
    if scene.exists():
        text = scene.read_text(encoding="utf-8")
        for name in (mesh, "orbit.gd"):
            text = text.replace(f'"res://{name}"', f'"{place}/{name}"')
    (folder / "main.tscn").write_text(text, encoding="utf-8")
    return mesh


def imported(root: Root, project: Path) -> tuple[Path, str]:
    """A copy of a project that both sides see, after Godot's editor has imported its files."""
    folder, inside = root.shared("project")
    shutil.copytree(project, folder, dirs_exist_ok=True)
    run_godot(root, ["--headless", "--path", inside, "--import"])
    return folder, inside


def pictures(
    root: Root, project: tuple[Path, str], renderer: str, shots: Sequence[Shot], name: str = ""
) -> list[Picture]:
    """Linear light (H, W, 3) of each shot of an imported project, rows from the top, clipped to 0..1.

    `name` is the folder of its scene.
    """
    folder, inside = project
    shutil.copy(_PROJECT / "serve.gd", folder)
    place = f"res://{name}" if name else "res:/"
    found = _shown(root, inside, folder / name, place, renderer, shots)
    root.end_server(_serving(inside, renderer, shots[0].camera.pixels))
    return found


def _shown(
    root: Root, inside: str, folder: Path, place: str, renderer: str, shots: Sequence[Shot]
) -> list[Picture]:
    outputs = [f"{number}.png" for number in range(len(shots))]
    facts = [shot.facts(f"{place}/{output}") for shot, output in zip(shots, outputs, strict=True)]
    asked = {"scene": f"{place}/main.tscn", "shots": facts}
    (folder / "asked.json").write_text(json.dumps(asked), encoding="utf-8")
    _ask(root, inside, renderer, f"{place}/asked.json", shots[0].camera.pixels)
    taken = [light_of(folder / output) for output in outputs]
    for output, shot, picture in zip(outputs, shots, taken, strict=True):
        assert picture.shape == (shot.camera.pixels, shot.camera.pixels, 3), picture.shape
        (folder / output).unlink()
    return taken


def _serving(inside: str, renderer: str, pixels: int) -> list[str]:
    """The Godot of a project that draws what it is asked for, in a window that keeps its size."""
    godot = ["godot", "--audio-driver", "Dummy", "--path", inside, *ALL_RENDERERS[renderer]]
    return screen([*godot, "--resolution", f"{pixels}x{pixels}", "--script", "res://serve.gd"])


def _ask(root: Root, inside: str, renderer: str, path: str, pixels: int = 256) -> None:
    """Have a project's Godot draw what a file asks for; AssertionError where it found an error."""
    _unless_error(root.ask(_serving(inside, renderer, pixels), path))


def _unless_error(said: str) -> None:
    assert "ERROR" not in said, said


def light_of(path: Path) -> Picture:
    """Linear light of a picture in sRGB."""
    with PIL.Image.open(path) as image:
        return linear(np.asarray(image.convert("RGB")) / 255)


def linear(shown: Floats) -> Picture:
    """Linear light of sRGB values in 0..1, of any shape."""
    light: Picture = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    return light


def run_godot(root: Root, arguments: Sequence[str], timeout: float = 240) -> str:
    """Run Godot before a screen of its own; AssertionError, with what it said, where it found an error."""
    said = said_by_godot(root, arguments, timeout)
    _unless_error(said)
    return said


def said_by_godot(root: Root, arguments: Sequence[str], timeout: float = 240) -> str:
    """All that Godot says, errors too, until it ends as it should."""
    ended = root.run(screen(["godot", "--audio-driver", "Dummy", *arguments]), timeout=timeout)
    said = ended.stdout + ended.stderr
    assert ended.returncode == 0, said
    return said


def _answered(path: Path) -> Floats:
    side_by_side = np.fromfile(path, np.float32).reshape(SIDE, 4, SIDE)
    return side_by_side.transpose(0, 2, 1).reshape(SIDE * SIDE, 4)


def _sampler(image: Image) -> str:
    first = image[0] if isinstance(image, list) else image
    return "sampler2DArray" if isinstance(first, np.ndarray) and first.ndim == 4 else "sampler2D"


def _stored(folder: Path, place: str, name: str, image: Image) -> dict[str, object]:
    """Write a texture beside the project; what serve.gd must know to load it."""
    if isinstance(image, Path):
        shutil.copy(image, folder / f"{name}{image.suffix}")
        return {"file": f"{place}/{name}{image.suffix}"}
    levels = [_layers(level) for level in (image if isinstance(image, list) else [image])]
    while len(levels) > 1 and max(levels[-1].shape[1:3]) > 1:  # Godot wants all, of which a lookup sees none
        count, height, width = levels[-1].shape[:3]
        levels.append(np.full((count, max(height // 2, 1), max(width // 2, 1), 4), 99, levels[0].dtype))
    layers = zip(*levels, strict=True)
    (folder / f"{name}.raw").write_bytes(b"".join(part.tobytes() for layer in layers for part in layer))
    count, height, width = levels[0].shape[:3]
    return {
        "file": f"{place}/{name}.raw",
        "half": levels[0].dtype == np.float16,
        "mipmaps": len(levels) > 1,
        "layers": count,
        "layered": _sampler(image) == "sampler2DArray",
        "size": [width, height],
    }


def _layers(image: Floats) -> Floats:
    """An image as layers of four channels."""
    layers = image if image.ndim == 4 else image[np.newaxis]
    filled: Floats = np.ones((*layers.shape[:3], 4), np.float16 if layers.dtype == np.float16 else np.float32)
    filled[..., : layers.shape[3]] = layers
    return filled
