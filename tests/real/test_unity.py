# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is exported for Unity, held to compilers and to an emulation of what Unity does around it.

Unity was not run: files beside this stand for those that its shaders include, and for what its scripts call.
"""

from __future__ import annotations

import re
import shutil
from base64 import b64encode
from collections import deque
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.targets.unity import SHARED, TEMPLATES, object_text, script_text, shader_text
from radtex_addon.export.unity_unreal import baked_matrix
from radtex_addon.formats.containers.dds import write_texture
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.formats.containers.texture import PixelFormat, Texture, encode_texture
from radtex_addon.forms.hlsl_lookup import IMAGE_TEXTURES
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.lookups import COUNT, SIDE
from tests.real.engine_lookups import FORMS, SUN, Asked
from tests.real.engines import HEADERS, SHADERS, Compilers, compiled_by, inlined, shown
from tests.real.exhibit import Bake, Exhibit, Form
from tests.real.hlsl import COMPILERS
from tests.real.webgpu import Resource, Sampler, fields
from tests.reference.importers import attributes_of, gltfast
from tests.strangers.attacks import elsewhere
from tests.transfer_lookups import IRRADIANCE

NAME = "Made up"
EVERY_COMPILER = ("dxc", *COMPILERS)
VISIBLE = ("Radiance", "ForwardOnly")  # passes that draw what is seen
PIPELINES = {"URP": "UniversalPipeline", "HDRP": "HDRenderPipeline", "built-in": ""}
FLIPPED = np.diag([-1.0, 1.0, 1.0])  # from glTF's axes to Unity's
STILL = "RADTEX_STEADY 0.0"  # places that are looked up here lie apart: no pixel tells of the next
FAR = np.array([4.0e5, -2.5e5, 3.0e5])  # there float32 knows places to some centimetres only
TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.60, 0.0], [0.48, 0.64, 0.60]])
_SUBSHADER = re.compile(r"^    SubShader\n    \{(.*?)^    \}", re.MULTILINE | re.DOTALL)
_PIPELINE = re.compile(r'"RenderPipeline" = "(\w+)"')
_SHARED = re.compile(r"HLSLINCLUDE(.*?)ENDHLSL", re.DOTALL)
_PASS = re.compile(r'Name "(\w+)".*?HLSLPROGRAM(.*?)ENDHLSL', re.DOTALL)
_STAGE = re.compile(r"#pragma (vertex|fragment) (\w+)")
_PRAGMA = re.compile(r"^\s*#pragma .*$", re.MULTILINE)
DRAW = """
Texture2DArray emulated_fields : register(t20);
cbuffer EmulatedObject : register(b0) { float4 emulated_object[4]; float4 emulated_inverse[4]; };
float4 main(float4 at : SV_Position) : SV_Target {
    int2 here = int2(at.xy);
    float4 a = emulated_fields.Load(int4(here, 0, 0)), b = emulated_fields.Load(int4(here, 1, 0));
    float4 c = emulated_fields.Load(int4(here, 2, 0)), place = emulated_fields.Load(int4(here, 3, 0));
    float4 m[4] = emulated_object, n[4] = emulated_inverse;
    unity_ObjectToWorld = float4x4(m[0], m[1], m[2], m[3]);
    unity_WorldToObject = float4x4(n[0], n[1], n[2], n[3]);
#ifdef CAMERA_RELATIVE
    unity_ObjectToWorld._m03_m13_m23 = place.xyz;
#endif
    _WorldSpaceCameraPos = place.xyz;
    unity_OrthoParams = float4(0.0, 0.0, 0.0, 0.0);
    RadtexVertex v = (RadtexVertex)0;
    v.position = float4(a.xyz, 1.0);
    v.normal = float3(0.0, 0.0, 1.0);
    v.uv = float2(a.w, b.x);
    v.tangent_xy = b.yz;
    v.tangent_z_side = float2(b.w, c.x);
    v.normal_xy = c.yz;
    v.normal_z = float2(c.w, 0.0);
#ifdef RADTEX_IMAGE_UVS
    v.image_uv = emulated_fields.Load(int4(here, 4, 0)).xy;
#endif
    return radtex_seen(radtex_vertex(v));
}
"""


@dataclass(frozen=True)
class Pass:
    """A pass of a shader: which pipeline it is for, its code, and its stages' functions."""

    pipeline: str
    name: str
    code: str
    vertex: str
    fragment: str


