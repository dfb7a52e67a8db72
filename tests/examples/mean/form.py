# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The mean of each texel's cells, in an image of buckets of one cell: all else is as in the plain form."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace

from radtex_addon.bake.progress import Progress, Stage
from radtex_addon.bake.session import fill_atlas
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.formats.bucket_files import write_buckets
from radtex_addon.formats.json_reader import Facts
from radtex_addon.forms.bake_job import BakeJob
from radtex_addon.forms.buckets.bake import capture_of
from radtex_addon.forms.buckets.form import Buckets
from radtex_addon.forms.form import Form
from radtex_addon.forms.outcome import Outcome
from radtex_addon.settings.forms import FORMS
from radtex_addon.settings.kinds import KINDS, Kind
from radtex_addon.settings.spec import BakeSpec


class Mean(Buckets):
    """One colour a texel: see `forms.form.Form`."""

    traits = next(traits for traits in FORMS if traits.name == "mean")

    def bake(self, job: BakeJob) -> Generator[Progress, None, Outcome]:
        spec, prepared = job.spec, job.prepared
        plan = yield from prepared.plan_of_seen(spec.bucket, job.folder, job.store)
        capture = capture_of(job.scratch, plan, spec, job.folder)
        image = yield from fill_atlas(plan, capture, spec.tile_mb, None, job.store, job.thumbnail)
        yield Progress(Stage.WRITE, 0, 1)
        means = plan.layout.to_buckets(image).mean(axis=(2, 3))
        facts = replace(prepared.facts(spec), bucket=1)
        written = write_buckets(job.place, means, {}, facts, spec.half, spec.compression)
        paths = len(plan.texel) * spec.bucket**2 * spec.samples
        layout = AtlasLayout(plan.layout.width, plan.layout.height, 1)
        images = self.images(spec, job.sidecar)
        return Outcome(images, layout, len(plan.texel), paths, written.clamped)

    def holds(self, facts: Facts) -> bool:
        return KINDS[Kind(facts.text("kind"))].form == self.traits

    def is_of(self, facts: Facts, spec: BakeSpec) -> bool:
        return facts.whole_number("samples", 1) == spec.samples


FORM: Form = Mean()
