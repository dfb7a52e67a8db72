# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings start from the library's defaults, explain themselves, and ask for what they say."""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import bpy
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.cycles.device import GPU_TYPES
from radtex_addon.job.layout_choice import OpenLayout
from radtex_addon.settings import menu_items as choices
from radtex_addon.settings.kinds import KINDS, Light
from radtex_addon.settings.presets import STOCK
from radtex_addon.settings.spec import BakeSpec, Compression, Kind, Layer, Layout, Unwrap
from radtex_addon.textures.export_spec import Target
from radtex_addon.ui import registration
from radtex_addon.ui.panel.settings_panels import RADTEX_PT_output
from radtex_addon.ui.settings.bake_settings import NAMES, places
from radtex_addon.ui.settings.presets import RADTEX_OT_preset_add, apply_preset
from radtex_addon.ui.settings.request import open_layout_of, request_of, spec_of, values_of, values_with
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.ui_stage import context, ops, preferences, properties_of, registered, settings

# Of the panel's own making: keys and menus call them, or nobody sees them.
_UNTOLD = {"radtex.cancel_here", "radtex.preset_add", "radtex.show_comparison", "Version Seen"}


@pytest.fixture(autouse=True)
def _registered(empty_file: None) -> Iterator[None]:
    with registered():
        yield


def test_the_scenes_settings_ask_for_the_default_bake() -> None:
    assert spec_of(values_of(settings())) == BakeSpec(denoise=True)


def test_the_panels_page_tells_of_every_setting_preset_and_operator() -> None:
    page = (Path(__file__).parents[2] / "docs" / "panel.md").read_text(encoding="utf-8")
    shown = [*properties_of(type(settings())), *properties_of(type(preferences()))]
    told = {one.name.removesuffix(" (MB)") for one in shown}
    told |= {name for _, name, _ in STOCK}
    told |= {name for items in (choices.KINDS, choices.LAYOUTS) for _, name, _ in items}
    told.add(choices.AUTOMATIC[1])
    told |= {cls.bl_idname for cls in registration.CLASSES if issubclass(cls, bpy.types.Operator)}
    missing = {name for name in told - _UNTOLD if name not in page}
    assert not missing


@pytest.mark.parametrize(
    ("items", "enum"),
    [
        (choices.KINDS, Kind),
        (choices.LAYERS, Layer),
        (choices.LAYOUTS, Layout),
        (choices.UNWRAPS, Unwrap),
        (choices.COMPRESSIONS, Compression),
        (choices.TARGETS, Target),
    ],
)
def test_every_choice_of_the_library_is_offered(items: Any, enum: type[StrEnum]) -> None:
    assert sorted(identifier for identifier, *_ in items) == sorted(choice.value for choice in enum)


def test_every_device_of_the_library_is_offered() -> None:
    known = {"auto", "cpu", "gpu", *(kind.lower() for kind in GPU_TYPES)}
    assert {identifier for identifier, _, _ in choices.DEVICES} == known


def test_everything_has_a_tooltip_in_blenders_manner() -> None:
    for cls in registration.CLASSES:
        properties = properties_of(cls) if cls is not RADTEX_OT_preset_add else []  # Blender's own
        texts = [cls.__doc__, *(one.description for one in properties)]
        texts += [
            item.description
            for one in properties
            if one.type == "ENUM"
            for item in getattr(one, "enum_items_static", one.enum_items)
        ]
        for text in texts:
            assert text, cls.__name__
            assert not text.endswith("."), text


def test_settings_can_be_neither_more_nor_less_than_the_names() -> None:
    assert {one.identifier for one in properties_of(type(settings()))} == set(NAMES)


@pytest.mark.parametrize(("layout", "cells"), [("buckets", 5), ("layered", 14)])
def test_a_layout_brings_the_cells_that_suit_it(layout: str, cells: int) -> None:
    settings().atlas_layout, settings().bucket = "buckets", 5
    settings().atlas_layout = layout
    assert settings().bucket == cells
    assert spec_of(values_of(settings())).bucket == cells


@pytest.mark.parametrize("kind", [kind for kind, traits in KINDS.items() if traits.form is not None])
def test_a_kind_brings_the_cells_that_suit_it(kind: str) -> None:
    settings().atlas_layout, settings().bucket = "auto", 5
    settings().kind = kind
    assert settings().bucket == BakeSpec(kind=Kind(kind)).bucket
    settings().kind = "radiance"
    assert settings().bucket == 5  # which was chosen for the automatic layout


def test_cells_that_were_chosen_come_back() -> None:
    settings().atlas_layout, settings().bucket = "buckets", 12
    settings().kind = "incident"  # whose cells are of the same sort
    assert settings().bucket == 12
    settings().kind = "transfer"
    assert settings().bucket == 9
    settings().bucket = 15
    settings().kind = "ao"  # which has none
    assert settings().bucket == 8
    settings().kind = "shadow"
    assert settings().bucket == 12
    settings().kind = "transfer"
    assert settings().bucket == 15
    settings().kind, settings().atlas_layout = "radiance", "layered"
    assert settings().bucket == 14
    settings().atlas_layout = "buckets"
    assert settings().bucket == 12