def passes(text: str) -> list[Pass]:
    """The passes with code of a file in ShaderLab."""
    found = []
    for subshader in _SUBSHADER.findall(text):
        tag, shared = _PIPELINE.search(subshader), _SHARED.search(subshader)
        pipeline = next(name for name, word in PIPELINES.items() if word == (tag[1] if tag else ""))
        for name, code in _PASS.findall(_SHARED.sub("", subshader)):
            whole = (shared[1] if shared else "") + code
            stages = dict(_STAGE.findall(whole))
            found.append(Pass(pipeline, name, _PRAGMA.sub("", whole), stages["vertex"], stages["fragment"]))
    return found


def folder_of(asked: Asked, folder: Path, clear: bool = False) -> list[Pass]:
    """The export's shader and its includes in a folder; the shader's passes."""
    (folder / "shaders").mkdir()
    for stem in asked.lookup.includes:
        shutil.copyfile(SHADERS / f"{stem}.hlsl", folder / "shaders" / f"{stem}.hlsl")
    shutil.copyfile(TEMPLATES / SHARED, folder / "shaders" / SHARED)
    text = object_text(NAME, asked.lookup, asked.mesh.baked, clear)
    (folder / f"{NAME}.hlsl").write_text(text, encoding="utf-8")
    return passes(shader_text(NAME, NAME, asked.lookup, clear, culled=True))


def complete(code: str, folder: Path, *defined: str) -> str:
    """A pass's code with all that it includes, ours or what stands for Unity's."""
    defines = "".join(f"#define {name}\n" for name in (STILL, *defined))
    return defines + inlined(code, [folder, HEADERS])


@cache
def asked_of(form: str) -> Asked:
    return FORMS[form](Target.UNITY)


def drawn(compilers: Compilers, compiler: str, asked: Asked, code: str, far: Floats) -> list[Floats]:
    """What a pass's vertex and pixel stage give, for each material, with the object moved by `far`."""
    seen = gltfast(asked.mesh.attributes)
    relative = "CAMERA_RELATIVE" in code
    object_to_world = np.eye(4)
    object_to_world[:3, :3], object_to_world[:3, 3] = 1.7 * TURN, far
    world_to_object = np.linalg.inv(object_to_world)
    of_bake = np.linalg.inv(asked.mesh.baked[:, :3])
    towards = asked.viewers @ (object_to_world[:3, :3] @ FLIPPED @ of_bake).T
    place = seen["POSITION"].astype(float) @ object_to_world[:3, :3].T + far + towards
    if relative:
        place = far - place  # of the object, as HDRP's matrices have it
    sets = [seen[f"TEXCOORD_{k}"] for k in range(asked.uv_sets)]
    values = np.column_stack([seen["POSITION"], *sets[-5:]])[:, :12]
    resources: dict[str, Resource] = {
        "t20": fields(SIDE, *np.split(values, 3, axis=1), place, *sets[:-5]),
        "b0": np.stack([object_to_world, world_to_object]).astype(np.float32),
        "s0": Sampler("linear"),
    }
    if asked.lookup.relit:
        sun = object_to_world[:3, :3] @ FLIPPED @ of_bake @ SUN
        resources["b1"] = np.array([1, 0, 0, 0, *sun, 0, *IRRADIANCE, 0], np.float32)
    code = code.replace("SamplerState radtex_trilinear_clamp_sampler;", "", 1)
    code = "SamplerState radtex_trilinear_clamp_sampler : register(s0);\n" + code
    for k, (name, texture) in enumerate(zip(asked.lookup.textures, asked.textures, strict=True)):
        code = re.sub(rf"^(Texture\w+ {name});", rf"\1 : register(t{k});", code, flags=re.MULTILINE)
        resources[f"t{k}"] = texture
    for k, name in enumerate(IMAGE_TEXTURES if asked.images else ()):
        declared = f"Texture2D {name}; SamplerState sampler{name};"
        assert code.count(declared) == 1
        bound = f"Texture2D {name} : register(t{24 + k}); SamplerState sampler{name} : register(s{1 + k});"
        code = code.replace(declared, bound)
        resources[f"s{1 + k}"] = Sampler("linear")
    found = []
    for number in range(asked.materials):
        keyword = f"#define RADTEX_MATERIAL_{number}\n" if number else ""
        own = {f"t{24 + k}": texture for k, texture in enumerate(asked.images.get(number, ()))}
        found.append(shown(compilers, compiler, keyword + code + DRAW, resources | own, SIDE))
    return found


