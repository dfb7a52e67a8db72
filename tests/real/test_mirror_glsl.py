# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A chrome ball that moves through a baked room, drawn in real time: GLSL finds the hits on the room, a box.

With RADTEX_FIGURES=docs/figures the picture is kept: path traced, then ours, at each place.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy
import moderngl
import numpy as np
import pytest
from PIL import Image

from radtex_addon.core.arrays import Floats
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.job import bake_object
from radtex_addon.report.gbuffer import eroded
from radtex_addon.report.metrics import display, psnr
from radtex_addon.settings.spec import BakeSpec
from tests.bench.gallery.looking import Camera, Place, added, empty_scene, principled, rendered
from tests.real.opengl import VERSIONS, compiled, drawn

SHADER = Path(__file__).parents[2] / "shaders" / "radtex.glsl"
SPEC = BakeSpec(texels=66, bucket=8, samples=4, uv_layer="Faces")
CAMERA = Camera((0.85, -0.9, 0.25), (-0.1, 0.15, -0.3), lens=24)
PLACES: list[Place] = [(-0.35, 0.3, -0.65), (0.1, -0.2, -0.5)]
RADIUS, CHROME = 0.35, (0.9, 0.92, 0.95)
PIXELS, FINER = 256, 2
LEAST = 27.0  # decibels in the ball
# The room is [-1, 1]³, seen from inside: each wall's normal, the way u grows on it, and the way v grows.
FACES = np.array(
    [
        [(1, 0, 0), (0, 1, 0), (0, 0, 1)],
        [(-1, 0, 0), (0, -1, 0), (0, 0, 1)],
        [(0, 1, 0), (-1, 0, 0), (0, 0, 1)],
        [(0, -1, 0), (1, 0, 0), (0, 0, 1)],
        [(0, 0, 1), (1, 0, 0), (0, 1, 0)],
        [(0, 0, -1), (1, 0, 0), (0, -1, 0)],
    ],
    dtype=float,
)
MARGIN = 1.5 / SPEC.texels  # around each wall's place in the atlas, of which there are 3 x 2
FRAGMENT = """
uniform sampler2D atlas;
uniform ivec2 texels;
uniform int n;
uniform vec3 eye, right, up, ahead, ball, chrome;
uniform float half_width, radius, side, margin;
uniform vec3 faces[18];  // normal, u and v of each wall
out vec4 result;

// What a ray from a place inside the room finds.
vec3 room(vec3 from, vec3 ray) {
    vec3 distances = (sign(ray) - from) / ray;  // to the wall ahead, along each axis
    float nearest = min(distances.x, min(distances.y, distances.z));
    int axis = nearest == distances.x ? 0 : nearest == distances.y ? 1 : 2;
    int face = 2 * axis + (ray[axis] > 0.0 ? 1 : 0);
    vec3 hit = from + nearest * ray, N = faces[3 * face], U = faces[3 * face + 1], V = faces[3 * face + 2];
    vec2 place = vec2(dot(hit, U), dot(hit, V)) * 0.5 + 0.5;
    vec2 size = vec2(1.0 / 3.0, 0.5);
    vec2 uv = vec2(face % 3, face / 3) * size + margin + place * (size - 2.0 * margin);
    return radtex_hit(atlas, texels, n, uv, ray, N, U, 1.0, RADTEX_QUADRILINEAR).rgb;
}

void main() {
    vec2 at = (gl_FragCoord.xy / side * 2.0 - 1.0) * half_width;
    vec3 ray = normalize(ahead + at.x * right + at.y * up), away = eye - ball;
    float along = dot(ray, away), root = along * along - dot(away, away) + radius * radius;
    if (root < 0.0) {
        result = vec4(room(eye, ray), 0.0);
        return;
    }
    vec3 hit = eye + (-along - sqrt(root)) * ray, N = (hit - ball) / radius;
    vec3 fresnel = chrome + (1.0 - chrome) * pow(1.0 + dot(ray, N), 5.0);
    result = vec4(fresnel * room(hit, reflect(ray, N)), 1.0);
}
"""


@dataclass(frozen=True, eq=False)
class Baked:
    """The room's atlas, (H*n, W*n, 4), and the ball in the open scene."""

    atlas: Floats
    ball: Any


