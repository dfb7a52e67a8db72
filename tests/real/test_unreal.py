# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is exported for Unreal, held to a compiler and to an emulation of what Unreal does around it.

Unreal was not run. Its material compiler writes a Custom node's code into a function, whose arguments are the
node's inputs, and beside each texture its sampler; Microsoft's compiler, which Unreal uses, compiles that.
"""

from __future__ import annotations

import re
from collections import deque
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.export.export_manifest import read_manifest
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.pack import filled
from radtex_addon.export.targets.unreal import (
    SCRIPT,
    TEMPLATES,
    custom_text,
    reads_places,
    script_words,
    texture_input,
    uv_sets,
)
from radtex_addon.export.unity_unreal import baked_matrix
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.forms.hlsl_lookup import IMAGE_TEXTURES, HlslLookup
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.lookups import COUNT, SIDE
from tests.real.engine_lookups import FORMS, SUN, Asked
from tests.real.engines import Compilers, by_dxc, shown
from tests.real.exhibit import Bake, Exhibit, Form
from tests.real.unreal_editor import Editor
from tests.real.webgpu import Resource, Sampler, fields
from tests.reference.importers import attributes_of, unreal
from tests.strangers.attacks import elsewhere
from tests.transfer_lookups import IRRADIANCE

FORMS_TAKEN = [form for form in FORMS if form != "buckets in pages"]
SWAPPED = np.array([[1, 0, 0], [0, 0, 1], [0, 1, 0]])  # from glTF's axes to Unreal's
FUNCTION = """
#define PIXELSHADER {pixel}
{textures}
Texture2DArray emulated_fields : register(t24);
SamplerState emulated_sampler : register(s0);
cbuffer Emulated : register(b0) {{ float4 emulated_sun, emulated_irradiance; }};
float4 CustomExpression0({arguments}) {{
{code}
}}
float4 CustomExpression1({arguments}) {{  // the same node a second time in the material
{code}
}}
float4 main(float4 at : SV_Position) : SV_Target {{
    int2 here = int2(at.xy);
    float4 a = emulated_fields.Load(int4(here, 0, 0)), b = emulated_fields.Load(int4(here, 1, 0));
    float4 c = emulated_fields.Load(int4(here, 2, 0)), d = emulated_fields.Load(int4(here, 3, 0));
    float2 UV0 = float2(a.w, b.x), UV1 = b.yz, UV2 = float2(b.w, c.x), UV3 = c.yz, UV4 = float2(c.w, d.w);
    float2 UV5 = emulated_fields.Load(int4(here, 4, 0)).xy;
    float3 Viewer = d.xyz, Place = a.xyz, Sun = emulated_sun.xyz, Irradiance = emulated_irradiance.xyz;
    return 0.5 * (CustomExpression0({given}) + CustomExpression1({given}));
}}
"""


@cache
def asked_of(form: str) -> Asked:
    return FORMS[form](Target.UNREAL)


def function(asked: Asked, material: int, pixel: int = 1, temporal: bool = False) -> str:
    """A shader around a Custom node's code, whose line for temporal antialiasing is no comment if asked."""
    code = custom_text("Made up", "import_made_up.py", asked.lookup, asked.mesh.baked, material)
    if temporal:
        assert code.count("// #define RADTEX_TEMPORAL  //") == 1
        code = code.replace("// #define RADTEX_TEMPORAL", "#define RADTEX_TEMPORAL")
    return around(code, asked.lookup, pixel, material)


def around(code: str, lookup: HlslLookup, pixel: int = 1, material: int = 0) -> str:
    """A shader around the code of a material's Custom node."""
    kinds = {f"UV{k}": "float2" for k in range(uv_sets(lookup))} | {"Viewer": "float3"}
    if reads_places(lookup):
        kinds["Place"] = "float3"
    if lookup.relit:
        kinds |= {"Sun": "float3", "Irradiance": "float3"}
    arguments = [f"{kind} {name}" for name, kind in kinds.items()]
    shown = IMAGE_TEXTURES if material in lookup.of_images else ()
    inputs = [texture_input(name) for name in (*lookup.textures_of(material), *shown)]
    return FUNCTION.format(
        pixel=pixel,
        textures="\n".join(f"Texture2D T{name} : register(t{k});" for k, name in enumerate(inputs)),
        arguments=", ".join(
            [*arguments, *(f"Texture2D {name}, SamplerState {name}Sampler" for name in inputs)]
        ),
        code=code.replace("RADTEX_STEADY 0.16", "RADTEX_STEADY 0"),  # pixels are no neighbours here
        given=", ".join([*kinds, *(f"T{name}, emulated_sampler" for name in inputs)]),
    )


