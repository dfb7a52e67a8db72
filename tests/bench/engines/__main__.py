# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How close does the default bake of each of the fidelity bench's scenes come, in each program that shows it?

    python -m tests.bench.engines --out DIR                         all scenes, 128 texels, two views
    python -m tests.bench.engines --scenes ceramic,curtain --texels 64 --views 1 --out DIR
    python -m tests.bench.engines --format ktx2-rgba16f --out DIR    without compressed blocks

Bakes each scene's object as a user does who names no layout, saves its preview, exports it for the web and
for Godot, and looks at it from the bench's held-out cameras: by the reference lookup, in Chromium, in Godot,
and as the preview in Eevee and in Cycles. PSNR is against Cycles's path-traced picture, of display values
(clipped, gamma 2.2), inside the object's eroded mask. Chromium and Godot run in the root of tests/real.

DIR gets table.md, figures.json, and for each scene a strip of pictures: path traced, the reference lookup,
Chromium, Godot, Eevee, Cycles. Scenes that figures.json has with the same settings are not measured again;
finished bakes in DIR/bakes are taken as they are.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from playwright.sync_api import sync_playwright

from radtex_addon.report.metrics import Picture
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.textures.export_spec import TextureFormat
from tests.bench.fidelity.choice import names_of
from tests.bench.fidelity.pictures import SAMPLES
from tests.bench.fidelity.scenes import SCENES, Stage
from tests.real.browser import SOFTWARE_GL, chromium, served
from tests.real.root import PROGRAMS, Root, ready_root
from tests.real.web import Site, build_page

from .baking import produce, size_of
from .looking import Seen, looked_up, looks
from .programs import by_blender, by_chromium, by_godot
from .report import LOOKUP, SHOWN_BY, Row, save_strip, table

RENDERER = "Compatibility"  # of Godot
_KEPT = "figures.json"


@dataclass(frozen=True)
class Programs:
    """What shows bakes: Godot in the `root`, and Chromium with the `site`, below whose folder bakes lie."""

    root: Root
    site: Site


@dataclass(frozen=True)
class Settings:
    """How scenes are measured.

    `views` are those of a scene, `samples` those of a pixel of the path-traced pictures, `spp` the bake's,
    `by` the programs, of SHOWN_BY.
    """

    texels: int = 128
    views: int = 2
    samples: int = SAMPLES
    spp: int = 16
    form: TextureFormat = TextureFormat.AUTO
    by: tuple[str, ...] = SHOWN_BY


def main() -> None:
    """Bake, export, look, compare, print."""
    options = _options()
    options.out.mkdir(parents=True, exist_ok=True)
    settings = Settings(
        options.texels,
        options.views,
        options.reference_samples,
        options.samples,
        options.format,
        tuple(options.programs),
    )
    rows = _kept(options.out, settings)
    with programs(options.out / "bakes") as showing:
        for name in options.scenes:
            if name not in rows:
                rows[name] = measured(SCENES[name], settings, showing, options.out / f"{name}.png")
                _keep(options.out, settings, rows)
                print(f"\n{table(rows)}", flush=True)
    print(f"\n{table(rows)}")


