# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The layout of a bake that names none: what was asked for and the object decide it, never the machine."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.cli.arguments import parse
from radtex_addon.cli.wording import worded
from radtex_addon.core.errors import InputError
from radtex_addon.formats.sidecar import file_name
from radtex_addon.forms.layered import bake as layered
from radtex_addon.job import Choice, OpenLayout, bake_object, choose_layout
from radtex_addon.settings import cost
from radtex_addon.settings.spec import BakeSpec, Compression, Kind, Layer, Layout, Split
from radtex_addon.store.checkpoint_files import Key, write_key
from tests.blender import stage

pytestmark = pytest.mark.one_blender

context: Any = bpy.context  # to the stubs, every pointer may be None
as_asked = partial(BakeSpec, denoise=True)  # the default of the command line and the panel
DEFAULT = as_asked(layout=Layout.LAYERED)
PLAIN = as_asked()
NOWHERE = Path("/nowhere")


@pytest.fixture(autouse=True)
def card(empty_file: None) -> Any:
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = "Card"
    context.object.data.materials.append(stage.material("Paper", "ShaderNodeBsdfDiffuse"))
    return context.object


def asked(line: str, folder: Path = NOWHERE) -> Choice:
    """What a command line comes to."""
    request = parse(["a.blend", "--object", "Card", *line.split()], inside_blender=False)
    bakes = request.bakes
    ((name,), (spec,)) = bakes.names, bakes.specs(context.scene)
    return choose_layout(
        context.scene,
        (name, spec),
        bakes.open_layout,
        folder,
        resume=bakes.resume,
        overwrite=bakes.overwrite,
    )


@pytest.mark.parametrize(
    ("line", "spec"),
    [
        ("--texels 64 --samples 4", as_asked(layout=Layout.LAYERED, texels=64, samples=4)),
        ("", DEFAULT),
        ("--bucket 14", DEFAULT),
        (
            "--float --compression piz",
            as_asked(layout=Layout.LAYERED, half=False, compression=Compression.PIZ),
        ),
        ("--layout layered", DEFAULT),
        ("--layout buckets", PLAIN),
        ("--frames 3", as_asked(layout=Layout.LAYERED, frame=3)),
        ("--lights Key", as_asked(layout=Layout.LAYERED, lights=("Key",))),
        ("--accumulate", as_asked(layout=Layout.LAYERED, accumulate=True)),
        ("--from High", as_asked(layout=Layout.LAYERED, source="High")),
        ("--split material", as_asked(layout=Layout.LAYERED, split=Split.MATERIAL)),
        ("--together All --object Box", as_asked(layout=Layout.LAYERED, objects=("Card", "Box"), texels=192)),
    ],
)
def test_what_goes_with_a_layout_gets_it(line: str, spec: BakeSpec) -> None:
    assert asked(line) == Choice(spec)


# Everything that layout buckets takes and the layered one does not, and what is said of it.
REFUSED = {
    "--kind incident": (as_asked(kind=Kind.INCIDENT), "the layered layout knows kind radiance only"),
    "--kind shadow": (as_asked(kind=Kind.SHADOW), "the layered layout holds light, not shadow"),
    "--kind transfer": (as_asked(kind=Kind.TRANSFER), "kind transfer does not go with the layered layout"),
    "--kind incident --capture panoramic": (None, "the layered layout knows kind radiance only"),
    "--layer base": (as_asked(layers=(Layer.BASE,)), "the layered layout has no layers"),
    "--refresh": (as_asked(refresh=True), "the layered layout cannot be refreshed"),
    "--bucket 8": (as_asked(bucket=8), "the layered layout chooses its cells itself, 14 or fewer, not 8"),
    "--texels 4096": (as_asked(texels=4096), "4096 texels at 16 samples would need"),
    "--samples 5000": (as_asked(samples=5000), "samples in the layered layout 5000"),
}


@pytest.mark.parametrize("line", REFUSED)
def test_what_the_layered_layout_refuses_gets_buckets_and_a_line_says_why(line: str) -> None:
    spec, words = REFUSED[line]
    found = asked(line)
    assert found.spec.layout is Layout.BUCKETS
    assert spec is None or found.spec == spec
    assert found.reason.startswith(words) or words in found.reason
    assert "layout buckets" not in found.reason, "that is no remedy now"
    assert found.told("Card") == f"'Card' is baked in layout buckets, not layered: {found.reason}"
    assert "\n" not in found.told("Card")