def drawn(compilers: Compilers, asked: Asked, temporal: bool = False) -> list[Floats]:
    """What the Custom node gives, for each material, of the mesh as Unreal imports it."""
    seen = unreal(asked.mesh.attributes)
    to_local = SWAPPED @ np.linalg.inv(asked.mesh.baked[:, :3])
    viewer = asked.viewers @ to_local.T
    viewer /= np.linalg.norm(viewer, axis=1, keepdims=True)  # CameraVectorWS is a unit vector
    sets = [seen[f"TEXCOORD_{k}"] for k in range(asked.uv_sets)]
    values = np.column_stack([seen["POSITION"], *sets[:5]])
    *three, last = np.split(values, [4, 8, 12], axis=1)
    resources: dict[str, Resource] = {
        "t24": fields(SIDE, *three, np.column_stack([viewer, last[:, :1]]), *sets[5:]),
        "s0": Sampler("linear"),
        "b0": np.array([*(to_local @ SUN), 0, *IRRADIANCE, 0], np.float32),
    }
    found = []
    for number in range(asked.materials):
        read = {f"t{k}": texture for k, texture in enumerate(asked.textures_of(number))}
        found.append(
            shown(compilers, "dxc", function(asked, number, temporal=temporal), resources | read, SIDE)
        )
    return found


@pytest.mark.parametrize("form", FORMS_TAKEN)
def test_light_is_the_references_through_unreals_importer(compilers: Compilers, form: str) -> None:
    asked = asked_of(form)
    mean, most = asked.error(drawn(compilers, asked))
    print(f"{form}: {COUNT} lookups, error {mean:.1e} on average, {most:.1e} at most")
    assert mean < asked.within[0]
    assert most < asked.within[1]


@pytest.mark.parametrize("form", FORMS_TAKEN)
def test_custom_nodes_compile_for_direct3d_in_every_stage(compilers: Compilers, form: str) -> None:
    for pixel in (1, 0):
        assert by_dxc(compilers, function(asked_of(form), 0, pixel))


def test_a_line_asks_for_cheaper_lookups(compilers: Compilers) -> None:
    asked = asked_of("layered")
    mean, _ = asked.error(drawn(compilers, asked, temporal=True))
    print(f"drawn by chance: error {mean:.1e} on average")
    assert asked.within[0] < mean < 0.1


@pytest.mark.parametrize("temporal", [False, True])
def test_a_custom_node_leaves_no_macro_behind(temporal: bool) -> None:
    for form in FORMS_TAKEN:
        code = function(asked_of(form), 0, temporal=temporal)
        defined, undefined = (
            set(re.findall(rf"^\s*#{word} (\w+)", code, re.MULTILINE)) for word in ("define", "undef")
        )
        assert defined - undefined == {"PIXELSHADER"}


@pytest.mark.parametrize("form", FORMS_TAKEN)
def test_the_script_connects_each_input_of_the_code(form: str, tmp_path: Path) -> None:
    asked = asked_of(form)
    codes = {
        f"Vase radiance {number}".removesuffix(" 0"): f"{number}.hlsl" for number in range(asked.materials)
    }
    for number, file in enumerate(codes.values()):
        code = custom_text("Vase", "import.py", asked.lookup, asked.mesh.baked, number)
        (tmp_path / file).write_text(code, encoding="utf-8")
    words = script_words("Vase", "radiance", "Vase.glb", asked.lookup, codes)
    words |= {"CLEAR": "True", "TWO_SIDED": "False"}
    script = tmp_path / "import.py"
    script.write_text(filled(TEMPLATES / SCRIPT, words), encoding="utf-8")
    editor = Editor(reversed(codes))
    editor.run(script)
    editor.run(script)  # again
    kinds = {each.name: each.kind for each in editor.assets.values()}
    textures = {texture_input(name) for name in asked.lookup.textures}
    assert {name for name, kind in kinds.items() if kind == "Texture2D"} == {
        f"T_Vase_radiance_{t}" for t in textures
    }
    mesh = next(each for each in editor.assets.values() if each.kind == "StaticMesh")
    assert [mesh.slots[k].name for k in range(asked.materials)][-1] == "M_Vase_radiance"
    for material in (each for each in editor.assets.values() if each.kind == "Material"):
        custom = material.inputs["MaterialProperty.MP_OPACITY"].inputs[""]
        arguments = re.findall(
            r"(?:float[23]|Texture2D) (\w+)[,)]", function(asked, 0).split("CustomExpression0(")[1]
        )
        assert list(custom.inputs) == arguments[: len(custom.inputs)]
        assert textures < set(custom.inputs)