@contextmanager
def programs(folder: Path) -> Iterator[Programs]:
    """Chromium with a server, and the root for Godot; bakes lie below `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    path, _ = ready_root(PROGRAMS)
    build_page()
    with (
        tempfile.TemporaryDirectory() as exchange,
        sync_playwright() as driver,
        chromium(root := Root(path, Path(exchange)), driver.chromium, *SOFTWARE_GL) as browser,
        served(folder) as address,
    ):
        yield Programs(root, Site(folder, address, browser))


def measured(build: Callable[[], Stage], settings: Settings, showing: Programs, strip: Path) -> Row:
    """Measure the scene that `build` makes, and save its `strip` of pictures."""
    stage = build()
    looked_from = looks(stage, settings.views, settings.samples)
    matrix, subject = np.array(stage.subject.matrix_world), stage.subject.name
    folder = showing.site.folder / f"{stage.name}-{settings.texels}-{settings.spp}"
    spec = BakeSpec(texels=settings.texels, samples=settings.spp)
    product = produce(stage, spec, folder, settings.form)
    seen = looked_up(product.finished, matrix, looked_from)
    preview = product.finished.preview
    shows: dict[str, Callable[[], list[Picture]]] = {
        "Chromium": lambda: by_chromium(showing.site, f"{folder.name}/{product.web.name}", looked_from),
        "Godot": lambda: by_godot(showing.root, product.godot, RENDERER, looked_from),
        "Eevee": lambda: by_blender(preview, subject, "eevee", looked_from, folder / "eevee"),
        "Cycles": lambda: by_blender(preview, subject, "cycles", looked_from, folder / "cycles"),
    }
    shown = {LOOKUP: [each.picture for each in seen]} | {by: shows[by]() for by in settings.by}
    decibels = _decibels(shown, seen)
    _save(strip, shown, seen, decibels)
    sizes = size_of(product.web), size_of(product.godot)
    layout = product.finished.form.traits.layout
    means = {by: float(np.mean(found)) for by, found in decibels.items()}
    return Row(means, layout, *sizes, product.seconds)


def _decibels(shown: dict[str, list[Picture]], seen: Sequence[Seen]) -> dict[str, list[float]]:
    return {
        by: [each.decibels(picture) for each, picture in zip(seen, pictures, strict=True)]
        for by, pictures in shown.items()
    }


def _save(
    path: Path, shown: dict[str, list[Picture]], seen: Sequence[Seen], decibels: dict[str, list[float]]
) -> None:
    """A row for each view; around the object every picture is the path-traced one."""
    views, labels = [], []
    for number, each in enumerate(seen):
        traced = each.look.view.reference
        pictures = {
            by: np.where(each.inside[..., None], found[number], traced) for by, found in shown.items()
        }
        views.append({"path traced": traced, **pictures})
        texts = {by: f"{by}: {found[number]:.1f} dB" for by, found in decibels.items()}
        labels.append({"path traced": f"{path.stem}, path traced", **texts})
    save_strip(path, views, labels)


def _kept(out: Path, settings: Settings) -> dict[str, Row]:
    """The scenes that figures.json has, if they were measured with these settings."""
    path = out / _KEPT
    if not path.is_file():
        return {}
    found = json.loads(path.read_text(encoding="utf-8"))
    if found["settings"] != json.loads(json.dumps(asdict(settings))):
        return {}
    return {name: Row(**row) for name, row in found["scenes"].items()}


def _keep(out: Path, settings: Settings, rows: dict[str, Row]) -> None:
    scenes = {name: asdict(row) for name, row in rows.items()}
    facts = {"settings": asdict(settings), "scenes": scenes}
    (out / _KEPT).write_text(json.dumps(facts, indent=2) + "\n", encoding="utf-8")
    (out / "table.md").write_text(table(rows), encoding="utf-8")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.engines",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    scenes = list(SCENES)
    parser.add_argument("--scenes", type=names_of(scenes), default=scenes, help="of " + ", ".join(scenes))
    parser.add_argument("--texels", type=int, default=128, help="along each side of the atlas (128)")
    parser.add_argument("--samples", type=int, default=16, help="as of bake.py --samples (16)")
    parser.add_argument("--views", type=int, choices=(1, 2), default=2, help="held-out cameras (2)")
    parser.add_argument("--reference-samples", type=int, default=SAMPLES, help=f"of a pixel ({SAMPLES})")
    known = list(SHOWN_BY)
    parser.add_argument("--programs", type=names_of(known), default=known, help="of " + ", ".join(known))
    parser.add_argument(
        "--format", type=TextureFormat, default=TextureFormat.AUTO, help="of the exports (auto: blocks)"
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for what it makes")
    return parser.parse_args()


if __name__ == "__main__":
    main()