@pytest.mark.parametrize("compiler", EVERY_COMPILER)
@pytest.mark.parametrize("form", FORMS)
def test_light_is_the_references_through_gltfast(
    compilers: Compilers, compiler: str, form: str, tmp_path: Path
) -> None:
    asked = asked_of(form)
    for each in folder_of(asked, tmp_path):
        if each.name not in VISIBLE or (compiler != "dxc" and each.pipeline != "built-in"):
            continue
        defined = ["SHOWN_PER_PIXEL", *["CAMERA_RELATIVE"] * (each.pipeline == "HDRP")]
        code = complete(each.code, tmp_path, *defined)
        mean, most = asked.error(drawn(compilers, compiler, asked, code, np.array([3.0, -2.0, 5.0])))
        print(
            f"{compiler}, {each.pipeline}, {form}: {COUNT} lookups, error {mean:.1e} on average, {most:.1e}"
        )
        assert mean < asked.within[0]
        assert most < asked.within[1]


def test_hdrp_sees_the_same_far_from_where_the_world_begins(compilers: Compilers, tmp_path: Path) -> None:
    asked = asked_of("layered")
    errors = {}
    for each in folder_of(asked, tmp_path):
        if each.name in VISIBLE:
            defined = ["SHOWN_PER_PIXEL", *["CAMERA_RELATIVE"] * (each.pipeline == "HDRP")]
            code = complete(each.code, tmp_path, *defined)
            errors[each.pipeline] = asked.error(drawn(compilers, "dxc", asked, code, FAR))[0]
    print(f"{np.linalg.norm(FAR) / 1000:.0f} km away, on average: {errors}")
    assert errors["HDRP"] < asked.within[0]
    assert errors["built-in"] > 3 * errors["HDRP"]  # so far away it matters


def test_a_material_may_ask_for_cheaper_lookups(compilers: Compilers, tmp_path: Path) -> None:
    asked = asked_of("layered")
    found = folder_of(asked, tmp_path)
    text = shader_text(NAME, NAME, asked.lookup, clear=False, culled=True)
    assert "[Toggle(RADTEX_TEMPORAL)] _RadtexTemporal" in text
    assert text.count("#pragma shader_feature_local _ RADTEX_TEMPORAL\n") == len(PIPELINES)
    (each,) = (some for some in found if some.name in VISIBLE and some.pipeline == "built-in")
    code = complete(each.code, tmp_path, "SHOWN_PER_PIXEL", "RADTEX_TEMPORAL")
    mean, _ = asked.error(drawn(compilers, "dxc", asked, code, np.array([3.0, -2.0, 5.0])))
    print(f"drawn by chance: error {mean:.1e} on average")
    assert asked.within[0] < mean < 0.1