@pytest.mark.parametrize(
    "line",
    [
        "--layout layered --kind incident",
        "--layout layered --bucket 8",
        "--layout layered --layer base",
        "--layout layered --refresh",
    ],
)
def test_a_layout_that_was_named_is_refused_and_never_replaced(line: str) -> None:
    with pytest.raises(InputError):
        asked(line)


def fill_with_smoke(card: Any) -> None:
    card.data.materials[0] = stage.material("Smoke", "ShaderNodeBsdfDiffuse")
    tree = card.data.materials[0].node_tree
    output = tree.get_output_node("CYCLES")
    tree.links.new(tree.nodes.new("ShaderNodeVolumePrincipled").outputs[0], output.inputs["Volume"])


def test_an_object_without_a_surface_gets_buckets(card: Any) -> None:
    fill_with_smoke(card)
    smoke = "its material 'Smoke' has a volume"
    assert asked("") == Choice(PLAIN, smoke)
    assert asked("--layout layered") == Choice(DEFAULT)
    assert asked("--layout buckets") == Choice(PLAIN)


def test_what_is_seen_through_has_an_alpha(card: Any) -> None:
    card.data.materials[0] = stage.material("Veil", "ShaderNodeBsdfTransparent")
    assert asked("") == Choice(DEFAULT)
    card.data.materials[0] = stage.material("Pane", "ShaderNodeBsdfGlass")
    assert asked("") == Choice(DEFAULT)
    context.scene.render.film_transparent = context.scene.cycles.film_transparent_glass = True
    assert asked("") == Choice(PLAIN, "its material 'Pane' is glass, which the transparent film makes clear")


def test_an_object_that_is_not_there_is_left_to_who_refuses_it() -> None:
    context.object.name = "Other"
    assert asked("") == Choice(DEFAULT)


LINES = (
    "",
    "--texels 64",
    "--texels 256",
    "--texels 640",
    "--texels 1024",
    "--bucket 8",
    "--layer base",
    "--layout buckets",
)


