# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stands for the module `unreal` of Unreal's editor, and records what a script does with it.

It knows no names but those that the exported script uses of Unreal's public Python API (dev.epicgames.com,
Unreal 5.4 to 5.7). It proves that the script runs to its end and connects what it means to; of Unreal it
proves nothing.
"""

from __future__ import annotations

import ast
import types
from collections.abc import Iterable
from pathlib import Path
from typing import Any

MATERIAL_NODES = {
    "MaterialExpressionTextureCoordinate": {"coordinate_index"},
    "MaterialExpressionCameraVectorWS": set[str](),
    "MaterialExpressionWorldPosition": set[str](),
    "MaterialExpressionTransform": {"transform_source_type", "transform_type"},
    "MaterialExpressionTransformPosition": {"transform_source_type", "transform_type"},
    "MaterialExpressionTextureObject": {"texture", "sampler_type"},
    "MaterialExpressionCustom": {"code", "description", "output_type", "inputs"},
    "MaterialExpressionComponentMask": {"r", "g", "b", "a"},
    "MaterialExpressionScalarParameter": {"parameter_name", "default_value"},
    "MaterialExpressionVectorParameter": {"parameter_name", "default_value"},
    "MaterialExpressionMultiply": set[str](),
}
PROPERTIES = {
    **MATERIAL_NODES,
    "Material": {"shading_model", "two_sided", "blend_mode"},
    "Texture2D": {
        *("compression_settings", "srgb", "mip_gen_settings", "filter", "address_x", "address_y"),
        *("never_stream", "virtual_texture_streaming", "power_of_two_mode", "max_texture_size"),
        "flip_green_channel",
    },
    "StaticMesh": {"static_materials"},
    "StaticMaterial": {"material_slot_name"},
    "CustomInput": {"input_name"},
    "ImportAssetParameters": {"is_automated", "replace_existing", "override_pipelines"},
    "InterchangeGenericTexturePipeline": {
        *("asset_name", "detect_normal_map_texture", "allow_non_power_of_two", "import_textures"),
    },
    "InterchangeGenericAssetsPipeline": {
        *("asset_name", "common_meshes_properties", "mesh_pipeline", "material_pipeline"),
    },
    "InterchangeGenericCommonMeshesProperties": {
        "bake_meshes",
        "recompute_normals",
        "use_full_precision_u_vs",
    },
    "InterchangeGenericMeshPipeline": {"generate_lightmap_u_vs", "build_nanite"},
    "InterchangeGenericMaterialPipeline": {"import_materials", "texture_pipeline"},
    "MaterialFactoryNew": set[str](),
}
ENUMS = {
    "TextureCompressionSettings": {"TC_HDR", "TC_BC7", "TC_NORMALMAP"},
    "TextureMipGenSettings": {"TMGS_LEAVE_EXISTING_MIPS", "TMGS_NO_MIPMAPS"},
    "TextureFilter": {"TF_TRILINEAR", "TF_DEFAULT"},
    "TextureAddress": {"TA_CLAMP", "TA_WRAP", "TA_MIRROR"},
    "TexturePowerOfTwoSetting": {"NONE"},
    "MaterialShadingModel": {"MSM_UNLIT"},
    "BlendMode": {"BLEND_ALPHA_COMPOSITE", "BLEND_OPAQUE"},
    "MaterialVectorCoordTransformSource": {"TRANSFORMSOURCE_WORLD"},
    "MaterialVectorCoordTransform": {"TRANSFORM_LOCAL"},
    "MaterialPositionTransformSource": {"TRANSFORMPOSSOURCE_WORLD", "TRANSFORMPOSSOURCE_LOCAL"},
    "MaterialSamplerType": {"SAMPLERTYPE_LINEAR_COLOR", "SAMPLERTYPE_COLOR", "SAMPLERTYPE_NORMAL"},
    "CustomMaterialOutputType": {"CMOT_FLOAT4"},
    "MaterialProperty": {"MP_EMISSIVE_COLOR", "MP_OPACITY"},
}
INNER = {
    "common_meshes_properties": "InterchangeGenericCommonMeshesProperties",
    "mesh_pipeline": "InterchangeGenericMeshPipeline",
    "material_pipeline": "InterchangeGenericMaterialPipeline",
    "texture_pipeline": "InterchangeGenericTexturePipeline",
}


class Thing:
    """An object of one of Unreal's classes, with those of its properties that are known."""

    def __init__(self, kind: str, name: str = "") -> None:
        self.kind, self.name = kind, name
        self.values: dict[str, Any] = {}
        self.inputs: dict[str, Thing] = {}
        self.slots: dict[int, Thing] = {}
        self.owner: Thing | None = None

    def set_editor_property(self, name: str, value: object) -> None:
        assert name in PROPERTIES[self.kind], f"{self.kind} has no {name}"
        self.values[name] = value

    def get_editor_property(self, name: str) -> Any:
        assert name in PROPERTIES[self.kind], f"{self.kind} has no {name}"
        if name in INNER:
            return self.values.setdefault(name, Thing(INNER[name]))
        return self.values[name]

    def get_name(self) -> str:
        return self.name or self.kind

    def get_path_name(self) -> str:
        return f"/Engine/Transient.{id(self)}"

    def set_material(self, index: int, material: Thing) -> None:
        assert self.kind == "StaticMesh"
        self.slots[index] = material