def compile_passes(
    compilers: Compilers, compiler: str, found: list[Pass], folder: Path, *defined: str
) -> None:
    for each in found:
        code = complete(each.code, folder, *defined)
        compiled_by(compilers, compiler, code, "vertex", each.vertex)
        compiled_by(compilers, compiler, code, "pixel", each.fragment)


@pytest.mark.parametrize("form", FORMS)
def test_every_pass_compiles(compilers: Compilers, form: str, tmp_path: Path) -> None:
    found = folder_of(asked_of(form), tmp_path, clear=True)
    assert {each.pipeline for each in found} == set(PIPELINES)
    assert len(found) == 8
    for defined in ("NOTHING_MORE", "_CASTING_PUNCTUAL_LIGHT_SHADOW 1", "STEREO_INSTANCING_ON"):
        compile_passes(compilers, "dxc", found, tmp_path, defined)


@pytest.mark.parametrize("compiler", COMPILERS)
def test_every_pass_compiles_for_shader_model_5(compilers: Compilers, compiler: str, tmp_path: Path) -> None:
    compile_passes(compilers, compiler, folder_of(asked_of("buckets"), tmp_path), tmp_path)


def pixels(levels: int, layers: int) -> list[Floats]:
    """Random mip levels of an array of pictures, (layers, H, W, 4), the largest first."""
    rng = np.random.default_rng(6)
    return [rng.uniform(0, 1, (layers, 32 >> k, 64 >> k, 4)).astype(np.float32) for k in range(levels)]


@pytest.fixture(scope="module")
def reader(compilers: Compilers) -> tuple[Path, str]:
    """The exported script, compiled against the declarations, with a program that reads a DDS by it."""
    host, inside = compilers.tools.shared("unity")
    materials = {"A": 0, 'B "b"': 1, "C\\\u2028\n\r\u2029\u0085\\": 2}
    script = script_text(NAME, "radiance", "Made up.glb", asked_of("layered").lookup, materials)
    (host / "Script.cs").write_text(script, encoding="utf-8")
    for name in ("Declarations.cs", "ReadDds.cs"):
        shutil.copyfile(HEADERS / name, host / name)
    sources = ["Declarations.cs", "Script.cs", "ReadDds.cs"]
    run = compilers.tools.run(
        ["mcs", "-warnaserror", "-langversion:7.2", "-out:read.exe", *sources], cwd=inside
    )
    assert run.returncode == 0, run.stdout + run.stderr
    return host, inside


@pytest.mark.parametrize(
    ("kind", "levels", "layers", "said"),
    [
        (PixelFormat.RGBA16F, 1, 1, "2D 64 32 R16G16B16A16_SFloat 1 None"),
        (PixelFormat.BC6H, 4, 1, "2D 64 32 RGB_BC6H_UFloat 4 MipChain"),
        (PixelFormat.RGBA16F, 3, 5, "array 64 32 5 R16G16B16A16_SFloat 3 MipChain"),
    ],
)
def test_the_script_reads_textures_to_the_last_bit(
    compilers: Compilers, reader: tuple[Path, str], kind: PixelFormat, levels: int, layers: int, said: str
) -> None:
    host, inside = reader
    texture: Texture = encode_texture(pixels(levels, layers), kind, is_array=layers > 1)
    write_texture(host / "made.dds", texture)
    command = ["mono", "read.exe", "made.dds", "given.bin"]
    run = compilers.tools.run(command, cwd=inside)
    assert run.returncode == 0, run.stderr
    first, *others = run.stdout.splitlines()
    assert first == said
    assert len(others) == levels * layers
    whole = (host / "made.dds").read_bytes()
    assert (host / "given.bin").read_bytes() == whole[148:]
    (host / "made.dds").write_bytes(whole[:-1])
    run = compilers.tools.run(command, cwd=inside)
    assert (run.returncode, run.stderr) == (1, "RadTex: the file is cut short: export it again\n")