def test_the_machine_has_no_say(card: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """One with little memory refuses what it cannot, and says which way there is; it chooses nothing else."""
    answers = {}
    for memory in (2**31, 2**36, None):
        monkeypatch.setattr(cost, "physical_memory", lambda memory=memory: memory)
        for line in LINES:
            if (memory, line) == (2**31, "--texels 1024"):
                with pytest.raises(
                    InputError, match=r"has 2\.0 GiB: lower one of them, or choose layout buckets"
                ):
                    asked(line)
            else:
                answers[memory, line] = asked(line)
        fill_with_smoke(card)
        assert asked("--texels 640").spec == as_asked(texels=640)
        card.data.materials[0] = stage.material("Paper", "ShaderNodeBsdfDiffuse")
    assert all(answers[memory, line] == answers[None, line] for memory, line in answers)
    assert len(answers) == 3 * len(LINES) - 1


def test_what_would_take_very_much_memory_is_plain() -> None:
    assert asked("--texels 640").spec.layout is Layout.LAYERED
    assert asked("--texels 2048").spec.layout is Layout.LAYERED
    plain = asked("--texels 4096")
    assert plain.spec == as_asked(texels=4096)
    assert plain.reason.startswith("4096 texels at 16 samples would need ")


def begin(folder: Path, spec: BakeSpec) -> None:
    """Leave what an interrupted bake does."""
    facts = {name: str(getattr(spec, name)) for name in ("layout", "bucket")}
    place = folder / file_name("Card", spec.kind, "radtex-unfinished")
    place.mkdir(parents=True)
    write_key(place, Key(facts, [], []))


BEGUN = {
    "the default": DEFAULT,
    "buckets": PLAIN,
    "buckets of other cells": as_asked(bucket=6),
}


@pytest.mark.parametrize("case", BEGUN)
def test_to_resume_goes_on_in_the_layout_that_was_begun(case: str, card: Any, out: Path) -> None:
    begin(out, BEGUN[case])
    assert asked("--resume", out) == Choice(BEGUN[case])
    assert asked("--resume --overwrite", out) == Choice(BEGUN[case])
    assert asked("--overwrite", out) == Choice(DEFAULT), "begun anew"
    fill_with_smoke(card)  # which its own key refuses, by name, if it was not so before
    assert asked("--resume", out) == Choice(BEGUN[case])


def test_to_resume_with_a_layout_or_cells_keeps_to_them(out: Path) -> None:
    begin(out, BEGUN["buckets of other cells"])
    assert asked("--resume --layout layered", out).spec == DEFAULT
    assert asked("--resume --bucket 10", out).spec.bucket == 10
    assert asked("--resume --layout buckets", out).spec == PLAIN


def test_a_key_that_says_nothing_of_layouts_is_no_hindrance(out: Path) -> None:
    begin(out, DEFAULT)
    write_key(out / "Card.radiance.radtex-unfinished", Key({"layout": "spirals"}, [], []))
    assert asked("--resume", out) == Choice(DEFAULT)


def finish(folder: Path, frame: int | None = None, layout: str = "buckets", **facts: object) -> None:
    folder.mkdir(exist_ok=True)
    name = "Card" if frame is None else f"Card-{frame:04d}"
    told = {"object": "Card", "kind": "radiance", "layout": layout, **facts}
    (folder / f"{name}.radiance.json").write_text(json.dumps(told))


@pytest.mark.parametrize("way", ["--accumulate", "--refresh"])
def test_what_is_folded_in_has_the_cells_of_what_is_there(way: str, out: Path) -> None:
    finish(out, bucket=6)
    found = asked(way, out)
    assert (found.spec.layout, found.spec.bucket, found.reason) == (Layout.BUCKETS, 6, "")
    assert asked(f"{way} --bucket 8", out).spec.bucket == 8
    finish(out, bucket=14, layout="layered")
    if way == "--accumulate":
        assert asked(way, out).spec == as_asked(layout=Layout.LAYERED, accumulate=True)
        return
    words = r"Card\.radiance\.json is in the layered layout, which cannot be refreshed, since a few paths "
    with pytest.raises(InputError, match=words) as refused:
        asked(way, out)
    assert worded(refused.value.message).endswith(
        ": bake it again only if it has changed (--changed, without --refresh), "
        "or bake it anew in layout buckets (--layout buckets, --overwrite)"
    )


def test_a_refusal_to_refresh_says_what_was_measured_and_what_to_do_instead() -> None:
    with pytest.raises(InputError) as refused:
        as_asked(layout=Layout.LAYERED, refresh=True)
    assert worded(refused.value.message) == (
        "the layered layout cannot be refreshed, since a few paths miss texels that show a change, "
        "and to bake those alone saves little time: "
        "bake again only the objects that have changed (--changed, without --refresh), "
        "or choose layout buckets (--layout buckets)"
    )


def test_other_frames_of_a_run_that_goes_on_are_alike(out: Path) -> None:
    line = "--frames 1,2 --resume"
    request = parse(["a.blend", "--object", "Card", *line.split()], inside_blender=False)
    bakes = request.bakes.asked(context.scene)

    def second(**options: bool) -> BakeSpec:
        wish = request.bakes.open_layout
        return choose_layout(context.scene, bakes[1], wish, out, others=bakes, **options).spec

    assert second(resume=True).layout is Layout.LAYERED
    finish(out, 1, bucket=6)
    assert (second(resume=True).layout, second(resume=True).bucket) == (Layout.BUCKETS, 6)
    assert second().layout is Layout.LAYERED
    assert second(resume=True, overwrite=True).layout is Layout.LAYERED
    finish(out, 1, bucket=14, layout="layered")
    assert (second(resume=True).layout, second(resume=True).bucket) == (Layout.LAYERED, 14)


def test_more_materials_than_a_sidecar_holds_are_refused_before_the_first_ray(
    out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage.world()
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=33, y_subdivisions=32)
    item: Any = bpy.context.object
    for number in range(33 * 32):
        item.data.materials.append(bpy.data.materials.new(f"No {number}"))
    item.data.polygons.foreach_set("material_index", range(33 * 32))
    spec = BakeSpec(layout=Layout.LAYERED, texels=64, samples=1, uv_layer="UVMap")
    monkeypatch.setattr(layered, "capture_layered", None)  # nothing is captured
    with pytest.raises(InputError, match="has 1056 materials, the layered layout holds 1024 in one atlas"):
        bake_object(context.scene, item.name, spec, out)
    assert list(out.glob("*")) == []
    assert choose_layout(context.scene, (item.name, BakeSpec()), OpenLayout(), out) == Choice(
        BakeSpec(), "it has 1056 materials, and layered holds 1024 in one atlas"
    )