def test_an_automatic_layout_has_cells_of_its_own_until_they_are_chosen() -> None:
    assert (settings().atlas_layout, settings().bucket) == ("auto", Layout.LAYERED.cells)
    assert open_layout_of(values_of(settings())) == OpenLayout()
    settings().bucket = 10
    assert open_layout_of(values_of(settings())) == OpenLayout(10)
    settings().kind = "incident"  # which has buckets
    assert (settings().bucket, open_layout_of(values_of(settings()))) == (8, OpenLayout())
    settings().kind = "shadow"  # which has nothing else
    assert open_layout_of(values_of(settings())) is None
    settings().kind = "radiance"
    assert settings().bucket == 10
    settings().atlas_layout = "buckets"
    assert (settings().bucket, open_layout_of(values_of(settings()))) == (8, None)
    settings().atlas_layout = "auto"
    assert settings().bucket == 10


def test_a_layout_of_an_earlier_version_is_the_automatic_one() -> None:
    """A .blend file has its number, which no layout has any longer."""
    chosen: Any = settings()
    chosen["atlas_layout"] = 1
    assert chosen.atlas_layout == ""
    assert spec_of(values_of(chosen)) == BakeSpec(denoise=True)
    assert open_layout_of(values_of(chosen)) == OpenLayout()


def test_choices_keep_the_numbers_that_files_store() -> None:
    stored = {
        "unwrap": {"xatlas": 0, "blender": 1, "auto": 2, "uvunwrap": 3},
        "atlas_layout": {"buckets": 0, "auto": 2, "layered": 3},
        "kind": dict(
            zip(
                ("radiance", "incident", "reflection", "proxy", "shadow", "ao", "transfer"),
                range(7),
                strict=True,
            )
        ),
        "split": {"none": 0, "material": 1, "udim": 2},
        "variants": {"none": 0, "frames": 1, "lamps": 2},
        "compression": {"zip": 0, "piz": 1, "dwaa": 2},
    }
    for name, numbers in stored.items():
        items = settings().bl_rna.properties[name].enum_items
        assert {item.identifier: item.value for item in items} == numbers


def test_a_preset_of_an_earlier_version_says_what_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "Old Pots.py"
    path.write_text(
        "import bpy\nradtex = bpy.context.scene.radtex\n"
        "radtex.samples = 7\nradtex.atlas_layout = 'shared'\nradtex.groups = 3\n"
    )
    left_out = apply_preset(str(path))
    assert settings().samples == 7
    assert [told.rpartition(" has no setting ")[2] for told in left_out] == [
        "atlas_layout = 'shared'",
        "groups = 3",
    ]
    assert ops.radtex.preset_apply(filepath=str(path)) == {"FINISHED"}


def test_cells_that_are_named_are_meant_also_where_they_suit() -> None:
    arguments: Any = SimpleNamespace(**values_of(settings()))
    named = values_with(settings(), arguments, ["bucket"])
    assert open_layout_of(named) == OpenLayout(Layout.LAYERED.cells)
    assert open_layout_of(values_with(settings(), arguments, ["texels"])) == OpenLayout()


def test_a_layout_that_is_named_brings_its_cells() -> None:
    settings().atlas_layout, settings().bucket = "buckets", 3
    arguments: Any = SimpleNamespace(**values_of(settings()) | {"atlas_layout": "layered"})
    named = values_with(settings(), arguments, ["atlas_layout"])
    assert (spec_of(named).layout, spec_of(named).bucket) == (Layout.LAYERED, 14)


def test_places_are_for_what_is_accumulated_or_refreshed() -> None:
    settings().where = "Rim"
    assert spec_of(values_of(settings())).where is None
    for name in ("accumulate", "refresh"):
        setattr(settings(), name, True)
        assert spec_of(values_of(settings())).where == "Rim"
        settings().kind = "shadow"
        assert spec_of(values_of(settings())).where is None
        settings().kind = "radiance"
        setattr(settings(), name, False)


def test_refresh_is_grey_in_layered_and_a_line_says_what_to_do_instead() -> None:
    class Rows(RecordedLayout):
        """Notes the settings that are drawn in a grey row."""

        enabled = True
        inner: list[Rows]

        def row(self, **options: Any) -> RecordedLayout:
            super().row(**options)
            made = Rows()
            self.inner = [*getattr(self, "inner", []), made]
            return made

    def drawn() -> tuple[set[str], str]:
        layout = Rows()
        RADTEX_PT_output.draw(cast(Any, SimpleNamespace(layout=layout)), context)
        grey = {name for row in layout.inner if not row.enabled for name in row.settings}
        return grey, " ".join(layout.texts)

    settings().atlas_layout = "buckets"
    settings().refresh = True
    assert drawn()[0] == set()
    assert spec_of(values_of(settings())).refresh
    settings().atlas_layout = "layered"
    grey, told = drawn()
    assert grey == {"refresh"}
    assert "Refresh is for Buckets" in told
    assert "Bake Changed" in told
    assert not spec_of(values_of(settings())).refresh
    settings().refresh = False
    assert drawn()[0] == {"refresh"}
    assert "Refresh is for Buckets" not in drawn()[1]


