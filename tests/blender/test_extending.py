# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One row makes an option, or a kind, and one folder with a row a form.

Kinds and forms bake, show, export and are found finished; options are offered, checked, stored and told of.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.examples.extended import ROOT, add_form, add_kind, add_option, summary

pytestmark = pytest.mark.one_blender

BAKE = """
import json, sys
from pathlib import Path
import bpy
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.core.sampler import Filter
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.export_manifest import read_manifest
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.job import bake_object
from radtex_addon.store.bake_folder import BakeFolder
from radtex_addon.textures.export_spec import ExportSpec, Target
from radtex_addon.settings.menu_items import KINDS
from tests.blender import stage

bpy.ops.wm.read_factory_settings(use_empty=True)
stage.world((0.5, 0.25, 1.0))
bpy.ops.mesh.primitive_plane_add()
bpy.context.object.name = "Card"
out = Path(sys.argv[1])
spec = BakeSpec(kind="irradiance", uv_layer="UVMap", texels=4, bucket=4, samples=4, half=False)
result = bake_object(bpy.context.scene, "Card", spec, out, preview=Filter.LINEAR)
pixels, facts = read_buckets(result.files.sidecar)
steps = export_steps(result.files.sidecar, ExportSpec(Target.RAW))
while True:
    try:
        next(steps)
    except StopIteration as stop:
        exported = stop.value
        break
manifest = read_manifest(exported.folder / "Card.export.json")
print("RESULT " + json.dumps({
    "light": pixels[..., :3].mean(axis=(0, 1)).tolist(),
    "spread": float(pixels[..., :3].std(axis=(0, 1)).max()),
    "size": list(pixels.shape[:2]),
    "finished": BakeFolder("Card", spec, out).is_finished(),
    "offered": "irradiance" in [name for name, _, _ in KINDS],
    "preview": result.files.preview.is_file(),
    "textures": list(manifest.textures),
}))
"""
OFFER = """
import json
from dataclasses import replace
from pathlib import Path
import bpy
from radtex_addon.settings.spec import BakeSpec, facts_of, fingerprint_texts, key_facts, spec_in
from radtex_addon.cli import arguments, wording
from radtex_addon.core.errors import InputError
from radtex_addon.formats.json_reader import Facts
from radtex_addon.formats.sidecar import Sidecar
from radtex_addon.prepare.facts import facts_of as sidecar_of
from radtex_addon.ui import registration
from radtex_addon.ui.panel.labels import remark
from radtex_addon.ui.panel.remedies import offers
from radtex_addon.ui.settings.request import spec_of, values_of

registration.register()
settings = bpy.context.scene.radtex
spec = replace(BakeSpec(), only_front=True)
told = Sidecar.from_json(sidecar_of("Card", spec, 4, 4, "UVMap").to_json())
try:
    BakeSpec(kind="ao", only_front=True)
except InputError as error:
    refused = error
settings.only_front = True
asked = spec_of(values_of(settings))
settings.kind = "ao"
print("RESULT " + json.dumps({
    "help": "--only-front" in arguments.build_parser(False).format_help(),
    "batch": arguments.parse("a.blend --object Card --only-front".split(), False).bakes.spec.only_front,
    "tooltip": settings.bl_rna.properties["only_front"].description,
    "panel": [asked.only_front, spec_of(values_of(settings)).only_front],
    "order": spec_in(Facts(facts_of(spec), "the order")) == spec,
    "sidecar": list(told.marks),
    "resumed": [key_facts(each)["only front"] for each in (BakeSpec(), spec)],
    "fingerprint": [text for text in fingerprint_texts(spec) if text not in fingerprint_texts(BakeSpec())],
    "refused": [wording.worded(refused.message), remark(refused)],
    "button": [offer.text for offer in offers(refused.message, settings)],
}))
"""


def result_of(package: Path, *command: str) -> Any:
    """What a script says that runs with a copy of the package."""
    environment = {name: value for name, value in os.environ.items() if name != "OCIO"}
    environment["PYTHONPATH"] = os.pathsep.join([str(package.parent), str(ROOT)])
    line = [sys.executable, "-c", *command]
    ended = subprocess.run(
        line, cwd=package.parent, env=environment, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stderr[-4000:]
    return json.loads(next(line for line in ended.stdout.splitlines() if line.startswith("RESULT "))[7:])


def test_an_option_that_is_added_is_offered_checked_stored_and_told_of(tmp_path: Path) -> None:
    assert result_of(add_option(tmp_path / "copy"), OFFER) == {
        "help": True,
        "batch": True,
        "tooltip": "Bake what is seen from in front alone",
        "panel": [True, False],
        "order": True,
        "sidecar": ["only_front"],
        "resumed": ["False", "True"],
        "fingerprint": ["only_front True"],
        "refused": [
            "ao has no front: leave --only-front out",
            "Ao has no front: leave Only Front off",
        ],
        "button": ["Switch Off Only Front"],
    }


@pytest.mark.parametrize(("add", "cells"), [(add_kind, 4), (add_form, 1)])
def test_what_is_added_bakes_and_exports(add: Callable[[Path], Path], cells: int, tmp_path: Path) -> None:
    found = result_of(add(tmp_path / "copy"), BAKE, str(tmp_path / "out"))
    assert found["light"] == pytest.approx([0.5, 0.25, 1.0], rel=1e-3)
    assert found["spread"] < 1e-3
    assert found["size"] == [4 * cells, 4 * cells]
    assert found["finished"]
    assert found["offered"]
    assert found["preview"]
    assert found["textures"] == ["irradiance"]


def test_what_is_added_is_what_the_documentation_says(tmp_path: Path) -> None:
    assert summary(add_option(tmp_path / "option")) == ["settings/options.py: edited, +6"]
    assert summary(add_kind(tmp_path / "kind")) == ["settings/kinds.py: edited, +10"]
    edited = ["settings/forms.py: edited, +2", "settings/kinds.py: edited, +12"]
    new = [line.partition(":")[0] for line in summary(add_form(tmp_path / "form")) if ": new" in line]
    assert [line for line in summary(add_form(tmp_path / "again")) if ": edited" in line] == edited
    assert new == ["forms/mean/__init__.py", "forms/mean/form.py"]
