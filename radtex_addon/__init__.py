# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""RadTex, layer by layer.

core <- formats <- bake <- scene <- cycles <- preview, textures, prepare <- forms <- export <- job
<- report, farm <- worker <- ui, cli.
"""