def test_places_of_the_active_object_are_found() -> None:
    bpy.ops.mesh.primitive_cube_add()
    context.object.vertex_groups.new(name="Rim")
    context.object.data.attributes.new("worn", "BOOLEAN", "FACE")
    context.object.data.attributes.new("heat", "FLOAT", "FACE")
    context.object.data.materials.append(bpy.data.materials.new("Brass"))
    found = {("Brass", "Material"), ("worn", "Boolean attribute"), ("Rim", "Vertex group")}
    assert set(places(settings(), context, "")) == found
    assert list(places(settings(), context, "ri")) == [("Rim", "Vertex group")]


def test_a_hull_shows_what_is_chosen_and_other_kinds_themselves() -> None:
    settings().kind = "proxy"
    assert spec_of(values_of(settings())).content is None
    settings().content = "all"
    assert spec_of(values_of(settings())).content == "*"
    settings().content = "collection"
    with pytest.raises(InputError, match="which collection does the hull show"):
        spec_of(values_of(settings()))
    settings().content_collection = "Leaves"
    assert spec_of(values_of(settings())).content == "Leaves"
    settings().kind = "radiance"
    assert spec_of(values_of(settings())).content is None


def test_how_far_ambient_rays_look_is_asked_of_them_alone() -> None:
    settings().ao_distance = 0.5
    assert spec_of(values_of(settings())).ao_distance is None
    settings().kind = "ao"
    assert spec_of(values_of(settings())).ao_distance == 0.5
    settings().ao_distance = 0.0
    assert spec_of(values_of(settings())).ao_distance is None


def test_what_another_object_shows_is_asked_for_where_it_can_be_had() -> None:
    settings().source = "High"
    assert (spec_of(values_of(settings())).source, spec_of(values_of(settings())).extrusion) == ("High", None)
    settings().extrusion = 0.25
    assert spec_of(values_of(settings())).extrusion == 0.25
    for name, value in (("kind", "proxy"), ("kind", "transfer"), ("source", "")):
        before = getattr(settings(), name)
        setattr(settings(), name, value)
        asked = spec_of(values_of(settings()))
        assert (asked.source, asked.extrusion) == (None, None)
        setattr(settings(), name, before)


def test_layers_are_for_light_in_buckets() -> None:
    settings().layers = {"rest", "base"}
    assert spec_of(values_of(settings())).layers == (Layer.BASE, Layer.REST)
    settings().atlas_layout = "layered"
    assert spec_of(values_of(settings())).layers == ()
    settings().kind = "shadow"
    assert spec_of(values_of(settings())).layers == ()


def test_settings_become_the_spec_that_they_say() -> None:
    chosen = settings()
    chosen.atlas_layout = "layered"
    chosen.texels, chosen.samples, chosen.seed = 64, 4, 7
    chosen.uv_layer, chosen.alone = "UVMap", True
    preferences().device, preferences().memory_mb = "cpu", 4096
    expected = BakeSpec(
        layout=Layout.LAYERED,
        texels=64,
        samples=4,
        seed=7,
        uv_layer="UVMap",
        alone=True,
        device="cpu",
        memory_mb=4096,
    )
    assert spec_of(values_of(chosen)) == expected


@pytest.mark.parametrize("kind", [kind for kind, traits in KINDS.items() if traits.light is Light.OCCLUSION])
def test_what_a_kind_without_light_does_not_take_is_left_out(kind: str) -> None:
    settings().kind, settings().atlas_layout = kind, "layered"
    settings().full_floats = True
    made = spec_of(values_of(settings()))
    assert (made.kind, made.layout, made.half) == (kind, Layout.BUCKETS, kind == "shadow")


def test_a_file_never_saved_goes_to_the_preferred_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="never saved: save it"):
        request_of(values_of(settings()), ("Card",))
    preferences().output_folder = str(tmp_path)
    assert request_of(values_of(settings()), ("Card",)).folder == tmp_path
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    assert request_of(values_of(settings()), ("Card",)).folder == tmp_path / "radtex" / "scene"


def test_an_export_wants_the_preview(tmp_path: Path) -> None:
    settings().directory, settings().export_targets = str(tmp_path), {"web", "raw"}
    assert request_of(values_of(settings()), ("Card",)).exports == (Target.WEB, Target.RAW)
    settings().preview = False
    with pytest.raises(InputError, match="switch Preview on"):
        request_of(values_of(settings()), ("Card",))


def test_settings_stay_with_the_file(tmp_path: Path) -> None:
    settings().texels = 77
    path = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert settings().texels == 128
    bpy.ops.wm.open_mainfile(filepath=path)
    assert settings().texels == 77
    bpy.ops.scene.new(type="FULL_COPY")
    assert context.scene.radtex.texels == 77
