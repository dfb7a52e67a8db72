# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations
from tests.bench.metamorphic.trial import Relation
RELATIONS: dict[str, Relation] = {}