def test_the_script_reads_no_texture_of_impossible_sizes(
    compilers: Compilers, reader: tuple[Path, str]
) -> None:
    host, inside = reader
    write_texture(host / "made.dds", encode_texture(pixels(1, 1), PixelFormat.RGBA16F))
    whole = (host / "made.dds").read_bytes()
    most = 1 << 30
    for place, number in ((12, 0), (12, most), (16, -5), (28, 20), (28, most), (140, 0), (140, most)):
        damaged = bytearray(whole)
        damaged[place : place + 4] = number.to_bytes(4, "little", signed=True)
        (host / "made.dds").write_bytes(damaged)
        run = compilers.tools.run(["mono", "read.exe", "made.dds", "given.bin"], cwd=inside)
        said = "RadTex: the file has impossible sizes: export it again\n"
        assert (run.returncode, run.stderr) == (1, said), (place, number)


def test_the_script_opens_no_file_elsewhere(compilers: Compilers, reader: tuple[Path, str]) -> None:
    host, inside = reader
    names = ["Vase.radiance.dds", "Käse 2.radiance.colour.exr", *elsewhere(".dds")]
    (host / "names").write_bytes(b"\n".join(b64encode(name.encode()) for name in names))
    run = compilers.tools.run(["mono", "read.exe", "names"], cwd=inside)
    assert run.stdout.split() == ["True", "True", *["False"] * (len(names) - 2)], run.stderr


def test_names_end_no_line_of_the_shader() -> None:
    asked = asked_of("layered")
    evil = 'Va"se\u2028evil\nevil\revil\u0085evil\\'
    code = object_text(evil, asked.lookup, asked.mesh.baked, clear=False)
    shader = shader_text(evil, evil, asked.lookup, clear=False, culled=False)
    for text in (code, shader):
        assert not [line for line in text.splitlines() if line.lstrip().startswith("evil")]
    (title,) = re.findall(r"^Shader (.*)$", shader, re.MULTILINE)
    assert re.fullmatch(r'"RadTex/[^"]*"', title)


@pytest.mark.parametrize("form", Form)
def test_an_export_of_a_bake_compiles_and_carries_its_frame(
    compilers: Compilers, exhibit: Exhibit, form: Form, tmp_path: Path
) -> None:
    bake: Bake = getattr(exhibit, form)
    for target in (Target.UNITY, Target.GLTF):
        deque(export_steps(bake.sidecar, ExportSpec(target), tmp_path / target), maxlen=0)
    folder = tmp_path / Target.UNITY
    (shader,), (glb,), (script,) = (list(folder.rglob(f"*.{end}")) for end in ("shader", "glb", "cs"))
    compile_passes(compilers, "dxc", passes(shader.read_text(encoding="utf-8")), folder)
    host, inside = compilers.tools.shared("unity")
    for source in (script, HEADERS / "Declarations.cs"):
        shutil.copyfile(source, host / source.name)
    command = ["mcs", "-warnaserror", "-target:library", script.name, "Declarations.cs"]
    run = compilers.tools.run(command, cwd=inside)
    assert run.returncode == 0, run.stdout + run.stderr
    plain = Glb.read(tmp_path / Target.GLTF / glb.name)
    baked = baked_matrix(plain)[:, :3]
    carried, frame = attributes_of(Glb.read(glb)), attributes_of(plain)
    sets = np.column_stack([carried[f"TEXCOORD_{k}"] for k in range(1, 5)])
    np.testing.assert_allclose(sets[:, :3], frame["TANGENT"][:, :3] @ baked.T, atol=1e-6)
    np.testing.assert_allclose(sets[:, 4:7], frame["NORMAL"] @ np.linalg.inv(baked), atol=1e-6)
    assert (sets[:, 3] == frame["TANGENT"][:, 3]).all()
    assert "TANGENT" not in carried