@pytest.fixture(scope="module")
def baked(tmp_path_factory: pytest.TempPathFactory) -> Baked:
    """A closed room that its ceiling lights; only then the ball comes, which the camera alone sees."""
    scene = empty_scene()
    scene.cycles.max_bounces = 4
    mesh = bpy.data.meshes.new("Room")
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    points = [-face[0] + u * face[1] + v * face[2] for face in FACES for u, v in corners]
    mesh.from_pydata(
        [tuple(point) for point in points], [], [tuple(range(k, k + 4)) for k in range(0, 24, 4)]
    )
    size = np.array([1 / 3, 1 / 2])
    places = [
        size * (number % 3, number // 3) + MARGIN + (corner / 2 + 0.5) * (size - 2 * MARGIN)
        for number in range(6)
        for corner in corners
    ]
    layer: Any = mesh.uv_layers.new(name="Faces")
    layer.uv.foreach_set("vector", np.ravel(places))
    colours = [(0.7, 0.15, 0.1), (0.15, 0.3, 0.65), (0.75, 0.72, 0.65), (0.2, 0.5, 0.25)]
    for number, colour in enumerate(colours):
        mesh.materials.append(principled(f"Wall {number}", colour, Roughness=0.7))
    mesh.materials.append(tiles())
    mesh.materials.append(
        principled("Sky", (0, 0, 0), Emission_Color=(1, 0.97, 0.9, 1), Emission_Strength=1.2)
    )
    for polygon in mesh.polygons:
        polygon.material_index = polygon.index
    scene.collection.objects.link(bpy.data.objects.new("Room", mesh))
    made = bake_object(scene, "Room", SPEC, tmp_path_factory.mktemp("room"))
    atlas, _ = read_buckets(made.files.sidecar)
    chrome = principled("Chrome", CHROME, Metallic=1.0, Roughness=0.0)
    ball = added("uv_sphere", "Ball", chrome, segments=128, ring_count=64, radius=RADIUS)
    ball.visible_diffuse = ball.visible_glossy = ball.visible_shadow = False
    return Baked(np.ascontiguousarray(atlas), ball)


def tiles() -> bpy.types.Material:
    """A floor of four by four tiles."""
    made: Any = principled("Tiles", (1, 1, 1), Roughness=0.7)
    tree = made.node_tree
    checker = tree.nodes.new("ShaderNodeTexChecker")
    checker.inputs["Scale"].default_value = 2.0
    checker.inputs["Color1"].default_value, checker.inputs["Color2"].default_value = (
        (0.8, 0.78, 0.7, 1),
        (0.1, 0.1, 0.12, 1),
    )
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Object"], checker.inputs["Vector"])
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    tree.links.new(checker.outputs["Color"], shader.inputs["Base Color"])
    return cast(bpy.types.Material, made)


def shown(context: moderngl.Context, atlas: Floats, place: Place) -> Floats:
    """GLSL's picture, (PIXELS, PIXELS, 4) from the top row on; alpha is how much of a pixel is the ball."""
    program = compiled(context, VERSIONS["GLSL ES 300"], SHADER.read_text(encoding="utf-8") + FRAGMENT)
    turn = np.array(CAMERA.turn.to_matrix())
    n = SPEC.bucket
    program["texels"], program["n"] = (atlas.shape[1] // n, atlas.shape[0] // n), n
    for name, vector in zip(("right", "up", "ahead"), (turn[:, 0], turn[:, 1], -turn[:, 2]), strict=True):
        program[name] = tuple(vector)
    program["eye"], program["ball"], program["chrome"] = CAMERA.place, place, CHROME
    program["half_width"], program["radius"] = 18 / CAMERA.lens, RADIUS
    program["side"], program["margin"] = float(PIXELS * FINER), MARGIN
    program["faces"] = [tuple(vector) for vector in FACES.reshape(18, 3)]
    found = drawn(context, program, {"atlas": atlas}, PIXELS * FINER)
    picture: Floats = found.reshape(PIXELS, FINER, PIXELS, FINER, 4).mean(axis=(1, 3))[::-1]
    return picture


def test_a_moving_ball_mirrors_the_room_as_cycles_has_it(context: moderngl.Context, baked: Baked) -> None:
    pictures = []
    for place in PLACES:
        baked.ball.location = place
        ours, truth = shown(context, baked.atlas, place).astype(float), rendered(CAMERA, samples=16)[..., :3]
        inside = eroded(ours[..., 3] == 1)
        assert inside.sum() > 2000
        found = psnr(ours[..., :3], truth, inside)
        whole = psnr(ours[..., :3], truth, np.ones_like(inside))
        print(f"ball at {place}: {found:.1f} dB, the whole picture {whole:.1f} dB")
        pictures += [truth, ours[..., :3]]
        assert found >= LEAST
    if folder := os.environ.get("RADTEX_FIGURES"):
        row = np.concatenate([display(picture) for picture in pictures], axis=1)
        image = Image.fromarray((row * 255 + 0.5).astype(np.uint8))
        image.quantize(128, dither=Image.Dither.NONE).save(Path(folder, "mirror-glsl.png"), optimize=True)