def test_names_end_no_line_of_the_script_and_the_code(tmp_path: Path) -> None:
    asked, evil = asked_of("layered"), 'Va"""se\u2028evil\nevil\revil\u0085evil\\'
    words = script_words(evil, "radiance", "Vase.glb", asked.lookup, {evil: "Vase.custom.hlsl"})
    words |= {"CLEAR": "True", "TWO_SIDED": "False"}
    code = custom_text(evil, "import.py", asked.lookup, asked.mesh.baked)
    (tmp_path / "Vase.custom.hlsl").write_text(code, encoding="utf-8")
    script = tmp_path / "import.py"
    script.write_text(filled(TEMPLATES / SCRIPT, words), encoding="utf-8")
    for text in (code, script.read_text(encoding="utf-8")):
        assert not [line for line in text.splitlines() if line.lstrip().startswith("evil")]
    Editor([evil]).run(script)


def test_the_script_opens_no_file_elsewhere(tmp_path: Path) -> None:
    asked = asked_of("layered")
    words = script_words("Vase", "radiance", "Vase.glb", asked.lookup, {"Vase": "Vase.custom.hlsl"})
    words |= {"CLEAR": "True", "TWO_SIDED": "False"}
    endings = {"MESH": ".glb", "TEXTURES": ".dds", "MATERIALS": ".hlsl", "IMAGES": ".png"}
    for key, ending in endings.items():
        for name in elsewhere(ending):
            evil = {"MESH": name, "TEXTURES": [("Atlas", name, False)], "MATERIALS": [("Vase", name)]}
            evil["IMAGES"] = [("Rust", name, "Base", "WRAP")]
            script = tmp_path / "import.py"
            text = filled(TEMPLATES / SCRIPT, words | {key: repr(evil[key])})
            script.write_text(text, encoding="utf-8")
            editor = Editor(["Vase"])
            with pytest.raises(RuntimeError, match="is no file of this folder"):
                editor.run(script)
            assert not editor.files


@pytest.mark.parametrize("form", Form)
def test_an_export_of_a_bake_compiles(
    compilers: Compilers, exhibit: Exhibit, form: Form, tmp_path: Path
) -> None:
    bake: Bake = getattr(exhibit, form)
    folder = tmp_path / "unreal"
    deque(export_steps(bake.sidecar, ExportSpec(Target.UNREAL), folder), maxlen=0)
    (manifest,), codes, (script,) = (sorted(folder.glob(f"*.{end}")) for end in ("export.json", "hlsl", "py"))
    read = read_manifest(manifest)
    lookup = read.form.hlsl(read.bake, read.textures, Target.UNREAL)
    assert codes
    for code in codes:
        assert by_dxc(compilers, around(code.read_text(encoding="utf-8"), lookup))
    Editor(["a slot"]).run(script)
    deque(export_steps(bake.sidecar, ExportSpec(Target.GLTF), tmp_path / "gltf"), maxlen=0)
    plain, ours = (Glb.read(next(path.glob("*.glb"))) for path in (tmp_path / "gltf", folder))
    before, after = baked_matrix(plain), baked_matrix(ours)
    for number in range(len(plain.document["meshes"][0]["primitives"])):
        was, now = (attributes_of(glb, number) for glb in (plain, ours))
        moved = was["POSITION"] @ before[:, :3].T + before[:, 3]
        np.testing.assert_allclose(now["POSITION"] @ after[:, :3].T + after[:, 3], moved, atol=1e-5)
    np.testing.assert_array_equal(after[:, :3], [[1, 0, 0], [0, 0, -1], [0, 1, 0]])