class Editor(types.ModuleType):
    """The module, its assets by their paths, and the files that were imported, by the assets' names."""

    def __init__(self, slots: Iterable[str]) -> None:
        super().__init__("unreal")
        self.assets: dict[str, Thing] = {}
        self.files: dict[str, str] = {}
        self._slots = list(slots)
        self.pipelines: dict[str, Thing] = {}
        for kind in PROPERTIES:
            setattr(self, kind, type(kind, (), {"__new__": lambda _, kind=kind: self._made(kind)}))
        for name, members in ENUMS.items():
            setattr(self, name, types.SimpleNamespace(**{each: f"{name}.{each}" for each in members}))
        self.SoftObjectPath = str
        self.LinearColor = lambda *parts: parts
        self.log = print
        self.load_asset = lambda path: self.assets[path.split(".")[0]]
        self.MaterialEditingLibrary = types.SimpleNamespace(
            create_material_expression=self._node,
            connect_material_expressions=self._connected,
            connect_material_property=self._connected_property,
            delete_all_material_expressions=lambda material: material.inputs.clear(),
            recompile_material=lambda _material: None,
        )
        self.EditorAssetLibrary = types.SimpleNamespace(
            does_asset_exist=lambda path: path in self.assets,
            list_assets=lambda _folder, recursive: self._listed() if recursive else [],
            save_directory=lambda _path: True,
        )
        tools = types.SimpleNamespace(create_asset=self._created)
        self.AssetToolsHelpers = types.SimpleNamespace(get_asset_tools=lambda: tools)
        manager = types.SimpleNamespace(import_asset=self._imported)
        self.InterchangeManager = types.SimpleNamespace(
            create_source_data=lambda path: path, get_interchange_manager_scripted=lambda: manager
        )

    def run(self, script: Path) -> None:
        """Execute a script, in which `import unreal` brings this module."""
        tree = ast.parse(script.read_text(encoding="utf-8"))
        tree.body = [
            each
            for each in tree.body
            if not (isinstance(each, ast.Import) and [alias.name for alias in each.names] == ["unreal"])
        ]
        exec(compile(tree, str(script), "exec"), {"unreal": self, "__file__": str(script)})

    def _made(self, kind: str) -> Thing:
        made = Thing(kind)
        self.pipelines[made.get_path_name()] = made
        return made

    def _imported(self, folder: str, path: str, parameters: Thing) -> bool:
        (pipeline,) = (self.pipelines[each] for each in parameters.values["override_pipelines"])
        name, is_mesh = pipeline.values["asset_name"], path.endswith(".glb")
        made = Thing("StaticMesh" if is_mesh else "Texture2D", name)
        if is_mesh:
            made.values["static_materials"] = []
            for slot in self._slots:
                material = Thing("StaticMaterial")
                material.values["material_slot_name"] = slot
                made.values["static_materials"].append(material)
        self.assets[f"{folder}/{'StaticMeshes' if is_mesh else 'Textures'}/{name}"] = made
        self.files[name] = Path(path).name
        return True

    def _listed(self) -> list[str]:
        return [f"{path}.{asset.name}" for path, asset in self.assets.items()]

    def _created(self, name: str, folder: str, _kind: object, _factory: object) -> Thing:
        made = self.assets[f"{folder}/{name}"] = Thing("Material", name)
        return made

    @staticmethod
    def _connected(source: Thing, _output: str, target: Thing, pin: str) -> bool:
        if target.kind == "MaterialExpressionCustom":
            pins = [each.values["input_name"] for each in target.values["inputs"]]
            assert pin in pins
        target.inputs[pin] = source
        return True

    @staticmethod
    def _connected_property(source: Thing, _output: str, name: str) -> bool:
        assert source.owner is not None
        source.owner.inputs[name] = source
        return True

    @staticmethod
    def _node(material: Thing, kind: Any, _x: int, _y: int) -> Thing:
        made: Thing = kind()
        made.owner = material
        return made
